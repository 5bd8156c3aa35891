"""The body fitted to observed surfaces: SURFACE's weights, pairs and energy, step by step."""
