"""Pose a jointed body with the mouse: pure functions from a pose and a drag to a pose.

`drag` is the entry point for everything a pointer does to the body. Points are in the camera frame,
metres; view coordinates are those of `PointerView`. Nothing here keeps anything: a gesture is
always applied to the pose before it began.
"""

from keypose.app.posing.angles import (
    angle_curve_deg,
    angles_deg,
    at_limit,
    clamp_to_limits,
    with_angles,
    with_reset,
)
from keypose.app.posing.dragging import drag
from keypose.app.posing.gesture import (
    BoxCorner,
    Eye,
    Gesture,
    InView,
    PlacedCorner,
    Posed,
    Reach,
    Readout,
)
from keypose.app.posing.handles import BodyHandle, handle_named, handles, lanes
from keypose.app.posing.holding import Held, ends_to_hold, keep_pinned, placed_ends
from keypose.app.posing.labels import axis_labels, part_label, short_label
from keypose.app.posing.limits import is_twisted
from keypose.app.posing.mirroring import mirror_pose, swap_left_right, with_other_side
from keypose.app.posing.placing import (
    Way,
    eye_rotation,
    facing,
    opening_pose,
    tilt_and_roll,
    up_from_vertical,
    view_rotations,
)
from keypose.app.posing.pointer_view import PointerView, outline, parts_at
from keypose.app.posing.resizing import (
    Size,
    part_sizes,
    with_height,
    with_joint,
    with_shape,
    with_size,
)
from keypose.app.posing.untwisting import untwisted_limb
from keypose.tracker.body.heading import CAMERA_UP

__all__ = [
    "CAMERA_UP",
    "BodyHandle",
    "BoxCorner",
    "Eye",
    "Gesture",
    "Held",
    "InView",
    "PlacedCorner",
    "PointerView",
    "Posed",
    "Reach",
    "Readout",
    "Size",
    "Way",
    "angle_curve_deg",
    "angles_deg",
    "at_limit",
    "axis_labels",
    "clamp_to_limits",
    "drag",
    "ends_to_hold",
    "eye_rotation",
    "facing",
    "handle_named",
    "handles",
    "is_twisted",
    "keep_pinned",
    "lanes",
    "mirror_pose",
    "opening_pose",
    "outline",
    "part_label",
    "part_sizes",
    "parts_at",
    "placed_ends",
    "short_label",
    "swap_left_right",
    "tilt_and_roll",
    "untwisted_limb",
    "up_from_vertical",
    "view_rotations",
    "with_angles",
    "with_height",
    "with_joint",
    "with_other_side",
    "with_reset",
    "with_shape",
    "with_size",
]
