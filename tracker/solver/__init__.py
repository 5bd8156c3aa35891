"""Solve nonlinear least squares over one pose or many: terms, point Jacobians, one loop."""
