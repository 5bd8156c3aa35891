"""Pins, proposed pins and the floor, as JSON. Points are metres, camera frame."""

from __future__ import annotations

import numpy as np

from keypose.app.editor.pinned import default_landmarks, open_proposals, pin_result, still_range
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.posing.labels import joint_label, kind_of, number_text
from keypose.app.store.sections.body_values import side_of
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.store.state import AppState
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin

SOLE_M = 0.015
"""What of a foot at rest counts as its sole: so much above its lowest point."""
AROUND = 30
"""Frames beside a pin in which its part may still stand."""
_JOINTS_NAMED = ("forearm", "shin")


def pins(app_state: AppState) -> Json:
    """The pins, in the session's order."""
    edit = app_state.edit
    if edit is None:
        return []
    return [
        {**_pin(edit.doc.body, pin), "sole": _sole(edit, pin), **_found(edit, pin)}
        for pin in edit.doc.pins
    ]


def still(app_state: AppState) -> Json:
    """Of every pin, in their order, first and last frame at which the tracked part stands still
    about its middle; null where it is not tracked."""
    edit = app_state.edit
    if edit is None:
        return []
    found = []
    for pin in edit.settled.pins:
        middle = (pin.first_frame + pin.last_frame) // 2
        reach = (pin.last_frame - pin.first_frame) // 2 + AROUND
        known = still_range(edit, pin, middle, reach)
        found.append(None if known is None else list(known))
    return found


def proposed_pins(app_state: AppState) -> Json:
    """The pins that are proposed and not yet answered."""
    edit = app_state.edit
    return [] if edit is None else [_pin(edit.doc.body, pin) for pin in open_proposals(edit)]


def floor(app_state: AppState) -> Json:
    """Where the floor is, and whether pinned feet could determine it."""
    doc = doc_of(app_state)
    if doc is None:
        return None
    has_feet = any(pin.floor or pin.landmarks for pin in doc.pins)
    return {"height_m": doc.floor_m, "has_feet": has_feet}


def _pin(body: Body, pin: Pin) -> dict[str, Json]:
    return {
        "part": pin.part,
        "label": pin_label(pin),
        "side": side_of(body, pin.part),
        "landmarks": list(pin.landmarks),
        "point_m": None if pin.point_m is None else list(pin.point_m),
        "first": pin.first_frame,
        "last": pin.last_frame,
        "floor": pin.floor,
    }


def pin_label(pin: Pin) -> str:
    """What is held: "Left foot", "Left heel", "Left knee"."""
    if len(pin.landmarks) == 1:
        return part_label(pin.landmarks[0])
    if not pin.landmarks and pin.point_m is None and kind_of(pin.part) in _JOINTS_NAMED:
        return joint_label(pin.part)
    return part_label(pin.part)


def _found(edit: EditorState, pin: Pin) -> dict[str, Json]:
    """What the solve found: how far it slides, and which keyframe is against it."""
    found = pin_result(edit, pin)
    if found is None:
        return {"slides_cm": None, "keyframe": None, "problem": ""}
    cm = 100 * found.off_m
    text = number_text(cm, 0 if cm >= 1 else 1)
    is_wrong = found.keyframe is not None
    problem = f"Keyframe {found.keyframe} is {text} cm off the pin." if is_wrong else ""
    return {"slides_cm": round(cm, 1), "keyframe": found.keyframe, "problem": problem}


def _sole(edit: EditorState, pin: Pin) -> list[list[float]]:
    """The outline of a pinned foot's sole, as it stands in the middle of the pin."""
    if not default_landmarks(edit.doc.body, pin.part):
        return []
    middle = (pin.first_frame + pin.last_frame) // 2
    T = pose_transforms(edit.skeleton, shown_pose(edit, middle).pose)
    T_part = T[edit.doc.body.index(pin.part)]
    outline = _sole_in_part(edit.skeleton, pin.part) @ T_part[:3, :3].T + T_part[:3, 3]
    found: list[list[float]] = outline.round(4).tolist()
    return found


def _sole_in_part(skeleton: Skeleton, part: str) -> Array:
    """(N, 3) around the lowest of a part at rest, metres in its frame."""
    i = skeleton.body.index(part)
    at_rest = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))[i]
    vertices = np.asarray(skeleton.body.parts[i].shape.mesh().vertices)
    across, down, along = (vertices @ at_rest[:3, :3].T).T
    low = np.flatnonzero(down > down.max() - SOLE_M)
    a, b = across[low] - across[low].mean(), along[low] - along[low].mean()
    return np.asarray(vertices[low[np.argsort(np.arctan2(b, a))]])
