"""Copy and paste a pose or several keyframes: between frames, sessions and bodies.

As text on a clipboard they are JSON; frames are counted from the first of them, in whose camera's
frame all poses are. Parts are matched by their names. Before a camera that moves they come back, in
the film that they are of, to where they stand in the world; in another one to where they are seen.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Literal, Self, TypeAlias

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from keypose.app.editor.documents import (
    ActionRefused,
    keyframe_of,
    posed,
    require_before_camera,
    require_within_reach,
    softened,
)
from keypose.app.editor.frames import carried_pose
from keypose.app.editor.keyframes import require_free, with_keyframes_placed
from keypose.app.editor.message import Edit, Look, PoseName
from keypose.app.editor.shown import find, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import mirror_pose
from keypose.tracker.body.body import Name
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import rotation_from_quaternion
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
    def keys_of(cls, state: EditorState, keyframes: Sequence[Keyframe]) -> Self:
        """Copy keyframes, in the order of their frames; of a single one its pose."""
        if len(keyframes) > MOST_KEYS:
            raise ActionRefused(f"At most {MOST_KEYS} keyframes can be copied at a time.")
        skeleton, first = state.skeleton, keyframes[0].frame
        keys = tuple(
            _key(
                skeleton,
                carried_pose(state.doc, k.frame, k.pose(skeleton), first),
                k.frame - first,
                k.soft,
            )
            for k in keyframes
        )
        kind: Literal["pose", "keyframes"] = "pose" if len(keys) == 1 else "keyframes"
        return cls(keypose=kind, body=skeleton.body.name, keys=keys).of_frame(state, first)

    def of_frame(self, state: EditorState, frame: int) -> Self:
        """The same with where it is from, where the camera moves."""
        if state.doc.camera_path is None:
            return self
        film = state.doc.view.video.fingerprint
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


class CopyPose(Look):
    """These keyframes, or the pose shown at the present frame."""

    do: Literal["copy_pose"] = "copy_pose"
    frames: Annotated[tuple[FrameIndex, ...], Field(max_length=10_000)] = ()

    def after(self, state: EditorState) -> EditorState:
        return replace(state, clipboard=copied_from(state, self.frames))


def copied_from(state: EditorState, frames: Collection[int]) -> Copied:
    """The keyframes at some frames; of none the pose shown at the present frame."""
    if not frames:
        copied = Copied.pose_of(state.skeleton, shown_pose(state).pose)
        return copied.of_frame(state, state.frame)
    found = [find(state.doc.subject.keyframes, frame) for frame in sorted(set(frames))]
    keyframes = [keyframe for keyframe in found if keyframe is not None]
    if len(keyframes) < len(found):
        raise ActionRefused("One of these frames is not a keyframe any more.")
    return Copied.keys_of(state, keyframes)


class PastePose(Edit):
    """What was copied: a pose here, keyframes from here on.

    copied: from elsewhere; left out, what was copied in this session.  onto_body: the first pose
    stands where the body does, not where it was copied.  replace: keyframes that are in the way.
    name: of a pose of the library.
    """

    do: Literal["paste_pose"] = "paste_pose"
    mirrored: bool = False
    copied: Copied | None = None
    onto_body: bool = False
    replace: bool = False
    name: PoseName | None = None

    def apply(self, state: EditorState) -> Session:
        copied = self._copied(state)
        poses = pasted_poses(state, copied, mirrored=self.mirrored, onto_body=self.onto_body)
        if copied.keypose == "pose":
            return posed(state.doc, state.skeleton, poses[0], state.frame, state.times_s)
        frames = [state.frame + key.after for key in copied.keys]
        _require_room(state, frames[-1] - frames[0])
        stay = state.doc.subject.keyframes
        if self.replace:
            stay = tuple(keyframe for keyframe in stay if keyframe.frame not in set(frames))
        else:
            require_free((*stay, *state.doc.subject.part_keyframes), frames)
        placed = []
        for key, pose, frame in zip(copied.keys, poses, frames, strict=True):
            pose = carried_pose(state.doc, state.frame, pose, frame)
            require_before_camera(state.skeleton, pose)
            keyframe = keyframe_of(state.skeleton, pose, frame, state.times_s)
            placed.append(softened(keyframe, key.soft))
        return with_keyframes_placed(state.doc, stay, placed)

    def label(self, state: EditorState) -> str:
        copied = self._copied(state)
        if copied.keypose == "pose":
            return "paste the pose" if self.name is None else f"insert the pose {self.name}"
        return f"paste {len(copied.keys)} keyframes"

    def _copied(self, state: EditorState) -> Copied:
        copied = self.copied or state.clipboard
        if copied is None:
            raise ActionRefused("Copy a pose first (Ctrl C).")
        return copied


MESSAGES = (CopyPose, PastePose)


def _require_room(state: EditorState, span: int) -> None:
    last = state.frame_count - 1
    if span > last:
        raise ActionRefused(
            f"The copied keyframes span {span + 1} frames, this video has {last + 1}."
        )
    if state.frame + span > last:
        raise ActionRefused(
            f"The copied keyframes would reach frame {state.frame + span}, the video ends at "
            f"{last}. Go to frame {last - span} or earlier."
        )


def pasted_poses(
    state: EditorState, copied: Copied, *, mirrored: bool, onto_body: bool
) -> list[Pose]:
    """The poses of what was copied, for this body, in the frame of the camera at the present frame.
    Parts that were not copied stand as they do in the present pose.

    onto_body: the first pose stands where the present one does, the others beside it as copied.
    """
    skeleton, doc, here = state.skeleton, state.doc, shown_pose(state).pose
    there = copied.frame_in(doc)
    there = state.frame if there is None else there
    present = carried_pose(doc, state.frame, here, there)
    if not any(name in skeleton.body.names for name in copied.keys[0].rotations_wxyz):
        raise ActionRefused(
            f"{_whose(copied)} has no part that this body has, so nothing was pasted."
        )
    poses = [_pose(skeleton, key, present) for key in copied.keys]
    if mirrored:
        poses = [mirror_pose(skeleton, pose) for pose in poses]
    poses = [carried_pose(doc, there, pose, state.frame) for pose in poses]
    if not onto_body:
        return poses
    shift = here.p_camera_root - poses[0].p_camera_root
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
