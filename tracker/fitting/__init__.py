"""Fit a pose, or the body's sizes, to what the pictures show."""
