"""First trajectories of a segment: interpolation, and following from both keyframes (METHOD §7)."""

from __future__ import annotations

import numpy as np

from tracker.geometry import Array
from tracker.images import Clip
from tracker.kernels.closing import blend
from tracker.kernels.pairs import follow_chain
from tracker.pose import Pose
from tracker.scene import Scene
from tracker.trajectory import Trajectory


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
    R = np.empty_like(forward.Rs_parent_part)
    t = np.empty_like(forward.ps_camera_root)
    blend(*forward.loose(), *backward.loose(), R, t)
    return Trajectory(forward.first_frame, R, t)


def _room(scene: Scene, count: int) -> tuple[Array, Array]:
    return np.empty((count, scene.skeleton.part_count, 3, 3)), np.empty((count, 3))
