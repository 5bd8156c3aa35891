"""Modify a body: add, remove and rename parts and clavicles; scale it whole or part by part.

A shoulder is no fixed point of the chest: shrugging and reaching carry it up and forward by several
centimetres. The part turns about its inner end beside the breastbone, up and down about z, forward
and back about y, within limits. In the rest pose shoulders are where they were, so that a pose of
the body without is the same pose of the body with them.

Brightness does not track it: it lies inside the chest, and two motions more that the picture hardly
shows made trunk and arms worse on real film. Keyframes turn it, and where keypoints are evidence
the shoulder's does.

Pure functions: a body goes in, a new validated body comes out. Lengths in metres; factors are
plain ratios, 1.0 changes nothing. People differ, so every size and joint can be edited. (DRIFT §4)
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from pydantic import ValidationError

from keypose.tracker.body.body import ROTATIONS, Body, Limits, Part, Point
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.shapes import Box, Cylinder
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import BodyError, one_sentence

INNER = 0.15
FORWARD = 0.03
"""Where the inner end is, estimated: this share of the way from the middle of the chest to the
shoulder, at its height, and so many metres before it, by an upper arm's length of 30 cm."""

RISES = 40.0
SINKS = 10.0
SWINGS = 25.0
GIVES = 10.0
"""Degrees that it rises and sinks, swings forward and back, and turns about its own length: what
textbooks give for the joint at the breastbone, rounded."""

ROUNDING: Final = 1e-9
"""Sizes that differ by so little, metres or as a ratio, are the same."""

HALF_HEIGHT = 0.02
HALF_DEPTH = 0.025
LENGTH = 0.9
"""Its shape, over an upper arm of 30 cm; it ends at this share of the way to the shoulder."""

ARM_M = 0.3
SIDES = ("left", "right")


def can_have_clavicles(body: Body) -> bool:
    """Whether both upper arms hang on one chest, and none is there yet."""
    arms = [_part(body, f"{side}_upper_arm") for side in SIDES]
    chests = {arm.parent for arm in arms if arm is not None}
    names = {f"{side}_clavicle" for side in SIDES} & set(body.names)
    return None not in arms and chests == {"chest"} and not names


def has_clavicles(body: Body) -> bool:
    """Whether both upper arms hang on a clavicle."""
    arms = [(side, _part(body, f"{side}_upper_arm")) for side in SIDES]
    return all(arm is not None and arm.parent == f"{side}_clavicle" for side, arm in arms)


def with_clavicles(body: Body) -> Body:
    """The body with a clavicle on each side; itself where it cannot have them."""
    if not can_have_clavicles(body):
        return body
    parts: list[Part] = []
    for part in body.parts:
        side = part.name.removesuffix("_upper_arm")
        if part.name == f"{side}_upper_arm" and side in SIDES:
            clavicle = _clavicle(side, part)
            x, y, z = np.subtract(part.joint_m, clavicle.joint_m).round(9).tolist()
            parts.append(clavicle)
            part = part.model_copy(update={"parent": clavicle.name, "joint_m": (x, y, z)})
        parts.append(part)
    pairs = (*body.mirror_pairs, ("left_clavicle", "right_clavicle"))
    return Body(**{**dict(body), "parts": tuple(parts), "mirror_pairs": pairs})


def without_clavicles(body: Body) -> Body:
    """The body with its upper arms on the chest again; itself where it has no clavicles."""
    if not has_clavicles(body):
        return body
    gone = {f"{side}_clavicle": body.parts[body.index(f"{side}_clavicle")] for side in SIDES}
    parts = []
    for part in body.parts:
        if part.name in gone:
            continue
        if part.parent in gone:
            above = gone[part.parent]
            x, y, z = np.add(above.joint_m, part.joint_m).round(9).tolist()
            part = part.model_copy(update={"parent": above.parent, "joint_m": (x, y, z)})
        parts.append(part)
    pairs = tuple(pair for pair in body.mirror_pairs if not set(pair) & set(gone))
    return Body(**{**dict(body), "parts": tuple(parts), "mirror_pairs": pairs})


