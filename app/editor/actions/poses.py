"""Poses that are copied, pasted and kept."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, StringConstraints

from keypose.app.editor.actions.message import Edit, Message
from keypose.app.editor.copied import Copied
from keypose.tracker.session.settings import FrameIndex

PoseName: TypeAlias = Annotated[
    str,
    StringConstraints(
        strip_whitespace=True, min_length=1, max_length=60, pattern=r"^[^\x00-\x1f]+$"
    ),
]
PoseId: TypeAlias = Annotated[str, Field(pattern=r"^[0-9a-f]{12}$")]


class CopyPose(Message):
    """These keyframes, or the pose shown at the present frame."""

    do: Literal["copy_pose"] = "copy_pose"
    frames: Annotated[tuple[FrameIndex, ...], Field(max_length=10_000)] = ()


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


class KeepPose(Message):
    """The pose shown here is kept under a name, for every session."""

    do: Literal["keep_pose"] = "keep_pose"
    name: PoseName


class RenamePose(Message):
    do: Literal["rename_pose"] = "rename_pose"
    id: PoseId
    name: PoseName


class DeletePose(Message):
    """A kept pose is deleted; RestorePose has it back."""

    do: Literal["delete_pose"] = "delete_pose"
    id: PoseId


class RestorePose(Message):
    do: Literal["restore_pose"] = "restore_pose"
    id: PoseId


class InsertPose(Message):
    """A kept pose becomes that of the present frame, where the body stands."""

    do: Literal["insert_pose"] = "insert_pose"
    id: PoseId
    mirrored: bool = False


PoseKeeping: TypeAlias = KeepPose | RenamePose | DeletePose | RestorePose
"""What the store does with the kept poses."""
