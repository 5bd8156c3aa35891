"""Give the motion in space as JSON: feet, pins, the floor, and what is implausible."""

from __future__ import annotations

from typing import Final

import numpy as np

from keypose.app.editor import shown
from keypose.app.editor.floor import uneven_feet_m
from keypose.app.editor.motion import feet_paths
from keypose.app.editor.pinned import default_landmarks, open_proposals, pin_result, still_range
from keypose.app.editor.shown import part_at
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.posing.labels import joint_label, number_text
from keypose.app.state.app_state import AppState
from keypose.app.store.sections.body_values import side_of
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.words.problems import pin_sentence, space_sentence
from keypose.app.words.standing import soles_words
from keypose.tracker.body.body import Body
from keypose.tracker.body.limb_groups import kind_of
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.shapes import Shape
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.review.places import REVIEWED_IN_SPACE
from keypose.tracker.review.segments import JudgedSegments
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.results import SpaceFinding
from keypose.tracker.space.soles import soles_of


def feet(app_state: AppState) -> Json:
    """The floor, and the ways of the feet."""
    edit = app_state.edit
    if edit is None:
        return None
    paths = feet_paths(edit)
    body = edit.settled.subject.body
    return {
        "floor_m": round(paths.floor_m, 4),
        "frames": paths.frames.tolist(),
        "paths": [
            {
                "part": part,
                "label": part_label(part),
                "side": side_of(body, part),
                "points": path.round(4).tolist(),
            }
            for part, path in paths.paths.items()
        ],
    }


def ghosts(app_state: AppState) -> Json:
    """Where the parts stand at the keyframes before and after the present frame, and at a
    soft one here."""
    edit = app_state.edit
    if (
        edit is None
        or not edit.display.ghosts
        or edit.doc.subject.body is not edit.settled.subject.body
    ):
        return []
    shown_poses = []
    for frame, pose in shown.ghosts(edit):
        Ts = shown.ghost_transforms(edit, frame, pose)
        rows = Ts[:, :3].reshape(-1, 12).round(4).tolist()
        shown_poses.append(
            {"frame": frame, "T": dict(zip(edit.doc.subject.body.names, rows, strict=True))}
        )
    return shown_poses


def solids(app_state: AppState) -> Json:
    """What every part's convex surface is drawn from, in its own frame."""
    doc = doc_of(app_state)
    return None if doc is None else solids_of(doc.subject.body)


def before(app_state: AppState) -> Json:
    """The body that is compared with, as it is posed at the present frame."""
    edit = app_state.edit
    if edit is None or edit.compared is None:
        return None
    was = edit.with_doc(edit.compared)
    body = was.doc.subject.body
    Ts = pose_transforms(was.skeleton, shown.shown_pose(was).pose)
    rows = Ts[:, :3].reshape(-1, 12).round(5).tolist()
    return {"solids": solids_of(body), "T": dict(zip(body.names, rows, strict=True))}


def solids_of(body: Body) -> Json:
    """What every part's convex surface is drawn from, in its own frame, by the part's name."""
    return {part.name: _solid(part.shape) for part in body.parts}


def _solid(shape: Shape) -> Json:
    mesh = shape.mesh()
    lines, normals = shape.wireframe().along()
    return {
        "points": mesh.vertices.round(4).tolist(),
        "flats": [
            {"points": points.round(4).tolist(), "normal": normal.round(4).tolist()}
            for points, normal in mesh.flats()
        ],
        "wires": [
            {"ends": ends.round(4).tolist(), "normal": normal.round(4).tolist()}
            for ends, normal in zip(lines, normals, strict=True)
        ],
    }


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
        {**_pin(edit.doc.subject.body, pin), "sole": _sole(edit, pin), **_found(edit, pin)}
        for pin in edit.doc.subject.pins
    ]


def still(app_state: AppState) -> Json:
    """For every pin, in their order, first and last frame at which the tracked part stands
    still about its middle; null where it is not tracked.
    """
    edit = app_state.edit
    if edit is None:
        return []
    ranges = []
    for pin in edit.settled.subject.pins:
        middle = (pin.first_frame + pin.last_frame) // 2
        reach = (pin.last_frame - pin.first_frame) // 2 + AROUND
        frames = still_range(edit, pin, middle, reach)
        ranges.append(None if frames is None else list(frames))
    return ranges


def proposed_pins(app_state: AppState) -> Json:
    """The pins that are proposed and not yet answered."""
    edit = app_state.edit
    return (
        [] if edit is None else [_pin(edit.doc.subject.body, pin) for pin in open_proposals(edit)]
    )


def floor(app_state: AppState) -> Json:
    """Where the floor is, whether pinned feet determine it, and how soles lie on it."""
    edit, doc = app_state.edit, doc_of(app_state)
    if edit is None or doc is None:
        return None
    has_feet = any(pin.floor or pin.landmarks for pin in doc.subject.pins)
    soles = soles_of(edit.settled, edit.results.space(edit.settled))
    return {
        "height_m": doc.world.floor_m,
        "has_feet": has_feet,
        "soles": "" if soles is None else soles_words(soles),
        "soles_off_cm": None if soles is None else round(100 * soles.off_m, 1),
    }


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
    result = pin_result(edit, pin)
    if result is None:
        return {"slides_cm": None, "keyframe": None, "problem": ""}
    cm = 100 * result.off_m
    text = number_text(cm, 0 if cm >= 1 else 1)
    is_wrong = result.keyframe is not None
    problem = f"Keyframe {result.keyframe} is {text} cm off the pin." if is_wrong else ""
    return {"slides_cm": round(cm, 1), "keyframe": result.keyframe, "problem": problem}


