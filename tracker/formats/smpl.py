"""The kinematic tree of SMPL-H, and a body laid into its rest pose.

The model itself, its surface and its own rest joints, is licensed apart and not needed: names and
parents of its joints are public, and where they rest is taken from our body. In the rest pose the
body stands as a T and looks along z; y points up and x to its left.

`RestBody` says for every joint which part carries it, how that part is turned in the rest pose, and
where the joint then is. The body's joints that the tree knows are where the parts have them, in
every pose, so that a pose of the tree repeats ours without an error. Of the others, what lies
between two of ours is spaced evenly and does not turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tracker.body.skeleton import Skeleton
from tracker.errors import FormatError, listed
from tracker.formats.axes import flipped
from tracker.formats.bvh import end_site
from tracker.geometry.rotations import Array, exp_rotation, frozen, transpose

JOINTS: Final = (
    *("pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2"),
    *("left_ankle", "right_ankle", "spine3", "left_foot", "right_foot", "neck", "left_collar"),
    *("right_collar", "head", "left_shoulder", "right_shoulder", "left_elbow", "right_elbow"),
    *("left_wrist", "right_wrist"),
)
"""The 22 joints of the body, as SMPL, SMPL-H and SMPL-X number them."""

PARENTS: Final = (-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19)

JOINT_COUNT: Final = 52
"""With the three joints of five fingers a hand: SMPL-H's."""

SPINE: Final = ("spine1", "spine2", "spine3")

BALL: Final = 2 / 3
"""Where the ball of the foot is on the way from ankle to toe."""

_LIMBS = {
    "shoulder": "upper_arm", "elbow": "forearm", "wrist": "hand",
    "hip": "thigh", "knee": "shin", "ankle": "foot",
}  # fmt: skip
_SIDES = {"left": 1.0, "right": -1.0}
_ARM, _LEG = ("shoulder", "elbow", "wrist"), ("hip", "knee")


@dataclass(frozen=True, eq=False)
class RestBody:
    """A body as the tree's rest pose has it.

    part:          (22,) the part that carries each joint, −1 where it moves with its parent's.
    Rs_part_rest:  (22, 3, 3) maps directions of the rest pose to the frame of that part, y up;
                   where there is none, to that of the nearest joint above that has one.
    ps_rest_joint: (22, 3) metres, the pelvis at the origin.
    """

    part: NDArray[np.int64]
    Rs_part_rest: Array
    ps_rest_joint: Array

    @classmethod
    def of(cls, skeleton: Skeleton) -> RestBody:
        """FormatError where the body lacks a part that every person has."""
        part = _carriers(skeleton)
        Rs = np.stack([_rest_turn(skeleton, joint, part) for joint in range(len(JOINTS))])
        return cls(_whole(part), frozen(Rs), frozen(_rest_places(skeleton, part, Rs)))


def _carriers(skeleton: Skeleton) -> list[int]:
    """By joint the part it belongs to, −1 for none."""
    names = skeleton.body.names
    wanted = {f"{side}_{j}": f"{side}_{p}" for side in _SIDES for j, p in _LIMBS.items()}
    wanted |= {"neck": "neck", "head": "head"}
    missing = [part.replace("_", " ") for part in wanted.values() if part not in names]
    if missing:
        raise FormatError(
            f"An SMPL body is a whole person, and this body has no {listed(missing[:3])}."
        )
    wanted |= {f"{side}_collar": f"{side}_clavicle" for side in _SIDES}
    found = {joint: names.index(part) for joint, part in wanted.items() if part in names}
    found |= {"pelvis": 0, **_spine(skeleton, found)}
    part = [found.get(joint, -1) for joint in JOINTS]
    _require_tree(skeleton, part)
    return part


def _spine(skeleton: Skeleton, found: dict[str, int]) -> dict[str, int]:
    """The parts between pelvis and neck."""
    between, part = list[int](), int(skeleton.parents[found["neck"]])
    while part > 0:
        between.append(part)
        part = int(skeleton.parents[part])
    if len(between) > len(SPINE):
        raise FormatError(
            f"An SMPL body has {len(SPINE)} joints between pelvis and neck, and this body has "
            f"{len(between)}."
        )
    return dict(zip(SPINE, reversed(between), strict=False))


def _require_tree(skeleton: Skeleton, part: list[int]) -> None:
    """What hangs on one another there must do so here, or joints would not stay where they are."""
    for joint, own in enumerate(part[1:], 1):
        if own >= 0 and skeleton.parents[own] != part[_above(part, joint)]:
            hung, on = (skeleton.body.names[i] for i in (own, part[_above(part, joint)]))
            raise FormatError(
                f"In an SMPL body the {hung} hangs on the {on}, and in this body it does not."
            )


