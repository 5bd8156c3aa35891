"""The joints of a person's limbs as a chain, from the hips outward."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tracker.body.body import Body
from tracker.body.pose import Pose, pose_transforms
from tracker.body.skeleton import Skeleton
from tracker.errors import KeypointError
from tracker.geometry.rotations import Array
from tracker.keypoints.keypoints import JOINTS
from tracker.keypoints.on_body import points_on_body
from tracker.solver.body_points import BodyPoints

SIDES: Final = ("left", "right")
LIMBS: Final = (("shoulder", "elbow", "wrist"), ("hip", "knee", "ankle"))


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

    parts (12,): the part that carries each.  points: them on the body.
    rest (12, 3): where they are in the rest pose, metres from the root.
    limbs: arms and legs, left before right.
    """

    skeleton: Skeleton
    parts: NDArray[np.int64]
    points: BodyPoints
    rest: Array
    limbs: tuple[Limb, ...]

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
        return cls(skeleton, parts, points, rest, limbs)

    def length_m(self, bone: Bone) -> float:
        """Of a bone on this body."""
        return float(np.linalg.norm(self.rest[bone.far] - self.rest[bone.near]))

    @property
    def bones(self) -> tuple[Bone, ...]:
        """Upper and lower ones of all limbs."""
        return tuple(bone for limb in self.limbs for bone in (limb.upper, limb.lower))


def place_of(side: str, joint: str) -> int:
    """Among `JOINTS`."""
    return JOINTS.index(f"{side}_{joint}")


def _limb(body: Body, parts: NDArray[np.int64], side: str, names: tuple[str, ...]) -> Limb:
    near, middle, far = (place_of(side, name) for name in names)
    upper, lower = int(parts[middle]), int(parts[far])
    low, high = body.parts[lower].limits_deg.get("x", (0.0, 0.0))
    # a turn by a positive angle about x brings a point from +y to +z
    bends_to = (0.0, 0.0, float(np.sign(low + high)))
    return Limb(Bone(near, middle, upper), Bone(middle, far, lower), bends_to)
