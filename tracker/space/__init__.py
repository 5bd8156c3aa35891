"""Solve for the motion in space over neighbouring segments, and measure its plausibility."""
