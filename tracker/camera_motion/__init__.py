"""Find how a film's camera turned and zoomed, from its background.

    found = find_camera_motion(pictures, camera, frame_count, background)
    found.kind      # "static", "turns" or "moves"
    found.path      # a CameraPath, or None for a static camera

`find` is the way in; `odometer` measures frame after frame from anchors, with the points that
`points` follows and the turns that `turn` solves for; `territory` and `landmarks` know what was
seen before; `anchors` and `path` put everything together.
"""

from __future__ import annotations

from keypose.tracker.camera_motion.find import (
    CameraKind,
    CameraMotion,
    FollowedPoints,
    find_camera_motion,
)
from keypose.tracker.camera_motion.findings import Finding
from keypose.tracker.camera_motion.focal import FocalScale
from keypose.tracker.camera_motion.matches import Matched, rotation_from_matches
from keypose.tracker.camera_motion.path import Correction

__all__ = [
    "CameraKind",
    "CameraMotion",
    "Correction",
    "Finding",
    "FocalScale",
    "FollowedPoints",
    "Matched",
    "find_camera_motion",
    "rotation_from_matches",
]
