"""Terms of a motion in space: points that stand still, the floor, and the jerk of parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.steps import add_blocks
from keypose.tracker.solver.posed import BodyPoints, Posed
from keypose.tracker.solver.robust import Kernel
from keypose.tracker.solver.terms import SharedRows, robust_cost


@dataclass(frozen=True, eq=False)
class AtOnePlace:
    """One point at one place in these frames: |p − c|/σ, c the shared unknowns at + 0 … 2.

    kernel: of the distance. A redescending one would let go just where the motion was wrong.
    """

    point: BodyPoints
    frames: slice
    at: int
    sigma_m: float
    kernel: Kernel

    def cost(self, posed: Posed, shared: Array) -> float:
        away = self._away(self.point.of(self._within(posed))[:, 0], shared)
        return robust_cost(self.kernel, np.linalg.norm(away, axis=-1))

    def rows(self, posed: Posed, shared: Array) -> SharedRows:
        p, J = self.point.jacobian(self._within(posed))
        away = self._away(p[:, 0], shared)
        weight = np.sqrt(self.kernel.weight(np.linalg.norm(away, axis=-1)))[:, None]
        scale = (weight / self.sigma_m)[..., None]
        return SharedRows(
            self.frames,
            weight * away,
            scale * np.swapaxes(J[:, 0], -1, -2),
            np.arange(self.at, self.at + 3),
            -scale * np.eye(3),
        )

    def _within(self, posed: Posed) -> Posed:
        R, p = posed.Rs_parent_part[self.frames], posed.p_camera_root[self.frames]
        return Posed(posed.skeleton, R, p)

    def _away(self, p: Array, shared: Array) -> Array:
        return np.asarray((p - shared[self.at : self.at + 3]) / self.sigma_m)


@dataclass(frozen=True, eq=False)
class Floor:
    """A plane whose height along up is the last of the shared unknowns; those before it are by how
    much it is tilted.

    up_world (3,): unit vector.  ways (T, 3): across up, in which it can tilt, none where up is
    known.  about (3,): where tilting leaves its height.
    """

    up_world: Array
    ways: Array
    about: Array

    def unknown(self, shared: Array) -> NDArray[np.int64]:
        """(T + 1,) its own."""
        return np.arange(len(shared) - len(self.ways) - 1, len(shared))

    def up(self, shared: Array) -> Array:
        """Unit vector (3,) as tilted."""
        up = self._leaning(shared)
        return np.asarray(up / np.linalg.norm(up))

    def height(self, shared: Array) -> float:
        """Metres along that vector."""
        up = self._leaning(shared)
        off = float((up - self.up_world) @ self.about)
        return (float(shared[-1]) + off) / float(np.linalg.norm(up))

    def _leaning(self, shared: Array) -> Array:
        return np.asarray(self.up_world + shared[self.unknown(shared)[:-1]] @ self.ways)

    def rows(self, place: Array, shared: Array) -> tuple[float, Array]:
        """How high a place (3,) is above it, and how that changes with the place and with its own
        unknowns (3 + T + 1,)."""
        away = place - self.about
        up = self._leaning(shared)
        high = float(self.up_world @ place + (up - self.up_world) @ away - shared[-1])
        return high, np.concatenate([up, self.ways @ away, [-1.0]])


@dataclass(frozen=True, eq=False)
class OnFloor:
    """A shared place so far above the floor, of which its height is above_m."""

    at: int
    floor: Floor
    above_m: float
    sigma_m: float

    def cost(self, posed: Posed, shared: Array) -> float:
        high, _ = self.floor.rows(shared[self.at : self.at + 3], shared)
        return 0.5 * ((high - self.above_m) / self.sigma_m) ** 2

    def rows(self, posed: Posed, shared: Array) -> SharedRows:
        high, slope = self.floor.rows(shared[self.at : self.at + 3], shared)
        own = np.arange(self.at, self.at + 3)
        unknown = np.concatenate([own, self.floor.unknown(shared)])
        r = np.array([(high - self.above_m) / self.sigma_m])
        return SharedRows.alone(posed.skeleton.dof_count, r, unknown, slope[None] / self.sigma_m)


@dataclass(frozen=True, eq=False)
class Near:
    """Shared unknowns near values, 1/σ each: what nothing else decides, or what is known."""

    values: Array
    scale: Array

    def cost(self, posed: Posed, shared: Array) -> float:
        return 0.5 * float((((shared - self.values) * self.scale) ** 2).sum())

    def rows(self, posed: Posed, shared: Array) -> SharedRows:
        r, unknown = (shared - self.values) * self.scale, np.arange(len(shared))
        return SharedRows.alone(posed.skeleton.dof_count, r, unknown, np.diag(self.scale))


SECOND = (1, -2, 1)
THIRD = (-1, 3, -3, 1)
"""Differences: third ones leave free flight and steady pushes alone."""


@dataclass(frozen=True, eq=False)
class Differences:
    """Differences of neighbouring frames' places of K points in one frame, in every direction
    alike.

    sigma (K,), or (N − d, K) of every difference, d the stencil's length less one: m/s^d, infinite
    where it does not count.  wanted (N − d, K, 3): what they are compared with. Rows and data both
    grow with the frame rate, so that it does not matter.
    """

    skeleton: Skeleton
    points: BodyPoints
    sigma: Array
    frames_per_second: float
    stencil: tuple[int, ...] = THIRD
    wanted: Array | float = 0.0

    def of(self, motion: Trajectory) -> Array:
        """(N − d, K, 3) m/s^d"""
        places = self.points.at(motion.transforms(self.skeleton))
        return np.asarray(np.diff(places, self._order, axis=0) * self._per_s)

    def cost(self, motion: Trajectory) -> float:
        away = self.of(motion) - self.wanted
        return 0.5 * float(((away / self.sigma[..., None]) ** 2).sum())

    def width(self, dofs: int) -> int:
        return len(self.stencil) * dofs

    def add_to(self, motion: Trajectory, unknown: slice, rows: Array, b: Array) -> None:
        J, widest = self._rows(motion), self._widest
        count, dofs, m = len(motion), J.shape[-1], max(len(motion) - self._order, 0)
        by_point = np.broadcast_to((widest / self.sigma) ** 2, (m, len(widest)))
        weights = np.repeat(by_point, 3, axis=1)
        away = self.of(motion) - self.wanted
        r = weights * (away / widest[:, None]).reshape(m, J.shape[1])
        start, stop, _ = unknown.indices(count)
        gradient = np.zeros((count, dofs))
        for i, share in enumerate(self.stencil):
            gradient[i : i + m] += share * np.einsum("nmd,nm->nd", J[i : i + m], r)
        b += gradient[unknown].ravel()
        for off in range(min(len(self.stencil), stop - start)):
            blocks = _products(J, off, weights, self.stencil)
            add_blocks(np.ascontiguousarray(blocks[start : stop - off]), off, rows)

    @property
    def _order(self) -> int:
        return len(self.stencil) - 1

    @property
    def _per_s(self) -> float:
        return self.frames_per_second**self._order

    @property
    def _widest(self) -> Array:
        """(K,) the largest finite sigma of each point."""
        finite = np.where(np.isfinite(self.sigma), self.sigma, 0.0)
        widest = finite if finite.ndim == 1 else finite.max(axis=0, initial=0.0)
        return np.asarray(np.where(widest > 0, widest, 1.0))

    def _rows(self, motion: Trajectory) -> Array:
        """(N, 3K, D) how the scaled places of every frame move."""
        posed = Posed(self.skeleton, motion.Rs_parent_part, motion.ps_camera_root)
        _, J = self.points.jacobian(posed)
        scaled = J * (self._per_s / self._widest)[:, None, None]
        return np.asarray(np.swapaxes(scaled, -1, -2).reshape(len(J), -1, J.shape[-2]))


def _products(J: Array, off: int, weights: Array, stencil: tuple[int, ...]) -> Array:
    """(N − off, D, D) JᵀJ of two frames so far apart, over all differences, which count by weights
    (N − d, 3K)."""
    count = len(J) - off
    total = np.zeros((count, J.shape[1]))
    for i in range(len(stencil) - off):
        total[i : i + len(weights)] += stencil[i] * stencil[i + off] * weights
    return np.asarray(np.swapaxes(total[..., None] * J[:count], 1, 2) @ J[off:])
