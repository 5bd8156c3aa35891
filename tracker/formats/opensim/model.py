"""Read a full-body model of OpenSim (.osim, version 4), and scale it to our body with our markers.

**Factors.** A limb's body is scaled alike along all axes, by the distance of its two joints: thigh,
shank, upper arm, forearm; the hand as the forearm. The foot goes by its length, of which a model
shows the part from heel to the joint of the toes. Pelvis and torso are scaled up and down by the
height from hips to lumbar joint and from there to the shoulders, sideways by the distance of the
hips and of the shoulders, and from front to back by the mean of both. The head and what hangs on no
joint of ours is scaled by the leg and trunk together.

**Markers.** They are on the model in its zero pose where they are on our body at rest: those of a
limb by the joints at both of its ends, those of trunk and head by the middle of the hips. So what
inverse kinematics leaves of our markers is what the two differ in between these joints.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.joint_angles import R_ANATOMICAL_PART, R_PALM_FORWARD
from keypose.tracker.errors import FormatError
from keypose.tracker.files import read_regular
from keypose.tracker.formats.marker_sets import Marker
from keypose.tracker.geometry.rotations import Array, frozen

LARGEST_BYTES = 64 * 2**20
OLDEST = 40000

SIDES: Final = ("r", "l")
NEEDED: Final = (
    *("pelvis", "torso"),
    *(
        f"{body}_{side}"
        for body in ("femur", "tibia", "talus", "calcn", "humerus", "ulna", "radius", "hand")
        for side in SIDES
    ),
)
"""Bodies after Rajagopal et al. (2016), which this program's body is compared with."""


@dataclass(frozen=True, eq=False)
class ModelJoint:
    """The joint by which a body hangs on its parent: its place in both frames (3,), metres."""

    parent: str
    p_parent: Array
    p_body: Array


@dataclass(frozen=True, eq=False)
class OpenSimModel:
    """name:   of the model.
    bodies:    by name, all of them.
    joints:    by the body that hangs on them.
    coordinates: the names of the joints' coordinates.
    """

    name: str
    bodies: tuple[str, ...]
    joints: Mapping[str, ModelJoint]
    coordinates: tuple[str, ...]


def read_model(path: Path) -> OpenSimModel:
    """The model in a file. FormatError in one sentence where it is none, or not of a whole body."""
    try:
        content = read_regular(path, LARGEST_BYTES)
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror or error}.") from None
    return model_of(path.name, content)


def model_of(file: str, content: bytes) -> OpenSimModel:
    """The model in a file's content; FormatError as `read_model`."""
    root = _document(file, content)
    model = root.find("Model")
    if model is None:
        raise FormatError(f"{file} holds no model of OpenSim.")
    bodies = tuple(body.get("name", "") for body in model.iterfind("BodySet/objects/Body"))
    joints = dict(_joint(file, joint) for joint in model.iterfind("JointSet/objects/*"))
    missing = [name for name in NEEDED if name not in bodies or name not in joints]
    if missing:
        raise FormatError(
            f"{file} has no {missing[0]}: a full-body model with arms is needed whose bodies are "
            "named as in Rajagopal's, such as Pose2Sim's Model_Pose2Sim_simple.osim."
        )
    names = (c.get("name", "") for c in model.iterfind("JointSet/objects/*/coordinates/Coordinate"))
    return OpenSimModel(model.get("name", ""), bodies, joints, tuple(names))


def _document(file: str, content: bytes) -> Element:
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise FormatError(f"{file} declares a document type, which models of OpenSim do not.")
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        raise FormatError(f"{file} is not XML: {error}.") from None
    version = root.get("Version", "")
    if root.tag != "OpenSimDocument" or not re.fullmatch("[0-9]{1,9}", version):
        raise FormatError(f"{file} is no document of OpenSim.")
    if int(version) < OLDEST:
        raise FormatError(f"{file} is of OpenSim 3 or older: open it in OpenSim 4 and save it.")
    return root


def _joint(file: str, joint: Element) -> tuple[str, ModelJoint]:
    """The body that hangs on a joint, and the joint."""
    frames = {frame.get("name", ""): frame for frame in joint.iterfind("frames/*")}
    parent, p_parent = _base(file, joint, frames, "socket_parent_frame")
    body, p_body = _base(file, joint, frames, "socket_child_frame")
    return body, ModelJoint(parent, p_parent, p_body)


def _base(file: str, joint: Element, frames: dict[str, Element], end: str) -> tuple[str, Array]:
    """The body under one end of a joint, and where on it the joint is."""
    name = joint.findtext(end, "").strip()
    frame = frames.get(name.rpartition("/")[2])
    if frame is None:
        return name.rpartition("/")[2], frozen(np.zeros(3))
    place = _three(file, frame.findtext("translation", "0 0 0"))
    return frame.findtext("socket_parent", "").strip().rpartition("/")[2], place


