"""Edits of the body: shapes, sizes, joints, presets, what is tracked."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TypeVar

from keypose.app.editor import actions as do
from keypose.app.editor.documents import ActionRefused, Posed, require_before_camera
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label, with_height, with_joint, with_shape, with_size
from keypose.tracker.body.body import PRESETS, Body, Part, preset
from keypose.tracker.body.modify import (
    can_have_clavicles,
    has_clavicles,
    with_clavicles,
    with_new_part,
    with_renamed_part,
    without_clavicles,
    without_part,
)
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session.annotations import Reviewed
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import TrackSettings

Named = TypeVar("Named", Pin, Reviewed)


def set_shape(state: EditorState, action: do.Shape) -> Session:
    """The shape of a part."""
    body = with_shape(state.doc.body, action.part, action.kind, linked=state.display.link)
    return with_body(state, body)


def set_size(state: EditorState, action: do.Size) -> Session:
    """One size of a part."""
    body = with_size(state.doc.body, action.part, action.key, action.cm, linked=state.display.link)
    return with_body(state, body)


def set_joint(state: EditorState, action: do.Joint) -> Session:
    """Return where a part hangs on its parent."""
    part = state.doc.body.parts[state.doc.body.index(action.part)]
    wanted = (action.x, action.y, action.z)
    x, y, z = (
        100 * old if new is None else new for old, new in zip(part.joint_m, wanted, strict=True)
    )
    linked = state.display.link
    return with_body(state, with_joint(state.doc.body, action.part, (x, y, z), linked=linked))


def set_height(state: EditorState, action: do.Height) -> Session:
    """The whole body made this high."""
    return with_body(state, with_height(state.doc.body, action.cm))


def set_preset(state: EditorState, action: do.Preset) -> Session:
    """One of the bodies that come with the product."""
    return with_body(state, _as_jointed(state.doc.body, preset(action.name)))


def set_body(state: EditorState, action: do.SetBody) -> Session:
    """A body of one's own."""
    return with_body(state, action.body)


def add_part(state: EditorState, action: do.AddPart) -> Session:
    """One more part at the far end of another, as long as that and thinner."""
    return with_body(state, with_new_part(state.doc.body, action.parent, action.name))


def delete_part(state: EditorState, action: do.DeletePart) -> Session:
    """Without a part and all that hangs on it."""
    body = state.doc.body
    if body.parts[body.index(action.part)].parent is None:
        raise ActionRefused(
            "The first part carries all others and stays. Choose another body instead."
        )
    return with_body(state, without_part(body, action.part))


def rename_part(state: EditorState, action: do.RenamePart) -> Session:
    """Another name of a part, wherever the session names it."""
    old, new = action.part, action.name
    body = with_renamed_part(state.doc.body, old, new)

    def renamed(names: Iterable[str]) -> tuple[str, ...]:
        return tuple(new if name == old else name for name in names)

    def posed(keyframe: Posed) -> Posed:
        rotations = keyframe.rotations_wxyz
        named = {new if name == old else name: q for name, q in rotations.items()}
        return keyframe.model_copy(update={"rotations_wxyz": named})

    doc = state.doc
    limbs = (k.model_copy(update={"parts": renamed(k.parts)}) for k in doc.part_keyframes)
    left_out = renamed(doc.settings.left_out)
    return doc.model_copy(
        update={
            "body": body,
            "settings": doc.settings.model_copy(update={"left_out": left_out}),
            "keyframes": tuple(map(posed, doc.keyframes)),
            "part_keyframes": tuple(map(posed, limbs)),
            "drafts": tuple(map(posed, doc.drafts)),
            "pins": tuple(_of_part(pin, old, new) for pin in doc.pins),
            "reviewed": tuple(_of_part(one, old, new) for one in doc.reviewed),
        }
    )


def _of_part(one: Named, old: str, new: str) -> Named:
    return one.model_copy(update={"part": new}) if one.part == old else one


def set_clavicles(state: EditorState, action: do.Clavicles) -> Session:
    """Shoulders that move, or not. Poses stay as they are; without, arms keep their directions."""
    body = state.doc.body
    if not action.on:
        return with_body(_with_arms_turned(state), without_clavicles(body))
    if not can_have_clavicles(body) and not has_clavicles(body):
        raise ActionRefused("Clavicles need a chest with two upper arms.")
    return with_body(state, with_clavicles(body))