def _clavicle(side: str, arm: Part) -> Part:
    x, y, z = arm.joint_m
    size = arm.shape.length_m / ARM_M
    joint: Point = (round(INNER * x, 4), y, round(z - FORWARD * size, 4))
    far = LENGTH * (x - joint[0])
    low, high = sorted((0.0, far))
    box = Box(
        low_m=(round(low, 4), -HALF_HEIGHT * size, -HALF_DEPTH * size),
        high_m=(round(high, 4), HALF_HEIGHT * size, HALF_DEPTH * size),
    )
    return Part(
        name=f"{side}_clavicle",
        parent=arm.parent,
        joint_m=joint,
        shape=box,
        limits_deg=_limits(side),
    )


def _limits(side: str) -> Limits:
    """A shoulder rises with a positive turn about z on the right, with a negative one on the
    left."""
    rising = (-SINKS, RISES) if side == "right" else (-RISES, SINKS)
    return {"x": (-GIVES, GIVES), "y": (-SWINGS, SWINGS), "z": rising}


def _part(body: Body, name: str) -> Part | None:
    return next((part for part in body.parts if part.name == name), None)


THINNER = 0.7
"""Width of a new part over that of the part it hangs on."""


def with_new_part(body: Body, parent: str, name: str) -> Body:
    """The body with one more part: a cylinder in line with its parent, from the parent's far end
    on, as long and thinner. It turns in every way, and so it is tracked.

    BodyError where there is no such parent, or the name is taken.
    """
    _require_new(body, name)
    part = body.parts[body.index(parent)]
    start, end = part.shape.span_y
    shape = Cylinder(
        start_m=0.0,
        end_m=end - start,
        radius_m=THINNER * part.shape.width_m / 2,
    )
    new = Part(name=name, parent=parent, joint_m=(0.0, end, 0.0), shape=shape, tracked=ROTATIONS)
    return body.replaced((*body.parts, new))


def without_part(body: Body, name: str) -> Body:
    """The body without a part and all that hangs on it.

    BodyError where there is no such part, and where none would be left.
    """
    gone = {body.parts[body.index(name)].name}
    for part in body.parts:
        if part.parent in gone:
            gone.add(part.name)
    left = tuple(part for part in body.parts if part.name not in gone)
    if not left:
        raise BodyError("A body needs one part at least.")
    pairs = tuple(pair for pair in body.mirror_pairs if not gone & set(pair))
    return Body(**{**dict(body), "parts": left, "mirror_pairs": pairs})


def with_renamed_part(body: Body, old: str, new: str) -> Body:
    """The body with another name of a part; BodyError where there is none, or the name is taken."""
    body.index(old)
    _require_new(body, new)

    def named(name: str | None) -> str | None:
        return new if name == old else name

    parts = [
        part.model_copy(update={"name": named(part.name), "parent": named(part.parent)})
        for part in body.parts
    ]
    pairs = [[named(name) for name in pair] for pair in body.mirror_pairs]
    return Body.model_validate({**dict(body), "parts": parts, "mirror_pairs": pairs})


def _require_new(body: Body, name: str) -> None:
    if name in body.names:
        raise BodyError(f"There is a part {name!r} already; every part needs a name of its own.")


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


def unscaled(body: Body, others: Iterable[Body]) -> Body | None:
    """Which of other bodies this one is, scaled evenly at most; None where it is none of them."""
    for candidate in others:
        if body.names == candidate.names:
            same_height = scaled(candidate, height(body) / height(candidate))
            if _is_alike(body.model_dump(), same_height.model_dump()):
                return candidate
    return None


def _is_alike(first: Any, second: Any) -> bool:
    """Whether all is equal but for rounding."""
    if isinstance(first, float) and isinstance(second, float):
        return math.isclose(first, second, rel_tol=ROUNDING, abs_tol=ROUNDING)
    if isinstance(first, dict) and isinstance(second, dict):
        return first.keys() == second.keys() and all(_is_alike(first[k], second[k]) for k in first)
    if isinstance(first, list | tuple) and isinstance(second, list | tuple):
        return len(first) == len(second) and all(map(_is_alike, first, second))
    return bool(first == second)


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
