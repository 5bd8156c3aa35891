"""First trajectories of a segment: interpolation, and following from both keyframes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tracker.geometry import Array, log_rotation, transpose
from tracker.images import Clip
from tracker.kernels.closing import blend
from tracker.kernels.pairs import follow_chain
from tracker.pose import Pose
from tracker.scene import Scene
from tracker.trajectory import Trajectory

TRUST_TURN_RAD = np.radians(1.5)
TRUST_SHIFT_PX = 2.0
"""Misses below which two chains are trusted alike."""


def follow(
    scene: Scene, clip: Clip, start: Pose, first: int, last: int, of: int, inner: int, stop: float,
    finest: int = 0,
) -> Trajectory:  # fmt: skip
    """Follow the body from `start`, posed at frame `first`, to `last`, which may lie before it.

    Constant velocity, from coarse down to the pyramid level `finest`, no drift correction. The
    trajectory is in frame order.
    """
    forward = last > first
    slots = clip.slots(min(first, last), max(first, last))
    R, t = _room(scene, len(slots))
    R[0], t[0] = start.Rs_parent_part, start.p_camera_root
    follow_chain(
        scene.arrays, scene.lens, scene.sight, scene.prior(of), clip.levels, finest,
        slots if forward else slots[::-1].copy(), R, t, of, inner, stop,
    )  # fmt: skip
    step = 1 if forward else -1
    return Trajectory(min(first, last), R[::step], t[::step])


def blended(forward: Trajectory, backward: Trajectory) -> Trajectory:
    """From the forward chain to the backward one, each part's rotation along one axis.

    Both start exactly at their keyframes, so the blend meets both. It is several times nearer to
    the truth than interpolation where the keyframes are far apart.
    """
    n, parts = len(forward) - 1, forward.Rs_parent_part.shape[1]
    shares = np.linspace(0.0, 1.0, n + 1)
    return _mixed(forward, backward, np.tile(shares[:, None], (1, parts)), shares)


def blended_by_trust(scene: Scene, forward: Trajectory, backward: Trajectory) -> Trajectory:
    """The same, but each limb leans to the chain that came nearer to the keyframe at its far end.

    A chain that loses an arm halfway misses its far keyframe by that arm; an even blend would drag
    a well followed arm along. With s the share of the way and g the miss of a limb, the chains
    weigh (1 − s) / (g² + ε) and s / (g² + ε), so that both keyframes are still met.
    """
    s = np.linspace(0.0, 1.0, len(forward))
    turn_f, turn_b = (
        _limb_miss(scene, a.Rs_parent_part[k], b.Rs_parent_part[k])
        for a, b, k in ((forward, backward, -1), (backward, forward, 0))
    )
    shift = forward.ps_camera_root[[-1, 0]] - backward.ps_camera_root[[-1, 0]]
    shift_f, shift_b = np.linalg.norm(shift, axis=1)
    turned = _leaning(s[:, None], turn_f, turn_b, TRUST_TURN_RAD)
    turned[:, ~_is_tracked(scene)] = s[:, None]  # led evenly, as everywhere
    shifted = _leaning(s, shift_f, shift_b, TRUST_SHIFT_PX * scene.pixel_m)
    return _mixed(forward, backward, turned, shifted)


def _leaning(s: Array, miss_forward: Array, miss_backward: Array, least: float) -> Array:
    """Share of the way to the backward chain."""
    forward = (1 - s) / (miss_forward**2 + least**2)
    backward = s / (miss_backward**2 + least**2)
    return np.asarray(backward / (forward + backward))


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
