"""Estimate the motion of one frame pair as DRIFT §2.3 prints it, a pass over a segment, its score.

`least_squares_pass` is the paper's: every seen point, squared residuals, a hard cut of small
singular values (6), and what lies below the cut taken from the prediction (10). `robust_pass` is
ours: the same rows under a soft prior and Huber weights, with the strongest gradients only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.chain import move
from keypose.tracker.kernels.layout import Lens
from keypose.tracker.kernels.noise import BINS, LOST
from keypose.tracker.kernels.pairs import (
    CAP,
    LONGEST_STEP,
    follow_pairs,
    linearise,
    mean_capped_square,
    shortened,
    view,
)
from keypose.tracker.kernels.robust import LEAST_SQUARES
from keypose.tracker.tracking.drift import Doubt, Motions
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.tracking.windows import Poses, follow_within, show
from keypose.tracker.video.pyramid import Clip, Picture, Prepared

SINGULAR_CUT = 0.02
"""Singular values below this share of the largest count as zero (the paper leaves it open)."""
SETTLED = 1e-5
OUTSIDE = 64.0
"""Grey levels charged for a point that leaves the picture, of which the paper says nothing: without
it, the path with the lowest score would lead out of the picture."""


@dataclass(frozen=True, eq=False)
class MotionStep:
    """The motion found for one frame pair by least squares.

    Rs_parent_part (P, 3, 3), p_camera_root (3,): where it leads. rank: singular values above the
    cut. singular_values (D,): of A with its columns scaled, largest first. squares: Σ r² at the
    prediction, where the trajectory's own score is read, over the points followed.
    """

    Rs_parent_part: Array
    p_camera_root: Array
    rank: int
    singular_values: Array
    squares: float
    followed: int


def solve_with_cut(A: Array, b: Array, scale: Array) -> tuple[Array, Array]:
    """x = −A⁺b without the directions below the cut, and the singular values.  DRIFT (6), (10)

    A (D, D) is AᵀA and b (D,) Aᵀr, both already at the prediction; so the prediction's share W Wᵀ y
    of a cut direction is to add nothing. scale (D,) makes metres and radians comparable.
    """
    if not len(b):
        return b.copy(), b.copy()
    values, V = np.linalg.eigh(A * scale * scale[:, None])
    singular = np.sqrt(np.maximum(values[::-1], 0.0))
    kept = np.sqrt(np.maximum(values, 0.0)) > SINGULAR_CUT * max(singular[0], 1e-300)
    inverse = np.where(kept, 1.0 / np.where(kept, values, 1.0), 0.0)
    return -scale * (V @ (inverse * (V.T @ (scale * b)))), singular


def least_squares_step(
    scene: Scene,
    source: Picture,
    target: Picture,
    before: Trajectory,
    j: int,
    inner: int,
    lens: Lens | None = None,
) -> MotionStep:
    """The motion from pose j of a trajectory to the next frame, started at pose j + 1.

    lens: that of the pictures' window; the scene's where they are whole.
    """
    lens = lens or scene.lens
    size, dofs = len(scene.points.points), scene.skeleton.dof_count
    chosen, grey = np.empty(size + 1, np.int32), np.empty(size + 1, np.float32)
    starts = np.empty(scene.skeleton.part_count + 1, np.int64)
    height, width = source.shape[:2]
    view(
        scene.arrays,
        lens,
        scene.visibility,
        width,
        height,
        source,
        1,
        *before.pose(before.first_frame + j).writable(),
        chosen,
        grey,
        starts,
    )
    R, t = before.pose(before.first_frame + j + 1).writable()
    N, histogram = np.empty((scene.skeleton.part_count, 7, 7)), np.empty(BINS, np.int32)
    A, b, singular = np.empty((dofs, dofs)), np.empty(dofs), np.zeros(dofs)
    squares = 0.0
    for k in range(inner):
        linearise(
            scene.arrays,
            chosen,
            grey,
            starts,
            R,
            t,
            target,
            lens,
            LEAST_SQUARES,
            1.0,
            N,
            histogram,
            A,
            b,
        )
        if k == 0:
            squares = float(N[0, 6, 6]) + OUTSIDE**2 * int(histogram[LOST])
        step, singular = solve_with_cut(A, b, scene.skeleton.column_scale)
        largest = shortened(step, LONGEST_STEP)
        if largest < 0:
            break
        move(scene.arrays, R, t, step)
        if largest < SETTLED:
            break
    rank = int((singular > SINGULAR_CUT * singular.max(initial=0.0)).sum())
    return MotionStep(R, t, rank, singular, squares, int(starts[-1]))


def least_squares_pass(
    scene: Scene, clip: Clip, trajectory: Trajectory, inner: int
) -> tuple[Motions, float]:
    """DRIFT's pass: motions from every pose, and the trajectory's printed score Σ r² (4)."""
    steps: list[MotionStep] = []

    def follow(shown: Prepared) -> Poses:
        steps[:] = _printed_steps(scene, clip, shown, trajectory, inner)
        R = np.stack([s.Rs_parent_part for s in steps])
        return R, np.stack([s.p_camera_root for s in steps])

    led = follow_within(scene, clip, trajectory.writable(), follow, is_chain=False)
    return Motions(*led), _printed_sum(steps)


def _printed_steps(
    scene: Scene, clip: Clip, shown: Prepared, trajectory: Trajectory, inner: int
) -> list[MotionStep]:
    """One for every frame pair."""
    slots = clip.slots(trajectory.first_frame, trajectory.last_frame)
    pictures, lens = shown.levels[0], shown.seen_by(scene.lens)
    return [
        least_squares_step(
            scene, pictures[slots[j]], pictures[slots[j + 1]], trajectory, j, inner, lens
        )
        for j in range(len(trajectory) - 1)
    ]


def printed_score(scene: Scene, clip: Clip, trajectory: Trajectory) -> float:
    """Σ over frames and points of the squared difference of brightness.  DRIFT (4)"""
    shown = show(scene, clip, *trajectory.writable())
    return _printed_sum(_printed_steps(scene, clip, shown, trajectory, 1))


def _printed_sum(steps: list[MotionStep]) -> float:
    """Σ r², and a charge for poses that show less than half of what either end does."""
    least = min(steps[0].followed, steps[-1].followed) // 2
    return sum(s.squares + OUTSIDE**2 * max(0, least - s.followed) for s in steps)


def robust_pass(
    scene: Scene, clip: Clip, trajectory: Trajectory, stride: int, inner: int, stop: float
) -> tuple[Motions, float]:
    """Our pass: motions from every pose, and the trajectory's capped score (grey levels²)."""
    n, parts = len(trajectory) - 1, scene.skeleton.part_count
    R, t, doubt = np.empty((n, parts, 3, 3)), np.empty((n, 3)), Doubt.equal(n, parts)
    slots: NDArray[np.int64] = clip.slots(trajectory.first_frame, trajectory.last_frame)
    before, score = trajectory.writable(), np.nan

    def follow(shown: Prepared) -> Poses:
        nonlocal score
        score = follow_pairs(
            scene.arrays,
            shown.seen_by(scene.lens),
            scene.visibility,
            scene.prior(stride),
            shown.levels[0],
            slots,
            *before,
            stride,
            inner,
            stop,
            R,
            t,
            doubt.turned,
            doubt.shifted,
        )
        return R, t

    follow_within(scene, clip, before, follow, is_chain=False)
    return Motions(R, t, doubt), float(score)


