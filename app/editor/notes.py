"""Edit what is said of the motion: notes, keypoints set right, reviewed places, the title."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import numpy as np
from pydantic import Field

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.keyframes import with_key_added
from keypose.app.editor.message import Edit
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.posing.gesture import Spot
from keypose.tracker.body.body import Name
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.review.places import Place, review_of
from keypose.tracker.session.annotations import (
    LONGEST,
    Answer,
    DraftPlace,
    KeypointCorrection,
    Note,
    Reviewed,
)
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import FrameIndex, Pixel, Title

DECIMALS = 2
NoteText: TypeAlias = Annotated[str, Field(max_length=LONGEST)]


class _OfKeypoint(Edit):
    """A joint as it is seen in a frame."""

    target = "joint"
    frame: FrameIndex
    joint: Name

    def _with(self, state: EditorState, correction: KeypointCorrection | None) -> Session:
        _require_counting(state.doc, self.joint)
        place, keypoint_corrections = (self.frame, self.joint), state.doc.view.keypoint_corrections
        every = [each for each in keypoint_corrections if _frame_and_joint(each) != place]
        every += [] if correction is None else [correction]
        corrections = tuple(sorted(every, key=_frame_and_joint))
        return state.doc.changed({"keypoint_corrections": corrections})


class CorrectKeypoint(_OfKeypoint):
    """Where a joint is seen in a frame, for sure. at: pixels of the main view."""

    do: Literal["correct_keypoint"] = "correct_keypoint"
    verb = "correct the keypoint"
    at: Spot

    def apply(self, state: EditorState) -> Session:
        uv = _in_video(state.doc.film_camera.at(self.frame), self.at)
        return self._with(state, KeypointCorrection(frame=self.frame, joint=self.joint, uv=uv))


class IgnoreKeypoint(_OfKeypoint):
    """What was found of a joint in a frame does not count."""

    do: Literal["ignore_keypoint"] = "ignore_keypoint"
    verb = "ignore the keypoint"

    def apply(self, state: EditorState) -> Session:
        return self._with(state, KeypointCorrection(frame=self.frame, joint=self.joint))


class RestoreKeypoint(_OfKeypoint):
    """A joint is where it was found in a frame."""

    do: Literal["restore_keypoint"] = "restore_keypoint"
    verb = "put back the keypoint"

    def apply(self, state: EditorState) -> Session:
        return self._with(state, None)


class SetNote(Edit):
    """A note at a frame, or other words for the one that is there; empty for a mere flag."""

    do: Literal["set_note"] = "set_note"
    verb = "write the note at"
    target = "frame"
    frame: FrameIndex
    text: NoteText = ""

    def apply(self, state: EditorState) -> Session:
        note = _at(state, self.frame) or Note(frame=self.frame)
        return _with_note(state, self.frame, note.model_copy(update={"text": self.text.strip()}))


class MoveNote(Edit):
    """A note at another frame, where there is none yet."""

    do: Literal["move_note"] = "move_note"
    verb = "move the note at"
    target = "frame"
    frame: FrameIndex
    to: FrameIndex

    def apply(self, state: EditorState) -> Session:
        note, to = _require(state, self.frame), self.to
        if to == self.frame:
            return state.doc
        if _at(state, to) is not None:
            raise ActionRefused(f"Frame {to} has a note already.")
        return _with_note(state, self.frame, note.model_copy(update={"frame": to}))


class DeleteNote(Edit):
    do: Literal["delete_note"] = "delete_note"
    verb = "delete the note at"
    target = "frame"
    frame: FrameIndex

    def apply(self, state: EditorState) -> Session:
        _require(state, self.frame)
        return _with_note(state, self.frame, None)


class _OfPlace(Edit):
    """A place to review: of a part, or of the whole body."""

    target = "part"
    frame: FrameIndex
    part: Name | None = None

    def _place(self, state: EditorState) -> Place:
        for place in review_of(state.doc, state.results).places:
            if (place.frame, place.part) == (self.frame, self.part):
                return place
        raise ActionRefused(f"There is nothing left to review at frame {self.frame}.")


class AcceptPlace(_OfPlace):
    """The motion is right there: kept with what was seen. A draft becomes a keyframe."""

    do: Literal["accept_place"] = "accept_place"
    verb = "accept"

    def apply(self, state: EditorState) -> Session:
        place = self._place(state)
        if isinstance(place.why, DraftPlace):
            return with_key_added(state, place.frame)
        return _answered(state.doc, place, "accepted")


class CannotTell(_OfPlace):
    """Whether it is right there nobody can tell from the picture: it is not asked again."""

    do: Literal["cannot_tell"] = "cannot_tell"
    verb = "leave open"

    def apply(self, state: EditorState) -> Session:
        return _answered(state.doc, self._place(state), "unclear")


class Rename(Edit):
    """What a person calls the open session; empty: as its folder is called."""

    do: Literal["rename"] = "rename"
    verb = "rename"
    title: Title

    def apply(self, state: EditorState) -> Session:
        title = " ".join(self.title.split())
        if not title.isprintable():
            raise ActionRefused("A name has letters, digits and signs only.")
        return state.doc.changed({"title": title})


MESSAGES = (
    CorrectKeypoint,
    IgnoreKeypoint,
    RestoreKeypoint,
    SetNote,
    MoveNote,
    DeleteNote,
    AcceptPlace,
    CannotTell,
    Rename,
)


def _frame_and_joint(each: KeypointCorrection) -> tuple[int, str]:
    return each.frame, each.joint


def _require_counting(doc: Session, joint: str) -> None:
    """Refused where tracking has no use for such a keypoint."""
    if doc.view.surface is not None:
        raise ActionRefused("Keypoints are found in a video, not in surfaces.")
    if not len(points_on_body(doc.subject.body, [joint]).indices):
        raise ActionRefused(f"This body has no keypoint {part_label(joint).lower()}.")


def _in_video(camera: Camera, at: Pixel) -> Pixel:
    """Convert from pixels of the main view, whose lens is ideal, to those of the video."""
    spot = np.array(at)
    if camera.is_distorted:
        spot = camera.project(camera.without_distortion().back_project(spot, 1.0))
    if not np.isfinite(spot).all():
        raise ActionRefused("The lens shows nothing there.")
    u, v = spot.round(DECIMALS).tolist()
    return u, v


def _with_note(state: EditorState, instead_of: int, note: Note | None) -> Session:
    """Put this note instead of the one at a frame, sorted by frame."""
    others = [kept_note for kept_note in state.doc.notes if kept_note.frame != instead_of]
    notes = [*others, *([] if note is None else [note])]
    return state.doc.changed({"notes": tuple(sorted(notes, key=lambda n: n.frame))})


def _at(state: EditorState, frame: int) -> Note | None:
    return next((note for note in state.doc.notes if note.frame == frame), None)


def _require(state: EditorState, frame: int) -> Note:
    note = _at(state, frame)
    if note is None:
        raise ActionRefused(f"Frame {frame} has no note.")
    return note


def _answered(doc: Session, place: Place, answer: Answer) -> Session:
    """Put an answer in place of older ones about the same part and frames."""
    x, y, z = (float(value) for value in place.end_m)
    part = place.part or doc.subject.body.names[0]
    first, last = min(place.frames[0], place.frame), max(place.frames[1], place.frame)
    reviewed = Reviewed(
        part=part,
        frame=place.frame,
        first_frame=first,
        last_frame=last,
        answer=answer,
        seen_m=(x, y, z),
    )
    others = [
        old
        for old in doc.subject.reviewed
        if old.part != part or old.last_frame < first or old.first_frame > last
    ]
    return doc.changed({"reviewed": (*others, reviewed)})
