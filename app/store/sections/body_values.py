"""Give the body, its pose, keyframes and kept poses as JSON. Points are metres, camera frame."""

from __future__ import annotations

from dataclasses import astuple
from typing import Final

from keypose.app.editor.motion import angle_curve, angles_at, end_trail
from keypose.app.editor.part_keyframes import keyed_limbs, keyed_words
from keypose.app.editor.posing import corners_placed
from keypose.app.editor.shown import counts, draft_at, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import at_limit, axis_labels, handles, part_label, part_sizes, short_label
from keypose.app.posing import lanes as lane_groups
from keypose.app.state.app_state import AppState
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.tracker.body.body import Body, Part, preset
from keypose.tracker.body.modify import can_have_clavicles, has_clavicles, height, without_clavicles
from keypose.tracker.body.pose import joint_names, joint_positions, pose_transforms
from keypose.tracker.body.preset_names import ADULTS, ANIMALS, CHILDREN, OBJECTS, PRESETS
from keypose.tracker.body.shapes import KINDS
from keypose.tracker.keypoints.on_animal import is_animals
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session.keyframe import PartKeyframe
from keypose.tracker.storage.results import listed, residual

_PRESETS: Final = {"adult": ADULTS, "child": CHILDREN, "animal": ANIMALS, "object": OBJECTS}
"""By their kind the bodies that come with the product."""


def body(app_state: AppState) -> Json:
    """The body's parts with all that can be changed about them."""
    doc = doc_of(app_state)
    if doc is None:
        return None
    present_body = doc.subject.body
    return {
        "name": present_body.name,
        "preset": present_body.name if present_body.name in PRESETS else None,
        "edited": present_body.name in PRESETS
        and without_clavicles(present_body).parts != preset(present_body.name).parts,
        "clavicles": _clavicles(present_body),
        "height_cm": round(100 * height(present_body), 2),
        "is_persons": is_persons(present_body),
        "is_animals": is_animals(present_body),
        "dof_count": sum(len(part.tracked) for part in present_body.parts),
        "dof_total": 3 + 3 * len(present_body.parts),
        "presets": [
            {"name": name, "label": part_label(name), "kind": kind}
            for kind, names in _PRESETS.items()
            for name in names
        ],
        "shapes": [{"kind": kind, "label": part_label(kind)} for kind in KINDS],
        "lanes": [
            {"label": label, "parts": list(parts)} for label, parts in lane_groups(present_body)
        ],
        "parts": [_part(present_body, part) for part in present_body.parts],
        "handles": [
            {
                "name": handle.name,
                "kind": handle.kind,
                "part": handle.part,
                "anchor": handle.anchor,
                "label": handle.label,
                "limb": list(handle.limb),
            }
            for handle in handles(present_body)
        ],
    }


def _clavicles(present_body: Body) -> bool | None:
    """Whether it has them; None where it cannot."""
    return (
        True if has_clavicles(present_body) else False if can_have_clavicles(present_body) else None
    )


def _part(present_body: Body, part: Part) -> Json:
    mirror = present_body.mirror_of(part.name)
    return {
        "name": part.name,
        "label": part_label(part.name),
        "short": short_label(part.name),
        "parent": part.parent,
        "side": side_of(present_body, part.name),
        "mirror": None if mirror == part.name else mirror,
        "tracked": list(part.tracked),
        "words": axis_labels(present_body, part.name),
        "limits": {axis: part.limits_deg.get(axis) for axis in ("x", "y", "z")},
        "joint_cm": [round(100 * value, 2) for value in part.joint_m],
        "landmarks": list(part.landmarks),
        "shape": part.shape.kind,
        "corners_cm": _corners_cm(part),
        "sizes": [
            {
                "key": size.key,
                "label": size.label,
                "role": size.role,
                "cm": round(size.cm, 2),
                "min": size.min,
                "max": size.max,
                "at_cm": [round(100 * v, 2) for v in size.at_m],
            }
            for size in part_sizes(present_body, part.name)
        ],
    }


def _corners_cm(part: Part) -> Json:
    """The corners of a box, in its part's frame; none of others."""
    corners = part.shape.corners()
    return [] if corners is None else (100 * corners).round(3).tolist()


def side_of(present_body: Body, name: str) -> str:
    """L, R or C, as the colours go: the first of a mirror pair is the left one."""
    for left, right in present_body.mirror_pairs:
        if name in (left, right):
            return "L" if name == left else "R"
    return "C"


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
            zip(
                edit.doc.subject.body.names,
                Ts[:, :3].reshape(-1, 12).round(6).tolist(),
                strict=True,
            )
        ),
        "points": dict(zip(joint_names(edit.skeleton), points, strict=True)),
        "angles": angles_at(edit, standing.pose),
        "root": standing.pose.p_camera_root.round(5).tolist(),
        "at_limit": at_limit(edit.skeleton, standing.pose) if edit.display.limits else {},
        "gesture": _gesture(edit),
        "corners": [
            {
                "part": placed_corner.part,
                "index": placed_corner.index,
                "uv": [float(v) for v in placed_corner.uv],
            }
            for placed_corner in corners_placed(edit)
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
        "frames": [keyframe.frame for keyframe in doc.subject.keyframes],
        "drafts": [draft.frame for draft in doc.subject.drafts if counts(edit, draft)],
        "soft": [keyframe.frame for keyframe in doc.subject.keyframes if keyframe.soft],
        "parts": [_part_keyframe(doc.subject.body, each) for each in doc.subject.part_keyframes],
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
    index, frames = edit.doc.subject.body.index(edit.selected), edit.frame_count
    angles = angle_curve(edit, index)
    error = residual(edit.fitting, frames, len(edit.doc.subject.body.parts))[:, index]
    error = error * _SHOWN_TIMES[edit.doc.evidence.residual_unit]
    rows = {axis: listed(angles[:, k], 2) for k, axis in enumerate("xyz")}
    return {"part": edit.selected, **rows, "error": listed(error, 2)}


def trail(app_state: AppState) -> Json:
    """The way of the selected part's far end around the present frame."""
    edit = app_state.edit
    end_path = end_trail(edit) if edit is not None and edit.display.trail else None
    if end_path is None or len(end_path.frames) < 2:
        return None
    places = end_path.p_camera.round(5).tolist()
    points = [[frame, *p] for frame, p in zip(end_path.frames, places, strict=True)]
    return {"part": end_path.part, "points": points, "keys": list(end_path.keys)}


def poses(app_state: AppState) -> Json:
    """Every kept pose with its picture, and whether the present body has any of its parts."""
    doc = doc_of(app_state)
    names = set(doc.subject.body.names) if doc is not None else set()
    return [
        {
            "id": pose.id,
            "name": pose.name,
            "body": pose.copied.body,
            "fits": not names.isdisjoint(pose.copied.keys[0].rotations_wxyz),
            "strokes": [list(astuple(stroke)) for stroke in pose.strokes],
        }
        for pose in app_state.poses
    ]
