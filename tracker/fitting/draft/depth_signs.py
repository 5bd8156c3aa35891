"""Decide over a whole stretch which way bones point in depth, and which side is left.

How steeply a bone stands to the picture's plane is seen by how short it looks; toward which side is
the network's word. Frame by frame that is often wrong: it puts a joint too near or too far by about
the same for a while, which for a bone near the plane is the other side. Freed of such a bias, what
it gives rises and falls with the bone's own tilt, in one sense or the other:

    told_n = s_n · tilt_n + bias + noise,   s_n = ±1

A sign changes only while the bone passes through the plane, and an upper arm hangs about where arms
hang. Signs are found by dynamic programming and the bias by what they leave, in turn, from several
biases on; the most probable outcome counts.

Arms and legs stand in each frame in one of three ways: as detected; exchanged; or with their outer
joints exchanged in the picture alone. That last a network does where one leg passes before the
other: hips, depths and visibility stay with their side, knees and feet are seen on the other one's.
What joints jump from frame to frame, in the picture and in depth, is least along one way through
these states, found by dynamic programming. The left shoulder and the left hip are on one side of a
body, and most of what is detected is right. Where both legs coincide the way may still be wrong: so
it stands beside what was detected, and all terms of the poses decide between the two.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Final, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft.observed import (
    LIMBS,
    POINTS,
    SIDES,
    Bone,
    Joints,
    Observed,
    place_of,
    unit,
)
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.outliers import trunk_straightness
from keypose.tracker.solver.sigmas import ARM_BACKWARD, ARM_FORWARD, TILT, TILT_BIAS
from keypose.tracker.tracking.cues.sides import mean_distance

PLANE: Final = float(np.sin(np.radians(15.0)))
"""A bone nearer to the picture's plane than this angle is in it: its mirror image is no matter."""
TOGETHER: Final = 10.0
"""Frames whose noise is the same: they count as one."""
LASTING_FRAMES: Final = 60.0
"""For how long a bias stays about the same."""
HANGS = -0.15
"""Sine of the angle by which an upper arm that hangs is before the trunk's plane: recorded walks,
jumps, washing and dancing."""
POSED_TOGETHER: Final = 5.0
"""Frames whose poses count as one."""
STARTS: Final = (-0.4, -0.2, 0.0, 0.2, 0.4)
ROUNDS: Final = 6
PASSING: Final = 0.1
"""Tilt at which a bone changes its side at the cost of one standard deviation; steeper ones hardly
ever do."""
DEPTH_CHANGE: Final = 0.5
"""What a change of side costs besides."""
SURE: Final = 4.0
"""A bone is turned where the other side is so much less probable, as −log p."""
_SIGNS: Final = np.array([-1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Pointing:
    """Of the 8 bones of `Joints.bones` in N frames.

    drafted: (N, 8) tilts, sines of the angle to the picture's plane, positive away from the camera.
    signs:   (N, 8) the most probable ones, −1 or 1.
    surer:   (N, 8) by how much the other sign is less probable, as −log p.
    """

    drafted: Array
    signs: Array
    surer: Array

    @property
    def against(self) -> NDArray[np.bool_]:
        """(N, 8) where a bone was surely drafted to the other side."""
        steep = np.abs(self.drafted) >= PLANE
        return np.asarray((self.drafted * self.signs < 0) & steep & (self.surer >= SURE))

    @property
    def limbs_against(self) -> list[int]:
        """The limbs with such a bone, each of two bones."""
        limbs = self.against.reshape(len(self.signs), -1, 2)
        return np.flatnonzero(limbs.any(axis=(0, 2))).tolist()

    def of_limbs(self, limbs: Sequence[int]) -> Pointing:
        """The same with nothing said for sure of the bones of other limbs."""
        own = np.isin(np.arange(self.surer.shape[1]) // 2, limbs)
        return replace(self, surer=np.where(own, self.surer, 0.0))


def pointing(joints: Joints, camera: Camera, p_hips: Array, motion: Trajectory) -> Pointing:
    """How the bones of a motion of N frames should point by the network's landmarks.

    camera: without distortion.  p_hips: (N, 12, 3) of the joints, finite.
    """
    p = joints.points.at(motion.transforms(joints.skeleton))
    drafted = np.stack([tilt(camera, p, bone) for bone in joints.bones], axis=1)
    estimated = np.stack([_estimated(p_hips, bone) for bone in joints.bones], axis=1)
    unlikely = _unlikely(joints, camera, p, drafted)
    return Pointing(drafted, *most_probable_signs(np.abs(drafted), estimated, unlikely))


def tilt(camera: Camera, p: Array, bone: Bone) -> Array:
    """(N,) sine of the angle between a bone and the picture's plane, positive away from the camera:
    along the ray of its far joint.  p: (N, 12, 3) in the camera's frame."""
    near, far = p[:, bone.near], p[:, bone.far]
    ray = far if camera.telephoto_distance_m is None else np.array([0.0, 0.0, 1.0])
    ray = ray / np.linalg.norm(ray, axis=-1, keepdims=True)
    along = far - near
    return np.asarray((along * ray).sum(-1) / np.maximum(np.linalg.norm(along, axis=-1), 1e-9))


def _estimated(p_hips: Array, bone: Bone) -> Array:
    along = p_hips[:, bone.far] - p_hips[:, bone.near]
    return np.asarray(along[:, 2] / np.maximum(np.linalg.norm(along, axis=-1), 1e-9))


def _unlikely(joints: Joints, camera: Camera, p: Array, drafted: Array) -> Array:
    """(N, 8, 2) half the squares by which upper arms depart from how arms hang, either way."""
    out = np.zeros((*drafted.shape, 2))
    up, forward = _trunk(p)
    for k, limb in enumerate(joints.limbs[:2]):
        near, far = limb.upper.near, limb.upper.far
        along = p[:, far] - p[:, near]
        along /= np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-9)
        ray = _ray(camera, p[:, far])
        mirrored = along - 2 * (along * ray).sum(-1, keepdims=True) * ray
        is_away = drafted[:, 2 * k] > 0
        for s in (0, 1):
            this = np.where((is_away == (s == 1))[:, None], along, mirrored)
            ahead = (this * forward).sum(-1) - HANGS
            square = (ahead / np.where(ahead < 0, ARM_BACKWARD, ARM_FORWARD)) ** 2 / 2
            hangs = (along * up).sum(-1) < 0
            out[:, 2 * k, s] = np.where(hangs, square, 0.0)
    return out


def _trunk(p: Array) -> tuple[Array, Array]:
    """Directions (N, 3) up along the trunk, and to where it faces."""
    ls, rs, lh, rh = (p[:, place_of(side, j)] for j in ("shoulder", "hip") for side in SIDES)
    up = unit(ls + rs - lh - rh)
    left = ls - rs + lh - rh
    left = unit(left - (left * up).sum(-1, keepdims=True) * up)
    return up, np.cross(left, up)


def _ray(camera: Camera, p: Array) -> Array:
    if camera.telephoto_distance_m is not None:
        return np.broadcast_to(np.array([0.0, 0.0, 1.0]), p.shape)
    return unit(p)


def most_probable_signs(steep: Array, estimated: Array, unlikely: Array) -> tuple[Array, Array]:
    """(N, B) −1 or 1, of B bones whose tilts (N, B) are `steep`, without a sign, and `estimated`;
    and (N, B) by how much every outcome with the other sign there is less probable, as −log p.

    unlikely: (N, B, 2) −log p of either sign besides.
    """
    best, surer = np.ones_like(estimated), np.zeros_like(estimated)
    cost = np.full(estimated.shape[1], np.inf)
    for start in STARTS:
        bias = np.full_like(estimated, start)
        for _ in range(ROUNDS):
            least = _least(steep, estimated - bias, unlikely)
            signs = _SIGNS[least.argmin(axis=-1)]
            bias = _bias(estimated - signs * steep)
        total = least.min(axis=-1)[0] + (bias**2).mean(0) / (2 * TILT_BIAS**2)
        better = total < cost
        cost = np.where(better, total, cost)
        best = np.where(better, signs, best)
        surer = np.where(better, np.abs(least[..., 1] - least[..., 0]), surer)
    return best, surer


def _bias(left: Array) -> Array:
    """(N, B) the slow part of what is left (N, B), drawn to 0."""
    weight = gaussian_filter1d(np.ones(len(left)), LASTING_FRAMES, mode="constant")[:, None]
    mean = gaussian_filter1d(left, LASTING_FRAMES, axis=0, mode="constant") / weight
    frames = weight * LASTING_FRAMES * np.sqrt(2 * np.pi)
    prior = TILT**2 * TOGETHER / TILT_BIAS**2
    return np.asarray(mean * frames / (frames + prior))


def _least(steep: Array, estimated: Array, unlikely: Array) -> Array:
    """(N, B, 2) the least sum of costs over all frames with this sign in this one."""
    own = (estimated[..., None] - _SIGNS * steep[..., None]) ** 2 / (2 * TILT**2 * TOGETHER)
    own = own + unlikely / POSED_TOGETHER
    change = ((np.minimum(steep[1:], steep[:-1]) / PASSING) ** 2 + DEPTH_CHANGE)[..., None]
    return _up_to(own, change) + _up_to(own[::-1], change[::-1])[::-1] - own


def _up_to(own: Array, change: Array) -> Array:
    """(N, B, 2) the least sum up to a frame that has this sign."""
    out = own.copy()
    for n in range(1, len(own)):
        before = out[n - 1]
        out[n] += np.minimum(before, before[:, ::-1] + change[n - 1])
    return out


def turned(
    joints: Joints, observed: Observed, p_hips: Array, drafted_pointing: Pointing
) -> Observed | None:
    """Turn bones to the other side where they were drafted against their signs; None where none
    was. p_hips: (N, 12, 3) of the joints, finite.
    """
    against = drafted_pointing.against
    if not against.any():
        return None
    p, depth = p_hips.copy(), p_hips[..., 2].copy()
    for k, bone in enumerate(joints.bones):
        along = p_hips[:, bone.far] - p_hips[:, bone.near]
        wanted = (
            drafted_pointing.signs[:, k]
            * np.abs(drafted_pointing.drafted[:, k])
            * np.linalg.norm(along, axis=-1)
        )
        estimated = wanted if against[:, k].any() else along[:, 2]
        depth[:, bone.far] = depth[:, bone.near] + estimated
    p[..., 2] = depth
    joint = slice(len(p[0]))
    every = observed.p_hips.copy()
    every[:, joint] = np.where(observed.known[:, joint, None], p, every[:, joint])
    return replace(observed, p_hips=every)


SIDE_CHANGE: Final = 0.05
"""What an exchange costs on the way, as a share of the body's height."""
AGAINST: Final = np.array([0.0, 0.01, 0.02])
"""What a frame costs in each way: outer joints alone are never exchanged for long."""
CROSSED: Final = 0.1
"""What a frame costs whose hips are turned against its shoulders."""
_ARMS, _LEGS = ([place_of(side, joint) for joint in limb for side in SIDES] for limb in LIMBS)
_LEGS += [POINTS.index(f"{side}_{end}") for end in ("heel", "foot_index") for side in SIDES]
"""From the trunk outward, left and right beside each other."""

Way: TypeAlias = Literal[0, 1, 2]
"""As detected, exchanged, or the outer joints exchanged in the picture alone."""
WAYS: Final[tuple[Way, ...]] = get_args(Way)
EXCHANGED, OUTER = WAYS[1:]
_STATES = np.array(list(product(WAYS, repeat=2)))
"""(9, 2) the ways of arms and legs."""


def consistent_sides(observed: Observed, height_px: float, height_m: float) -> Observed | None:
    """Exchange arms and legs where they jump from side to side; None where they do not.

    height_px, height_m: of the body.
    """
    where = np.concatenate([observed.uv / height_px, observed.p_hips[..., 2:] / height_m], axis=-1)
    where[~observed.known] = np.nan
    own = AGAINST[_STATES].sum(axis=1) + _crossed(observed)
    steps = np.zeros((len(observed) - 1, len(_STATES), len(_STATES)))
    for k, group in enumerate((_ARMS, _LEGS)):
        before, now = _STATES[:, None, k], _STATES[None, :, k]
        steps += SIDE_CHANGE * (before != now) + _group_jumps(where, group)[:, before, now]
    states = _STATES[_least_way(own, steps)]
    return _exchanged(observed, states) if states.any() else None


def _crossed(observed: Observed) -> Array:
    """(N, 9) by frame and state."""
    straight = trunk_straightness(JOINTS, observed.p_hips[:, : len(JOINTS)])
    assert straight is not None
    cosine = np.nan_to_num(straight)
    turned = _STATES == EXCHANGED
    sign = np.where(turned[:, 0] == turned[:, 1], 1.0, -1.0)
    return np.asarray(CROSSED * np.maximum(-cosine[:, None] * sign, 0.0))


def _group_jumps(where: Array, group: list[int]) -> Array:
    """(N − 1, 3 before, 3) mean distance from a group's joints to those of the frame before, each
    in one of the ways; 0 where nothing is known in both."""
    ways = np.stack([_in_way(where[:, group], order) for order in WAYS])
    return np.stack(
        [
            np.stack([mean_distance(now[1:], before[:-1]) for now in ways], axis=-1)
            for before in ways
        ],
        axis=1,
    )


def _in_way(where: Array, order: Way) -> Array:
    """Joints (N, J, 3), pixels and depth, of one group in one of the ways."""
    if order == EXCHANGED:
        return _other(where)
    if order != OUTER:
        return where
    out = where.copy()
    out[:, len(SIDES) :, :2] = _other(where)[:, len(SIDES) :, :2]
    return out


def _other(values: NDArray[Any]) -> NDArray[Any]:
    """Left and right, which lie beside each other, exchanged."""
    pairs = values.reshape(len(values), values.shape[1] // 2, 2, *values.shape[2:])
    return np.asarray(pairs[:, :, ::-1].reshape(values.shape))


def _least_way(own: Array, steps: Array) -> NDArray[np.int64]:
    """(N,) the states whose sum of own costs (N, S) and of steps (N − 1, S before, S) is least."""
    cost, came_from = own[0], np.zeros(own.shape, np.int64)
    for n in range(1, len(own)):
        totals = cost[:, None] + steps[n - 1]
        came_from[n] = totals.argmin(axis=0)
        cost = totals.min(axis=0) + own[n]
    states = np.zeros(len(own), np.int64)
    states[-1] = int(cost.argmin())
    for n in range(len(own) - 1, 0, -1):
        states[n - 1] = came_from[n, states[n]]
    return states


def _exchanged(observed: Observed, states: NDArray[np.int64]) -> Observed:
    """Exchange arms and legs as states (N, 2) say."""
    places = np.tile(np.arange(len(POINTS)), (len(observed), 1))
    labels = places.copy()
    for group, ways in zip((_ARMS, _LEGS), states.T, strict=True):
        for order, joints, rows in (
            (places, group, ways == EXCHANGED),
            (labels, group, ways == EXCHANGED),
            (places, group[len(SIDES) :], ways == OUTER),
        ):
            here = np.ix_(rows, joints)
            order[here] = _other(order[here])
    every = np.arange(len(observed))[:, None]
    is_known = observed.known[every, places] & observed.known[every, labels]
    return replace(
        observed,
        uv=observed.uv[every, places],
        known=is_known,
        visibility=np.where(is_known, observed.visibility[every, labels], 0.0),
        p_hips=observed.p_hips[every, labels],
    )
