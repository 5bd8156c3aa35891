"""Posing a jointed body with the mouse: pure functions from a pose and a drag to a pose.

`drag` is the door for everything a pointer does to the body. Points are in the camera frame,
metres; view coordinates are those of `PointerView`. Nothing here keeps anything: a gesture is
always applied to the pose before it began.
"""

from app.posing.angles import (
    angles_deg,
    at_limit,
    clamped,
    part_angles_deg,
    with_angles,
    with_reset,
)
from app.posing.dragging import drag
from app.posing.facing import Way, facing
from app.posing.gesture import Gesture, Posed, Reach, Readout
from app.posing.handles import BodyHandle, handle_named, handles, lanes
from app.posing.mirroring import mirrored, with_other_side
from app.posing.picking import outline, parts_at
from app.posing.placing import opening_pose
from app.posing.pointer_view import PointerView
from app.posing.resizing import Size, part_sizes, with_height, with_joint, with_size
from app.posing.swapping import sides_swapped
from app.posing.upright import CAMERA_UP, tilt_and_roll, up_from_vertical, view_rotations
from app.posing.words import part_label, part_words

__all__ = [
    "CAMERA_UP",
    "BodyHandle",
    "Gesture",
    "PointerView",
    "Posed",
    "Reach",
    "Readout",
    "Size",
    "Way",
    "angles_deg",
    "at_limit",
    "clamped",
    "drag",
    "facing",
    "handle_named",
    "handles",
    "lanes",
    "mirrored",
    "opening_pose",
    "outline",
    "part_angles_deg",
    "part_label",
    "part_sizes",
    "part_words",
    "parts_at",
    "sides_swapped",
    "tilt_and_roll",
    "up_from_vertical",
    "view_rotations",
    "with_angles",
    "with_height",
    "with_joint",
    "with_other_side",
    "with_reset",
    "with_size",
]