def _three(file: str, text: str) -> Array:
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError:
        values = np.zeros(0)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise FormatError(f"{file} has {text.strip()[:40]!r} where three numbers are due.")
    return frozen(values)


BALL_SHARE: Final = 0.73
"""Of a foot's length, from the heel to where the toes bend (Gordon et al. 2014, ball of foot)."""

IN_LINE_M: Final = 0.01
"""Markers no farther beside a line do not show how they are turned about it."""

_SIDE: Final = {"r": "right", "l": "left"}
_LIMBS: Final = {
    "thigh": ("femur", "tibia", "shin"),
    "shin": ("tibia", "talus", "foot"),
    "upper_arm": ("humerus", "ulna", "forearm"),
    "forearm": ("radius", "hand", "hand"),
}
"""By part the model's body, the one that hangs on it, and the part that hangs on ours."""
_UPPER: Final = ("chest", "clavicle", "neck", "head")
_KINDS: Final = {*_LIMBS, *_UPPER, "waist", "foot", "hand"}


@dataclass(frozen=True, eq=False)
class Scaled:
    """factors: (3,) of every body of the model, along its x forward, y up, z right.
    placed: the markers, each by its body and its place (3,) there once scaled, metres.
    """

    factors: Mapping[str, Array]
    placed: Mapping[str, tuple[str, Array]]

    @property
    def shows_tilt(self) -> bool:
        """Whether the markers show how the pelvis is turned: not all of its own lie in one
        line.
        """
        places = np.array([place for body, place in self.placed.values() if body == "pelvis"])
        if len(places) < 3:
            return False
        beside_line_m = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)[1]
        return bool(beside_line_m > IN_LINE_M)


def scaled(model: OpenSimModel, body: Body, markers: tuple[Marker, ...]) -> Scaled:
    """The model as large as the body, with the markers on parts that it has.

    FormatError where its torso does not hang on its pelvis.
    """
    factors = _factors(model, body)
    placeable = [m for m in markers if _kind_and_side(m.part)[0] in _KINDS]
    return Scaled(factors, {m.name: _placed(model, body, factors, m) for m in placeable})


def mid_hips(model: OpenSimModel, factors: Mapping[str, Array]) -> Array:
    """(3,) The middle of the hips in the scaled pelvis."""
    both = (model.joints["femur_r"].p_parent + model.joints["femur_l"].p_parent) / 2
    return np.asarray(both * factors["pelvis"])


def _factors(model: OpenSimModel, body: Body) -> dict[str, Array]:
    joints = model.joints
    pelvis, torso = _trunk(model, body)
    factors = {"pelvis": pelvis, "torso": torso}
    whole = 0.0
    for s, side in _SIDE.items():
        shin, foot, forearm, hand = (
            _own_joint(body, f"{side}_{part}") for part in ("shin", "foot", "forearm", "hand")
        )
        femur = _ratio(shin, joints[f"tibia_{s}"].p_parent - joints[f"femur_{s}"].p_body)
        tibia = _ratio(foot, joints[f"talus_{s}"].p_parent - joints[f"tibia_{s}"].p_body)
        upper = _ratio(forearm, joints[f"ulna_{s}"].p_parent - joints[f"humerus_{s}"].p_body)
        lower = _ratio(hand, _elbow_to_wrist(model, s))
        foot_factor = _foot_factor(model, body, s)
        factors |= {
            f"femur_{s}": femur,
            f"patella_{s}": femur,
            f"tibia_{s}": tibia,
            f"talus_{s}": foot_factor,
            f"calcn_{s}": foot_factor,
            f"toes_{s}": foot_factor,
            f"humerus_{s}": upper,
            f"ulna_{s}": lower,
            f"radius_{s}": lower,
            f"hand_{s}": lower,
        }
        whole += (float(femur[0]) + float(tibia[0]) + float(torso[1])) / 6
    return {name: factors.get(name, np.full(3, whole)) for name in model.bodies}


def _trunk(model: OpenSimModel, body: Body) -> tuple[Array, Array]:
    """Factors of pelvis and torso."""
    hip, left_hip = _anatomical(body, "right_thigh"), _anatomical(body, "left_thigh")
    lumbar, shoulder = _anatomical(body, "chest"), _under(body, "right_upper_arm")
    joints = model.joints
    if joints["torso"].parent != "pelvis":
        raise FormatError(
            "The torso of this model does not hang on its pelvis by one joint: choose a model "
            "without single vertebrae, such as Model_Pose2Sim_simple.osim."
        )
    high = (lumbar - (hip + left_hip) / 2)[1]
    high_there = (joints["torso"].p_parent - joints["femur_r"].p_parent)[1]
    wide = (hip - left_hip)[2] / (joints["femur_r"].p_parent - joints["femur_l"].p_parent)[2]
    arm = joints["humerus_r"].p_parent - joints["torso"].p_body
    return (
        _front_to_back(high / high_there, wide),
        _front_to_back(shoulder[1] / arm[1], shoulder[2] / arm[2]),
    )


