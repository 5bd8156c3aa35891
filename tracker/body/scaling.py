"""Bodies of other sizes: whole bodies scaled, single parts made longer or thicker, joints moved.

Pure functions: a body goes in, a new validated body comes out. Lengths in metres; factors are
plain ratios, 1.0 changes nothing. People differ, so every size and joint can be edited. (DRIFT §4)
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from pydantic import ValidationError

from keypose.tracker.body.body import Body, Part, Point
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import BodyError, one_sentence


def scaled(body: Body, factor: float) -> Body:
    """The body with every length, joint and landmark multiplied by `factor` (a ratio above 0)."""
    _require_ratio("factor", factor)
    return with_parts(body, (_scale_part(part, factor, factor, factor) for part in body.parts))


def height(body: Body) -> float:
    """Metres from sole to head top in the rest pose: the extent of all parts along y."""
    skeleton = Skeleton.of(body)
    Ts = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))
    ys = [
        part.shape.mesh().vertices[:, 1] + T[1, 3] for part, T in zip(body.parts, Ts, strict=True)
    ]
    return float(np.concatenate(ys).max() - np.concatenate(ys).min())


def with_height(body: Body, height_m: float) -> Body:
    """The body scaled evenly so that `height` gives `height_m` metres."""
    _require_ratio("height_m", height_m)
    return scaled(body, height_m / height(body))


def resized(
    body: Body,
    part_name: str,
    *,
    length_factor: float = 1.0,
    thickness_factor: float = 1.0,
    linked: bool = True,
) -> Body:
    """One part made longer (along its y axis) and thicker (across it), both factors ratios.

    Its children's joints and its landmarks move with its surface, so that a longer thigh carries
    the shin along. The part on the other side follows unless `linked` is False.
    """
    _require_ratio("length_factor", length_factor)
    _require_ratio("thickness_factor", thickness_factor)
    names = _sides(body, part_name, linked)

    def change(part: Part) -> Part:
        if part.name in names:
            return _scale_part(part, 1.0, length_factor, thickness_factor)
        if part.parent in names:
            joint = _times(part.joint_m, length_factor, thickness_factor)
            return part.model_copy(update={"joint_m": joint})
        return part

    return with_parts(body, map(change, body.parts))


def joint_moved(body: Body, part_name: str, joint_m: Point, *, linked: bool = True) -> Body:
    """The part's joint put at `joint_m`, metres in the parent's frame.

    The part on the other side follows with x negated unless `linked` is False. The root has no
    joint: its place is its pose.
    """
    names = _sides(body, part_name, linked)
    if body.parts[body.index(part_name)].parent is None:
        raise BodyError(f"Part {part_name!r} is the root and has no joint; move the pose instead.")
    x, y, z = joint_m

    def change(part: Part) -> Part:
        if part.name not in names:
            return part
        place = (x, y, z) if part.name == part_name else (-x, y, z)
        return part.model_copy(update={"joint_m": place})

    return with_parts(body, map(change, body.parts))


def _sides(body: Body, name: str, linked: bool) -> set[str]:
    mirror = body.mirror_of(name)
    return {name, mirror} if linked else {name}


def _scale_part(part: Part, joint: float, along: float, across: float) -> Part:
    """Joint times one ratio; shape and landmarks times one ratio along y, another across."""
    return part.model_copy(
        update={
            "joint_m": _times(part.joint_m, joint, joint),
            "shape": part.shape.scaled(along, across),
            "landmarks": {k: _times(p, along, across) for k, p in part.landmarks.items()},
        }
    )


def _times(point: Point, along: float, across: float) -> Point:
    return point[0] * across, point[1] * along, point[2] * across


def _require_ratio(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0):
        raise BodyError(f"The {name} is {value}; it must be a number above 0.")


def with_parts(body: Body, parts: Iterable[Part]) -> Body:
    """The body with these parts instead; BodyError in one sentence where they make none."""
    # model_copy does not validate, so the whole body is read again: sizes have bounds.
    try:
        return Body.model_validate({**body.model_dump(), "parts": [p.model_dump() for p in parts]})
    except ValidationError as error:
        raise BodyError(f"This size is not possible: {one_sentence(error)}") from None
