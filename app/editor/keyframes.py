"""Edit keyframes: add, delete, move, stretch, soften."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from itertools import pairwise
from typing import Literal, Self

from pydantic import model_validator

from keypose.app.editor.documents import (
    ActionRefused,
    keyframe_of,
    posed,
    require_before_camera,
    require_in_video,
    softened,
    with_drafts,
    with_keyframes,
    with_part_keyframes,
    without,
)
from keypose.app.editor.drafted import flipped_drafts, with_accepted
from keypose.app.editor.message import Degrees, Edit, Frames
from keypose.app.editor.motion import angle_curve
from keypose.app.editor.part_keyframes import require_correctable
from keypose.app.editor.shown import find, require_keyframe, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import with_angles
from keypose.app.posing.gesture import Axis
from keypose.app.words.people import flipped_place
from keypose.tracker.body.body import Name
from keypose.tracker.errors import listed
from keypose.tracker.geometry.camera_path import rigid_inverse
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import FrameIndex

MOST_NAMED = 3
"""Frames that a sentence lists one by one."""


class AddKey(Edit):
    """The pose shown at a frame becomes its keyframe; where it is already, nothing changes."""

    do: Literal["add_key"] = "add_key"
    verb = "add keyframe"
    target = "frame"
    frame: FrameIndex

    def apply(self, state: EditorState) -> Session:
        return with_key_added(state, self.frame)


def with_key_added(state: EditorState, frame: int) -> Session:
    """Make the pose shown at a frame its keyframe, unless it is that already."""
    stands = shown_pose(state, frame)
    if stands.source == "keyframe":
        return state.doc
    require_before_camera(state.skeleton, stands.pose)
    if stands.source == "draft":
        _require_sound_draft(state.doc, frame)
        return with_accepted(state.doc, {frame})
    keyframe = keyframe_of(state.skeleton, stands.pose, frame, state.times_s)
    # one as tracked gives way in depth, where the motion is smoothed in space anyway
    gives_way = stands.source == "tracked" and state.doc.settings.smooth
    keyframe = softened(keyframe, "depth" if gives_way else False)
    doc = with_keyframes(state.doc, (*without(state.doc.subject.keyframes, frame), keyframe))
    return with_drafts(doc, without(doc.subject.drafts, frame))


def _require_sound_draft(doc: Session, frame: int) -> None:
    """Refused where a limb of the draft is known to be wrong and nobody has posed it since."""
    for run in flipped_drafts(doc):
        if run.first_frame <= frame <= run.last_frame:
            raise ActionRefused(
                f"This draft is wrong ({flipped_place(run)}): drag the limb into place before you "
                "key it."
            )


class DeleteKey(Edit):
    """The keyframe of a frame, or its part keyframe; the same for the next two."""

    do: Literal["delete_key"] = "delete_key"
    verb = "delete keyframe"
    target = "frame"
    frame: FrameIndex

    def apply(self, state: EditorState) -> Session:
        return _without(state.doc, _require(state, self.frame))


class MoveKey(Edit):
    do: Literal["move_key"] = "move_key"
    verb = "move keyframe"
    target = "frame"
    frame: FrameIndex
    to: FrameIndex

    def apply(self, state: EditorState) -> Session:
        to = self.to
        if to == self.frame:
            return state.doc
        keyframe = _require(state, self.frame)
        doc = _keyed(state, _without(state.doc, keyframe), keyframe, to)
        if isinstance(keyframe, PartKeyframe):
            return doc
        return doc.changed(doc.evidence.with_key_moved(self.frame, to))


class DuplicateKey(Edit):
    do: Literal["duplicate_key"] = "duplicate_key"
    verb = "duplicate keyframe"
    target = "frame"
    frame: FrameIndex
    to: FrameIndex

    def apply(self, state: EditorState) -> Session:
        return _keyed(state, state.doc, _require(state, self.frame), self.to)


class DeleteDraft(Edit):
    """The draft of a frame: shown there again is what is tracked, or lies between keyframes."""

    do: Literal["delete_draft"] = "delete_draft"
    verb = "delete draft"
    target = "frame"
    frame: FrameIndex

    def apply(self, state: EditorState) -> Session:
        if find(state.doc.subject.drafts, self.frame) is None:
            raise ActionRefused(f"Frame {self.frame} has no draft.")
        return with_drafts(state.doc, without(state.doc.subject.drafts, self.frame))


class DeleteKeys(Edit):
    do: Literal["delete_keys"] = "delete_keys"
    frames: Frames

    def apply(self, state: EditorState) -> Session:
        gone = _require_all(state, self.frames)
        return with_keyframes(
            state.doc, [k for k in state.doc.subject.keyframes if k.frame not in gone]
        )

    def label(self, state: EditorState) -> str:
        return f"delete {_count(self.frames)}"


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

    def apply(self, state: EditorState) -> Session:
        if self.frames == self.to:
            return state.doc
        taken = _require_all(state, self.frames)
        stay = [k for k in state.doc.subject.keyframes if self.copy_them or k.frame not in taken]
        require_free((*stay, *state.doc.subject.part_keyframes), self.to)
        placed = [_at_frame(state, taken[a], b) for a, b in zip(self.frames, self.to, strict=True)]
        doc = with_keyframes_placed(state.doc, stay, placed)
        if self.copy_them:
            return doc
        moved = zip(self.frames, self.to, strict=True)
        fields = [doc.evidence.with_key_moved(frame, to) for frame, to in moved]
        return doc.changed({name: value for values in fields for name, value in values.items()})

    def label(self, state: EditorState) -> str:
        is_shift = len({b - a for a, b in zip(self.frames, self.to, strict=True)}) == 1
        verb = "copy" if self.copy_them else "move" if is_shift else "stretch"
        return f"{verb} {_count(self.frames)}"


class KeyAngle(Edit):
    """One angle of a part at some keyframe: a point of the curve, dragged. The root's is in the
    world, as the curve has it."""

    do: Literal["key_angle"] = "key_angle"
    verb = "turn"
    target = "part"
    frame: FrameIndex
    part: Name
    axis: Axis
    deg: Degrees

    def apply(self, state: EditorState) -> Session:
        soft = require_keyframe(state, self.frame).soft
        pose = shown_pose(state, self.frame).pose
        T = state.doc.film_camera.T_camera_world(self.frame)
        part, moves = state.doc.subject.body.index(self.part), state.doc.camera_path is not None
        of_root = moves and state.doc.subject.body.parts[part].parent is None
        wanted = {self.axis: self.deg}
        pose = with_angles(
            state.skeleton,
            pose.carried(rigid_inverse(T)) if of_root else pose,
            self.part,
            wanted.get("x"),
            wanted.get("y"),
            wanted.get("z"),
            near_deg=angle_curve(state, part)[self.frame],
            up_camera=state.doc.world.up,
        )
        pose = pose.carried(T) if of_root else pose
        return posed(state.doc, state.skeleton, pose, self.frame, state.times_s, soft)


class SoftenKey(Edit):
    """The motion need only come near a keyframe."""

    do: Literal["soften_key"] = "soften_key"
    verb = "approximate keyframe"
    target = "frame"
    frame: FrameIndex

    def apply(self, state: EditorState) -> Session:
        return _with_softness(state, {require_keyframe(state, self.frame).frame}, True)


class SoftenKeys(Edit):
    """The motion need only come near some keyframes, such as those that pins contradict."""

    do: Literal["soften_keys"] = "soften_keys"
    verb = "approximate keyframes"
    frames: Frames

    def apply(self, state: EditorState) -> Session:
        named = set(state.keys).intersection(self.frames)
        if not named:
            raise ActionRefused("None of these frames is a keyframe any more.")
        return _with_softness(state, named, True)


class ExactKey(Edit):
    """The motion meets a keyframe exactly, as it does unless it was softened."""

    do: Literal["exact_key"] = "exact_key"
    verb = "set exact keyframe"
    target = "frame"
    frame: FrameIndex

    def apply(self, state: EditorState) -> Session:
        return _with_softness(state, {require_keyframe(state, self.frame).frame}, False)


MESSAGES = (
    AddKey,
    DeleteKey,
    MoveKey,
    DuplicateKey,
    DeleteDraft,
    DeleteKeys,
    RetimeKeys,
    KeyAngle,
    SoftenKey,
    SoftenKeys,
    ExactKey,
)


def _count(frames: Collection[int]) -> str:
    return f"{len(frames)} keyframe{'' if len(frames) == 1 else 's'}"


def _require_all(state: EditorState, frames: Iterable[int]) -> dict[int, Keyframe]:
    """The keyframes at these frames, by frame; refused where there is none at one of them."""
    keyframes = {keyframe.frame: keyframe for keyframe in state.doc.subject.keyframes}
    return {frame: keyframes.get(frame) or require_keyframe(state, frame) for frame in frames}


def _with_softness(state: EditorState, frames: set[int], soft: bool) -> Session:
    """Set whether the motion need only come near the keyframes at these frames; whoever has one met
    exactly stands for its pose."""

    def changed(keyframe: Keyframe) -> Keyframe:
        drafted = keyframe.drafted and soft
        return softened(keyframe, soft).model_copy(update={"drafted": drafted})

    keyframes = [changed(k) if k.frame in frames else k for k in state.doc.subject.keyframes]
    return with_keyframes(state.doc, keyframes)


def with_keyframes_placed(
    doc: Session, stay: Iterable[Keyframe], placed: Collection[Keyframe]
) -> Session:
    """Set keyframes beside those that stay, in the place of what may be drafted there: that would
    hide them.
    """
    frames = {keyframe.frame for keyframe in placed}
    doc = with_keyframes(doc, (*stay, *placed))
    return with_drafts(doc, (draft for draft in doc.subject.drafts if draft.frame not in frames))


def require_free(stay: Iterable[Keyframe], frames: Iterable[int]) -> None:
    """Refused, naming them, where keyframes, of the body or of limbs, stand at some of these
    frames."""
    taken = {keyframe.frame for keyframe in stay}
    met = [frame for frame in frames if frame in taken]
    if len(met) == 1:
        raise ActionRefused(f"Frame {met[0]} is already a keyframe. Delete it first.")
    if met:
        raise ActionRefused(f"Frames {_listed(met)} are already keyframes. Delete them first.")


def _listed(frames: list[int]) -> str:
    """ "12, 24 and 36", or "12, 24 and 7 more"."""
    shown = len(frames) if len(frames) <= MOST_NAMED else MOST_NAMED - 1
    more = [f"{len(frames) - shown} more"] if shown < len(frames) else []
    return listed([*map(str, frames[:shown]), *more])


def _at_frame(state: EditorState, keyframe: Keyframe, frame: int) -> Keyframe:
    """The keyframe at another frame, where it stands in the world, which is no draft of that;
    refused outside the video, or behind the camera."""
    time_s = float(state.times_s[require_in_video(state.doc, frame)])
    if frame == keyframe.frame:
        return keyframe.model_copy(update={"time_s": time_s})
    update: dict[str, object] = {"frame": frame, "time_s": time_s, "drafted": False}
    if state.doc.camera_path is not None:
        pose = keyframe.pose(state.skeleton)
        pose = state.doc.film_camera.pose_seen_at(frame, keyframe.frame, pose)
        require_before_camera(state.skeleton, pose)
        placed = keyframe_of(state.skeleton, pose, frame, state.times_s)
        update |= {"root_m": placed.root_m, "rotations_wxyz": placed.rotations_wxyz}
    return keyframe.model_copy(update=update)


def _keyed(state: EditorState, doc: Session, keyframe: Keyframe, frame: int) -> Session:
    """Set one more keyframe at a frame, in the place of what may be drafted there. Refused where
    there is one already."""
    require_free((*state.doc.subject.keyframes, *state.doc.subject.part_keyframes), [frame])
    placed = _at_frame(state, keyframe, frame)
    if not isinstance(placed, PartKeyframe):
        return with_keyframes_placed(doc, doc.subject.keyframes, [placed])
    require_correctable(state, frame)
    doc = with_part_keyframes(doc, (*doc.subject.part_keyframes, placed))
    return with_drafts(doc, without(doc.subject.drafts, frame))


def _without(doc: Session, keyframe: Keyframe) -> Session:
    if isinstance(keyframe, PartKeyframe):
        return with_part_keyframes(doc, without(doc.subject.part_keyframes, keyframe.frame))
    return with_keyframes(doc, without(doc.subject.keyframes, keyframe.frame))


def _require(state: EditorState, frame: int) -> Keyframe:
    """The keyframe of a frame, or its part keyframe."""
    return find(state.doc.subject.part_keyframes, frame) or require_keyframe(state, frame)
