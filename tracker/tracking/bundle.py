"""Whole-segment refinement: all inner poses of a segment improved together.

The cycle of DRIFT has the wide basin, this has the accuracy: it compares every frame with the
textures of both keyframes instead of with its neighbour, so no error accumulates. It cannot mend a
start that is far off, and it gains nothing where keyframes are badly posed; whoever calls it keeps
the better of the two.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracker.body.trajectory import Trajectory
from tracker.geometry.rotations import Array
from tracker.kernels.chain import solve_banded
from tracker.kernels.pairs import view
from tracker.kernels.whole import move_inner, see_all, whole_segment
from tracker.tracking.scene import Scene
from tracker.video.pyramid import Clip, Picture

if TYPE_CHECKING:
    from tracker.tracking.method import Refinement

SMOOTH_TURN_RAD = np.radians(1.0)
SMOOTH_SHIFT_PX = 1.1
"""Standard deviations of the motion's change from frame to frame."""
LONGEST_STEP = 0.3
SETTLED = 2e-4
FIRST_SIGMA = 12.0
LOOK_AGAIN = 5
"""Solves after which visibility is found anew."""


@dataclass(frozen=True, eq=False)
class _Textures:
    """The followed points of both keyframes: stacked on a first axis of two."""

    chosen: NDArray[np.int32]
    grey: NDArray[np.float32]
    starts: NDArray[np.int64]


def refine(scene: Scene, clip: Clip, start: Trajectory, how: Refinement) -> Trajectory:
    """The refined trajectory; its ends stay exactly where they are."""
    n, dofs = len(start) - 1, scene.skeleton.dof_count
    if n < 2 or not dofs:
        return start
    R, t = start.loose()
    slots, pictures = clip.slots(start.first_frame, start.last_frame), clip.levels[0]
    height, width = pictures.shape[1:3]
    seen = np.zeros((n + 1, len(scene.points.points)), np.uint8)
    textures = _keyframe_textures(scene, pictures, slots, R, t, how.of)
    sigma = np.full((2, n + 1), FIRST_SIGMA)
    banded, gradient = np.empty((3 * dofs, (n - 1) * dofs)), np.empty((n - 1) * dofs)
    smooth = scene.precision(SMOOTH_TURN_RAD, SMOOTH_SHIFT_PX * scene.pixel_m)
    for k in range(how.solves):
        if k % LOOK_AGAIN == 0:
            see_all(scene.arrays, scene.lens, scene.sight, width, height, R, t, seen)
        whole_segment(
            scene.arrays, scene.lens, pictures, slots, R, t,
            textures.chosen, textures.grey, textures.starts, seen,
            scene.information(how.of), smooth, sigma, banded, gradient,
        )  # fmt: skip
        step = _damped_step(banded, gradient)
        if step is None:
            break
        move_inner(scene.arrays, R, t, step.reshape(n - 1, dofs))
        if np.abs(step).max() < SETTLED:
            break
    return Trajectory(start.first_frame, R, t)


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
    scene: Scene, pictures: Picture, slots: NDArray[np.int64], R: Array, t: Array, of: int
) -> _Textures:
    """What the first and the last frame show of the body."""
    size, parts = len(scene.points.points), scene.skeleton.part_count
    chosen, grey = np.zeros((2, size + 1), np.int32), np.zeros((2, size + 1), np.float32)
    starts = np.zeros((2, parts + 1), np.int64)
    height, width = pictures.shape[1:3]
    for k, j in enumerate((0, len(t) - 1)):
        view(
            scene.arrays, scene.lens, scene.sight, width, height, pictures[slots[j]],
            of, R[j], t[j], chosen[k], grey[k], starts[k],
        )  # fmt: skip
    return _Textures(chosen, grey, starts)