def _sole(edit: EditorState, pin: Pin) -> list[list[float]]:
    """The outline of a pinned foot's sole in the world, as it stands in the middle of the pin."""
    if not default_landmarks(edit.doc.subject.body, pin.part):
        return []
    middle = (pin.first_frame + pin.last_frame) // 2
    T_part = edit.doc.film_camera.parts_to_world(part_at(edit, pin.part, middle)[None], [middle])[0]
    outline = _sole_in_part(edit.skeleton, pin.part) @ T_part[:3, :3].T + T_part[:3, 3]
    points: list[list[float]] = outline.round(4).tolist()
    return points


def _sole_in_part(skeleton: Skeleton, part: str) -> Array:
    """(N, 3) around the lowest of a part at rest, metres in its frame."""
    i = skeleton.body.index(part)
    at_rest = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))[i]
    vertices = np.asarray(skeleton.body.parts[i].shape.mesh().vertices)
    across, down, along = (vertices @ at_rest[:3, :3].T).T
    low = np.flatnonzero(down > down.max() - SOLE_M)
    a, b = across[low] - across[low].mean(), along[low] - along[low].mean()
    return np.asarray(vertices[low[np.argsort(np.arctan2(b, a))]])


_REMEDIES: Final = {
    "slides": "pin",
    "off_floor": "pin",
    "below_floor": "floor",
    "keyframe_depth": "soften",
    "mirrored": "turn",
    "twisted": "untwist",
    "leans": "",
    "shakes": "smooth",
    "pulled": "unpin",
    "bent": "unpin",
    "jumps": "unpin",
}
_WEIGHTS: Final = {
    "slides": 20.0,
    "off_floor": 20.0,
    "below_floor": 20.0,
    "keyframe_depth": 15.0,
    "mirrored": 20.0,
    "twisted": 3.0,
    "leans": 3.0,
    "shakes": 0.1,
    "pulled": 0.12,
    "bent": 6.0,
    "jumps": 0.05,
}
"""What makes findings of different kinds comparable: of 5 cm, of 8 px, of a knee's 10° or a body's
20°, of a shake of 10 or a jump of 20 m/s² each about 1."""
_ANSWERED: Final = frozenset({*REVIEWED_IN_SPACE, "mirrored"})
"""Kinds that a person's answer for the same part and frame settles."""


def space(app_state: AppState) -> Json:
    """What is wrong with the motion in space: sentence, part, frames, frame to go to, and
    what mends it with one press; the worst first.
    """
    edit = app_state.edit
    if edit is None:
        return []
    weighted: list[tuple[float, Json]] = []
    judged_segments = JudgedSegments.of(edit.settled, edit.results)
    for stretch in edit.results.space(edit.settled):
        waiting = (
            finding for finding in stretch.findings if not _is_accepted(judged_segments, finding)
        )
        weighted += [(_weight(space_finding), _finding(space_finding)) for space_finding in waiting]
        for pin in stretch.pins:
            if pin.keyframe is not None:
                row = {
                    "kind": "pin",
                    "words": pin_sentence(pin),
                    "part": pin.part,
                    "first": pin.first_frame,
                    "last": pin.last_frame,
                    "go": pin.keyframe,
                    "remedy": "soften",
                    "keyframes": sorted({pin.keyframe, *pin.others}),
                    "cm": round(100 * pin.off_m, 1),
                }
                weighted.append((_WEIGHTS["slides"] * pin.off_m, row))
    rows = [row for _, row in sorted(weighted, key=lambda pair: -pair[0])]
    is_known = edit.results.space(edit.settled)
    share = edit.settled.view.depth_share
    rise_m = uneven_feet_m(edit) if is_known else None
    first = [] if rise_m is None else [_guessed_up(edit, rise_m)]
    last = [_guessed_lens(edit, share)] if is_known and share is not None else []
    return [*first, *rows, *last]


def _guessed_up(edit: EditorState, rise_m: float) -> Json:
    """Feet that climb since nobody knows how the camera tilts: what else is found rests on it."""
    pins = edit.settled.subject.pins
    return {
        "kind": "up",
        "words": f"Pinned feet differ by {100 * rise_m:.0f} cm in height: the camera’s tilt is a "
        "guess.",
        "part": pins[0].part,
        "first": pins[0].first_frame,
        "last": pins[-1].last_frame,
        "go": pins[0].first_frame,
        "remedy": "level",
    }


def _is_accepted(judged_segments: JudgedSegments, space_finding: SpaceFinding) -> bool:
    """Whether a person has accepted what is found: a foot off the floor, what a pin does, the way a
    limb points.
    """
    asked = space_finding.kind in _ANSWERED
    answered = judged_segments.answer(space_finding.part, space_finding.go) if asked else None
    return answered is not None and answered.answer == "accepted"


def _guessed_lens(edit: EditorState, share: float) -> Json:
    """Depth that rests on a lens nobody knows."""
    return {
        "kind": "lens",
        "words": f"Depth rests on a guessed lens. Distances may be off by {100 * share:.0f} %.",
        "part": edit.settled.subject.body.names[0],
        "first": edit.keys[0],
        "last": edit.keys[-1],
        "go": edit.keys[0],
        "remedy": "lens",
    }


def _weight(space_finding: SpaceFinding) -> float:
    return _WEIGHTS[space_finding.kind] * abs(space_finding.amount)


def _finding(space_finding: SpaceFinding) -> Json:
    return {
        "kind": space_finding.kind,
        "words": space_sentence(space_finding),
        "part": space_finding.part,
        "first": space_finding.first_frame,
        "last": space_finding.last_frame,
        "go": space_finding.go,
        "remedy": _REMEDIES[space_finding.kind],
    }
