"""First trajectories of a segment: following from both keyframes, and a motion from elsewhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, log_rotation, nearest_rotation, transpose
from keypose.tracker.kernels.closing import blend
from keypose.tracker.kernels.pairs import follow_chain
from keypose.tracker.solver.sigmas import DOUBT_FLOOR, TRUSTED
from keypose.tracker.tracking.drift import Doubt, Motions, correct_drift
from keypose.tracker.tracking.method import Keypose
from keypose.tracker.tracking.per_clip import PerClip
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment, is_sound
from keypose.tracker.tracking.windows import Poses, follow_within
from keypose.tracker.video.pyramid import Clip, Prepared

SMOOTHING_FRAMES = 2.0
"""Sigma of the smoothing over time that removes the jitter of an imported motion: passes would
accumulate it."""


@dataclass(frozen=True, eq=False)
class Chain(Trajectory):
    """A trajectory followed from one keyframe, and how uncertain each of its n steps is."""

    doubt: Doubt

    @classmethod
    def even(cls, trajectory: Trajectory) -> Chain:
        """A trajectory with equal doubts for all steps."""
        doubt = Doubt.equal(len(trajectory) - 1, trajectory.Rs_parent_part.shape[1])
        return cls(trajectory.first_frame, *trajectory.writable(), doubt)


Chains: TypeAlias = tuple[Chain, Chain]


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
    chain is in frame order; the latest of each clip are kept.
    """

    def followed() -> Chain:
        forward = last > first
        slots = clip.slots(min(first, last), max(first, last))
        R, t = _empty(scene, len(slots))
        R[0], t[0] = start.Rs_parent_part, start.p_camera_root
        doubt = Doubt.equal(len(slots) - 1, R.shape[1])

        def led(shown: Prepared) -> Poses:
            follow_chain(
                scene.arrays,
                shown.seen_by(scene.lens),
                scene.visibility,
                scene.prior(stride),
                shown.levels,
                finest,
                slots if forward else slots[::-1].copy(),
                R,
                t,
                stride,
                inner,
                stop,
                doubt.turned,
                doubt.shifted,
            )
            return R, t

        follow_within(scene, clip, (R[:1].copy(), t[:1].copy()), led, is_chain=True)
        step = 1 if forward else -1
        doubt = Doubt(doubt.turned[::step], doubt.shifted[::step])
        return Chain(min(first, last), R[::step], t[::step], doubt)

    pose = start.Rs_parent_part.tobytes() + start.p_camera_root.tobytes()
    key = (scene.followed, pose, first, last, stride, inner, stop, finest)
    return _CHAINS.get(clip, key, followed)


_CHAINS: Final[PerClip[Chain]] = PerClip(most=8)
"""Of both qualities those from the far keyframe stay while the near one is moved."""


def follow_both(scene: Scene, segment: Segment, method: Keypose) -> Chains | None:
    """The chains from both keyframes; None where one of them leaves the scene."""
    how = (method.stride, method.chain_inner, method.stop, method.finest)
    first, last = segment.first_frame, segment.last_frame
    forward = follow(scene, segment.clip, segment.start, first, last, *how)
    backward = follow(scene, segment.clip, segment.end, last, first, *how)
    if is_sound(scene, segment, forward) and is_sound(scene, segment, backward):
        return forward, backward
    return None


def blend_chains(scene: Scene, forward: Chain, backward: Chain) -> Trajectory:
    """Blend from the forward chain to the backward one, each part's rotation along one axis.

    Both start exactly at their keyframes, so the blend meets both. A chain's variance grows with
    every step, the more the less observable the step is: the blend moves to the other chain where
    a part is hidden, not in the middle. Each limb also prefers the chain that came nearer to the
    keyframe at its far end: one that loses an arm halfway misses that keyframe by the arm. With V
    the variance so far and g the miss, a chain has the weight 1 / (V · (g² + ε)).
    """
    turn_f, turn_b = (
        _limb_miss(scene, a.Rs_parent_part[k], b.Rs_parent_part[k])
        for a, b, k in ((forward, backward, -1), (backward, forward, 0))
    )
    shift = forward.ps_camera_root[[-1, 0]] - backward.ps_camera_root[[-1, 0]]
    shift_f, shift_b = np.linalg.norm(shift, axis=1)
    there, back = forward.doubt, backward.doubt
    turned = _backward_share(there.turned, back.turned, turn_f, turn_b, TRUSTED.turn_rad)
    even = np.linspace(0.0, 1.0, len(forward))
    turned[:, ~_is_tracked(scene)] = even[:, None]  # interpolated evenly, as everywhere
    least_m = TRUSTED.shift * scene.pixel_m
    shifted = _backward_share(there.shifted, back.shifted, shift_f, shift_b, least_m)
    return _blend(forward, backward, turned, shifted)


def fit_to_keyframes(
    motion: Trajectory, start: Pose, end: Pose, first: int, last: int
) -> Trajectory | None:
    """An imported motion made to meet both keyframes; None where it does not reach both, or has
    frames without a pose (NaN) between.

    It is smoothed. Its turns continue from the first keyframe, and drift correction makes them meet
    the second one. The root's path is shifted by what is missing at either end, linearly between.
    """
    if first < motion.first_frame or last > motion.last_frame:
        return None
    rows = slice(first - motion.first_frame, last - motion.first_frame + 1)
    if not np.isfinite(motion.ps_camera_root[rows]).all():
        return None
    R, t = _smooth(motion, first, last)
    s = np.linspace(0.0, 1.0, len(t))[:, None]
    path = t + (1 - s) * (start.p_camera_root - t[0]) + s * (end.p_camera_root - t[-1])
    path[0], path[-1] = start.p_camera_root, end.p_camera_root
    R_next = R[1:].copy()
    R_next[0] = start.Rs_parent_part @ transpose(R[0]) @ R[1]
    R[0] = start.Rs_parent_part
    closed = correct_drift(Trajectory(first, R, path), Motions(R_next, path[1:].copy()), end)
    return Trajectory(first, closed.trajectory.Rs_parent_part, path)


def _smooth(motion: Trajectory, first: int, last: int) -> tuple[Array, Array]:
    """Rotations and root positions of these frames, each the mean over those around it.

    As many count before as after, so that an even motion does not change.
    """
    n = np.arange(first, last + 1) - motion.first_frame
    Rs, ps = motion.Rs_parent_part[n].copy(), motion.ps_camera_root[n].copy()
    weights = np.ones(len(n))
    for away in range(1, int(3 * SMOOTHING_FRAMES) + 1):
        weight = np.exp(-0.5 * (away / SMOOTHING_FRAMES) ** 2)
        k = np.flatnonzero((n >= away) & (n + away < len(motion)))
        for side in (n[k] - away, n[k] + away):
            Rs[k] += weight * motion.Rs_parent_part[side]
            ps[k] += weight * motion.ps_camera_root[side]
        weights[k] += 2 * weight
    return nearest_rotation(Rs), ps / weights[:, None]


def _backward_share(
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


def _blend(forward: Trajectory, backward: Trajectory, turned: Array, shifted: Array) -> Trajectory:
    R, t = forward.writable()
    blend(*forward.writable(), *backward.writable(), turned, shifted, R, t)
    return Trajectory(forward.first_frame, R, t)


def _empty(scene: Scene, count: int) -> tuple[Array, Array]:
    return np.empty((count, scene.skeleton.part_count, 3, 3)), np.empty((count, 3))
