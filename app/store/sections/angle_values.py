"""The angle of a joint by its clinical name, over all frames, left and right."""

from __future__ import annotations

from keypose.app.editor.motion import part_rotations
from keypose.app.posing import part_label
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.store.state import AppState
from keypose.app.words.angles import angle_words
from keypose.tracker.body.joint_angles import ROOT, Angle, Joint, angles_of, joints_of
from keypose.tracker.storage.results import listed

SIDES = {"left": "L", "right": "R", "": "C"}


def joint_angle(app_state: AppState) -> Json:
    """The chosen joint's angle by frame, degrees, on each side; None where none is chosen or the
    body has no such joint. choices: all that could be chosen."""
    edit, doc = app_state.edit, doc_of(app_state)
    if edit is None or doc is None or edit.display.joint is None:
        return None
    joints = [joint for joint in joints_of(doc.subject.body) if joint.carrier != ROOT]
    own = [joint for joint in joints if name_of(joint) == edit.display.joint]
    if not own:
        return None
    angle = next((a for a in own[0].angles if a.name == edit.display.angle), own[0].angles[0])
    sides = []
    for joint in own:
        found = angles_of(doc.subject.body, joint, lambda part: part_rotations(edit, part))
        side = joint.name.removesuffix(name_of(joint)).rstrip("_")
        values = listed(found[angle.name], 1)
        sides.append({"side": SIDES[side], "part": joint.part, "values": values})
    return {
        "joint": edit.display.joint,
        "angle": angle.name,
        "label": label_of(own[0], angle),
        "positive": angle_words(angle)[0],
        "negative": angle_words(angle)[1],
        "sides": sides,
        "choices": [
            {"joint": name_of(joint), "angle": each.name, "label": label_of(joint, each)}
            for joint in joints
            if not joint.name.startswith("right_")
            for each in joint.angles
        ],
    }


def name_of(joint: Joint) -> str:
    """ "knee" of either side."""
    return joint.name.removeprefix("left_").removeprefix("right_")


def label_of(joint: Joint, angle: Angle) -> str:
    """ "Knee flexion"."""
    return f"{part_label(name_of(joint))} {angle_words(angle)[0]}"
