"""Clavicles for a person's body: a part between chest and upper arm, so that shoulders can move.

A shoulder is no fixed point of the chest: shrugging and reaching carry it up and forward by several
centimetres. The part turns about its inner end beside the breastbone, up and down about z, forward
and back about y, within limits. In the rest pose shoulders are where they were, so that a pose of
the body without is the same pose of the body with them.

Brightness does not track it: it lies inside the chest, and two motions more that the picture hardly
shows made trunk and arms worse on real film. Keyframes turn it, and where keypoints are evidence
the shoulder's does.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.body.body import Body, Limits, Part, Point
from keypose.tracker.body.shapes import Box

INNER, FORWARD = 0.15, 0.03
"""Where the inner end is, estimated: this share of the way from the middle of the chest to the
shoulder, at its height, and so many metres before it, by an upper arm's length of 30 cm."""

RISES, SINKS, SWINGS, GIVES = 40.0, 10.0, 25.0, 10.0
"""Degrees that it rises and sinks, swings forward and back, and turns about its own length: what
textbooks give for the joint at the breastbone, rounded."""

HALF_HEIGHT, HALF_DEPTH, LENGTH = 0.02, 0.025, 0.9
"""Its shape, over an upper arm of 30 cm; it ends at this share of the way to the shoulder."""

ARM_M = 0.3
SIDES = ("left", "right")


def can_have_clavicles(body: Body) -> bool:
    """Return whether both upper arms hang on one chest, and none is there yet."""
    arms = [_part(body, f"{side}_upper_arm") for side in SIDES]
    chests = {arm.parent for arm in arms if arm is not None}
    names = {f"{side}_clavicle" for side in SIDES} & set(body.names)
    return None not in arms and chests == {"chest"} and not names


def has_clavicles(body: Body) -> bool:
    """Return whether both upper arms hang on a clavicle."""
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
        name=f"{side}_clavicle", parent=arm.parent, joint_m=joint, shape=box,
        limits_deg=_limits(side),
    )  # fmt: skip


def _limits(side: str) -> Limits:
    """A shoulder rises with a positive turn about z on the right, with a negative one on the
    left."""
    rising = (-SINKS, RISES) if side == "right" else (-RISES, SINKS)
    return {"x": (-GIVES, GIVES), "y": (-SWINGS, SWINGS), "z": rising}


def _part(body: Body, name: str) -> Part | None:
    return next((part for part in body.parts if part.name == name), None)
