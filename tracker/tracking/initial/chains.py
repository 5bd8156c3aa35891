"""First trajectories of a segment: following from both keyframes, and a motion from elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker.body.pose import Pose
from tracker.body.trajectory import Trajectory
from tracker.geometry.rotations import Array, log_rotation, nearest_rotation, transpose
from tracker.kernels.closing import blend
from tracker.kernels.pairs import follow_chain
from tracker.tracking.drift import DOUBT_FLOOR, Doubt, Motions, correct_drift
from tracker.tracking.scene import Scene
from tracker.video.pyramid import Clip

TRUST_TURN_RAD = np.radians(20.0)
TRUST_SHIFT_PX = 30.0
"""Misses well below which two chains are trusted alike: small ones tell little of who is right."""
EVENED_FRAMES = 2.0
"""Spread of the mean over time that takes the jitter of a motion from elsewhere: passes would
accumulate it."""


@dataclass(frozen=True, eq=False)
class Chain(Trajectory):
    """A trajectory followed from one keyframe, and how uncertain each of its n steps is."""

    doubt: Doubt

    @classmethod
    def even(cls, trajectory: Trajectory) -> Chain:
        """A trajectory whose steps are all alike."""
        doubt = Doubt.none(len(trajectory) - 1, trajectory.Rs_parent_part.shape[1])
        return cls(trajectory.first_frame, *trajectory.loose(), doubt)


def follow(
    scene: Scene,
    clip: Clip,
    start: Pose,
    first: int,
    last: int,
    stride: int,
    inner: int,
    stop: float,
    finest: int = 0,
) -> Chain:
    """Follow the body from `start`, posed at frame `first`, to `last`, which may lie before it.

    Constant velocity, from coarse down to the pyramid level `finest`, no drift correction. The
    chain is in frame order.
    """
    forward = last > first
    slots = clip.slots(min(first, last), max(first, last))
    R, t = _room(scene, len(slots))
    R[0], t[0] = start.Rs_parent_part, start.p_camera_root
    doubt = Doubt.none(len(slots) - 1, R.shape[1])
    follow_chain(
        scene.arrays, scene.lens, scene.sight, scene.prior(stride), clip.levels, finest,
        slots if forward else slots[::-1].copy(), R, t, stride, inner, stop,
        doubt.turned, doubt.shifted,
    )  # fmt: skip
    step = 1 if forward else -1
    doubt = Doubt(doubt.turned[::step], doubt.shifted[::step])
    return Chain(min(first, last), R[::step], t[::step], doubt)


def blend_chains(scene: Scene, forward: Chain, backward: Chain) -> Trajectory:
    """From the forward chain to the backward one, each part's rotation along one axis.

    Both start exactly at their keyframes, so the blend meets both. A chain's variance grows with
    every step, the more the less the picture told of it: the way to the other chain is made where a
    part is hidden, not in the middle. Each limb leans as well to the chain that came nearer to the
    keyframe at its far end: one that loses an arm halfway misses that keyframe by the arm. With V
    the variance so far and g the miss, a chain weighs 1 / (V · (g² + ε)).
    """
    turn_f, turn_b = (
        _limb_miss(scene, a.Rs_parent_part[k], b.Rs_parent_part[k])
        for a, b, k in ((forward, backward, -1), (backward, forward, 0))
    )
    shift = forward.ps_camera_root[[-1, 0]] - backward.ps_camera_root[[-1, 0]]
    shift_f, shift_b = np.linalg.norm(shift, axis=1)
    there, back = forward.doubt, backward.doubt
    turned = _leaning(there.turned, back.turned, turn_f, turn_b, TRUST_TURN_RAD)
    even = np.linspace(0.0, 1.0, len(forward))
    turned[:, ~_is_tracked(scene)] = even[:, None]  # led evenly, as everywhere
    least_m = TRUST_SHIFT_PX * scene.pixel_m
    shifted = _leaning(there.shifted, back.shifted, shift_f, shift_b, least_m)
    return _mixed(forward, backward, turned, shifted)


def fit_to_keyframes(
    motion: Trajectory, start: Pose, end: Pose, first: int, last: int
) -> Trajectory | None:
    """A motion from elsewhere made to meet both keyframes; None where it does not reach both.

    Its jitter is evened out. Its turns are carried on from the first keyframe, and drift correction
    closes them on the second one. The root's path is shifted, evenly from what is missing at one
    end to that at the other.
    """
    if first < motion.first_frame or last > motion.last_frame:
        return None
    R, t = _evened(motion, first, last)
    s = np.linspace(0.0, 1.0, len(t))[:, None]
    path = t + (1 - s) * (start.p_camera_root - t[0]) + s * (end.p_camera_root - t[-1])
    path[0], path[-1] = start.p_camera_root, end.p_camera_root
    R_next = R[1:].copy()
    R_next[0] = start.Rs_parent_part @ transpose(R[0]) @ R[1]
    R[0] = start.Rs_parent_part
    closed = correct_drift(Trajectory(first, R, path), Motions(R_next, path[1:].copy()), end)
    return Trajectory(first, closed.trajectory.Rs_parent_part, path)


def _evened(motion: Trajectory, first: int, last: int) -> tuple[Array, Array]:
    """Rotations and root positions of these frames, each the mean over those around it.

    As many count before as after, so that an even motion stays where it is.
    """
    n = np.arange(first, last + 1) - motion.first_frame
    Rs, ps = motion.Rs_parent_part[n].copy(), motion.ps_camera_root[n].copy()
    weights = np.ones(len(n))
    for away in range(1, int(3 * EVENED_FRAMES) + 1):
        weight = np.exp(-0.5 * (away / EVENED_FRAMES) ** 2)
        k = np.flatnonzero((n >= away) & (n + away < len(motion)))
        for side in (n[k] - away, n[k] + away):
            Rs[k] += weight * motion.Rs_parent_part[side]
            ps[k] += weight * motion.ps_camera_root[side]
        weights[k] += 2 * weight
    return nearest_rotation(Rs), ps / weights[:, None]


def _leaning(
    doubt_forward: Array,
    doubt_backward: Array,
    miss_forward: Array,
    miss_backward: Array,
    least: float,
) -> Array:
    """(n + 1, …) share of the way to the backward chain; doubts (n, …) of the steps."""
    nothing = np.zeros_like(doubt_forward[:1])
    there = np.concatenate([nothing, np.cumsum(DOUBT_FLOOR + doubt_forward, axis=0)])
    back = np.cumsum(DOUBT_FLOOR + doubt_backward[::-1], axis=0)[::-1]
    forward = there * (miss_forward**2 + least**2)
    backward = np.concatenate([back, nothing]) * (miss_backward**2 + least**2)
    return np.asarray(forward / (forward + backward))


def _limb_miss(scene: Scene, Rs_reached: Array, Rs_keyed: Array) -> Array:
    """(P,) radians by which the tracked parts of each part's limb miss their keyed rotations."""
    miss = np.linalg.norm(log_rotation(transpose(Rs_keyed) @ Rs_reached), axis=-1)
    weights = miss * _is_tracked(scene)
    return np.asarray(np.bincount(scene.skeleton.limbs, weights=weights)[scene.skeleton.limbs])


def _is_tracked(scene: Scene) -> NDArray[np.bool_]:
    """(P,) whether a part has degrees of freedom of its own."""
    return np.isin(np.arange(scene.skeleton.part_count), scene.skeleton.dof_part)


def _mixed(forward: Trajectory, backward: Trajectory, turned: Array, shifted: Array) -> Trajectory:
    R, t = forward.loose()
    blend(*forward.loose(), *backward.loose(), turned, shifted, R, t)
    return Trajectory(forward.first_frame, R, t)


def _room(scene: Scene, count: int) -> tuple[Array, Array]:
    return np.empty((count, scene.skeleton.part_count, 3, 3)), np.empty((count, 3))
