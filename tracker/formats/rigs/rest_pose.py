"""The body in a rig's rest pose: standing on the floor, facing +z, y up, its left toward +x.

Part frames are those of files whose y points up (`keypose.tracker.formats.axes`): at the body's
own rest parallel to the world.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.formats.axes import flipped
from keypose.tracker.formats.end_sites import end_site
from keypose.tracker.formats.rigs.table import SIDES
from keypose.tracker.geometry.rotations import Array, exp_rotation, transform

_ARM, _LEG = ("upper_arm", "forearm", "hand"), ("thigh", "shin")
_DOWN = np.array([0.0, -1.0, 0.0])


def rest_pose(skeleton: Skeleton, arms_below_horizontal_deg: float | None) -> Array:
    """Ts_world_part (P, 4, 4), metres, with the root's joint above the world's origin.

    None: the body's own rest pose. Otherwise arms straight out to the sides, so far below the
    horizontal, and legs straight down, each part turned there from the own rest pose about the one
    axis that takes it; the rest of the body as in the own rest pose.
    """
    Rs = np.tile(np.eye(3), (skeleton.part_count, 1, 1))
    if arms_below_horizontal_deg is not None:
        for part, direction in _directions(arms_below_horizontal_deg).items():
            if part in skeleton.body.names:
                i = skeleton.body.index(part)
                Rs[i] = _turn_onto(_along(skeleton, i), direction)
    Ts = transform(Rs, np.zeros((skeleton.part_count, 3)))
    for i, parent in enumerate(skeleton.parents):
        if parent >= 0:
            Ts[i, :3, 3] = Ts[parent, :3, 3] + Rs[parent] @ flipped(skeleton.joints[i])
    Ts[:, 1, 3] -= _lowest(skeleton, Ts)
    return Ts


def _directions(below_deg: float) -> dict[str, Array]:
    """Where the parts of arms and legs point."""
    below = np.deg2rad(below_deg)
    found: dict[str, Array] = {}
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        out = np.array([sign * np.cos(below), -np.sin(below), 0.0])
        found |= {f"{side}_{part}": out for part in _ARM}
        found |= {f"{side}_{part}": _DOWN for part in _LEG}
    return found


def _along(skeleton: Skeleton, i: int) -> Array:
    """Where a part points in its own frame: to its first child's joint, or to its end."""
    children = np.flatnonzero(skeleton.parents == i)
    end = skeleton.joints[children[0]] if len(children) else end_site(skeleton.body.parts[i])
    return flipped(np.asarray(end))


def _turn_onto(start: Array, end: Array) -> Array:
    """The smallest rotation (3, 3) that takes one direction (3,) to another."""
    axis = np.cross(start, end)
    length, along = np.linalg.norm(axis), float(start @ end)
    if (
        length < 1e-9
    ):  # parallel: nothing to do; opposed: any axis across, here the one to the front
        return np.asarray(exp_rotation(np.array([0.0, 0.0, 0.0 if along >= 0 else np.pi])))
    return np.asarray(exp_rotation(axis / length * np.arctan2(length, along)))


def _lowest(skeleton: Skeleton, Ts_world_part: Array) -> float:
    """y of the body's lowest point."""
    heights = (
        flipped(part.shape.mesh().vertices) @ T[1, :3] + T[1, 3]
        for part, T in zip(skeleton.body.parts, Ts_world_part, strict=True)
    )
    return float(min(h.min() for h in heights))