def _front_to_back(high: float, wide: float) -> Array:
    return np.array([(high + wide) / 2, high, wide])


def _elbow_to_wrist(model: OpenSimModel, s: str) -> Array:
    """(3,) in the zero pose."""
    ulna, radius, hand = (model.joints[f"{name}_{s}"] for name in ("ulna", "radius", "hand"))
    return np.asarray((radius.p_parent - ulna.p_body) + (hand.p_parent - radius.p_body))


def _foot_factor(model: OpenSimModel, body: Body, s: str) -> Array:
    """Scale by the foot's length; 1 where model or body does not give it."""
    marks = body.parts[body.index(f"{_SIDE[s]}_foot")].landmarks
    heel, toe = (marks.get(f"{_SIDE[s]}_{end}") for end in ("heel", "toe"))
    toes = model.joints.get(f"toes_{s}")
    if heel is None or toe is None or toes is None:
        return np.ones(3)
    return _ratio(BALL_SHARE * np.subtract(toe, heel), toes.p_parent)


def _placed(
    model: OpenSimModel, body: Body, factors: Mapping[str, Array], marker: Marker
) -> tuple[str, Array]:
    """The model's body that carries a marker, and its place there."""
    p = R_ANATOMICAL_PART @ np.array(marker.p_part)
    kind, s = _kind_and_side(marker.part)
    joints = model.joints
    if kind == "waist":
        ours = (_anatomical(body, "right_thigh") + _anatomical(body, "left_thigh")) / 2
        return "pelvis", mid_hips(model, factors) + p - ours
    if kind in _UPPER:
        p_torso = joints["torso"].p_body * factors["torso"] + p + _under(body, marker.part)
        p_torso = p_torso - _behind_hips(model, factors)
        head = joints.get("head")
        if kind != "head" or head is None:
            return "torso", p_torso
        return "head", p_torso - head.p_parent * factors["torso"] + head.p_body * factors["head"]
    if kind == "foot":
        calcn = joints[f"calcn_{s}"]
        ankle = calcn.p_body * factors[f"calcn_{s}"]
        ankle = ankle + (joints[f"talus_{s}"].p_body - calcn.p_parent) * factors[f"talus_{s}"]
        return f"calcn_{s}", ankle + p
    if kind == "hand":
        turned = np.diag([1.0, 1.0, 1.0 if s == "r" else -1.0])
        at = joints[f"hand_{s}"].p_body * factors[f"hand_{s}"]
        return f"hand_{s}", at + turned @ R_PALM_FORWARD @ turned @ p
    upper, lower, part = _LIMBS[kind]
    near, far = joints[f"{upper}_{s}"].p_body, joints[f"{lower}_{s}"].p_parent
    factor = factors[f"{upper}_{s}"]
    along = _anatomical(body, f"{_SIDE[s]}_{part}")
    if kind == "forearm":  # the radius begins beside the elbow: its wrist is what is known of it
        return f"{upper}_{s}", far * factor + p - along
    share = float(p @ along) / float(along @ along)
    return f"{upper}_{s}", near * factor + p + share * ((far - near) * factor - along)


def _behind_hips(model: OpenSimModel, factors: Mapping[str, Array]) -> Array:
    """(3,) How far back the model's torso stands of its hips; ours stands over them at rest."""
    lumbar = model.joints["torso"].p_parent * factors["pelvis"]
    return np.array([(lumbar - mid_hips(model, factors))[0], 0.0, 0.0])


def _kind_and_side(part: str) -> tuple[str, str]:
    """Such as thigh and r."""
    for s, side in _SIDE.items():
        if part.startswith(f"{side}_"):
            return part.removeprefix(f"{side}_"), s
    return part, ""


def _under(body: Body, name: str) -> Array:
    """(3,) A part's origin in the chest at rest, x forward, y up, z right."""
    at = np.zeros(3)
    while name != "chest":
        part = body.parts[body.index(name)]
        at += R_ANATOMICAL_PART @ np.array(part.joint_m)
        if part.parent is None:
            raise FormatError(f"The body's {name} does not hang on its chest.")
        name = part.parent
    return at


def _own_joint(body: Body, name: str) -> Array:
    return np.array(body.parts[body.index(name)].joint_m)


def _anatomical(body: Body, name: str) -> Array:
    """(3,) A part's joint in its parent, x forward, y up, z right."""
    return np.asarray(R_ANATOMICAL_PART @ _own_joint(body, name))


def _ratio(ours: Array, theirs: Array) -> Array:
    """(3,) The same along all axes."""
    return np.full(3, float(np.linalg.norm(ours) / np.linalg.norm(theirs)))
