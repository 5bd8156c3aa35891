"""A copied pose, or copied keyframes: between frames, sessions and bodies.

As text on a clipboard they are JSON; frames are counted from the first of them, in whose camera's
frame all poses are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from keypose.app.editor.documents import ActionRefused, require_within_reach
from keypose.tracker.body.body import Name
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session.keyframe import Keyframe, Quaternion, Softness
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import FrameIndex, Position

MOST_KEYS = 500
MOST_PARTS = 1000
DIGITS = 9
"""Decimals in the text: far below what a joint can be posed to."""

Turns: TypeAlias = Annotated[dict[Name, Quaternion], Field(min_length=1, max_length=MOST_PARTS)]


class CopiedKey(BaseModel):
    """One pose. after: frames after the first.  root_m: in the frame of the camera at the first,
    metres."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    after: FrameIndex = 0
    root_m: Position
    rotations_wxyz: Turns
    soft: Softness = False

    @field_validator("rotations_wxyz")
    @classmethod
    def _are_rotations(cls, rotations: dict[str, Quaternion]) -> dict[str, Quaternion]:
        for name, q in rotations.items():
            if abs(math.hypot(*q) - 1.0) > 1e-3:
                raise ValueError(f"the rotation of {name!r} is not a unit quaternion [w, x, y, z]")
        return rotations


class Copied(BaseModel):
    """What was copied. keypose: a pose goes to one frame and need not be a keyframe there.

    frame, film: the first one's, and the fingerprint of its film, before a camera that moves.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    keypose: Literal["pose", "keyframes"]
    version: Literal[1] = 1
    body: Annotated[str, Field(max_length=200)] = ""
    film: Annotated[str, Field(max_length=200)] = ""
    frame: FrameIndex | None = None
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
    def keys_of(cls, doc: Session, skeleton: Skeleton, keyframes: Sequence[Keyframe]) -> Self:
        """Copy a document's keyframes, in the order of their frames; of a single one its pose."""
        if len(keyframes) > MOST_KEYS:
            raise ActionRefused(f"At most {MOST_KEYS} keyframes can be copied at a time.")
        first = keyframes[0].frame
        keys = tuple(
            _key(
                skeleton,
                doc.film_camera.pose_seen_at(first, k.frame, k.pose(skeleton)),
                k.frame - first,
                k.soft,
            )
            for k in keyframes
        )
        kind: Literal["pose", "keyframes"] = "pose" if len(keys) == 1 else "keyframes"
        return cls(keypose=kind, body=skeleton.body.name, keys=keys).of_frame(doc, first)

    def of_frame(self, doc: Session, frame: int) -> Self:
        """The same with where it is from, where the camera of its document moves."""
        if doc.camera_path is None:
            return self
        film = doc.view.video.fingerprint
        return self.model_copy(update={"film": film, "frame": frame})

    def frame_in(self, doc: Session) -> int | None:
        """At which frame of a session's film it was copied; None where of another one."""
        frame = self.frame if self.film == doc.view.video.fingerprint else None
        return frame if frame is None or frame < doc.view.video.frame_count else None

    @property
    def text(self) -> str:
        """The text that stands on a clipboard."""
        keys = tuple(key.model_copy(update=_rounded(key)) for key in self.keys)
        unsaid = {"film", "frame"} if self.frame is None else None
        return self.model_copy(update={"keys": keys}).model_dump_json(exclude=unsaid)


def _key(skeleton: Skeleton, pose: Pose, after: int, soft: Softness) -> CopiedKey:
    require_within_reach(pose)
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
