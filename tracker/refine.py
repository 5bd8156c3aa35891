"""Whole-segment refinement: all inner poses of a segment improved together.

The cycle of DRIFT has the wide basin, this has the accuracy: it compares every frame with the
textures of both keyframes instead of with its neighbour, so no error accumulates. It cannot mend a
start that is far off, and it gains nothing where keyframes are badly posed; whoever calls it keeps
the better of the two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker.geometry import Array
from tracker.images import Clip
from tracker.kernels.chain import solve_banded
from tracker.kernels.pairs import scaled_lens, view
from tracker.kernels.whole import move_inner, see_all, whole_segment
from tracker.scene import Scene
from tracker.trajectory import Trajectory

SMOOTH_TURN_RAD = np.radians(1.0)
SMOOTH_SHIFT_PX = 1.1
"""Standard deviations of the motion's change from frame to frame."""
LONGEST_STEP = 0.3
SETTLED = 2e-4
FIRST_SIGMA = 12.0
LOOK_AGAIN = 5
"""Solves after which visibility is found anew."""


@dataclass(frozen=True)
class Refinement:
    """How to refine.

    solves: at each pyramid level, finest first.  of: one point of so many is followed.
    prior_rad: how firmly a pose is held to where it was (None: not at all).
    gain: whether a part may be brighter or darker than in the keyframe.
    """

    solves: tuple[int, ...]
    of: int
    prior_rad: float | None = None
    gain: bool = True


@dataclass(frozen=True, eq=False)
class _Textures:
    """The followed points of both keyframes: stacked on a first axis of two."""

    chosen: NDArray[np.int32]
    grey: NDArray[np.float32]
    starts: NDArray[np.int64]


def refine(scene: Scene, clip: Clip, start: Trajectory, how: Refinement) -> Trajectory:
    """The refined trajectory; its ends stay exactly where they are."""
    if len(start) < 3 or not scene.skeleton.dof_count:
        return start
    R, t = start.loose()
    away = np.zeros((len(start) - 2, scene.skeleton.dof_count))
    for level in reversed(range(len(how.solves))):
        if how.solves[level]:
            _solve_level(scene, clip, start.first_frame, R, t, away, how, level)
    return Trajectory(start.first_frame, R, t)


def _solve_level(
    scene: Scene, clip: Clip, first: int, R: Array, t: Array, away: Array, how: Refinement,
    level: int,
) -> None:  # fmt: skip
    n, dofs = len(t) - 1, scene.skeleton.dof_count
    slots = clip.slots(first, first + n)
    lens = scaled_lens(scene.lens, 0.5**level)
    of, every = (max(1, how.of // 2), 4) if level >= 2 else (how.of, 1)
    height, width = clip.levels[0].shape[1:3]
    seen = np.zeros((n + 1, len(scene.points.points)), np.uint8)
    textures = _keyframe_textures(scene, clip, slots, R, t, level, of, every)
    sigma = np.full((2, n + 1), FIRST_SIGMA)
    banded, gradient = np.empty((3 * dofs, (n - 1) * dofs)), np.empty((n - 1) * dofs)
    smooth = scene.precision(SMOOTH_TURN_RAD, SMOOTH_SHIFT_PX * scene.pixel_m)
    prior = np.zeros(dofs) if how.prior_rad is None else scene.prior(1, how.prior_rad).precision
    for k in range(how.solves[level]):
        if k % LOOK_AGAIN == 0:
            see_all(scene.arrays, scene.lens, scene.sight, width, height, R, t, seen)
        whole_segment(
            scene.arrays, lens, clip.levels[level], slots, R, t,
            textures.chosen, textures.grey, textures.starts, seen, how.gain,
            scene.information(of * every), smooth, prior, away, sigma, banded, gradient,
        )  # fmt: skip
        step = _damped_step(banded, gradient)
        if step is None:
            return
        steps = step.reshape(n - 1, dofs)
        away += steps
        move_inner(scene.arrays, R, t, steps)
        if np.abs(steps).max() < SETTLED:
            return


def _damped_step(banded: Array, gradient: Array) -> Array | None:
    """−A⁻¹ b with a trace of damping, shortened to LONGEST_STEP; None where it cannot be had."""
    banded[-1] = banded[-1] * (1 + 1e-4) + 1e-6
    step = -gradient
    if not solve_banded(banded, step):
        return None
    largest = np.abs(step).max()
    if not np.isfinite(largest):
        return None
    return np.asarray(step * min(1.0, LONGEST_STEP / max(largest, 1e-12)))


def _keyframe_textures(
    scene: Scene, clip: Clip, slots: NDArray[np.int64], R: Array, t: Array, level: int, of: int,
    every: int,
) -> _Textures:  # fmt: skip
    """What the first and the last frame show of the body, at a pyramid level."""
    size, parts = len(scene.points.points), scene.skeleton.part_count
    chosen, grey = np.zeros((2, size + 1), np.int32), np.zeros((2, size + 1), np.float32)
    starts = np.zeros((2, parts + 1), np.int64)
    height, width = clip.levels[0].shape[1:3]
    for k, j in enumerate((0, len(t) - 1)):
        view(
            scene.arrays, scene.lens, scene.sight, width, height, clip.levels[level][slots[j]],
            0.5**level, of, every, R[j], t[j], chosen[k], grey[k], starts[k],
        )  # fmt: skip
    return _Textures(chosen, grey, starts)
