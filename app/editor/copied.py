"""A pose or several keyframes as they are copied: between frames, sessions and bodies.

As text on a clipboard they are JSON; frames are counted from the first of them. Parts are matched
by their names.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Literal, Self, TypeAlias

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from keypose.app.editor.documents import ActionRefused
from keypose.app.posing import mirror_pose
from keypose.tracker.body.body import Name
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import rotation_from_quaternion
from keypose.tracker.session.keyframe import Keyframe, Quaternion
from keypose.tracker.session.settings import FrameIndex, Position

MOST_KEYS = 500
MOST_PARTS = 1000
DIGITS = 9
"""Decimals in the text: far below what a joint can be posed to."""

Turns: TypeAlias = Annotated[dict[Name, Quaternion], Field(min_length=1, max_length=MOST_PARTS)]


class CopiedKey(BaseModel):
    """One pose. after: frames after the first.  root_m: in the camera frame, metres."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    after: FrameIndex = 0
    root_m: Position
    rotations_wxyz: Turns
    soft: bool = False

    @field_validator("rotations_wxyz")
    @classmethod
    def _are_rotations(cls, rotations: dict[str, Quaternion]) -> dict[str, Quaternion]:
        for name, q in rotations.items():
            if abs(math.hypot(*q) - 1.0) > 1e-3:
                raise ValueError(f"the rotation of {name!r} is not a unit quaternion [w, x, y, z]")
        return rotations

    @field_validator("root_m")
    @classmethod
    def _is_within_reach(cls, root_m: Position) -> Position:
        if max(map(abs, root_m)) > 1e4:
            raise ValueError("the root lies farther than 10 km away")
        return root_m


class Copied(BaseModel):
    """What was copied. keypose: a pose goes to one frame and need not be a keyframe there."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    keypose: Literal["pose", "keyframes"]
    version: Literal[1] = 1
    body: Annotated[str, Field(max_length=200)] = ""
    keys: Annotated[tuple[CopiedKey, ...], Field(min_length=1, max_length=MOST_KEYS)]

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        after = [key.after for key in self.keys]
        if after[0] != 0 or any(a >= b for a, b in pairwise(after)):
            raise ValueError("the copied frames must ascend from 0")
        if self.keypose == "pose" and len(after) > 1:
            raise ValueError("a copied pose is one pose")
        return self

    @classmethod
    def pose_of(cls, skeleton: Skeleton, pose: Pose) -> Self:
        """Copy one pose."""
        return cls(keypose="pose", body=skeleton.body.name, keys=(_key(skeleton, pose, 0, False),))

    @classmethod
    def keys_of(cls, skeleton: Skeleton, keyframes: Sequence[Keyframe]) -> Self:
        """Copy keyframes, in the order of their frames; of a single one its pose."""
        if len(keyframes) > MOST_KEYS:
            raise ActionRefused(f"At most {MOST_KEYS} keyframes can be copied at a time.")
        first = keyframes[0].frame
        keys = tuple(_key(skeleton, k.pose(skeleton), k.frame - first, k.soft) for k in keyframes)
        return cls(
            keypose="pose" if len(keys) == 1 else "keyframes", body=skeleton.body.name, keys=keys
        )

    @property
    def text(self) -> str:
        """Return the text that stands on a clipboard."""
        keys = tuple(key.model_copy(update=_rounded(key)) for key in self.keys)
        return self.model_copy(update={"keys": keys}).model_dump_json()


def pasted_poses(
    skeleton: Skeleton, copied: Copied, present: Pose, *, mirrored: bool, onto_body: bool
) -> list[Pose]:
    """The poses of what was copied, for this body. Parts that were not copied stand as they do in
    the present pose.

    onto_body: the first pose stands where the present one does, the others beside it as copied.
    """
    if not any(name in skeleton.body.names for name in copied.keys[0].rotations_wxyz):
        raise ActionRefused(
            f"{_whose(copied)} has no part that this body has, so nothing was pasted."
        )
    poses = [_pose(skeleton, key, present) for key in copied.keys]
    if mirrored:
        poses = [mirror_pose(skeleton, pose) for pose in poses]
    if not onto_body:
        return poses
    shift = present.p_camera_root - poses[0].p_camera_root
    return [Pose(pose.Rs_parent_part, pose.p_camera_root + shift) for pose in poses]


def _whose(copied: Copied) -> str:
    return f"The copied body, {copied.body}," if copied.body else "The copied body"


def _pose(skeleton: Skeleton, key: CopiedKey, present: Pose) -> Pose:
    Rs = present.Rs_parent_part.copy()
    for index, name in enumerate(skeleton.body.names):
        if name in key.rotations_wxyz:
            q = np.array(key.rotations_wxyz[name])
            Rs[index] = rotation_from_quaternion(q / np.linalg.norm(q))
    return Pose(Rs, np.array(key.root_m))


def _key(skeleton: Skeleton, pose: Pose, after: int, soft: bool) -> CopiedKey:
    whole = Keyframe.of(skeleton, pose, 0, 0.0)
    return CopiedKey(
        after=after, root_m=whole.root_m, rotations_wxyz=whole.rotations_wxyz, soft=soft
    )


def _rounded(key: CopiedKey) -> dict[str, object]:
    return {
        "root_m": tuple(round(v, DIGITS) for v in key.root_m),
        "rotations_wxyz": {
            name: tuple(round(v, DIGITS) for v in q) for name, q in key.rotations_wxyz.items()
        },
    }
