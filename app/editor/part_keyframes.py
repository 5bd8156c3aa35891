"""Edit part keyframes: keyframes of some limbs alone, the rest of the body being tracked."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from keypose.app.editor.documents import (
    ActionRefused,
    keyframe_of,
    require_before_camera,
    with_drafts,
    with_part_keyframes,
    without,
)
from keypose.app.editor.message import Edit
from keypose.app.editor.shown import draft_at, find, pose_behind, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import lanes, part_label
from keypose.tracker.body.body import Body, Name
from keypose.tracker.body.limb_groups import kind_of
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import listed
from keypose.tracker.session.keyframe import PartKeyframe
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import FrameIndex

SAME = 1e-5
"""Entries of a rotation, and metres, up to which a part stands as it did."""

WHOLE_BODY = "The whole body was moved here. Press K to key all of it."


class KeyParts(Edit):
    """Limbs as they are shown at a frame become its part keyframe, with those that are keyed there
    already: those of these parts; left out, those that were posed there, else the selected
    part's."""

    do: Literal["key_parts"] = "key_parts"
    verb = "add part keyframe"
    target = "frame"
    frame: FrameIndex
    parts: Annotated[tuple[Name, ...], Field(max_length=1000)] = ()

    def apply(self, state: EditorState) -> Session:
        frame = self.frame
        require_correctable(state, frame)
        parts = self.parts or _posed_parts(state, frame)
        if not parts:
            if state.selected is None:
                raise ActionRefused("Select a limb, or move one, to key it alone.")
            parts = (state.selected,)
        limbs = limbs_of(state.doc.subject.body, parts)
        return _with_parts(state, frame, shown_pose(state, frame).pose, limbs)


class UnkeyParts(Edit):
    """The limbs of these parts are tracked at a frame again."""

    do: Literal["unkey_parts"] = "unkey_parts"
    verb = "change part keyframe"
    target = "frame"
    frame: FrameIndex
    parts: Annotated[tuple[Name, ...], Field(min_length=1, max_length=1000)]

    def apply(self, state: EditorState) -> Session:
        part_keyframe = find(state.doc.subject.part_keyframes, self.frame)
        if part_keyframe is None:
            raise ActionRefused(f"Frame {self.frame} is not a part keyframe.")
        gone = set(limbs_of(state.doc.subject.body, self.parts))
        left = tuple(part for part in part_keyframe.parts if part not in gone)
        rest = without(state.doc.subject.part_keyframes, self.frame)
        if left:
            rest = (*rest, part_keyframe.model_copy(update={"parts": left}))
        return with_part_keyframes(state.doc, rest)


MESSAGES = (KeyParts, UnkeyParts)


def with_limbs_posed(state: EditorState, pose: Pose) -> Session | None:
    """A pose of the present frame taken into its part keyframe, which need not be there yet; None
    where more than limbs moved.

    state: before it was posed.
    """
    before = shown_pose(state).pose
    moved = moved_parts(state.skeleton, before, pose)
    if moved is None:
        return None
    return _with_parts(state, state.frame, pose, limbs_of(state.doc.subject.body, moved))


def moved_parts(skeleton: Skeleton, before: Pose, after: Pose) -> tuple[str, ...] | None:
    """The parts that stand otherwise on what carries them; None where the root does."""
    turned = np.abs(after.Rs_parent_part - before.Rs_parent_part).max(axis=(1, 2)) > SAME
    if turned[0] or np.abs(after.p_camera_root - before.p_camera_root).max() > SAME:
        return None
    return tuple(skeleton.body.names[part] for part in np.flatnonzero(turned))


def limbs_of(body: Body, parts: Iterable[str]) -> tuple[str, ...]:
    """The limbs that parts belong to, with all that hangs on them, in the body's order.

    A limb are parts that follow one another without branching: an arm, a leg, neck and head. A
    clavicle is keyed only by itself. Refused for the root, which carries everything.
    """
    skeleton, named = Skeleton.of(body), [body.index(part) for part in parts]
    if 0 in named:
        raise ActionRefused(WHOLE_BODY)
    clavicles = np.array([kind_of(name) == "clavicle" for name in body.names])
    of_limb = np.isin(skeleton.limbs, skeleton.limbs[named]) & ~clavicles
    of_limb[named] = True
    return tuple(body.names[i] for i in np.flatnonzero(skeleton.below[:, of_limb].any(axis=1)))


def keyed_limbs(body: Body, parts: Iterable[str]) -> list[tuple[str, tuple[str, ...]]]:
    """The groups of parts, as lists of the body have them, of which any part is keyed: what each
    is called, and its parts that are."""
    keyed = set(parts)
    groups = []
    for label, group in lanes(body):
        own = tuple(name for name in group if name in keyed)
        if not own:
            continue
        limb = len(own) > 1 and body.names[0] not in group
        groups.append((label if limb else part_label(own[0 if "chest" in own else -1]), own))
    return groups


def keyed_words(body: Body, parts: Iterable[str]) -> str:
    """What of the body is keyed: "right arm and left leg"."""
    return listed([label.lower() for label, _ in keyed_limbs(body, parts)])


def _posed_parts(state: EditorState, frame: int) -> tuple[str, ...]:
    """What a draft of the frame moved; none without a draft, or where more than limbs moved
    and a part is selected.
    """
    if draft_at(state, frame) is None:
        return ()
    drafted = shown_pose(state, frame).pose
    moved = moved_parts(state.skeleton, pose_behind(state, frame).pose, drafted)
    if moved is None and state.selected in (None, state.doc.subject.body.names[0]):
        raise ActionRefused(WHOLE_BODY)
    return moved or ()


def _with_parts(state: EditorState, frame: int, pose: Pose, parts: Iterable[str]) -> Session:
    """These parts keyed as the pose has them, beside those that were."""
    require_before_camera(state.skeleton, pose)
    part_keyframe = find(state.doc.subject.part_keyframes, frame)
    keyed = {*parts, *(part_keyframe.parts if part_keyframe is not None else ())}
    whole = keyframe_of(state.skeleton, pose, frame, state.times_s)
    made = PartKeyframe(
        **whole.model_dump(), parts=tuple(n for n in state.doc.subject.body.names if n in keyed)
    )
    rest = without(state.doc.subject.part_keyframes, frame)
    doc = with_part_keyframes(state.doc, (*rest, made))
    return with_drafts(doc, without(doc.subject.drafts, frame))


def require_correctable(state: EditorState, frame: int) -> None:
    """Refused where there is no motion that a part keyframe could correct."""
    if state.doc.view.surface is not None:
        raise ActionRefused("A body is fitted to surfaces as a whole. Press K to key all of it.")
    if find(state.doc.subject.keyframes, frame) is not None:
        raise ActionRefused(f"Frame {frame} is already a keyframe of the whole body.")
    if not any(first < frame < last for first, last in state.doc.spans):
        raise ActionRefused("A part keyframe corrects tracking: it goes between two keyframes.")
