"""The angle of a joint by its clinical name, over all frames, left and right."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from keypose.app.editor.motion import part_rotations
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.state.app_state import AppState
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.words.angles import angle_words
from keypose.tracker.body.angle_errors import GUESSED_RAD
from keypose.tracker.body.joint_angles import ROOT, Angle, Joint, angles_of, joints_of
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.review.segments import JudgedSegments
from keypose.tracker.storage.results import listed
from keypose.tracker.tracking.result import side_by_side

SIDES = {"left": "L", "right": "R", "": "C"}


def joint_angle(app_state: AppState) -> Json:
    """The chosen joint's angle by frame, degrees, on each side, with what it is expected to be off
    by; None where none is chosen or the body has no such joint. guess: errors above are guesses.
    choices: all that could be chosen."""
    edit, doc = app_state.edit, doc_of(app_state)
    if edit is None or doc is None or edit.display.joint is None:
        return None
    joints = [joint for joint in joints_of(doc.subject.body) if joint.carrier != ROOT]
    own = [joint for joint in joints if name_of(joint) == edit.display.joint]
    if not own:
        return None
    angle = next((a for a in own[0].angles if a.name == edit.display.angle), own[0].angles[0])
    errors = _expected_errors(edit, own)
    sides = []
    for joint in own:
        joint_angles = angles_of(doc.subject.body, joint, lambda part: part_rotations(edit, part))
        side = joint.name.removesuffix(name_of(joint)).rstrip("_")
        values = listed(joint_angles[angle.name], 1)
        column = joint.angles.index(angle)
        off = None if errors is None else listed(errors[joint][:, column], 1)
        row = {"side": SIDES[side], "part": joint.part, "values": values, "errors": off}
        sides.append(row)
    return {
        "joint": edit.display.joint,
        "angle": angle.name,
        "label": label_of(own[0], angle),
        "positive": angle_words(angle)[0],
        "negative": angle_words(angle)[1],
        "sides": sides,
        "guess": round(math.degrees(GUESSED_RAD), 1),
        "choices": [
            {"joint": name_of(joint), "angle": each.name, "label": label_of(joint, each)}
            for joint in joints
            if not joint.name.startswith("right_")
            for each in joint.angles
        ],
    }


def _expected_errors(edit: EditorState, joints: Sequence[Joint]) -> dict[Joint, Array] | None:
    """Degrees (F, 3) by which joints' angles are expected to be off, NaN where that is not known;
    None where it is of none."""
    judged_segments = JudgedSegments.of(edit.doc, edit.results)
    judged = [
        (track.first, judged_segments.angle_errors(track, joints))
        for track in judged_segments.tracks.values()
    ]
    pieces = [(first, errors) for first, errors in judged if errors is not None]
    if not pieces:
        return None
    errors_of_joint: dict[Joint, Array] = {}
    for joint in joints:
        rows = [(first, errors[joint]) for first, errors in pieces]
        errors_of_joint[joint] = np.degrees(side_by_side(rows, edit.frame_count, (3,)))
    return errors_of_joint


def name_of(joint: Joint) -> str:
    """ "knee" of either side."""
    return joint.name.removeprefix("left_").removeprefix("right_")


def label_of(joint: Joint, angle: Angle) -> str:
    """ "Knee flexion"."""
    return f"{part_label(name_of(joint))} {angle_words(angle)[0]}"
