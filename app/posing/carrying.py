"""What is held goes along with what holds it: a limb reaches after it, a thing moves as a whole."""

from __future__ import annotations

import numpy as np

from keypose.app.posing.gesture import GestureContext
from keypose.app.posing.holding import ends_to_hold, limb_of
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array


def reached(skeleton: Skeleton, pose: Pose, part: str, p_part: Array, place: Array) -> Pose | None:
    """The pose with a point of a part at a place, or as near as its limb comes; None where the part
    is of no limb that could bend.

    p_part: (3,) in the part's frame.  place: (3,) in the camera frame.
    """
    movers = _movers(skeleton.body, part)
    if len(movers) < 2:
        return None
    context = GestureContext.of(skeleton, pose, True)
    parts = tuple(map(skeleton.body.index, movers))
    p_camera = context.placed(skeleton.body.index(part), p_part)
    T_camera_last = context.Ts_camera_part[parts[-1]]
    tip = placed(np.linalg.inv(T_camera_last), p_camera)
    return context.turned(limb_of(context, parts, tip).toward(place).rotations)


def moved(pose: Pose, T: Array) -> Pose:
    """The whole body moved by T (4, 4) in the camera frame."""
    Rs = pose.Rs_parent_part.copy()
    Rs[0] = T[:3, :3] @ Rs[0]
    return Pose(Rs, placed(T, pose.p_camera_root))


def placed(T: Array, p: Array) -> Array:
    """(3,) one point moved by T (4, 4)."""
    return np.asarray(T[:3, :3] @ p + T[:3, 3])


def _movers(body: Body, part: str) -> tuple[str, ...]:
    """The parts that bend to move this one, from the trunk outward."""
    handle = next((each for each in ends_to_hold(body) if part in each.limb), None)
    if handle is None:
        return ()
    within = handle.limb[: handle.limb.index(part) + 1]
    return tuple(name for name in handle.movers if name in within)
