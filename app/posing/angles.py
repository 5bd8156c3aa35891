"""Rotations as the three angles that fields and sliders show, [x, y, z] in degrees.

Of a part R = Qz·Qy·Qx, of the root Qy·Qz·Qx against what is up (`keypose.tracker.body.heading`): it
turns first, then tilts and leans, so that somebody who turns round neither tilts nor leans for it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from keypose.app.posing.limits import (
    FREE,
    SLACK,
    TURN,
    JointRange,
    beyond,
    box_of,
    fitting,
    furthest_share,
    is_twisted,
    nearest_within,
    range_of,
    triples,
    twist_of,
)
from keypose.tracker.body.body import Part
from keypose.tracker.body.heading import CAMERA_UP, from_heading_first, heading_first
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, rotation_from_euler

AXES = ("x", "y", "z")
GIMBAL = 1e-4
"""Where the cosine of the angle in the middle is smaller, the two others turn about the same axis
and cannot be distinguished."""


def angles_deg(skeleton: Skeleton, pose: Pose, up_camera: ArrayLike = CAMERA_UP) -> Array:
    """Every part's [x, y, z] (P, 3) in degrees."""
    shown = []
    for part, R in zip(skeleton.body.parts, pose.Rs_parent_part, strict=True):
        shown.append(_of_both(part, R[None], _both(part, R[None], up_camera)))
    return np.degrees(np.concatenate(shown)) + 0.0


def _both(part: Part, Rs_parent_part: Array, up_camera: ArrayLike) -> Array:
    """Both triples [x, y, z] (..., 2, 3) of a part's rotations, radians."""
    if part.parent is not None:
        return triples(Rs_parent_part)
    return _shown_of_root(triples(heading_first(Rs_parent_part, up_camera)))


def _shown_of_root(angles: Array) -> Array:
    """[lean, turn, tilt] (..., 3) of the root's [x, y, z] with its heading first."""
    x, y, z = np.moveaxis(angles, -1, 0)
    return np.stack([x, z, -y], axis=-1)


def _of_shown_root(angles: Array) -> Array:
    lean, turn, tilt = np.moveaxis(angles, -1, 0)
    return np.stack([lean, -tilt, turn], axis=-1)


def _middle(part: Part) -> int:
    """Which of [x, y, z] is a quarter turn where the others cannot be distinguished."""
    return 1 if part.parent is not None else 2


def angle_curve_deg(
    part: Part, Rs_parent_part: Array, keys: NDArray[np.intp], up_camera: ArrayLike = CAMERA_UP
) -> Array:
    """One part's [x, y, z] (N, 3) in degrees over frames, without jumps.

    Of the two triples of each rotation (N, 3, 3) the one that is nearer to the frame before, from
    that keyframe on, of the rows `keys`, whose own triple is the clearest; from the first frame
    where there are none. Angles run on through 180°.
    """
    both, middle = _both(part, Rs_parent_part, up_camera), _middle(part)
    clear = np.abs(np.cos(both[:, 0, middle])) >= GIMBAL
    rows = np.flatnonzero(clear if clear.any() else ~clear)
    if not len(rows):
        return np.empty((0, 3))
    curve = np.empty((len(both), 3))
    curve[rows] = np.unwrap(_nearer_in_turn(both[rows]), axis=0)
    start = _clearest(both, np.intersect1d(keys, rows), rows)
    own = _of_both(part, Rs_parent_part[start : start + 1], both[start : start + 1])[0]
    if math.cos(curve[start, 0] - own[0]) < 0:  # the other triple, half a turn away about x
        curve[:, middle] *= -1.0
        curve += math.pi
    curve += TURN * np.round((own - curve[start]) / TURN)
    for row in np.setdiff1d(np.arange(len(both)), rows):
        near = rows[max(np.searchsorted(rows, row) - 1, 0)]
        curve[row] = continued(part, Rs_parent_part[row], curve[near], up_camera)
    return np.degrees(curve) + 0.0


def _nearer_in_turn(both: Array) -> Array:
    """Choose of pairs of triples (N, 2, 3) the first one's first, then each time the nearer (N, 3).

    The other triple of both is as far from one as that is from the other: whether to change over
    between two frames does not depend on where one is.
    """
    steps = both[1:] - both[:-1, :1]
    far = ((steps - TURN * np.round(steps / TURN)) ** 2).sum(axis=-1)
    changes = np.concatenate([[False], far[:, 1] < far[:, 0]])
    takes_second = np.logical_xor.accumulate(changes)
    return np.where(takes_second[:, None], both[:, 1], both[:, 0])


def _clearest(both: Array, keys: NDArray[np.intp], rows: NDArray[np.intp]) -> int:
    """The row of `keys` whose two triples (N, 2, 3) lean most unequally; the first without any."""
    if not len(keys):
        return int(rows[0])
    aside = _aside(both[keys])
    return int(keys[np.argmax(np.abs(aside[:, 0] - aside[:, 1]))])


def _of_both(part: Part, Rs_parent_part: Array, both: Array) -> Array:
    """Choose of two triples (N, 2, 3) of a part's rotations (N, 3, 3) the one to show (N, 3),
    radians.

    The one that keeps the part's limits, else the one with y within ±90°. The root has no limits:
    the triple with less lean and tilt, as of a part that is twisted beyond its limit, which no
    triple within its limits shows.
    """
    if part.parent is None:
        return _more_upright(both)
    shown, box, twisted = both[:, 0], box_of(part), is_twisted(part, Rs_parent_part)
    if box is not None:
        out = beyond(shown, box) > SLACK
        if out.any():
            shown = np.where(out[:, None], fitting(Rs_parent_part, box), shown)
    return np.where(twisted[:, None], _more_upright(both), shown) if twisted.any() else shown


