"""Calibrated cameras around a thing: what they saw of it, and the surfaces that follow."""
