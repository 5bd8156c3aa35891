"""By how much the angles of a tracked person are expected to be off, from the errors of joints.

One view shows well where a joint is across the line of sight, and poorly how far away it is. From
the middle of the hips, errors along the view pass from joint to joint: a knee that is too near
takes its ankle along, so the shin between them is surer than either. A direction is off by what
its two ends are off from one another; a hinge, elbow or knee, shows besides how far the bone above
it is turned about its length, the more the more it is bent. What no keypoint shows, hands, feet,
the head, and a straight limb about its length, is only known as well as bodies usually hold it.

Errors are medians, half of all are smaller: of four films with truth in space, each part of the
network's training left out, `python -m bench angles` compares them with what is measured.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from keypose.tracker.body.joint_angles import (
    R_ANATOMICAL_PART,
    ROOT,
    Joint,
    joint_rotations,
    joints_of,
)
from keypose.tracker.body.pose import part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array

MEDIAN_OF_SIGMA: Final = 0.674
"""Half of what is distributed normally is off by less."""
PASSED_ON: Final = 0.85
"""Correlation, along the view, of the errors of a joint and of the next one down a limb."""
SHOULDERS_ALIKE: Final = 0.5
"""The same of the two shoulders. The hips' are opposite: errors count from their middle."""
DEFINED_RAD: Final = np.radians(3.5)
"""How well a bone's direction is defined: makers of bodies put joints differently."""
TURNED_RAD: Final = np.radians(15.0)
"""Standard deviation of how a limb is turned about its length where nothing shows it."""
UNSEEN_RAD: Final = np.radians(20.0)
"""The median of an angle that is not seen: it stays as keyframes have it."""
GUESSED_RAD: Final = np.radians(12.0)
"""An angle that is expected to be off by more is a guess."""
LEAST_COSINE: Final = 0.1
"""Of the middle angle: nearer to the pole the other two are not told apart."""
NEAREST_M: Final = 0.05
"""A body is taken to be no nearer."""
CHUNK: Final = 256
"""Frames at a time."""

_LIMBS: Final = (("thigh", "shin", "foot"), ("upper_arm", "forearm", "hand"))
_SIDES: Final = ("left", "right")
_HINGES: Final = ("knee", "elbow")
_JOINTS: Final = tuple(f"{side}_{part}" for limb in _LIMBS for side in _SIDES for part in limb)
"""Parts, each of which begins at its joint, limb by limb."""


def direction_errors(
    skeleton: Skeleton, motion: Trajectory, across_m: Array, along_m: Array
) -> Array | None:
    """(N, P) radians by which the parts that are seen are expected to point elsewhere: limbs, and
    the waist's and the chest's lines from left to right; medians, NaN of others and where nothing
    was observed. None where the body is not a person's.

    across_m, along_m (N, P): by which the joint at the far end of a part is expected to be off, in
    the picture and along the view; medians, NaN where nothing is known.
    """
    if not _is_persons(skeleton):
        return None
    errors = np.full((len(motion), skeleton.part_count), np.nan)
    for rows, body in _pieces(skeleton, motion, across_m, along_m):
        for name, line in body.lines.items():
            turn = body.turns[name] - line[:, None] * (body.turns[name] @ line[..., None])
            errors[rows, skeleton.body.index(name)] = _median(turn)
    return errors


def angle_errors(
    skeleton: Skeleton,
    motion: Trajectory,
    across_m: Array,
    along_m: Array,
    R_ground_camera: Array | None = None,
    joints: Collection[Joint] | None = None,
) -> dict[Joint, Array] | None:
    """(N, 3) radians by which every joint's three angles are expected to be off, as of
    `direction_errors`; None where the body is not a person's.

    R_ground_camera (3, 3) or (N, 3, 3): without it the pelvis' angles are left out.  joints: those
    that are wanted, all where None.
    """
    if not _is_persons(skeleton):
        return None
    wanted = [
        joint
        for joint in joints_of(skeleton.body)
        if (joint.carrier != ROOT or R_ground_camera is not None)
        and (joints is None or joint in joints)
    ]
    ground = np.eye(3) if R_ground_camera is None else R_ground_camera
    ground = np.broadcast_to(ground, (len(motion), 3, 3))
    errors_of_joint = {joint: np.full((len(motion), 3), np.nan) for joint in wanted}
    for rows, body in _pieces(skeleton, motion, across_m, along_m):
        for joint in wanted:
            errors_of_joint[joint][rows] = _of_joint(skeleton, body, joint, ground[rows])
    return errors_of_joint


