"""Change keyframes, of the whole body and of parts, notes, reviews and keypoints."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from keypose.app.editor.actions.message import Degrees, Edit, Spot
from keypose.tracker.body.body import Name
from keypose.tracker.session.annotations import LONGEST
from keypose.tracker.session.settings import FrameIndex

Axis: TypeAlias = Literal["x", "y", "z"]
NoteText: TypeAlias = Annotated[str, Field(max_length=LONGEST)]
Frames: TypeAlias = Annotated[tuple[FrameIndex, ...], Field(min_length=1, max_length=10_000)]


class AddKey(Edit):
    """The pose shown at a frame becomes its keyframe; where it is already, nothing changes."""

    do: Literal["add_key"] = "add_key"
    frame: FrameIndex


class DeleteKey(Edit):
    """The keyframe of a frame, or its part keyframe; the same for the next two."""

    do: Literal["delete_key"] = "delete_key"
    frame: FrameIndex


class DeleteDraft(Edit):
    """The draft of a frame: shown there again is what is tracked, or lies between keyframes."""

    do: Literal["delete_draft"] = "delete_draft"
    frame: FrameIndex


class MoveKey(Edit):
    do: Literal["move_key"] = "move_key"
    frame: FrameIndex
    to: FrameIndex


class DuplicateKey(Edit):
    do: Literal["duplicate_key"] = "duplicate_key"
    frame: FrameIndex
    to: FrameIndex


class KeyParts(Edit):
    """Limbs as they are shown at a frame become its part keyframe: those of these parts; left out,
    those that were posed there, else the selected part's."""

    do: Literal["key_parts"] = "key_parts"
    frame: FrameIndex
    parts: Annotated[tuple[Name, ...], Field(max_length=1000)] = ()


class UnkeyParts(Edit):
    """The limbs of these parts are tracked at a frame again."""

    do: Literal["unkey_parts"] = "unkey_parts"
    frame: FrameIndex
    parts: Annotated[tuple[Name, ...], Field(min_length=1, max_length=1000)]


class DeleteKeys(Edit):
    do: Literal["delete_keys"] = "delete_keys"
    frames: Frames


class RetimeKeys(Edit):
    """Several keyframes at other frames, one for each, in the same order: moved or stretched.
    copy_them: they stay where they are, too."""

    do: Literal["retime_keys"] = "retime_keys"
    frames: Frames
    to: Frames
    copy_them: bool = False

    @model_validator(mode="after")
    def _one_for_each(self) -> Self:
        if len(self.frames) != len(self.to):
            raise ValueError("give one frame for each keyframe")
        for frames in (self.frames, self.to):
            if any(a >= b for a, b in pairwise(frames)):
                raise ValueError("give frames in ascending order, each once")
        return self

    @property
    def is_shift(self) -> bool:
        """Return whether all of them move by as much."""
        return len({b - a for a, b in zip(self.frames, self.to, strict=True)}) == 1


class KeyAngle(Edit):
    """One angle of a part at some keyframe: a point of the curve, dragged."""

    do: Literal["key_angle"] = "key_angle"
    frame: FrameIndex
    part: Name
    axis: Axis
    deg: Degrees


class SoftenKey(Edit):
    """The motion need only come near a keyframe."""

    do: Literal["soften_key"] = "soften_key"
    frame: FrameIndex


class SoftenKeys(Edit):
    """The motion need only come near some keyframes, such as those that pins contradict."""

    do: Literal["soften_keys"] = "soften_keys"
    frames: Frames


class ExactKey(Edit):
    """The motion meets a keyframe exactly, as it does unless it was softened."""

    do: Literal["exact_key"] = "exact_key"
    frame: FrameIndex


class SetNote(Edit):
    """A note at a frame, or other words for the one that is there; empty for a mere flag."""

    do: Literal["set_note"] = "set_note"
    frame: FrameIndex
    text: NoteText = ""


class MoveNote(Edit):
    """A note at another frame, where there is none yet."""

    do: Literal["move_note"] = "move_note"
    frame: FrameIndex
    to: FrameIndex


class DeleteNote(Edit):
    do: Literal["delete_note"] = "delete_note"
    frame: FrameIndex


Keying: TypeAlias = (
    AddKey
    | DeleteKey
    | DeleteDraft
    | MoveKey
    | DuplicateKey
    | DeleteKeys
    | RetimeKeys
    | KeyParts
    | UnkeyParts
    | KeyAngle
    | SoftenKey
    | SoftenKeys
    | ExactKey
)
Noting: TypeAlias = SetNote | MoveNote | DeleteNote


class AcceptPlace(Edit):
    """The motion is right at this place to review: of a part, or of the whole body."""

    do: Literal["accept_place"] = "accept_place"
    frame: FrameIndex
    part: Name | None = None


class CannotTell(Edit):
    """Whether it is right there nobody can tell from the picture."""

    do: Literal["cannot_tell"] = "cannot_tell"
    frame: FrameIndex
    part: Name | None = None


class CorrectKeypoint(Edit):
    """Where a joint is seen in a frame. at: pixels of the main view."""

    do: Literal["correct_keypoint"] = "correct_keypoint"
    frame: FrameIndex
    joint: Name
    at: Spot


class IgnoreKeypoint(Edit):
    """What was found of a joint in a frame does not count."""

    do: Literal["ignore_keypoint"] = "ignore_keypoint"
    frame: FrameIndex
    joint: Name


class RestoreKeypoint(Edit):
    """A joint is where it was found in a frame."""

    do: Literal["restore_keypoint"] = "restore_keypoint"
    frame: FrameIndex
    joint: Name


Reviewing: TypeAlias = AcceptPlace | CannotTell
Seeing: TypeAlias = CorrectKeypoint | IgnoreKeypoint | RestoreKeypoint
