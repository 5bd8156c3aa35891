"""Refine a roughly posed keyframe on its picture: a suggestion, which can be undone."""

from keypose.tracker.fitting.pose.keyframe import PictureFit, fit_pose_to_picture

__all__ = ["PictureFit", "fit_pose_to_picture"]
