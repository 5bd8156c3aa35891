"""Keyframe reduction: a dense motion as the fewest keyframes that interpolation needs for it."""
