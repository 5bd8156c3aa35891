"""Reduce a dense motion to the fewest keyframes that interpolation needs for it."""
