"""Where on an animal's body the keypoints are that networks of animals know, AP-10K's."""

from __future__ import annotations

from typing import Final

import numpy as np

from keypose.tracker.body.body import Body, Part, Point
from keypose.tracker.keypoints.layouts import AP_10K
from keypose.tracker.keypoints.on_body import PointsOnBody

ANIMAL_POINTS: Final = AP_10K
"""The names of an animal's keypoints, in the order of its networks."""
EYE: Final = (0.8, 0.5, 0.4)
"""Estimate: where an eye is on a head: shares of its half width, of its height above the joint, and
of the way to the nose."""
_LEGS: Final = {
    "shoulder": ("front", "upper_leg"),
    "elbow": ("front", "lower_leg"),
    "hip": ("hind", "upper_leg"),
    "knee": ("hind", "lower_leg"),
}
"""By keypoint the part of a leg that begins there."""
_ENDS: Final = {"front_paw": "front", "back_paw": "hind"}
_ON_TRUNK: Final = {"neck": "neck", "tail_root": "tail"}


def points_on_animal(body: Body) -> PointsOnBody:
    """The places of `ANIMAL_POINTS` on a body with the parts of a dog or a horse: none on another.

    A joint lies on the part nearer to the trunk, where the next part begins. What an animal ends
    in, a paw or a hoof, is the only landmark of the leg's lower part.
    """
    located = [
        (index, *at) for index, name in enumerate(ANIMAL_POINTS) if (at := _place(body, name))
    ]
    return PointsOnBody(
        np.array([index for index, _, _ in located], dtype=np.int64),
        np.array([part for _, part, _ in located], dtype=np.int64),
        np.array([point for _, _, point in located], dtype=np.float64).reshape(-1, 3),
    )


def is_animals(body: Body) -> bool:
    """Whether all of an animal's keypoints are on a body."""
    return len(points_on_animal(body).indices) == len(ANIMAL_POINTS)


def _place(body: Body, name: str) -> tuple[int, Point] | None:
    """The part that carries a keypoint, and where; None on a body without it."""
    if name == "nose" or name.endswith("_eye"):
        return _on_head(body, name)
    if name in _ON_TRUNK:
        return _beginning(body, _ON_TRUNK[name])
    side, _, joint = name.partition("_")
    if joint in _ENDS:
        lower = f"{side}_{_ENDS[joint]}_lower_leg"
        if lower not in body.names:
            return None
        index = body.index(lower)
        ends = tuple(body.parts[index].landmarks.values())
        return (index, ends[0]) if len(ends) == 1 else None
    leg, half = _LEGS[joint]
    return _beginning(body, f"{side}_{leg}_{half}")


def _beginning(body: Body, name: str) -> tuple[int, Point] | None:
    """Where a part begins, on its parent."""
    part = _part(body, name)
    if part is None or part.parent is None:
        return None
    return body.index(part.parent), part.joint_m


def _on_head(body: Body, name: str) -> tuple[int, Point] | None:
    head = _part(body, "head")
    nose = None if head is None else head.landmarks.get("nose")
    if head is None or nose is None:
        return None
    index = body.index("head")
    if name == "nose":
        return index, nose
    aside, up, forward = EYE
    wide, _ = head.shape.half_widths(0.0)
    top = min(head.shape.span_y)
    sideways = 1.0 if name.startswith("left_") else -1.0
    return index, (sideways * aside * wide, up * top, forward * nose[2])


def _part(body: Body, name: str) -> Part | None:
    return body.parts[body.index(name)] if name in body.names else None
