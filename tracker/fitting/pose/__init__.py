"""A roughly posed keyframe improved from the picture: a suggestion, which may be taken back."""

from tracker.fitting.pose.keyframe import Fitted, fit_here

__all__ = ["Fitted", "fit_here"]
