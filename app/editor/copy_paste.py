"""Copy a pose or several keyframes, and paste them.

Parts are matched by their names. Before a camera that moves poses come back, in the film that they
are of, to where they stand in the world; in another one to where they are seen.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from keypose.app.editor.copied import Copied, CopiedKey
from keypose.app.editor.documents import (
    ActionRefused,
    keyframe_of,
    posed,
    require_before_camera,
    softened,
)
from keypose.app.editor.keyframes import require_free, with_keyframes_placed
from keypose.app.editor.message import Edit, Look, PoseName
from keypose.app.editor.shown import find, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import mirror_pose
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import rotation_from_quaternion
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import FrameIndex


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
        return copied.of_frame(state.doc, state.frame)
    at_frames = [find(state.doc.subject.keyframes, frame) for frame in sorted(set(frames))]
    keyframes = [keyframe for keyframe in at_frames if keyframe is not None]
    if len(keyframes) < len(at_frames):
        raise ActionRefused("One of these frames is not a keyframe any more.")
    return Copied.keys_of(state.doc, state.skeleton, keyframes)


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
            pose = state.doc.film_camera.pose_seen_at(frame, state.frame, pose)
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
    present = doc.film_camera.pose_seen_at(there, state.frame, here)
    if not any(name in skeleton.body.names for name in copied.keys[0].rotations_wxyz):
        raise ActionRefused(
            f"{_whose(copied)} has no part that this body has, so nothing was pasted."
        )
    poses = [_pose(skeleton, key, present) for key in copied.keys]
    if mirrored:
        poses = [mirror_pose(skeleton, pose) for pose in poses]
    poses = [doc.film_camera.pose_seen_at(state.frame, there, pose) for pose in poses]
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