def capped_score(scene: Scene, clip: Clip, trajectory: Trajectory, stride: int) -> float:
    """DRIFT (4), per point and capped, of one surface point in every `stride`: grey levels²."""
    slots = clip.slots(trajectory.first_frame, trajectory.last_frame)
    return _capped(scene, clip, slots, trajectory, stride)


def best_of(tried: Sequence[Pass]) -> int:
    """Index of the lowest score; of the last trajectory where that was not judged."""
    if tried[-1].score is None:
        return len(tried) - 1
    return int(np.argmin([np.inf if p.score is None else p.score for p in tried]))


def keyframe_difference(scene: Scene, segment: Segment, stride: int) -> float:
    """How different the textures of the two keyframes are, each compared with the other
    directly.

    Mean capped square: small where both are posed exactly, 0 where nothing can be compared.
    """
    frames, ends = (segment.first_frame, segment.last_frame), (segment.start, segment.end)
    total = 0.0
    for a, b in ((0, 1), (1, 0)):
        slots = np.concatenate([segment.clip.slots(frames[k], frames[k]) for k in (a, b)])
        jump = Trajectory(
            0,
            np.stack([ends[a].Rs_parent_part, ends[b].Rs_parent_part]),
            np.stack([ends[a].p_camera_root, ends[b].p_camera_root]),
        )
        total += 0.5 * _capped(scene, segment.clip, slots, jump, stride)
    return total


def _capped(
    scene: Scene, clip: Clip, slots: NDArray[np.int64], trajectory: Trajectory, stride: int
) -> float:
    shown = show(scene, clip, *trajectory.writable())
    return float(
        mean_capped_square(
            scene.arrays,
            shown.seen_by(scene.lens),
            scene.visibility,
            shown.levels[0],
            slots,
            *trajectory.writable(),
            stride,
            CAP,
        )
    )
