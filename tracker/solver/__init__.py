"""Nonlinear least squares over one pose or many: terms, how a body moves, and one loop."""
