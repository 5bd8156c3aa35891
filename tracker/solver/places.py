"""Points of the body that stand at one unknown place over a range of frames, and a floor of
unknown height that such places may lie on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.body_points import BodyPoints
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.robust import Kernel
from keypose.tracker.solver.stretch_poses import SharedEquations


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
        return 0.5 * float(self.kernel.loss(np.linalg.norm(away, axis=-1)).sum())

    def equations(self, posed: Posed, shared: Array) -> SharedEquations:
        within = self._within(posed)
        p, J = self.point.jacobian(within)
        away, J = self._away(p[:, 0], shared), np.swapaxes(J[:, 0], -1, -2) / self.sigma_m
        weight = self.kernel.weight(np.linalg.norm(away, axis=-1))
        pulled = np.swapaxes(J, -1, -2) * weight[:, None, None]  # (n, D, 3)
        return SharedEquations(
            self.frames,
            pulled @ J,
            (pulled @ away[..., None])[..., 0],
            np.arange(self.at, self.at + 3),
            -pulled / self.sigma_m,
            np.eye(3) * weight.sum() / self.sigma_m**2,
            -(away * weight[:, None]).sum(axis=0) / self.sigma_m,
        )

    def _within(self, posed: Posed) -> Posed:
        R, p = posed.Rs_parent_part[self.frames], posed.p_camera_root[self.frames]
        return Posed(posed.skeleton, R, p)

    def _away(self, p: Array, shared: Array) -> Array:
        return np.asarray((p - shared[self.at : self.at + 3]) / self.sigma_m)


@dataclass(frozen=True, eq=False)
class OnFloor:
    """A shared place on the floor: (up · c − h)/σ, h the last of the shared unknowns."""

    at: int
    up_camera: Array
    sigma_m: float

    def cost(self, posed: Posed, shared: Array) -> float:
        return 0.5 * float(self._row @ shared[self._unknown(shared)]) ** 2

    def equations(self, posed: Posed, shared: Array) -> SharedEquations:
        unknown, row = self._unknown(shared), self._row
        r = float(row @ shared[unknown])
        return SharedEquations.alone(posed.skeleton.dof_count, unknown, np.outer(row, row), row * r)

    @property
    def _row(self) -> Array:
        return np.append(self.up_camera, -1.0) / self.sigma_m

    def _unknown(self, shared: Array) -> NDArray[np.int64]:
        return np.array([self.at, self.at + 1, self.at + 2, len(shared) - 1])


@dataclass(frozen=True, eq=False)
class Near:
    """Shared unknowns near values, 1/σ each: what nothing else decides, or what is known."""

    values: Array
    scale: Array

    def cost(self, posed: Posed, shared: Array) -> float:
        return 0.5 * float((((shared - self.values) * self.scale) ** 2).sum())

    def equations(self, posed: Posed, shared: Array) -> SharedEquations:
        r = (shared - self.values) * self.scale
        unknown = np.arange(len(shared))
        return SharedEquations.alone(
            posed.skeleton.dof_count, unknown, np.diag(self.scale**2), r * self.scale
        )
