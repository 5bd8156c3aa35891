"""Keyframes: poses that a person set, as plain numbers."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from typing import Annotated, Literal, TypeAlias

import numpy as np
from pydantic import Field, FiniteFloat, field_validator

from keypose.tracker.body.body import Name
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import quaternion_wxyz, rotation_from_quaternion
from keypose.tracker.session.settings import FrameIndex, Plain, Position

Quaternion: TypeAlias = tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]
Seconds: TypeAlias = Annotated[FiniteFloat, Field(ge=0, le=1e7)]

Softness: TypeAlias = bool | Literal["depth"]
"""How far the motion in space may leave a keyframe: not at all, somewhat, or in depth alone."""

AT_REST: Quaternion = (1.0, 0.0, 0.0, 0.0)


class Keyframe(Plain):
    """A pose that a person set at one frame. It is never changed by tracking."""

    frame: FrameIndex
    time_s: Seconds = Field(description="Time of the frame from the video's first, seconds.")
    root_m: Position = Field(description="The root part's origin in the camera frame, metres.")
    rotations_wxyz: dict[Name, Quaternion] = Field(
        description="Each part's rotation in its parent's frame; parts left out are at rest."
    )
    soft: Softness = Field(
        default=False,
        exclude_if=operator.not_,
        description="The motion need only come near it: mostly its depth gives way to pins and "
        "smoothness. depth: in the picture it is met exactly. Left out where it is met exactly in "
        "space.",
    )
    followed: bool = Field(
        default=False,
        exclude_if=operator.not_,
        description="Of a draft: found by tracking ahead, and not changed by a person since. Left "
        "out otherwise.",
    )
    drafted: bool = Field(
        default=False,
        exclude_if=operator.not_,
        description="Of a draft, and of a keyframe made of one as it was: found by drafting the "
        "film, not posed by a person since. Left out otherwise.",
    )

    @property
    def is_found(self) -> bool:
        """Whether it is as it was found in the film: tracking replaces such a draft."""
        return self.followed or self.drafted

    @field_validator("rotations_wxyz")
    @classmethod
    def _are_rotations(cls, rotations: dict[str, Quaternion]) -> dict[str, Quaternion]:
        for name, q in rotations.items():
            if abs(math.sqrt(sum(c * c for c in q)) - 1.0) > 1e-3:
                raise ValueError(f"the rotation of {name!r} is not a unit quaternion [w, x, y, z]")
        return rotations

    @classmethod
    def of(cls, skeleton: Skeleton, pose: Pose, frame: int, time_s: float) -> Keyframe:
        """The keyframe of a pose."""
        quaternions = quaternion_wxyz(pose.Rs_parent_part)
        names = skeleton.body.names
        return cls(
            frame=frame,
            time_s=time_s,
            root_m=_triple(pose.p_camera_root),
            rotations_wxyz={n: _quad(q) for n, q in zip(names, quaternions, strict=True)},
        )

    def pose(self, skeleton: Skeleton) -> Pose:
        """The pose it holds."""
        quaternions = np.array(quaternions_of(self, skeleton.body.names))
        return Pose(rotation_from_quaternion(quaternions), np.array(self.root_m))


class PartKeyframe(Keyframe):
    """A keyframe of some parts alone: these are exact at its frame, the rest is tracked.

    Its pose is of the whole body as it stood when it was set. Its parts are seen where that pose
    has them, and as far from the root in depth; the rest of it is shown until the frame is tracked.
    """

    parts: Annotated[tuple[Name, ...], Field(min_length=1, max_length=1000)] = Field(
        description="The parts that are exact, each once; what hangs on one belongs to it."
    )


def quaternions_of(keyframe: Keyframe, names: Sequence[str]) -> list[Quaternion]:
    """The rotations of these parts, each in its parent's frame: those left out are at rest."""
    return [keyframe.rotations_wxyz.get(name, AT_REST) for name in names]


def _triple(values: np.ndarray) -> Position:
    x, y, z = (float(v) for v in values)
    return x, y, z


def _quad(values: np.ndarray) -> Quaternion:
    w, x, y, z = (float(v) for v in values)
    return w, x, y, z
