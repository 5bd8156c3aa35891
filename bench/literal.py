"""What a solve costs in other forms: the dense rows of the paper, and what nothing can undercut."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.sequences import Sequence
from keypose.tracker.body.pose import pose_transforms, twists
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.pairs import solve_pair, view
from keypose.tracker.tracking.method import FULL, Keypose
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.video.pyramid import Clip

DENSE_POINTS = 13_500
FLOW_POINTS = (128, 72)

# Floating-point operations for a followed point in one solve: its place (18), its pixel (7), four
# weights (8) and three interpolations (21), its row (22), its robust weight (3), 28 products (63).
POINT_FLOPS = 18 + 7 + 8 + 21 + 22 + 3 + 63
# For a surface point when visibility is found: facing (15), place (18), pixel (7), cell (4).
SEEING_FLOPS = 44


@dataclass(frozen=True)
class Timing:
    """Milliseconds: the least and the median of several runs."""

    least: float
    median: float

    @classmethod
    def of(cls, work: Callable[[], object], repeats: int = 7, per: float = 1.0) -> Timing:
        """Time `work`, run once before, and divide by `per` (frames, solves)."""
        work()
        return cls.spent([_seconds(work) for _ in range(repeats)], per)

    @classmethod
    def spent(cls, seconds: list[float], per: float = 1.0) -> Timing:
        ms = 1000 * np.array(seconds) / per
        return cls(float(ms.min()), float(np.median(ms)))

    def __str__(self) -> str:
        digits = 3 if self.median < 0.1 else 2 if self.median < 10 else 1
        return f"{self.least:.{digits}f}/{self.median:.{digits}f}"


def _seconds(work: Callable[[], object]) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


@dataclass(frozen=True, eq=False)
class Seen:
    """Surface points that a pose shows: their index and brightness, and where each part begins."""

    chosen: NDArray[np.int32]
    grey: NDArray[np.float32]
    starts: NDArray[np.int64]

    def __len__(self) -> int:
        return int(self.starts[-1])


def seen_points(scene: Scene, shown: Sequence, clip: Clip, of: int = 1) -> Seen:
    """Of the first frame; one of so many, the one with the strongest gradient."""
    size, picture = len(scene.points.points), clip.levels[0][0]
    chosen, grey = np.zeros(size + 1, np.int32), np.zeros(size + 1, np.float32)
    starts = np.zeros(scene.skeleton.part_count + 1, np.int64)
    height, width = picture.shape[:2]
    pose = shown.truth.pose(0)
    view(
        scene.arrays, scene.lens, scene.visibility, width, height, picture, of,
        *pose.writable(), chosen, grey, starts,
    )  # fmt: skip
    return Seen(chosen, grey, starts)


class DenseRows:
    """One frame pair with A (m × D) written out row by row, and solved as printed."""

    def __init__(self, shown: Sequence, clip: Clip) -> None:
        poses = [shown.truth.pose(0), shown.truth.pose(1)]
        plenty = Scene.of(shown.skeleton, shown.camera, poses, density=12.0)
        seen = seen_points(plenty, shown, clip)
        rows = np.linspace(0, len(seen) - 1, DENSE_POINTS).astype(int)
        self.part = np.searchsorted(seen.starts, rows, side="right") - 1
        self.p_part = plenty.points.points[seen.chosen[rows]].astype(np.float64)
        self.grey, self.picture = seen.grey[rows], clip.levels[0][1]
        self.skeleton, self.camera = shown.skeleton, shown.camera
        self.T = pose_transforms(shown.skeleton, poses[1])
        self.moves = shown.skeleton.below[shown.skeleton.dof_part][:, self.part].T

    def build(self) -> tuple[Array, Array]:
        """A (m, D) and r (m,) with A x = −r."""
        T, camera = self.T[self.part], self.camera
        p = (T[:, :3, :3] @ self.p_part[:, :, None])[:, :, 0] + T[:, :3, 3]
        u = camera.fx * p[:, 0] / p[:, 2] + camera.cx
        v = camera.fy * p[:, 1] / p[:, 2] + camera.cy
        taken = cv2.remap(
            self.picture, u.astype(np.float32), v.astype(np.float32), cv2.INTER_LINEAR
        )  # fmt: skip
        E, Eu, Ev, _ = taken[:, 0].T
        gx, gy = camera.fx * Eu / p[:, 2], camera.fy * Ev / p[:, 2]
        g = np.stack([gx, gy, -(p[:, 0] * gx + p[:, 1] * gy) / p[:, 2]], axis=1)
        row = np.concatenate([g, np.cross(p, g)], axis=1)
        return (row @ twists(self.skeleton, self.T).T) * self.moves, E - self.grey

    def svd(self, A: Array, r: Array) -> Array:
        """x = −A⁺ r by the singular value decomposition of A."""
        U, s, Vt = np.linalg.svd(A * self.skeleton.column_scale, full_matrices=False)
        kept = s > 0.02 * s[0]
        return -self.skeleton.column_scale * (Vt[kept].T @ ((U.T @ r)[kept] / s[kept]))

    def lstsq(self, A: Array, r: Array) -> Array:
        return np.linalg.lstsq(A, -r, rcond=None)[0]


def own_solve(shown: Sequence, scene: Scene, clip: Clip, method: Keypose = FULL) -> Timing:
    """One solve of ours: sums over the followed points, equations, Cholesky, update."""
    followed, solves = seen_points(scene, shown, clip, method.stride), 40
    pose, dofs = shown.truth.pose(1), scene.skeleton.dof_count

    def work() -> None:
        R, t = pose.Rs_parent_part.copy(), pose.p_camera_root.copy()
        A = np.empty((dofs, dofs))
        solve_pair(
            scene.arrays, followed.chosen, followed.grey, followed.starts, R, t, np.zeros(dofs),
            clip.levels[0][1], scene.lens, scene.prior(method.stride), solves, 0.0, A,
        )  # fmt: skip

    return Timing.of(work, 15, solves)


def optical_flow(shown: Sequence) -> Timing:
    """Pyramidal Lucas–Kanade of OpenCV on a grid over the picture."""
    columns, rows = FLOW_POINTS
    grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 1, 2)
    points = ((grid + 0.5) * (shown.camera.width / columns)).astype(np.float32)
    before, after = (np.array(shown.grey[k]) for k in (0, 1))
    return Timing.of(lambda: cv2.calcOpticalFlowPyrLK(before, after, points, None))


@dataclass(frozen=True)
class Floor:
    """What one frame has to compute and to read, and how long bare loops of that size take."""

    megaflops: float
    megabytes: float
    compute: Timing
    read: Timing


def most_solves(method: Keypose) -> int:
    """Solves a frame has at most: two chains over the levels, the passes, the refinement."""
    levels = 3 - method.finest
    chains = 2 * levels * method.chain_inner
    return chains + method.passes * method.inner + 2 * method.refinement.solves


def floor(shown: Sequence, scene: Scene, clip: Clip, method: Keypose = FULL) -> Floor:
    """The floor under one frame of a method, at most of its solves."""
    seen, followed = seen_points(scene, shown, clip), seen_points(scene, shown, clip, method.stride)
    looks = 2 + method.passes + 1
    flops = most_solves(method) * len(followed) * POINT_FLOPS
    flops += looks * len(scene.points.points) * SEEING_FLOPS
    touched = _touched_bytes(shown, scene, seen)
    # eight independent sums, so that they fill the vector units as the real sums do
    compute = Timing.of(lambda: _multiply(flops // 16), 15)
    pool = np.zeros((max(2, 200_000_000 // touched), touched // 4), np.float32)
    turn = iter(range(10**6))
    read = Timing.of(lambda: _read(pool[next(turn) % len(pool)]), 15)
    return Floor(flops / 1e6, touched / 1e6, compute, read)


def _touched_bytes(shown: Sequence, scene: Scene, seen: Seen) -> int:
    """Bytes of the distinct pixels around the seen points, with a third more for the pyramid."""
    T = pose_transforms(scene.skeleton, shown.truth.pose(0))
    count = len(seen)
    part = np.searchsorted(seen.starts, np.arange(count), side="right") - 1
    p = scene.points.points[seen.chosen[:count]]
    uv = shown.camera.project((T[part, :3, :3] @ p[..., None])[..., 0] + T[part, :3, 3])
    corner = np.floor(uv).astype(int)
    pixels = {
        (u + du, v + dv) for u, v in corner.tolist() for du in (0, 1) for dv in (0, 1)
    }  # fmt: skip
    return int(len(pixels) * 16 * 4 / 3)


@compiled
def _multiply(rounds):  # type: ignore[no-untyped-def]
    s = np.zeros(8, np.float32)
    f = np.float32(0.999)
    a = b = c = d = e = g = h = i = np.float32(1)
    for _ in range(rounds):
        a = a * f + f
        b = b * f + f
        c = c * f + f
        d = d * f + f
        e = e * f + f
        g = g * f + f
        h = h * f + f
        i = i * f + f
    s[0] = a + b + c + d + e + g + h + i
    return s


@compiled
def _read(values):  # type: ignore[no-untyped-def]
    s = np.float32(0)
    for k in range(values.shape[0]):
        s += values[k]
    return s
