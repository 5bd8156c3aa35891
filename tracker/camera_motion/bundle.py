"""Bundle adjustment: where a camera was in several views, and how far all points are, in one solve.

A point lies at an inverse depth along its ray in its *anchor*, the view in which it was first seen:
0 is infinitely far, so that a point of unknown depth is as good as any. What is minimised are the
distances between where points are seen and where they should be, in standard deviations, weighed by
Cauchy's kernel; depths are eliminated exactly (Schur), one number each.

Where points are seen is x/z and y/z. Lengths have one unit, whichever it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse.linalg import splu

from keypose.tracker.geometry.rotations import Array, exp_rotation, transpose
from keypose.tracker.solver.least_squares import Criteria, Damping, Problem, least_squares
from keypose.tracker.solver.robust import Cauchy

Indices = NDArray[np.int64]

KERNEL = Cauchy(2.0)
"""Of residuals, standard deviations."""
FARTHEST = 1e3
"""Standard deviations, beyond which the cost rises no more: that of a point behind is finite."""
LEAST_DEPTH = 1e-3
"""Of a point before the camera, its depth at its anchor the unit."""
DENSE = 24
"""Views that may move, with more of which the equations are kept sparse."""
MOST_AT_ONCE = 20_000
"""Observations whose Jacobians are in memory at a time."""
ADJUSTING = Criteria(most_tries=4, gain=1e-4, damping=Damping(first=1e-4, easier=5.0))
"""Of an adjustment from near by, which a hundredth of a percent of the cost ends."""


@dataclass(frozen=True, eq=False)
class Bundle:
    """V views, P points, N observations of points, without those in their anchors.

    Ts: (V, 4, 4) camera from world.  free: (V,), the others stay as they are.
    anchor: (P,) views.  rays: (P, 2) where points are seen there.  depths: (P,) inverse.
    mean, spread: (P,) of the depths, before anything is seen.
    view, point: (N,) indices.  xy: (N, 2) as x/z and y/z.  noise: standard deviation of an xy.
    """

    Ts: Array
    free: NDArray[np.bool_]
    anchor: Indices
    rays: Array
    depths: Array
    mean: Array
    spread: Array
    view: Indices
    point: Indices
    xy: Array
    noise: float

    def only(self, rows: Indices) -> Bundle:
        """The same with some of the observations."""
        return replace(self, view=self.view[rows], point=self.point[rows], xy=self.xy[rows])


def adjusted(bundle: Bundle, steps: int) -> tuple[Bundle, Array]:
    """The bundle after steps of Levenberg and Marquardt, and the standard deviations of its depths
    (P,), the cameras taken as known."""
    criteria = replace(ADJUSTING, most_steps=steps)
    solution = least_squares(_Adjustment(_Layout.of(bundle)), bundle, criteria)
    return solution.state, 1 / np.sqrt(solution.here.equations.H_depth)


def residual_lengths(bundle: Bundle) -> Array:
    """Distances (N,) of what is seen from where it should be, standard deviations; inf behind."""
    return _residuals(bundle)[1]


def cost_of(bundle: Bundle) -> float:
    """What is minimised: half the sum of squares, those of places robust."""
    robust = KERNEL.loss(np.minimum(residual_lengths(bundle), FARTHEST))
    prior = ((bundle.depths - bundle.mean) / bundle.spread) ** 2
    return 0.5 * float(robust.sum() + prior.sum())


def points_in_views(bundle: Bundle) -> Array:
    """Where points are in the views that see them (N, 3), their depth at anchor the unit."""
    R, t = bundle.Ts[:, :3, :3], bundle.Ts[:, :3, 3]
    anchor, depth = bundle.anchor, bundle.depths[:, None]
    b = np.concatenate([bundle.rays, np.ones((len(anchor), 1))], axis=1)
    in_world = np.einsum("pba,pb->pa", R[anchor], b - depth * t[anchor])
    i, j = bundle.view, bundle.point
    return np.asarray(np.einsum("nab,nb->na", R[i], in_world[j]) + depth[j] * t[i])


def _residuals(bundle: Bundle) -> tuple[Array, Array]:
    """Residuals (N, 2) and their lengths (N,), in standard deviations; inf behind."""
    Y = points_in_views(bundle)
    ahead = Y[:, 2] > LEAST_DEPTH
    z = np.where(ahead, Y[:, 2], 1.0)
    residual = (Y[:, :2] / z[:, None] - bundle.xy) / bundle.noise
    return residual, np.where(ahead, np.linalg.norm(residual, axis=1), np.inf)


@dataclass(frozen=True, eq=False)
class _Batch:
    """Some of the observations, few enough to have their Jacobians in memory.

    rows: sorted by the slots of view and anchor.  pairs (R, 2): slots that occur together, and
    starts (R,): where in the rows each pair begins.
    """

    rows: Indices
    pairs: Indices
    starts: Indices


@dataclass(frozen=True, eq=False)
class _Layout:
    """Where in the equations a bundle's views stand: M of them may move, and one more slot is
    for all others.

    slot: (V,) of each view.
    """

    slot: Indices
    count: int
    batches: tuple[_Batch, ...]

    @classmethod
    def of(cls, bundle: Bundle) -> _Layout:
        count = int(bundle.free.sum())
        slot = np.where(bundle.free, np.cumsum(bundle.free) - 1, count).astype(np.int64)
        key = slot[bundle.view] * (count + 1) + slot[bundle.anchor[bundle.point]]
        order = np.argsort(key, kind="stable")
        batches = []
        for first in range(0, len(order), MOST_AT_ONCE):
            rows = order[first : first + MOST_AT_ONCE]
            keys, starts = np.unique(key[rows], return_index=True)
            batches.append(_Batch(rows, np.stack(np.divmod(keys, count + 1), axis=1), starts))
        return cls(slot, count, tuple(batches))

    def equations(self, bundle: Bundle) -> _Equations:
        """The normal equations at where the bundle is."""
        H_depth = 1 / bundle.spread**2
        g_depth = (bundle.depths - bundle.mean) / bundle.spread**2
        sums, cross = [], []
        for batch in self.batches:
            part = bundle.only(batch.rows)
            J, depth, residual, weight = _jacobians(part)
            wJ, count = weight[:, None, None] * J, len(bundle.anchor)
            H_depth += np.bincount(part.point, weight * (depth**2).sum(axis=1), count)
            g_depth += np.bincount(part.point, weight * (depth * residual).sum(axis=1), count)
            blocks = np.concatenate(
                [transpose(wJ) @ J, transpose(wJ) @ residual[..., None]], axis=2
            )
            sums.append(np.add.reduceat(blocks, batch.starts, axis=0))
            cross.append(self._cross(part, np.einsum("nka,nk->na", wJ, depth)))
        pairs = np.concatenate([batch.pairs for batch in self.batches])
        H, g = self._gather(pairs, np.concatenate(sums))
        rows, columns, values = (np.concatenate(parts) for parts in zip(*cross, strict=True))
        E = self._matrix(rows, columns, values, len(bundle.anchor))
        return _Equations(H, g, E, H_depth, g_depth)

    def _gather(self, pairs: Indices, sums: Array) -> tuple[Array | sparse.csr_array, Array]:
        """H (6M, 6M) and g (6M,) of the blocks (R, 12, 13) of all pairs."""
        m, (view, anchor) = self.count, pairs.T
        g = np.zeros((m + 1, 6))
        np.add.at(g, view, sums[:, :6, 12])
        np.add.at(g, anchor, sums[:, 6:, 12])
        first = np.concatenate([view, anchor, view, anchor])
        second = np.concatenate([view, anchor, anchor, view])
        blocks = np.concatenate(
            [sums[:, :6, :6], sums[:, 6:, 6:12], sums[:, :6, 6:12], sums[:, 6:, :6]]
        )
        kept = (first < m) & (second < m)
        steps = np.arange(6)
        rows = np.broadcast_to(6 * first[kept, None, None] + steps[:, None], (kept.sum(), 6, 6))
        columns = np.broadcast_to(6 * second[kept, None, None] + steps, (kept.sum(), 6, 6))
        H = self._matrix(rows.ravel(), columns.ravel(), blocks[kept].ravel(), 6 * m)
        return H, g[:m].ravel()

    def _cross(self, part: Bundle, both: Array) -> tuple[Indices, Indices, Array]:
        """Rows, columns and values of E (P, 6M) from (N, 12), of the view and of the anchor."""
        slots = np.concatenate([self.slot[part.view], self.slot[part.anchor[part.point]]])
        points = np.concatenate([part.point, part.point])
        kept = slots < self.count
        columns = (6 * slots[kept, None] + np.arange(6)).ravel()
        values = np.concatenate([both[:, :6], both[:, 6:]])[kept].ravel()
        return np.repeat(points[kept], 6), columns, values

    def _matrix(
        self, rows: Indices, columns: Indices, values: Array, height: int
    ) -> Array | sparse.csr_array:
        """(height, 6M), what has one place summed.

        Args:
            rows, columns, values: (Z,) of each entry.
            height: of the matrix.
        """
        width = 6 * self.count
        if self.count > DENSE:
            return sparse.csr_array((values, (rows, columns)), shape=(height, width))
        flat = np.bincount(rows * width + columns, values, height * width)
        return np.asarray(flat, float).reshape(height, width)


@dataclass(frozen=True, eq=False)
class _Equations:
    """Normal equations: H (6M, 6M) and g (6M,) of the views that may move, H_depth and g_depth
    (P,) of the points, E (P, 6M) between these.
    """

    H: Array | sparse.csr_array
    g: Array
    E: Array | sparse.csr_array
    H_depth: Array
    g_depth: Array

    def step(self, damping: float) -> Array:
        """The damped step (6M + P,): first the views, the depths eliminated, then these."""
        inverse = 1 / (self.H_depth * (1 + damping))
        g = self.g - self.E.T @ (inverse * self.g_depth)
        more = damping * self.H.diagonal() + 1e-9
        if isinstance(self.E, np.ndarray):
            S = self.H + np.diag(more) - self.E.T @ (inverse[:, None] * self.E)
            step = -cho_solve(cho_factor(S, check_finite=False), g) if len(g) else -g
        else:
            S = self.H + sparse.diags_array(more) - self.E.T @ self.E.multiply(inverse[:, None])
            step = -splu(sparse.csc_matrix(S)).solve(g)
        return np.concatenate([step, -inverse * (self.g_depth + self.E @ step)])


@dataclass(frozen=True, eq=False)
class _Adjusted:
    """A bundle on the way, and its cost and equations there."""

    bundle: Bundle
    layout: _Layout

    @cached_property
    def cost(self) -> float:
        return cost_of(self.bundle)

    @cached_property
    def equations(self) -> _Equations:
        return self.layout.equations(self.bundle)

    def step(self, damping: float) -> Array:
        return self.equations.step(damping)


@dataclass(frozen=True, eq=False)
class _Adjustment(Problem[Bundle, _Adjusted]):
    """All views that may move, and all depths."""

    layout: _Layout

    def at(self, state: Bundle, count: int) -> _Adjusted:
        return _Adjusted(state, self.layout)

    def moved(self, state: Bundle, step: Array) -> Bundle:
        of_views, of_depths = np.split(step, [6 * self.layout.count])
        Ts = state.Ts.copy()
        Ts[state.free] = nudged(Ts[state.free], of_views.reshape(-1, 6))
        return replace(state, Ts=Ts, depths=state.depths + of_depths)


def nudged(Ts: Array, steps: Array) -> Array:
    """T (..., 4, 4) moved and then turned in their own frames by (..., 6): p + w × p + v."""
    R = exp_rotation(steps[..., 3:])
    moved = Ts.copy()
    moved[..., :3, :3] = R @ Ts[..., :3, :3]
    moved[..., :3, 3] = (R @ Ts[..., :3, 3:])[..., 0] + steps[..., :3]
    return moved


def _jacobians(bundle: Bundle) -> tuple[Array, Array, Array, Array]:
    """Jacobians (N, 2, 12) of the residuals by view and anchor, (N, 2) by depth, the residuals
    (N, 2) and the weights (N,).
    """
    Y, (residual, length) = points_in_views(bundle), _residuals(bundle)
    i, j = bundle.view, bundle.point
    R, t = bundle.Ts[:, :3, :3], bundle.Ts[:, :3, 3]
    anchor, depth = bundle.anchor[j], bundle.depths[j]
    weight = KERNEL.weight(length)
    P = projection_jacobian(Y) / bundle.noise
    PR = P @ R[i] @ transpose(R[anchor])
    # of the camera frame's motion v, w: δY = depth v + w × Y; of the anchor's: turned back
    b = np.concatenate([bundle.rays[j], np.ones((len(j), 1))], axis=1)
    own = np.concatenate([P * depth[:, None, None], cross_rows(P, Y)], axis=2)
    anchors = -np.concatenate([PR * depth[:, None, None], cross_rows(PR, b)], axis=2)
    shift = t[i] - np.einsum("nab,ncb,nc->na", R[i], R[anchor], t[anchor], optimize=True)
    by_depth = np.einsum("nka,na->nk", P, shift)
    return np.concatenate([own, anchors], axis=2), by_depth, residual, weight


def projection_jacobian(Y: Array) -> Array:
    """(N, 2, 3) of x/z and y/z by the place (N, 3); what is behind counts as just before."""
    z = np.maximum(Y[:, 2], LEAST_DEPTH)
    P = np.zeros((len(Y), 2, 3))
    P[:, 0, 0] = P[:, 1, 1] = 1 / z
    P[:, :, 2] = -Y[:, :2] / (z * z)[:, None]
    return P


def cross_rows(P: Array, Y: Array) -> Array:
    """(N, 2, 3): P (w × Y) as a map of w."""
    return np.cross(Y[:, None, :], P)
