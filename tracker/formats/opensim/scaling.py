"""A full-body model scaled to our body, and our markers on it.

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

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.joint_angles import R_ANATOMICAL_PART, R_PALM_FORWARD
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.marker_sets import Marker
from keypose.tracker.formats.opensim.model import OpenSimModel
from keypose.tracker.geometry.rotations import Array

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
        """Whether the markers show how the pelvis is turned: not all of its own lie in one line."""
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
    known = [m for m in markers if _kind_and_side(m.part)[0] in _KINDS]
    return Scaled(factors, {m.name: _placed(model, body, factors, m) for m in known})


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
            _joint(body, f"{side}_{part}") for part in ("shin", "foot", "forearm", "hand")
        )
        femur = _ratio(shin, joints[f"tibia_{s}"].p_parent - joints[f"femur_{s}"].p_body)
        tibia = _ratio(foot, joints[f"talus_{s}"].p_parent - joints[f"tibia_{s}"].p_body)
        upper = _ratio(forearm, joints[f"ulna_{s}"].p_parent - joints[f"humerus_{s}"].p_body)
        lower = _ratio(hand, _elbow_to_wrist(model, s))
        foot_factor = _foot_factor(model, body, s)
        factors |= {
            f"femur_{s}": femur, f"patella_{s}": femur, f"tibia_{s}": tibia,
            f"talus_{s}": foot_factor, f"calcn_{s}": foot_factor, f"toes_{s}": foot_factor,
            f"humerus_{s}": upper, f"ulna_{s}": lower, f"radius_{s}": lower, f"hand_{s}": lower,
        }  # fmt: skip
        whole += (float(femur[0]) + float(tibia[0]) + float(torso[1])) / 6
    return {name: factors.get(name, np.full(3, whole)) for name in model.bodies}


def _trunk(model: OpenSimModel, body: Body) -> tuple[Array, Array]:
    """Factors of pelvis and torso."""
    hip, other = _anatomical(body, "right_thigh"), _anatomical(body, "left_thigh")
    lumbar, shoulder = _anatomical(body, "chest"), _under(body, "right_upper_arm")
    joints = model.joints
    if joints["torso"].parent != "pelvis":
        raise FormatError(
            "The torso of this model does not hang on its pelvis by one joint: choose a model "
            "without single vertebrae, such as Model_Pose2Sim_simple.osim."
        )
    high = (lumbar - (hip + other) / 2)[1]
    high_there = (joints["torso"].p_parent - joints["femur_r"].p_parent)[1]
    wide = (hip - other)[2] / (joints["femur_r"].p_parent - joints["femur_l"].p_parent)[2]
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
    """By the foot's length; 1 where model or body does not give it."""
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


def _joint(body: Body, name: str) -> Array:
    return np.array(body.parts[body.index(name)].joint_m)


def _anatomical(body: Body, name: str) -> Array:
    """(3,) A part's joint in its parent, x forward, y up, z right."""
    return np.asarray(R_ANATOMICAL_PART @ _joint(body, name))


def _ratio(ours: Array, theirs: Array) -> Array:
    """(3,) The same along all axes."""
    return np.full(3, float(np.linalg.norm(ours) / np.linalg.norm(theirs)))
