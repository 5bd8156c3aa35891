"""Fit the body to observed surfaces step by step: SURFACE's weights, pairs and energy."""
