"""Every edit of the document in one table: how it is made, and what undo calls it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from keypose.app.editor import actions as do
from keypose.app.editor import (
    annotation_edits,
    body_edits,
    camera_edits,
    floor_edits,
    keyframe_edits,
    part_edits,
    pin_edits,
    posing_edits,
    tracking_edits,
)
from keypose.app.editor.documents import ActionRefused, require_in_video
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.posing.gesture import Surface
from keypose.tracker.session.schema import Session


@dataclass(frozen=True)
class EditKind:
    """One kind of edit.

    apply: the document after it; KeyposeError, in one sentence, when it cannot be done.
    verb: what undo calls it, or how that is made of the action.
    target: the action's field that names what it is done to.
    """

    apply: Callable[[EditorState, Any], Session]
    verb: str | Callable[[Any], str]
    target: str | None = None


def _add_keyframe(state: EditorState, action: do.AddKey) -> Session:
    return keyframe_edits.add_keyframe(state, require_in_video(state, action.frame))


def _delete_keyframe(state: EditorState, action: do.DeleteKey) -> Session:
    return keyframe_edits.delete_keyframe(state, action.frame)


def _delete_draft(state: EditorState, action: do.DeleteDraft) -> Session:
    return keyframe_edits.delete_draft(state, action.frame)


def _move_keyframe(state: EditorState, action: do.MoveKey) -> Session:
    require_in_video(state, action.to)
    return keyframe_edits.move_keyframe(state, action)


def _duplicate_keyframe(state: EditorState, action: do.DuplicateKey) -> Session:
    require_in_video(state, action.to)
    return keyframe_edits.duplicate_keyframe(state, action)


def _key_parts(state: EditorState, action: do.KeyParts) -> Session:
    require_in_video(state, action.frame)
    return part_edits.key_parts(state, action)


def _rename(state: EditorState, action: do.Rename) -> Session:
    title = " ".join(action.title.split())
    if not title.isprintable():
        raise ActionRefused("A name has letters, digits and signs only.")
    return state.doc.model_copy(update={"title": title})


def _alone(apply: Callable[[EditorState], Session]) -> Callable[[EditorState, Any], Session]:
    """An edit that needs no more than its name."""
    return lambda state, _: apply(state)


EDITS: Mapping[type[do.Edit], EditKind] = {
    do.Angles: EditKind(posing_edits.set_angles, "turn", "part"),
    do.Root: EditKind(posing_edits.set_root, "move the body"),
    do.Face: EditKind(posing_edits.set_facing, "turn the body"),
    do.ResetPart: EditKind(posing_edits.reset_part, "reset", "part"),
    do.ResetPose: EditKind(_alone(posing_edits.reset_pose), "reset the pose"),
    do.Exchange: EditKind(_alone(posing_edits.swap_sides), "swap left and right"),
    do.TurnInDepth: EditKind(posing_edits.turn_in_depth, "turn in depth", "part"),
    do.Untwist: EditKind(posing_edits.untwist, "untwist", "part"),
    do.PastePose: EditKind(keyframe_edits.paste, keyframe_edits.pasting),
    do.CopyKey: EditKind(posing_edits.copy_key, "copy keyframe", "from_frame"),
    do.TakeTracked: EditKind(_alone(posing_edits.take_tracked), "use the tracked pose"),
    do.KeyAngle: EditKind(posing_edits.turn_key, "turn", "part"),
    do.Rename: EditKind(_rename, "rename"),
    do.AddKey: EditKind(_add_keyframe, "add keyframe", "frame"),
    do.DeleteKey: EditKind(_delete_keyframe, "delete keyframe", "frame"),
    do.DeleteDraft: EditKind(_delete_draft, "delete draft", "frame"),
    do.MoveKey: EditKind(_move_keyframe, "move keyframe", "frame"),
    do.DeleteKeys: EditKind(keyframe_edits.delete_keyframes, keyframe_edits.deleting),
    do.RetimeKeys: EditKind(keyframe_edits.retime_keyframes, keyframe_edits.retiming),
    do.DuplicateKey: EditKind(_duplicate_keyframe, "duplicate keyframe", "frame"),
    do.KeyParts: EditKind(_key_parts, "add part keyframe", "frame"),
    do.UnkeyParts: EditKind(part_edits.unkey_parts, "change part keyframe", "frame"),
    do.SoftenKey: EditKind(pin_edits.soften_key, "soften keyframe", "frame"),
    do.SoftenKeys: EditKind(pin_edits.soften_keys, "soften keyframes"),
    do.ExactKey: EditKind(pin_edits.soften_key, "set exact keyframe", "frame"),
    do.SetNote: EditKind(annotation_edits.set_note, "write the note at", "frame"),
    do.MoveNote: EditKind(annotation_edits.move_note, "move the note at", "frame"),
    do.DeleteNote: EditKind(annotation_edits.delete_note, "delete the note at", "frame"),
    do.SetPin: EditKind(pin_edits.set_pin, "pin", "part"),
    do.ChangePin: EditKind(pin_edits.change_pin, "change a pin"),
    do.DeletePin: EditKind(pin_edits.delete_pin, "unpin"),
    do.SplitPin: EditKind(pin_edits.split_pin, "split a pin at", "frame"),
    do.AcceptPins: EditKind(pin_edits.accept_pins, "accept proposed pins"),
    do.AcceptPlace: EditKind(annotation_edits.accept_place, "accept", "part"),
    do.CannotTell: EditKind(annotation_edits.cannot_tell, "leave open", "part"),
    do.Floor: EditKind(floor_edits.set_floor, "change the floor"),
    do.Shape: EditKind(body_edits.set_shape, "change the shape of", "part"),
    do.Size: EditKind(body_edits.set_size, "resize", "part"),
    do.Joint: EditKind(body_edits.set_joint, "move the joint of", "part"),
    do.Height: EditKind(body_edits.set_height, "change the height"),
    do.Preset: EditKind(body_edits.set_preset, "change the body to", "name"),
    do.SetBody: EditKind(body_edits.set_body, "change the body"),
    do.AddPart: EditKind(body_edits.add_part, "add", "name"),
    do.DeletePart: EditKind(body_edits.delete_part, "delete", "part"),
    do.RenamePart: EditKind(body_edits.rename_part, "rename", "part"),
    do.ResetBody: EditKind(_alone(body_edits.reset_body), "reset the body"),
    do.Clavicles: EditKind(body_edits.set_clavicles, "change the clavicles"),
    do.Tracked: EditKind(body_edits.set_tracked, "change the tracked motions of", "part"),
    do.Intrinsics: EditKind(camera_edits.set_intrinsics, "change the camera"),
    do.FieldOfView: EditKind(camera_edits.set_fov, "change the field of view"),
    do.Lens: EditKind(camera_edits.set_lens, "change the lens"),
    do.Distortion: EditKind(camera_edits.set_distortion, "change the distortion"),
    do.Vertical: EditKind(camera_edits.set_up, "change the up direction"),
    do.Horizon: EditKind(floor_edits.set_horizon, "set the horizon"),
    do.UpFromFeet: EditKind(_alone(floor_edits.set_up_from_feet), "level the pinned feet"),
    do.ResetUp: EditKind(_alone(camera_edits.reset_up), "reset the up direction"),
    do.AddMask: EditKind(tracking_edits.add_mask, "draw a mask"),
    do.ChangeMask: EditKind(tracking_edits.change_mask, "change a mask"),
    do.DeleteMask: EditKind(tracking_edits.delete_mask, "delete a mask"),
    do.Settings: EditKind(tracking_edits.set_settings, "change the settings"),
    do.CorrectKeypoint: EditKind(
        annotation_edits.correct_keypoint, "correct the keypoint", "joint"
    ),
    do.IgnoreKeypoint: EditKind(annotation_edits.ignore_keypoint, "ignore the keypoint", "joint"),
    do.RestoreKeypoint: EditKind(
        annotation_edits.restore_keypoint, "put back the keypoint", "joint"
    ),
    do.Observe: EditKind(tracking_edits.set_surface, "change the surfaces"),
    do.ReadFilm: EditKind(camera_edits.read_film, "change how the film was taken"),
}
"""All edits but a drag, which is a gesture and says what it turns or moves (`label_of`)."""


def label_of(action: do.Edit) -> str:
    """Return what undo offers to undo: "turn right forearm"."""
    if isinstance(action, do.Drag):
        return _drag_label(action)
    kind = EDITS[type(action)]
    if not isinstance(kind.verb, str):
        return kind.verb(action)
    target = getattr(action, kind.target) if kind.target else None
    if target is None:
        return kind.verb
    return f"{kind.verb} {part_label(target).lower() if isinstance(target, str) else target}"


def _drag_label(action: do.Drag) -> str:
    handle = action.handle
    if isinstance(handle, Surface) and (handle.tool or action.tool) == "move":
        return "move the body"
    verbs = {"ring": "turn", "root": "move the body", "size": "resize", "surface": "turn"}
    if handle.kind == "box_corner":
        return f"move a corner of {part_label(handle.part).lower()}"
    verb = verbs.get(handle.kind, "move")
    name = getattr(handle, "part", None) or getattr(handle, "name", None)
    return verb if name is None else f"{verb} {part_label(name).lower()}"
