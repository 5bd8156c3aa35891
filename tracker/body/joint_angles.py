"""The joint angles of a person, as movement science names them: flexion, adduction, rotation.

**Axes.** Every part has x forward, y up and z to the right, as the International Society of
Biomechanics recommends (Wu et al. 2002, 2005); a part's own axes are x left, y down, z back, the
body at rest facing the camera. All angles are 0 in the rest pose: upright, arms hanging, thumbs
forward.

**Order.** A rotation is R = Rz · Rx · Ry: flexion about the z of the part that carries the joint,
rotation about the y of the part that moves, adduction about the axis at right angles to both. That
is the joint coordinate system of Grood and Suntay (1983), which the society takes up for hip, knee
and ankle, and what full-body models of OpenSim use (Rajagopal et al. 2016). The shoulder has the
same order, as in that model; the society's Y-X-Y says nothing where an arm hangs. The pelvis has
this order as well.

**Over time** angles run on without jumps, beyond half a turn where the motion does. Where an upper
arm points straight sideways flexion and rotation are not determined one by one: within 20° of there
they are smoothed, and leave the pose by a degree, where it passes fast by up to seven
(`keypose.tracker.body.cardan`); beside there they may still turn faster than the arm.

**Signs.** Left limbs are mirrored, so that both sides have the same signs; `JOINTS` names what is
positive. Pelvis, trunk and neck count bending and obliquity to the right, turns to the left.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.cardan import continuous_zxy
from keypose.tracker.geometry.rotations import Array, frozen

R_ANATOMICAL_PART: Final = frozen([[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]])
"""A part's frame to x forward, y up, z right; the same for every part at rest."""

