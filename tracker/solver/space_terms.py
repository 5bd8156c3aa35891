"""Terms of a motion in space: points that stand still, the floor, and the jerk of parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.banded import add_coupling_blocks
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
            self.frames, weight * away, scale * np.swapaxes(J[:, 0], -1, -2),
            np.arange(self.at, self.at + 3), -scale * np.eye(3),
        )  # fmt: skip

    def _within(self, posed: Posed) -> Posed:
        R, p = posed.Rs_parent_part[self.frames], posed.p_camera_root[self.frames]
        return Posed(posed.skeleton, R, p)

    def _away(self, p: Array, shared: Array) -> Array:
        return np.asarray((p - shared[self.at : self.at + 3]) / self.sigma_m)


@dataclass(frozen=True, eq=False)
class OnFloor:
    """A shared place so far above the floor: (up · c − h − above)/σ, h the last of the shared
    unknowns."""

    at: int
    up_world: Array
    above_m: float
    sigma_m: float

    def cost(self, posed: Posed, shared: Array) -> float:
        return 0.5 * float(self._off(shared)[0]) ** 2

    def rows(self, posed: Posed, shared: Array) -> SharedRows:
        unknown = self._unknown(shared)
        return SharedRows.alone(
            posed.skeleton.dof_count, self._off(shared), unknown, self._row[None]
        )

    def _off(self, shared: Array) -> Array:
        """(1,)"""
        off = self._row @ shared[self._unknown(shared)] - self.above_m / self.sigma_m
        return np.array([off])

    @property
    def _row(self) -> Array:
        return np.append(self.up_world, -1.0) / self.sigma_m

    def _unknown(self, shared: Array) -> NDArray[np.int64]:
        return np.array([self.at, self.at + 1, self.at + 2, len(shared) - 1])


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


THIRD = (-1, 3, -3, 1)
"""Third differences: they leave free flight and steady pushes alone."""


@dataclass(frozen=True, eq=False)
class Jerk:
    """Third differences of K points' places in one frame, in every direction alike.

    sigma (K,), or (N − 3, K) of every difference: m/s³. Rows and data both grow with the frame
    rate, so that it does not matter.
    """

    skeleton: Skeleton
    points: BodyPoints
    sigma: Array
    frames_per_second: float

    def of(self, motion: Trajectory) -> Array:
        """(N − 3, K, 3) m/s³"""
        places = self.points.at(motion.transforms(self.skeleton))
        return np.asarray(np.diff(places, 3, axis=0) * self.frames_per_second**3)

    def cost(self, motion: Trajectory) -> float:
        return 0.5 * float(((self.of(motion) / self.sigma[..., None]) ** 2).sum())

    def equations(self, motion: Trajectory, unknown: slice) -> tuple[Array, Array]:
        """Upper banded (4D, uD) and gradient (u, D) of the u unknown poses."""
        J, widest = self._rows(motion), self._widest
        count, dofs, m = len(motion), J.shape[-1], max(len(motion) - 3, 0)
        by_point = np.broadcast_to((widest / self.sigma) ** 2, (m, len(widest)))
        weights = np.repeat(by_point, 3, axis=1)
        r = weights * (self.of(motion) / widest[:, None]).reshape(m, J.shape[1])
        start, stop, _ = unknown.indices(count)
        gradient = np.zeros((count, dofs))
        for i, share in enumerate(THIRD):
            gradient[i : i + m] += share * np.einsum("nmd,nm->nd", J[i : i + m], r)
        banded = np.zeros((len(THIRD) * dofs, (stop - start) * dofs))
        for off in range(min(len(THIRD), stop - start)):
            blocks = _products(J, off, weights)
            banded = add_coupling_blocks(banded, off, blocks[start : stop - off])
        return banded, gradient[unknown]

    @property
    def _widest(self) -> Array:
        """(K,) the largest sigma of each point."""
        return self.sigma if self.sigma.ndim == 1 else self.sigma.max(axis=0)

    def _rows(self, motion: Trajectory) -> Array:
        """(N, 3K, D) how the scaled places of every frame move."""
        posed = Posed(self.skeleton, motion.Rs_parent_part, motion.ps_camera_root)
        _, J = self.points.jacobian(posed)
        scaled = J * (self.frames_per_second**3 / self._widest)[:, None, None]
        return np.asarray(np.swapaxes(scaled, -1, -2).reshape(len(J), -1, J.shape[-2]))


def _products(J: Array, off: int, weights: Array) -> Array:
    """(N − off, D, D) JᵀJ of two frames so far apart, over all third differences, which count by
    weights (N − 3, 3K)."""
    count = len(J) - off
    total = np.zeros((count, J.shape[1]))
    for i in range(len(THIRD) - off):
        total[i : i + len(weights)] += THIRD[i] * THIRD[i + off] * weights
    return np.asarray(np.swapaxes(total[..., None] * J[:count], 1, 2) @ J[off:])