def _as_jointed(old: Body, body: Body) -> Body:
    """Add clavicles where the old body had them and this one can."""
    return with_clavicles(body) if has_clavicles(old) and can_have_clavicles(body) else body


def _with_arms_turned(state: EditorState) -> EditorState:
    """Every upper arm turned as its clavicle is, so that it points the same way without it."""
    skeleton = Skeleton.of(state.doc.body)

    def turned(keyframe: Posed) -> Posed:
        pose = keyframe.pose(skeleton)
        Rs = pose.Rs_parent_part.copy()
        for side in ("left", "right"):
            arm, clavicle = (skeleton.body.index(f"{side}_{n}") for n in ("upper_arm", "clavicle"))
            Rs[arm] = Rs[clavicle] @ Rs[arm]
        made = Keyframe.of(skeleton, Pose(Rs, pose.p_camera_root), keyframe.frame, keyframe.time_s)
        return keyframe.model_copy(update={"rotations_wxyz": made.rotations_wxyz})

    if not has_clavicles(state.doc.body):
        return state
    doc = state.doc.model_copy(
        update={
            "keyframes": tuple(map(turned, state.doc.keyframes)),
            "part_keyframes": tuple(map(turned, state.doc.part_keyframes)),
            "drafts": tuple(map(turned, state.doc.drafts)),
        }
    )
    return replace(state, doc=doc)


def reset_body(state: EditorState) -> Session:
    """The preset's own sizes again."""
    name = state.doc.body.name
    if name not in PRESETS:
        raise ActionRefused("This body is not based on a preset.")
    return with_body(state, _as_jointed(state.doc.body, preset(name)))


def set_tracked(state: EditorState, action: do.Tracked) -> Session:
    """Return which motions of a part are tracked."""
    body = state.doc.body
    part = body.parts[body.index(action.part)]
    changed = Part.model_validate({**part.model_dump(), "tracked": action.dofs})
    return with_body(state, body.with_part(changed))


def with_body(state: EditorState, body: Body) -> Session:
    """Another body in all poses: parts it does not have are left out of them."""
    known = set(body.names)
    _require_pinned_parts(state, known)
    skeleton = Skeleton.of(body)
    doc = state.doc.model_copy(
        update={
            "body": body,
            "settings": _without_unknown(state.doc.settings, known),
            "keyframes": tuple(_fitted(k, known) for k in state.doc.keyframes),
            "part_keyframes": tuple(_with_parts(state.doc, known)),
            "drafts": tuple(_fitted(k, known) for k in state.doc.drafts),
        }
    )
    for keyframe in (*doc.keyframes, *doc.part_keyframes, *doc.drafts):
        require_before_camera(skeleton, keyframe.pose(skeleton))
    return doc


def _require_pinned_parts(state: EditorState, known: set[str]) -> None:
    """Refused where a pin would lose its part."""
    lost = [pin.part for pin in state.doc.pins if pin.part not in known]
    if lost:
        raise ActionRefused(
            f"{part_label(lost[0])} is pinned and not part of that body. Unpin it first."
        )


def _without_unknown(settings: TrackSettings, known: set[str]) -> TrackSettings:
    left_out = tuple(name for name in settings.left_out if name in known)
    return settings.model_copy(update={"left_out": left_out})


def _with_parts(doc: Session, known: set[str]) -> Iterator[PartKeyframe]:
    """The part keyframes of which any part is left."""
    for keyframe in doc.part_keyframes:
        parts = tuple(name for name in keyframe.parts if name in known)
        if parts == keyframe.parts:
            yield _fitted(keyframe, known)
        elif parts:
            yield _fitted(keyframe.model_copy(update={"parts": parts}), known)


def _fitted(keyframe: Posed, known: set[str]) -> Posed:
    if set(keyframe.rotations_wxyz) <= known:
        return keyframe
    rotations = {name: q for name, q in keyframe.rotations_wxyz.items() if name in known}
    return keyframe.model_copy(update={"rotations_wxyz": rotations})