_MIRRORED = np.diag([1.0, 1.0, -1.0])
R_PALM_FORWARD: Final = frozen([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
"""Thumbs forward to palms forward, as the right hand's axes are meant: x out of the palm."""

ROOT = ""
"""Stands for the ground, where a joint has no part that carries it."""


@dataclass(frozen=True)
class Angle:
    """One of the three angles of a joint.

    name:    what is positive, as in columns of tables: "flexion".
    other:   what is negative: "extension".
    sign:    of the Cardan angle, of the right side.
    """

    name: str
    other: str
    sign: float = 1.0


@dataclass(frozen=True)
class Joint:
    """A joint of a person: where the rotation of `part` in `carrier` is read.

    angles: about z, x and y, in this order.
    usual_deg: near which the angles of a motion are chosen, of a right limb, signs as of the axes:
        every rotation has two triples, and an arm raised beyond the horizontal needs to be given
        which.
    """

    name: str
    part: str
    carrier: str
    angles: tuple[Angle, Angle, Angle]
    usual_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def left(self) -> bool:
        return self.name.startswith("left_")

    @property
    def axes_turned(self) -> Array:
        """(3, 3) From the axes of this file's top to those that the joint's angles are about."""
        turned = R_PALM_FORWARD if self.name.endswith("wrist") else np.eye(3)
        return np.asarray(turned @ _MIRRORED) if self.left else turned


_FLEXION = Angle("flexion", "extension")
_FLEXION_BACK = Angle("flexion", "extension", -1.0)
"""Of the knee, which bends backward, and of the trunk, which stands on what carries it."""
_ADDUCTION = Angle("adduction", "abduction")
_TURN = Angle("internal_rotation", "external_rotation")
_TURN_LEFT = Angle("rotation", "rotation_right")
_BENT = (_FLEXION_BACK, Angle("bending", "bending_left"), _TURN_LEFT)
_TILTED = (
    Angle("anterior_tilt", "posterior_tilt", -1.0),
    Angle("obliquity", "obliquity_left", -1.0),
    _TURN_LEFT,
)
_ELBOW = (_FLEXION, _ADDUCTION, Angle("pronation", "supination"))
_WRIST = (_FLEXION, Angle("ulnar_deviation", "radial_deviation"), _TURN)
_ANKLE = (Angle("dorsiflexion", "plantarflexion"), Angle("inversion", "eversion"), _TURN)

_LIMBS: Final[dict[str, tuple[str, str, tuple[Angle, Angle, Angle]]]] = {
    "shoulder": ("upper_arm", "chest", (_FLEXION, _ADDUCTION, _TURN)),
    "elbow": ("forearm", "upper_arm", _ELBOW),
    "wrist": ("hand", "forearm", _WRIST),
    "hip": ("thigh", "waist", (_FLEXION, _ADDUCTION, _TURN)),
    "knee": ("shin", "thigh", (_FLEXION_BACK, _ADDUCTION, _TURN)),
    "ankle": ("foot", "shin", _ANKLE),
}
_USUAL_SHOULDER_DEG = (60.0, -60.0, 0.0)
"""Half of how far an arm is raised, forward and sideways."""
_TRUNK = ("waist", "chest", "head")


def _on(side: str, joint: str) -> Joint:
    part, carrier, angles = _LIMBS[joint]
    on = carrier if carrier in _TRUNK else f"{side}_{carrier}"
    usual = _USUAL_SHOULDER_DEG if joint == "shoulder" else (0.0, 0.0, 0.0)
    return Joint(f"{side}_{joint}", f"{side}_{part}", on, angles, usual)


JOINTS: Final[tuple[Joint, ...]] = (
    Joint("pelvis", "waist", ROOT, _TILTED),
    Joint("trunk", "chest", "waist", _BENT),
    Joint("neck", "head", "chest", _BENT),
    *(_on(side, joint) for joint in _LIMBS for side in ("left", "right")),
)
"""Every joint with a name. Trunk is the chest in the pelvis, neck the head in the chest."""


@dataclass(frozen=True, eq=False)
class JointAngles:
    """One joint over N frames. angles_deg: (N, 3) of `joint.angles`, NaN where not known.

    errors_deg: (N, 3) by which they are expected to be off, see
        `keypose.tracker.body.angle_errors`; None where nothing is known of any.
    """

    joint: Joint
    angles_deg: Array
    errors_deg: Array | None = None

    def __getitem__(self, name: str) -> Array:
        """(N,) one of the angles by its name."""
        return np.asarray(self.angles_deg[:, self._column(name)])

    def error_deg(self, name: str) -> Array | None:
        """(N,) by which one of them is expected to be off; None where that is not known."""
        errors = self.errors_deg
        return None if errors is None else np.asarray(errors[:, self._column(name)])

    def _column(self, name: str) -> int:
        return [angle.name for angle in self.joint.angles].index(name)


def joints_of(body: Body) -> tuple[Joint, ...]:
    """The joints of a body whose rest pose is a person's; none of another body."""
    if not _stands_as_a_person(body):
        return ()
    return tuple(joint for joint in JOINTS if _chain(body, joint))


def joint_angles(
    body: Body, Rs_parent_part: Array, R_ground_camera: Array
) -> tuple[JointAngles, ...]:
    """Every joint's angles over N frames, degrees; none where the body is not a person's.

    Rs_parent_part:  (N, P, 3, 3), NaN where not known.
    R_ground_camera: (3, 3) the ground has y up; the pelvis is given in it.
    """
    angles = []
    for joint in joints_of(body):
        Rs = joint_rotations(body, joint, Rs_parent_part, R_ground_camera)
        angles.append(JointAngles(joint, _angles_deg(joint, Rs)))
    return tuple(angles)


def angles_of(body: Body, joint: Joint, rotations: Callable[[int], Array]) -> JointAngles:
    """One joint's angles over N frames, of a joint that another part carries.

    rotations: (N, 3, 3) of a part in its parent by the part's number, NaN where not known.
    """
    Rs = [rotations(i) for i in _chain(body, joint)]
    return JointAngles(joint, _angles_deg(joint, _in_its_axes(joint, Rs, R_ANATOMICAL_PART)))


def joint_rotations(
    body: Body, joint: Joint, Rs_parent_part: Array, R_ground_camera: Array
) -> Array:
    """The part in its carrier (N, 3, 3), in the axes that the joint's angles are about."""
    Rs = [Rs_parent_part[:, i] for i in _chain(body, joint)]
    return _in_its_axes(joint, Rs, R_ground_camera if joint.carrier == ROOT else R_ANATOMICAL_PART)


def _in_its_axes(joint: Joint, Rs: Sequence[Array], R_carrier: Array) -> Array:
    """Rotations one after the other, each (N, 3, 3), in the axes that the angles are about."""
    R = functools.reduce(np.matmul, Rs)
    turned = joint.axes_turned
    return np.asarray(turned @ (R_carrier @ R @ R_ANATOMICAL_PART.T) @ turned.T)


def _chain(body: Body, joint: Joint) -> tuple[int, ...]:
    """The parts from the one that the carrier carries to the joint's own; empty where the body has
    not both."""
    chain: list[int] = []
    name: str | None = joint.part
    while name is not None and name in body.names and name != joint.carrier:
        chain.insert(0, body.index(name))
        name = body.parts[chain[0]].parent
    reached = ROOT if name is None else name
    return tuple(chain) if reached == joint.carrier else ()


def _angles_deg(joint: Joint, rotations: Array) -> Array:
    signs = np.array([angle.sign for angle in joint.angles])
    is_known = np.isfinite(rotations).all(axis=(1, 2))
    made = np.full((len(rotations), 3), np.nan)
    if is_known.any():
        both = (continuous_zxy(rotations[is_known], turned) for turned in (0.0, np.pi))
        shown = (_near(joint, np.degrees(angles)) for angles in both)
        made[is_known] = min(shown, key=lambda candidate: candidate[0])[1]
    return np.asarray(made * signs + 0.0)


def _near(joint: Joint, angles: Array) -> tuple[float, Array]:
    """How far angles (N, 3) are from the usual ones in all, and the angles, by such whole
    turns over all frames as bring their middle, the pelvis' first ones, nearest to these, degrees.
    """
    usual = np.array(joint.usual_deg)
    middle = angles[0] if joint.carrier == ROOT else np.median(angles, axis=0)
    near = angles - 360.0 * np.round((middle - usual) / 360.0)
    return round(float(np.abs(near - usual).mean(axis=0).sum()), 6), near


def _stands_as_a_person(body: Body) -> bool:
    """Whether left is at +x and limbs hang along +y at rest, as in the presets."""
    limbs: Sequence[tuple[str, str]] = (
        ("thigh", "shin"),
        ("shin", "foot"),
        ("upper_arm", "forearm"),
    )
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for upper, lower in limbs:
            if not {f"{side}_{upper}", f"{side}_{lower}"} <= set(body.names):
                return False
            part = body.parts[body.index(f"{side}_{lower}")]
            along = np.array(part.joint_m)
            if part.parent != f"{side}_{upper}" or along[1] < 0.9 * np.linalg.norm(along):
                return False
        hip = body.parts[body.index(f"{side}_thigh")]
        if hip.parent != "waist" or hip.joint_m[0] * sign <= 0:
            return False
    return body.names[0] == "waist"
