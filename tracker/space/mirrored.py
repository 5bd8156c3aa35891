"""Limbs that a keyframe may have the wrong way round in depth: toward the camera instead of away.

In the picture both look the same, and a person who poses on the picture alone takes either. Both
are compared with the same limb at the nearest other keyframes, in the trunk's frame: a limb that is
near there to its mirror image, and not to itself, was probably mirrored, if its joints can bend the
other way: knees and elbows mostly cannot. It needs no keypoints, and says nothing where the same
limb is mirrored at neighbouring keyframes, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.depth_turn import turned_in_depth, turns_round

NEAR_S: Final = 1.2
"""Keyframes farther apart than this say nothing about each other."""
OTHERS: Final = 2
"""Keyframes that one is compared with: those before and after it, of the first and the last one the
two next to it."""
APART_M: Final = 0.15
"""Mirror images nearer to each other than this are no matter."""
NEARER_M: Final = 0.1
"""By how much nearer to a neighbour the mirror image has to be, in the mean over the joints. Of
seven motions keyed every 20 frames two of 188 right limbs are reported, of those mirrored by a
quarter of a metre or more 22 of 33, hardly a leg, of 32 lesser ones five."""
STRAYS: Final = 0.3
"""Share of the way to the mirror image by which joints may miss it, for it to be a pose."""
_LIMBS: Final[Mapping[str, tuple[str, tuple[str, ...]]]] = {
    "upper_arm": ("chest", ("forearm", "hand")),
    "forearm": ("chest", ("hand",)),
    "thigh": ("waist", ("shin", "foot")),
    "shin": ("waist", ("foot",)),
}
"""By the part that is turned: the trunk it is seen from, and the parts whose joints move."""


@dataclass(frozen=True)
class Mirrored:
    """A limb, from `part` on, at a keyframe; nearer_m: by how much its mirror image is nearer."""

    frame: int
    part: str
    nearer_m: float


def mirrored_limbs(
    skeleton: Skeleton, camera: Camera, poses: Mapping[int, Pose], frames_per_second: float
) -> tuple[Mirrored, ...]:
    """Find limbs that keyframes may have mirrored in depth; poses by frame; of one limb at one
    keyframe the likelier part.

    camera: without distortion.
    """
    limbs: list[Mirrored] = []
    frames, most = sorted(poses), NEAR_S * frames_per_second
    there = {frame: pose_transforms(skeleton, poses[frame]) for frame in frames}
    for frame in frames:
        others = [there[k] for k in _near(frames, frame, most)]
        for limb in _limbs(skeleton) if len(others) == OTHERS else ():
            gains = [_compared(skeleton, camera, part, poses[frame], others) for part in limb]
            nearer, part = max(zip(gains, limb, strict=True), key=lambda pair: pair[0])
            if nearer > NEARER_M:
                limbs.append(Mirrored(frame, part.name, nearer))
    return tuple(limbs)


def _near(frames: Sequence[int], frame: int, most: float) -> list[int]:
    """The keyframes before and after one, or the two next to it where it is the first or last."""
    i = frames.index(frame)
    first = min(max(i - 1, 0), max(len(frames) - 1 - OTHERS, 0))
    near = [k for k in frames[first : first + OTHERS + 1] if k != frame]
    return [k for k in near if abs(k - frame) <= most]


@dataclass(frozen=True)
class _Part:
    """A part from which a limb is turned: where its trunk and its further joints are."""

    name: str
    top: int
    trunk: int
    ends: tuple[int, ...]

    def joints(self, Ts: Array) -> Array:
        """(K, 3) the further joints, camera frame."""
        return np.asarray(Ts[list(self.ends), :3, 3])

    def in_trunk(self, Ts: Array, p_camera: Array) -> Array:
        """Points (K, 3) in the trunk's frame."""
        T = Ts[self.trunk]
        return np.asarray((p_camera - T[:3, 3]) @ T[:3, :3])


def _limbs(skeleton: Skeleton) -> Iterator[list[_Part]]:
    """Both arms and both legs, as far as they are there: the parts from which each is turned."""
    index = {name: k for k, name in enumerate(skeleton.body.names)}
    for side, kinds in product(("left", "right"), (("upper_arm", "forearm"), ("thigh", "shin"))):
        parts = []
        for kind in kinds:
            trunk, ends = _LIMBS[kind]
            names = [f"{side}_{kind}", trunk, *(f"{side}_{end}" for end in ends)]
            if index.keys() >= set(names):
                top, middle, *far = (index[name] for name in names)
                parts.append(_Part(names[0], top, middle, tuple(far)))
        if parts:
            yield parts


def _compared(
    skeleton: Skeleton, camera: Camera, part: _Part, pose: Pose, others: Sequence[Array]
) -> float:
    """Metres by which the mirror image is nearer to a neighbour; 0 where there is none."""
    Ts = pose_transforms(skeleton, pose)
    shown, top = part.joints(Ts), Ts[part.top, :3, 3]
    ray = top / np.linalg.norm(top) if camera.telephoto_distance_m is None else np.eye(3)[2]
    image = shown - 2 * ((shown - top) @ ray)[:, None] * ray
    apart = _apart(shown, image)
    near = [part.in_trunk(T, part.joints(T)) for T in others]

    def nearer(p_camera: Array) -> float:
        as_it_is, candidate = part.in_trunk(Ts, shown), part.in_trunk(Ts, p_camera)
        return min(_apart(as_it_is, p) for p in near) - min(_apart(candidate, p) for p in near)

    if apart < APART_M or nearer(image) < NEARER_M:
        return 0.0
    turned = turned_in_depth(skeleton, camera, pose, part.top)
    turned_joints = part.joints(pose_transforms(skeleton, turned))
    strays = _apart(turned_joints, image) > STRAYS * apart
    return (
        0.0
        if strays or not turns_round(skeleton, pose, turned, part.top)
        else nearer(turned_joints)
    )


def _apart(p: Array, q: Array) -> float:
    return float(np.linalg.norm(p - q, axis=-1).mean())