def _more_upright(both: Array) -> Array:
    """Choose of two triples (..., 2, 3) the one with less lean and tilt (..., 3)."""
    aside = _aside(both)
    second = aside[..., 1] < aside[..., 0] - SLACK
    return np.where(second[..., None], both[..., 1, :], both[..., 0, :])


def _aside(both: Array) -> Array:
    """(...) lean and tilt of triples (..., 3), added."""
    return np.asarray(np.abs(both[..., 0]) + np.abs(both[..., 2]))


def continued(
    part: Part, rotation: Array, before_rad: Array, up_camera: ArrayLike = CAMERA_UP
) -> Array:
    """The angles [x, y, z] of a part's rotation, radians, that are nearest to those before."""
    both = _both(part, rotation, up_camera)
    both = both - TURN * np.round((both - before_rad) / TURN)
    if abs(math.cos(both[0][_middle(part)])) < GIMBAL:
        if part.parent is not None:
            return _at_gimbal(both[0], before_rad)
        return _shown_of_root(_at_gimbal(_of_shown_root(both[0]), _of_shown_root(before_rad)))
    near = ((both - before_rad) ** 2).sum(axis=1)
    return np.asarray(both[int(np.argmin(near))])


def _at_gimbal(angles: Array, before_rad: Array) -> Array:
    """Set angles at gimbal lock: with y a quarter turn only z − x (or z + x, at −90°) is
    determined; both change equally.
    """
    x, y, z = angles.tolist()
    sign = -1.0 if math.sin(y) > 0 else 1.0
    sum_angle = z + sign * x
    was = before_rad[2] + sign * before_rad[0]
    half = math.remainder(sum_angle - was, TURN) / 2
    return np.array([before_rad[0] + sign * half, y, before_rad[2] + half])


def with_angles(
    skeleton: Skeleton,
    pose: Pose,
    part: str,
    x: float | None = None,
    y: float | None = None,
    z: float | None = None,
    *,
    limits_on: bool = False,
    near_deg: Array | None = None,
    up_camera: ArrayLike = CAMERA_UP,
) -> Pose:
    """The pose with some angles of one part set, in degrees; `limits_on` stops at the limits.

    The others stay as they are in the triple that is shown, or in that nearest to `near_deg` (3,).
    """
    i = skeleton.body.index(part)
    if near_deg is None:
        now = angles_deg(skeleton, pose, up_camera)[i].tolist()
    else:
        own = skeleton.body.parts[i]
        R, near = pose.Rs_parent_part[i], np.radians(near_deg)
        now = np.degrees(continued(own, R, near, up_camera)).tolist()
    wanted = [old if new is None else new for old, new in zip(now, (x, y, z), strict=True)]
    if limits_on:
        limits = skeleton.body.parts[i].limits_deg
        wanted = [
            min(max(value, limits[axis][0]), limits[axis][1]) if axis in limits else value
            for axis, value in zip(AXES, wanted, strict=True)
        ]
    if limits_on:
        wanted = _stopped(skeleton.body.parts[i], now, wanted)
    if skeleton.body.parts[i].parent is None:
        R = rotation_of(_of_shown_root(np.array(wanted)))
        return with_rotation(pose, i, from_heading_first(R, up_camera))
    return with_rotation(pose, i, rotation_of(wanted))


def _stopped(part: Part, now: list[float], wanted: list[float]) -> list[float]:
    """Go as far on the way from angles to others, degrees, as the part may twist."""
    twist = twist_of(part)
    if twist is None:
        return wanted
    start, change = np.array(now), np.array(wanted) - now
    allowed = JointRange(FREE, twist).widened(rotation_of(now))

    def on_the_way(shares: Array) -> Array:
        return np.stack([rotation_of(start + share * change) for share in shares])

    share = furthest_share(on_the_way, math.radians(float(np.abs(change).max())), allowed)
    return list((start + share * change).tolist())


def rotation_of(angles_xyz_deg: list[float] | Array) -> Array:
    """Qz·Qy·Qx of [x, y, z] in degrees."""
    x, y, z = (math.radians(float(angle)) for angle in angles_xyz_deg)
    return rotation_from_euler(z, y, x)


def with_rotation(pose: Pose, index: int, R_parent_part: Array) -> Pose:
    """The pose with one part's rotation exchanged."""
    Rs = pose.Rs_parent_part.copy()
    Rs[index] = R_parent_part
    return Pose(Rs, pose.p_camera_root)


def with_reset(skeleton: Skeleton, pose: Pose, part: str) -> Pose:
    """The pose with one part at rest."""
    return with_rotation(pose, skeleton.body.index(part), np.eye(3))


def clamp_to_limits(skeleton: Skeleton, pose: Pose) -> Pose:
    """The pose with every part turned back to its limits, by the least turn."""
    Rs = [
        nearest_within(R, range_of(part))
        for R, part in zip(pose.Rs_parent_part, skeleton.body.parts, strict=True)
    ]
    return Pose(np.stack(Rs), pose.p_camera_root)


def at_limit(skeleton: Skeleton, pose: Pose, margin_deg: float = 0.05) -> dict[str, list[str]]:
    """The axes of every part that stand at a limit of theirs, or beyond."""
    now = angles_deg(skeleton, pose)
    axes_of_part: dict[str, list[str]] = {}
    for i, part in enumerate(skeleton.body.parts):
        axes: list[str] = [
            axis
            for axis, angle in zip(AXES, now[i].tolist(), strict=True)
            if axis in part.limits_deg and not _inside(angle, part.limits_deg[axis], margin_deg)
        ]
        if axes:
            axes_of_part[part.name] = axes
    return axes_of_part


def _inside(angle: float, limits: tuple[float, float], margin: float) -> bool:
    return limits[0] + margin < angle < limits[1] - margin
