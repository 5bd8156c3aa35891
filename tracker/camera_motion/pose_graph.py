"""The pose graph of a camera that turns: what was measured twice is met as well as can be.

From one keyframe to the next the turn is known from points followed; to older ones from landmarks
that came back into view. Each is an edge with its own doubt, and all keyframes together are solved
by Gauss–Newton on the sparse normal equations, the first held where it is. An edge that closes a
loop and contradicts all others loses its weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from keypose.tracker.camera_motion.turn import Turn
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation, transpose
from keypose.tracker.solver.gauss_newton import GAUSS_NEWTON, gauss_newton
from keypose.tracker.solver.robust import GemanMcClure

CRITERIA = replace(GAUSS_NEWTON, most_steps=8, settled=1e-9)
"""Of the solve, which starts as near as the keyframes have drifted."""
CLOSURES = GemanMcClure(4.0)
"""Of edges that close loops, standard deviations."""
USUAL_DRIFT = np.radians(0.02)
"""By which an edge that closes a loop may be off besides its own standard deviation and that of the
way along the keyframes."""


@dataclass(frozen=True, eq=False)
class Edge:
    """What was measured from a keyframe, the source, to a later one, the target; by number.

    turn: from the source's camera to the target's; its zoom is the quotient.  information (4, 4):
    of a small turn, radians, and of the logarithm of the zoom.  closes_loop: whether landmarks of
    old tell it, not points followed between the two.
    """

    source: int
    target: int
    turn: Turn
    information: Array
    closes_loop: bool = False


def optimised(turns: Sequence[Turn], edges: Sequence[Edge]) -> list[Turn]:
    """The keyframes' turns, from the world, that agree best with all edges; the first stays.

    turns: where they begin.
    """
    if len(turns) < 2:
        return list(turns)
    start = _Turns(np.stack([turn.R for turn in turns]), np.log([turn.zoom for turn in turns]))
    step = _Edges.of(edges, len(turns)).step
    end = gauss_newton(step, _Turns.moved, start, CRITERIA).state
    zooms = np.exp(end.log_zoom)
    return [Turn(R, float(zoom)) for R, zoom in zip(end.R, zooms, strict=True)]


@dataclass(frozen=True, eq=False)
class _Turns:
    """Of all keyframes, from the world: R (A, 3, 3) and log_zoom (A,)."""

    R: Array
    log_zoom: Array

    def moved(self, step: Array) -> _Turns:
        """All turned on by step[:, :3], radians, and zoomed by exp(step[:, 3])."""
        return _Turns(exp_rotation(step[:, :3]) @ self.R, self.log_zoom + step[:, 3])


@dataclass(frozen=True, eq=False)
class _Edges:
    """All edges (E,) as arrays, from keyframes a to b. variance (E,): of how far one may be off."""

    a: NDArray[np.int64]
    b: NDArray[np.int64]
    R: Array
    log_zoom: Array
    information: Array
    closes_loop: NDArray[np.bool_]
    variance: Array

    @classmethod
    def of(cls, edges: Sequence[Edge], count: int) -> _Edges:
        return cls(
            a=np.array([edge.source for edge in edges]),
            b=np.array([edge.target for edge in edges]),
            R=np.stack([edge.turn.R for edge in edges]),
            log_zoom=np.log([edge.turn.zoom for edge in edges]),
            information=np.stack([edge.information for edge in edges]),
            closes_loop=np.array([edge.closes_loop for edge in edges]),
            variance=_variance(edges, count),
        )

    def step(self, turns: _Turns, count: int) -> Array:  # noqa: ARG002
        """The step (A, 4), none for the first keyframe; edges weighed by how far they are off."""
        a, b, keyframes = self.a, self.b, len(turns.R)
        between = turns.R[b] @ transpose(turns.R[a])
        miss = np.empty((len(a), 4))
        miss[:, :3] = log_rotation(between @ transpose(self.R))
        miss[:, 3] = turns.log_zoom[b] - turns.log_zoom[a] - self.log_zoom
        sigmas = np.sqrt((miss**2).mean(axis=1) / self.variance)
        weight = np.where(self.closes_loop, CLOSURES.weight(sigmas), 1.0)
        information = self.information * weight[:, None, None]
        to_a = np.zeros((len(a), 4, 4))
        to_a[:, :3, :3], to_a[:, 3, 3] = -between, -1.0
        Ia = transpose(to_a) @ information
        entries = [(a, a, Ia @ to_a), (a, b, Ia), (b, a, transpose(Ia)), (b, b, information)]
        row = np.concatenate([(4 * i[:, None, None] + _ROW).ravel() for i, _, _ in entries])
        column = np.concatenate([(4 * j[:, None, None] + _COLUMN).ravel() for _, j, _ in entries])
        value = np.concatenate([m.ravel() for _, _, m in entries])
        H = coo_matrix((value, (row, column)), shape=(4 * keyframes, 4 * keyframes)).tocsc()[4:, 4:]
        g = np.zeros((keyframes, 4))
        np.add.at(g, a, np.einsum("eab,eb->ea", Ia, miss))
        np.add.at(g, b, np.einsum("eab,eb->ea", information, miss))
        step = np.zeros((keyframes, 4))
        step[1:] = -np.reshape(spsolve(H, g[1:].ravel()), (-1, 4))
        return step


def _variance(edges: Sequence[Edge], count: int) -> Array:
    """By how much (E,) an edge may differ from the way along the keyframes: its own variance and
    that of all steps between.
    """
    own = np.array([np.trace(np.linalg.inv(edge.information)) / 4 for edge in edges])
    steps = np.zeros(count)
    for edge, variance in zip(edges, own, strict=True):
        if not edge.closes_loop:
            steps[edge.target] = variance
    along = np.cumsum(steps)
    between = [abs(along[edge.target] - along[edge.source]) for edge in edges]
    return np.asarray(own + between + USUAL_DRIFT**2)


_ROW, _COLUMN = (grid[None] for grid in np.meshgrid(np.arange(4), np.arange(4), indexing="ij"))