def in_metres(
    errors_px: Array, camera: Camera, ps_camera_root: Array, zoom: Array | float = 1.0
) -> Array:
    """(N, P) errors in the picture in metres where the body is.

    ps_camera_root (N, 3).  zoom: (N,) by which the camera's focal length is multiplied.
    """
    away_m = np.maximum(camera.depth(ps_camera_root), NEAREST_M)
    return np.asarray(errors_px * (away_m / (math.sqrt(camera.fx * camera.fy) * zoom))[:, None])


def _is_persons(skeleton: Skeleton) -> bool:
    names = set(skeleton.body.names)
    return {*_JOINTS, "chest"} <= names and bool(joints_of(skeleton.body))


def _pieces(
    skeleton: Skeleton, motion: Trajectory, across_m: Array, along_m: Array
) -> Iterator[tuple[slice, _Posed]]:
    """Some frames at a time."""
    carriers = [skeleton.parents[skeleton.body.index(name)] for name in _JOINTS]
    across, along = (values[:, carriers] / MEDIAN_OF_SIGMA for values in (across_m, along_m))
    for at in range(0, len(motion), CHUNK):
        rows = slice(at, at + CHUNK)
        Rs = motion.Rs_parent_part[rows]
        Ts = part_transforms(skeleton, Rs, motion.ps_camera_root[rows])
        yield (
            rows,
            _Posed(
                dict(zip(skeleton.body.names, np.moveaxis(Ts, 1, 0), strict=True)),
                Rs,
                across[rows],
                along[rows],
            ),
        )


def _of_joint(skeleton: Skeleton, body: _Posed, joint: Joint, ground: Array) -> Array:
    """(N, 3) of a joint's angles about z, x and y."""
    is_seen = np.asarray(np.isfinite(body.along_m).all(axis=-1))[:, None]
    unseen = np.full((len(is_seen), 3), UNSEEN_RAD)
    if joint.part not in body.turns or (joint.carrier != ROOT and joint.carrier not in body.turns):
        return np.where(is_seen, unseen, np.nan)
    turned, R_axes_camera = body.turns[joint.part], joint.axes_turned @ ground
    if joint.carrier != ROOT:
        turned = turned - body.turns[joint.carrier]
        R_carrier_camera = np.swapaxes(body.Ts_camera_part[joint.carrier][:, :3, :3], -1, -2)
        R_axes_camera = joint.axes_turned @ R_ANATOMICAL_PART @ R_carrier_camera
    rates = (
        _rates(joint_rotations(skeleton.body, joint, body.Rs_parent_part, ground)) @ R_axes_camera
    )
    each = _median((turned @ np.swapaxes(rates, -1, -2))[..., None])
    each = np.minimum(each, np.pi / 2)
    if joint.name.endswith(_HINGES):
        each[:, 1:] = UNSEEN_RAD
    return np.where(is_seen, each, np.nan)


def _rates(R: Array) -> Array:
    """(N, 3, 3) from small turns, in the axes of the carrier, to angles z, x, y of Rz · Rx · Ry."""
    z = np.arctan2(-R[:, 0, 1], R[:, 1, 1])
    sin_x = np.clip(R[:, 2, 1], -1.0, 1.0)
    cos_x = np.maximum(np.sqrt(1 - sin_x**2), LEAST_COSINE)
    c, s = np.cos(z), np.sin(z)
    zero = np.zeros_like(z)
    along_y = np.stack([-s, c, zero], axis=-1) / cos_x[:, None]
    about_z = np.stack([zero, zero, zero + 1], axis=-1) - sin_x[:, None] * along_y
    about_x = np.stack([c, s, zero], axis=-1)
    return np.stack([about_z, about_x, along_y], axis=1)


def _median(causes: Array) -> Array:
    """(N, …) the median of the sum of independent causes (N, K, …, d), with what every direction is
    unsure by."""
    square = np.square(MEDIAN_OF_SIGMA * causes).sum(axis=(1, -1))
    return np.asarray(np.sqrt(square + DEFINED_RAD**2))