def _above(part: list[int], joint: int) -> int:
    """The nearest joint above that has a part of its own."""
    joint = PARENTS[joint]
    while part[joint] < 0:
        joint = PARENTS[joint]
    return joint


def _rest_turn(skeleton: Skeleton, joint: int, part: list[int]) -> Array:
    """R_part_rest (3, 3): limbs are turned by the least that lays them straight; the rest stands.

    Part frames are those of the file, whose y points up.
    """
    if part[joint] < 0:
        return _rest_turn(skeleton, _above(part, joint), part)
    side, _, kind = JOINTS[joint].rpartition("_")
    if kind in _ARM:
        straight = np.array([_SIDES[side], 0.0, 0.0])
    elif kind in _LEG:
        straight = np.array([0.0, -1.0, 0.0])
    else:
        return np.eye(3)
    own = part[joint]
    below = [k for k in part if k >= 0 and skeleton.parents[k] == own]
    end = skeleton.joints[below[0]] if below else np.array(end_site(skeleton.body.parts[own]))
    return _least_turn(straight, flipped(end))


def _least_turn(start: Array, end: Array) -> Array:
    """The rotation about one axis that turns one direction (3,) into another (3,)."""
    axis = np.cross(start, end)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-12:
        return np.eye(3)
    return exp_rotation(axis / sine * np.arctan2(sine, start @ end))


def _rest_places(skeleton: Skeleton, part: list[int], Rs_part_rest: Array) -> Array:
    """(22, 3): where every joint rests, the pelvis at the origin."""
    ps: dict[int, Array] = {0: np.zeros(3)}
    for joint, own in enumerate(part[1:], 1):
        if own >= 0:
            above = _above(part, joint)
            ps[joint] = ps[above] + flipped(skeleton.joints[own]) @ Rs_part_rest[above]
    for side in _SIDES:
        ankle, ball = (JOINTS.index(f"{side}_{name}") for name in ("ankle", "foot"))
        toe = flipped(np.array(end_site(skeleton.body.parts[part[ankle]])))
        ps[ball] = ps[ankle] + BALL * toe
    _space_evenly(ps, [JOINTS.index(name) for name in ("pelvis", *SPINE, "neck")])
    for side in _SIDES:
        _space_evenly(
            ps, [JOINTS.index(n) for n in ("spine3", f"{side}_collar", f"{side}_shoulder")]
        )
    return np.stack([ps[joint] for joint in range(len(JOINTS))])


def _space_evenly(ps: dict[int, Array], chain: list[int]) -> None:
    """Give the joints of a chain that have no place one between their neighbours that have."""
    known = [k for k, joint in enumerate(chain) if joint in ps]
    for low, high in pairwise(known):
        for k in range(low + 1, high):
            share = (k - low) / (high - low)
            ps[chain[k]] = (1 - share) * ps[chain[low]] + share * ps[chain[high]]


def rotations_of(rest: RestBody, Rs_world_part: Array) -> Array:
    """Rs_parent_joint (N, 22, 3, 3), the pelvis' in the world, of a pose of all parts.

    Rs_world_part: (N, P, 3, 3) in any world, of part frames whose y points up in our rest pose.
    """
    Rs_world_joint = np.empty((len(Rs_world_part), len(JOINTS), 3, 3))
    Rs_parent_joint = np.empty_like(Rs_world_joint)
    for joint, parent in enumerate(PARENTS):
        if rest.part[joint] < 0:
            Rs_world_joint[:, joint] = Rs_world_joint[:, parent]
        else:
            R_part_rest = rest.Rs_part_rest[joint]
            Rs_world_joint[:, joint] = Rs_world_part[:, rest.part[joint]] @ R_part_rest
        above = np.eye(3) if parent < 0 else transpose(Rs_world_joint[:, parent])
        Rs_parent_joint[:, joint] = above @ Rs_world_joint[:, joint]
    return Rs_parent_joint


def joints_of(ps_rest_joint: Array, Rs_parent_joint: Array, ps_world_pelvis: Array) -> Array:
    """ps_world_joint (N, 22, 3): forward kinematics of the tree."""
    N = len(Rs_parent_joint)
    Rs, ps = np.empty((N, len(JOINTS), 3, 3)), np.empty((N, len(JOINTS), 3))
    Rs[:, 0], ps[:, 0] = Rs_parent_joint[:, 0], ps_world_pelvis
    for joint, parent in list(enumerate(PARENTS))[1:]:
        offset = ps_rest_joint[joint] - ps_rest_joint[parent]
        ps[:, joint] = ps[:, parent] + Rs[:, parent] @ offset
        Rs[:, joint] = Rs[:, parent] @ Rs_parent_joint[:, joint]
    return ps


def _whole(values: list[int]) -> NDArray[np.int64]:
    array = np.array(values, dtype=np.int64)
    array.setflags(write=False)
    return array
