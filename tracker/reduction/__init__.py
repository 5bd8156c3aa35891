"""Keyframe reduction: a dense motion as the fewest keyframes that interpolation needs for it."""

from tracker.reduction.compare import Tolerance
from tracker.reduction.reduce import Reduction, reduce_motion

__all__ = ["Reduction", "Tolerance", "reduce_motion"]
