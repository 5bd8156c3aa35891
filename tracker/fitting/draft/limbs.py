"""The joints of a person's limbs as a chain, from the hips outward; and points of head and feet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import ROTATIONS, Body, Point
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.solver.posed import BodyPoints

SIDES: Final = ("left", "right")
LIMBS: Final = (("shoulder", "elbow", "wrist"), ("hip", "knee", "ankle"))
ENDS: Final = (
    *("nose", "left_ear", "right_ear", "left_heel", "right_heel"),
    *("left_foot_index", "right_foot_index"),
)
"""Keypoints that show how head and feet are turned."""
POINTS: Final = (*JOINTS, *ENDS)
_ON_HEAD: Final = {
    "nose": (0.0, 0.4, -0.55), "left_ear": (0.4, 0.45, 0.0), "right_ear": (-0.4, 0.45, 0.0)
}  # fmt: skip
"""Where on a head they are: to the side, up and forward, as shares of its height."""
_NEARER_M: Final = {"elbow": 0.02, "wrist": 0.01, "ankle": 0.02}
"""The network puts these so much nearer to the trunk, along the limb, than where the limb turns:
the mean over four people in five clips, two of them rendered. With it 13 % fewer joints of their
drafts are more than 7 px off."""


class Bone(NamedTuple):
    """From one joint to the next: places among `JOINTS`, and the part between them."""

    near: int
    far: int
    part: int


class Limb(NamedTuple):
    """An arm or a leg: its upper and its lower bone, and where its hinge bends to: the far joint
    goes along this direction of the upper part when the limb is bent."""

    upper: Bone
    lower: Bone
    bends_to: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Joints:
    """The twelve `JOINTS` of a person's body.

    parts (12,): the part that carries each.  points: them on the body.  seen: where on it the
    network puts them.
    rest (12, 3): where they are in the rest pose, metres from the root.
    limbs: arms and legs, left before right.
    ends: where the body has points of `ENDS`, places among `POINTS`, and these points on it.
    """

    skeleton: Skeleton
    parts: NDArray[np.int64]
    points: BodyPoints
    seen: BodyPoints
    rest: Array
    limbs: tuple[Limb, ...]
    ends: tuple[NDArray[np.int64], BodyPoints]

    @classmethod
    def of(cls, skeleton: Skeleton) -> Joints:
        """KeypointError for a body without one of them."""
        body = skeleton.body
        index, parts, places = points_on_body(body, JOINTS)
        if len(index) < len(JOINTS):
            raise KeypointError(
                f"The body {body.name!r} has no joints of a person's arms and legs: a draft is "
                "made of people only."
            )
        points = BodyPoints.single(skeleton, parts, places)
        rest = points.at(pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0))))
        limbs = tuple(_limb(body, parts, side, names) for names in LIMBS for side in SIDES)
        seen = BodyPoints.single(skeleton, parts, places - _nearer(places))
        return cls(skeleton, parts, points, seen, rest, limbs, _ends(skeleton))

    def length_m(self, bone: Bone) -> float:
        """Of a bone on this body."""
        return float(np.linalg.norm(self.rest[bone.far] - self.rest[bone.near]))

    def seen_length_m(self, bone: Bone) -> float:
        """Between the points that the network sees at its ends."""
        near, far = (_NEARER_M.get(JOINTS[end].split("_")[1], 0.0) for end in (bone.near, bone.far))
        return self.length_m(bone) + near - far

    @property
    def bones(self) -> tuple[Bone, ...]:
        """Upper and lower ones of all limbs."""
        return tuple(bone for limb in self.limbs for bone in (limb.upper, limb.lower))


def place_of(side: str, joint: str) -> int:
    """Among `JOINTS`."""
    return JOINTS.index(f"{side}_{joint}")


def _nearer(places: Array) -> Array:
    """(12, 3) from where the network puts the joints to where they are, in their parts' frames."""
    length = np.linalg.norm(places, axis=-1, keepdims=True)
    by_m = np.array([_NEARER_M.get(name.split("_")[1], 0.0) for name in JOINTS])
    return np.asarray(places / np.maximum(length, 1e-9) * by_m[:, None])


def turning_ends(joints: Joints) -> Skeleton:
    """The body with those parts alone free to turn that carry `ENDS`."""
    body = joints.skeleton.body
    ends = {body.names[part] for place in joints.ends[1].points for part, _ in place}
    some = (
        part.model_copy(update={"tracked": ROTATIONS if part.name in ends else ()})
        for part in body.parts
    )
    return Skeleton.of(body.replaced(some))


def _ends(skeleton: Skeleton) -> tuple[NDArray[np.int64], BodyPoints]:
    found = {name: place for name in ENDS if (place := _end(skeleton.body, name))}
    index = np.array([POINTS.index(name) for name in found], dtype=np.int64)
    return index, BodyPoints(skeleton, tuple((place,) for place in found.values()))


def _end(body: Body, name: str) -> tuple[int, Point] | None:
    """The part that carries an end and where; None on a body without it."""
    if name in _ON_HEAD:
        top = _landmark(body, "head", "head_top")
        if top is None:
            return None
        aside, up, forward = _ON_HEAD[name]
        size = -top[1]
        return body.index("head"), (aside * size, -up * size, forward * size)
    side, _, what = name.partition("_")
    part, landmark = f"{side}_foot", f"{side}_{'heel' if what == 'heel' else 'toe'}"
    place = _landmark(body, part, landmark)
    return None if place is None else (body.index(part), place)


def _landmark(body: Body, part: str, name: str) -> Point | None:
    return body.parts[body.index(part)].landmarks.get(name) if part in body.names else None


def _limb(body: Body, parts: NDArray[np.int64], side: str, names: tuple[str, ...]) -> Limb:
    near, middle, far = (place_of(side, name) for name in names)
    upper, lower = int(parts[middle]), int(parts[far])
    low, high = body.parts[lower].limits_deg.get("x", (0.0, 0.0))
    # a turn by a positive angle about x brings a point from +y to +z
    bends_to = (0.0, 0.0, float(np.sign(low + high)))
    return Limb(Bone(near, middle, upper), Bone(middle, far, lower), bends_to)
