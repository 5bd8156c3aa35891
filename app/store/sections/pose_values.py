"""The pose at the present frame and the keyframes, as JSON. Points are metres, camera frame."""

from __future__ import annotations

from keypose.app.editor.angle_curve import angle_curve
from keypose.app.editor.part_edits import keyed_limbs, keyed_words
from keypose.app.editor.placed_corners import corners_placed
from keypose.app.editor.posing_edits import angles_at
from keypose.app.editor.shown import counts, draft_at, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.editor.trail import end_trail
from keypose.app.posing import at_limit
from keypose.app.store.sections.body_values import side_of
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.store.state import AppState
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import joint_names, joint_positions, pose_transforms
from keypose.tracker.session.keyframe import PartKeyframe
from keypose.tracker.storage.results import listed, residual


def pose(app_state: AppState) -> Json:
    """Where every part stands at the present frame."""
    edit = app_state.edit
    if edit is None:
        return None
    standing = shown_pose(edit)
    Ts = pose_transforms(edit.skeleton, standing.pose)
    points = joint_positions(edit.skeleton, Ts).round(6).tolist()
    return {
        "frame": edit.frame,
        "source": standing.source,
        "followed": _is_followed(edit),
        "stroke": edit.stroke.name if edit.stroke else None,
        "T": dict(
            zip(edit.doc.body.names, Ts[:, :3].reshape(-1, 12).round(6).tolist(), strict=True)
        ),
        "points": dict(zip(joint_names(edit.skeleton), points, strict=True)),
        "angles": angles_at(edit, standing.pose),
        "root": standing.pose.p_camera_root.round(5).tolist(),
        "at_limit": at_limit(edit.skeleton, standing.pose) if edit.display.limits else {},
        "gesture": _gesture(edit),
        "corners": [
            {"part": one.part, "index": one.index, "uv": [float(v) for v in one.uv]}
            for one in corners_placed(edit)
        ],
    }


def _is_followed(edit: EditorState) -> bool:
    """Whether the pose at the present frame was found by tracking ahead."""
    draft = draft_at(edit, edit.frame)
    return draft is not None and draft.followed


def _gesture(edit: EditorState) -> Json:
    readout = edit.stroke.readout if edit.stroke else None
    if readout is None:
        return None
    reach = readout.reach
    return {
        "label": readout.label,
        "value": readout.value,
        "change": readout.change,
        "part": readout.part,
        "axis": readout.axis,
        "angle_rad": readout.angle_rad,
        "reach": None
        if reach is None
        else {"centre": [float(v) for v in reach.centre], "radius_m": float(reach.radius_m)},
        "out_of_reach": readout.out_of_reach,
        "depth_m": readout.depth_m,
        "unreached": list(readout.unreached),
    }


def keys(app_state: AppState) -> Json:
    """Frames of keyframes, and of drafts that nothing tracked is shown instead of."""
    edit, doc = app_state.edit, doc_of(app_state)
    if edit is None or doc is None:
        return {"frames": [], "drafts": [], "soft": [], "parts": []}
    return {
        "frames": [keyframe.frame for keyframe in doc.keyframes],
        "drafts": [draft.frame for draft in doc.drafts if counts(edit, draft)],
        "soft": [keyframe.frame for keyframe in doc.keyframes if keyframe.soft],
        "parts": [_part_keyframe(doc.body, each) for each in doc.part_keyframes],
    }


def _part_keyframe(body: Body, keyframe: PartKeyframe) -> Json:
    limbs = keyed_limbs(body, keyframe.parts)
    return {
        "frame": keyframe.frame,
        "parts": list(keyframe.parts),
        "limbs": [
            {"label": label, "side": side_of(body, parts[-1]), "parts": list(parts)}
            for label, parts in limbs
        ],
        "words": f"{keyed_words(body, keyframe.parts)} only",
    }


_SHOWN_TIMES = {"px": 1, "m": 1000}
"""Pixels are shown as they are, metres as millimetres."""


def curve(app_state: AppState) -> Json:
    """The selected part's angles and error, by frame."""
    edit = app_state.edit
    if edit is None or edit.selected is None:
        return None
    index, frames = edit.doc.body.index(edit.selected), edit.frame_count
    angles = angle_curve(edit, index)
    error = residual(edit.fitting, frames, len(edit.doc.body.parts))[:, index]
    error = error * _SHOWN_TIMES[edit.doc.evidence.residual_unit]
    rows = {axis: listed(angles[:, k], 2) for k, axis in enumerate("xyz")}
    return {"part": edit.selected, **rows, "error": listed(error, 2)}


def trail(app_state: AppState) -> Json:
    """The way of the selected part's far end around the present frame."""
    edit = app_state.edit
    found = end_trail(edit) if edit is not None and edit.display.trail else None
    if found is None or len(found.frames) < 2:
        return None
    places = found.p_camera.round(5).tolist()
    points = [[frame, *p] for frame, p in zip(found.frames, places, strict=True)]
    return {"part": found.part, "points": points, "keys": list(found.keys)}