@dataclass(frozen=True, eq=False)
class _Posed:
    """N frames of a person, and how unsure their joints are.

    Ts_camera_part: (N, 4, 4) by part.  Rs_parent_part (N, P, 3, 3).
    across_m, along_m (N, Q): standard deviations of `_JOINTS`.
    """

    Ts_camera_part: Mapping[str, Array]
    Rs_parent_part: Array
    across_m: Array
    along_m: Array

    def point(self, name: str) -> Array:
        """(N, 3) where a part begins, camera frame."""
        return self.Ts_camera_part[name][:, :3, 3]

    @cached_property
    def lines(self) -> dict[str, Array]:
        """(N, 3) unit vectors along the bones that are seen, of waist and chest from right to
        left."""
        p = self.point
        line_of_part = {"waist": p("left_thigh") - p("right_thigh")}
        line_of_part["chest"] = p("left_upper_arm") - p("right_upper_arm")
        for upper, lower, end in _limbs():
            line_of_part[upper], line_of_part[lower] = p(lower) - p(upper), p(end) - p(lower)
        return {name: _unit(line) for name, line in line_of_part.items()}

    @cached_property
    def turns(self) -> dict[str, Array]:
        """(N, K, 3) radians, camera frame, by which each independent cause turns a part: standard
        deviations."""
        off = dict(zip(_JOINTS, self._displaced(), strict=True))
        p, lines = self.point, self.lines
        middle = 0.5 * (off["left_upper_arm"] + off["right_upper_arm"])
        spine = 0.5 * (p("left_upper_arm") + p("right_upper_arm"))
        spine = spine - 0.5 * (p("left_thigh") + p("right_thigh"))
        lean = _swing(spine, middle)
        turn_of_part = {}
        for name, left, right in (
            ("waist", "left_thigh", "right_thigh"),
            ("chest", "left_upper_arm", "right_upper_arm"),
        ):
            about = lines[name][:, None] * (lean @ lines[name][..., None])
            turn_of_part[name] = _swing(p(left) - p(right), off[left] - off[right]) + about
        for upper, lower, end in _limbs():
            turn_of_part[upper] = _swing(p(lower) - p(upper), off[lower] - off[upper])
            turn_of_part[lower] = _swing(p(end) - p(lower), off[end] - off[lower])
        return self._with_twists(turn_of_part)

    def _displaced(self) -> Iterator[Array]:
        """(N, K, 3) of each joint, metres."""
        passed = _passed_on()
        for q, name in enumerate(_JOINTS):
            ray = _unit(self.point(name))
            side = _unit(np.cross(ray, [0.0, 1.0, 0.0]))
            along = self.along_m[:, q, None, None] * passed[q][:, None] * ray[:, None]
            across = np.zeros((len(ray), 2 * len(_JOINTS), 3))
            across[:, 2 * q] = self.across_m[:, q, None] * side
            across[:, 2 * q + 1] = self.across_m[:, q, None] * np.cross(ray, side)
            yield np.concatenate([along, across], axis=1)

    def _with_twists(self, turns: dict[str, Array]) -> dict[str, Array]:
        """Add how limbs may be turned about their length, each a cause of its own."""
        count = len(turns["waist"])
        twists = {}
        lines = self.lines
        for upper, lower, _ in _limbs():
            normal = np.cross(lines[upper], lines[lower])
            sine = np.linalg.norm(normal, axis=-1)
            inside = np.cross(_unit(normal), lines[upper])
            apart = np.square((turns[lower] - turns[upper]) @ inside[..., None]).sum(axis=(1, 2))
            shown = np.square(sine) / np.maximum(apart, 1e-12)
            twists[upper] = lines[upper] / np.sqrt(1 / TURNED_RAD**2 + shown)[:, None]
        turn_of_part = {}
        for name, turn in turns.items():
            own = np.zeros((count, len(twists), 3))
            if name in twists:
                own[:, list(twists).index(name)] = twists[name]
            turn_of_part[name] = np.concatenate([turn, own], axis=1)
        return turn_of_part


def _limbs() -> Iterator[tuple[str, str, str]]:
    for upper, lower, end in _LIMBS:
        for side in _SIDES:
            yield f"{side}_{upper}", f"{side}_{lower}", f"{side}_{end}"


def _passed_on() -> Array:
    """(Q, K) how independent causes, each of variance 1, make the errors of `_JOINTS` along the
    view."""
    own = np.sqrt(1 - PASSED_ON**2)
    common, each = np.sqrt(SHOULDERS_ALIKE), np.sqrt(1 - SHOULDERS_ALIKE)
    causes = np.zeros((len(_JOINTS), 2 + len(_JOINTS)))  # hips, each joint's own, shoulders
    for q, name in enumerate(_JOINTS):
        side, part = name.split("_", 1)
        if part == "thigh":
            causes[q, 0] = 1.0 if side == "left" else -1.0
        elif part == "upper_arm":
            causes[q, -1], causes[q, 1 + q] = common, each
        else:
            causes[q] = PASSED_ON * causes[q - 1]
            causes[q, 1 + q] = own
    return causes


def _swing(line: Array, off: Array) -> Array:
    """(N, K, 3) the turn of a line (N, 3) whose end is displaced by `off` (N, K, 3) from its
    beginning."""
    return np.asarray(np.cross(line[:, None], off) / np.square(line).sum(-1)[:, None, None])


def _unit(v: Array) -> Array:
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-9))
