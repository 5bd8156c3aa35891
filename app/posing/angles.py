"""Rotations as the three angles that fields and sliders show: R = Qz·Qy·Qx, in degrees."""

from __future__ import annotations

import math

import numpy as np

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
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, rotation_from_euler

AXES = ("x", "y", "z")
GIMBAL = 1e-4
"""Where cos y is smaller, x and z turn about the same axis and cannot be distinguished."""


def angles_deg(skeleton: Skeleton, pose: Pose, previous_deg: Array | None = None) -> Array:
    """Every part's [x, y, z] (P, 3) in degrees.

    Two triples give the same rotation. With the angles shown before, (P, 3), the nearer is taken,
    so that a field runs on through 180° and through the place where y is a quarter turn. Without,
    it is that of `part_angles_deg`.
    """
    if previous_deg is not None:
        before = np.radians(previous_deg)
        pairs = zip(pose.Rs_parent_part, before, strict=True)
        return np.degrees([continued(R, angles) for R, angles in pairs])
    both = triples(pose.Rs_parent_part)
    plain = both[:, 0]
    plain[0] = _more_upright(both[0])
    for i, part in enumerate(skeleton.body.parts):
        box, R = box_of(part), pose.Rs_parent_part[i]
        if is_twisted(part, R):  # no triple in the box shows it, the other one does
            plain[i] = _more_upright(both[i])
        elif box is not None and beyond(plain[i], box) > SLACK:
            plain[i] = fitting(R, box)
    return np.degrees(plain) + 0.0


def part_angles_deg(part: Part, Rs_parent_part: Array) -> Array:
    """One part's [x, y, z] (N, 3) in degrees, of N rotations (N, 3, 3).

    Of the two triples: the one that keeps the part's limits, else the one with y within ±90. The
    root has no limits; a person who has turned round is described by y, not by lean and tilt, and
    so is a part that is twisted beyond its limit.
    """
    both, box = triples(Rs_parent_part), box_of(part)
    if part.parent is None:
        return np.degrees(_more_upright(both)) + 0.0
    plain = both[:, 0]
    if box is not None:
        boxed = triples(Rs_parent_part, box)
        out = beyond(boxed, box)
        inner = np.where((out[:, 1] < out[:, 0] - SLACK)[:, None], boxed[:, 1], boxed[:, 0])
        plain = np.where((beyond(plain, box) > SLACK)[:, None], inner, plain)
    twisted = is_twisted(part, Rs_parent_part)
    return np.degrees(np.where(twisted[:, None], _more_upright(both), plain)) + 0.0


def _more_upright(both: Array) -> Array:
    """Of two triples (..., 2, 3) the one with less lean and tilt (..., 3)."""
    aside = np.abs(both[..., 0]) + np.abs(both[..., 2])
    second = aside[..., 1] < aside[..., 0] - SLACK
    return np.where(second[..., None], both[..., 1, :], both[..., 0, :])


def continued(rotation: Array, before_rad: Array) -> Array:
    """The angles [x, y, z] of a rotation, radians, that are nearest to those before."""
    both = triples(rotation)
    both = both - TURN * np.round((both - before_rad) / TURN)
    if abs(math.cos(both[0][1])) < GIMBAL:
        return _at_gimbal(rotation, both[0], before_rad)
    near = ((both - before_rad) ** 2).sum(axis=1)
    return np.asarray(both[int(np.argmin(near))])


def _at_gimbal(rotation: Array, angles: Array, before_rad: Array) -> Array:
    """With y a quarter turn only z − x (or z + x, at −90°) is determined; both change equally."""
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
) -> Pose:
    """The pose with some angles of one part set, in degrees; `limits_on` stops at the limits."""
    i = skeleton.body.index(part)
    now = angles_deg(skeleton, pose)[i].tolist()
    wanted = [old if new is None else new for old, new in zip(now, (x, y, z), strict=True)]
    if limits_on:
        limits = skeleton.body.parts[i].limits_deg
        wanted = [
            min(max(value, limits[axis][0]), limits[axis][1]) if axis in limits else value
            for axis, value in zip(AXES, wanted, strict=True)
        ]
    if limits_on:
        wanted = _stopped(skeleton.body.parts[i], now, wanted)
    return with_rotation(pose, i, rotation_of(wanted))


def _stopped(part: Part, now: list[float], wanted: list[float]) -> list[float]:
    """As far on the way from angles to others, degrees, as the part may twist."""
    twist = twist_of(part)
    if twist is None:
        return wanted
    start, way = np.array(now), np.array(wanted) - now
    allowed = JointRange(FREE, twist).widened(rotation_of(now))

    def on_the_way(shares: Array) -> Array:
        return np.stack([rotation_of(start + share * way) for share in shares])

    share = furthest_share(on_the_way, math.radians(float(np.abs(way).max())), allowed)
    return list((start + share * way).tolist())


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
    found: dict[str, list[str]] = {}
    for i, part in enumerate(skeleton.body.parts):
        axes: list[str] = [
            axis
            for axis, angle in zip(AXES, now[i].tolist(), strict=True)
            if axis in part.limits_deg and not _inside(angle, part.limits_deg[axis], margin_deg)
        ]
        if axes:
            found[part.name] = axes
    return found


def _inside(angle: float, limits: tuple[float, float], margin: float) -> bool:
    return limits[0] + margin < angle < limits[1] - margin
