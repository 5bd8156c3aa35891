"""The body laid into observed surfaces: SURFACE's weights, pairs and energy, step by step."""
