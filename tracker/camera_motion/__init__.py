"""Find how a film's camera turned and zoomed, or where it went, from its background.

    found = find_camera_motion(pictures, camera, frame_count, background)
    found.kind      # "static", "turns" or "moves"
    found.path      # a CameraPath, or None for a static camera

Where it moves (and does not zoom), its path is found in a second pass, in a unit of its own, and
feet that stand show how long that is:

    moved = find_moved_path(pictures, camera, frame_count, background)
    scale = scale_from_stances(moved.path, [StandingPoint(12, p_camera_foot), ...])
    path = moved.in_metres(scale.metres)            # where scale is not None

The README beside this file says how, step by step.
"""

from __future__ import annotations

from keypose.tracker.camera_motion.find import (
    CameraKind,
    CameraMotion,
    MovedPath,
    find_camera_motion,
    find_moved_path,
)
from keypose.tracker.camera_motion.findings import Finding
from keypose.tracker.camera_motion.focal import FocalScale
from keypose.tracker.camera_motion.matches import Matched, rotation_from_matches
from keypose.tracker.camera_motion.measurements import FollowedPoints
from keypose.tracker.camera_motion.metric import PathScale, StandingPoint, scale_from_stances

__all__ = [
    "CameraKind",
    "CameraMotion",
    "Finding",
    "FocalScale",
    "FollowedPoints",
    "Matched",
    "MovedPath",
    "PathScale",
    "StandingPoint",
    "find_camera_motion",
    "find_moved_path",
    "rotation_from_matches",
    "scale_from_stances",
]
