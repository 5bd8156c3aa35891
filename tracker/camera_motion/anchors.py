"""Bring the turns between anchors into agreement: what was measured twice is met as well as can be.

From one anchor to the next the turn is known from points followed; to older ones from landmarks
that came back into view. Each is an edge with its own doubt, and all anchors together are solved
by Gauss–Newton on the sparse normal equations, the first held where it is. An edge to an older
anchor that contradicts all others loses its weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from keypose.tracker.camera_motion.turn import Turn
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation, transpose
from keypose.tracker.solver.robust import GemanMcClure

STEPS = 8
SETTLED = 1e-9
RETURNS = GemanMcClure(4.0)
"""Of edges to older anchors, standard deviations."""
USUAL_DRIFT = np.radians(0.02)
"""By which an edge to an older anchor may be off besides its own standard deviation and that of the
way along the anchors."""


@dataclass(frozen=True, eq=False)
class Edge:
    """What was measured from anchor `one` to anchor `other`.

    turn: from the one's camera to the other's; its zoom is the quotient.  information (4, 4).
    returns: whether it leads to landmarks that came back.
    """

    one: int
    other: int
    turn: Turn
    information: Array
    returns: bool = False


def agreed(turns: Sequence[Turn], edges: Sequence[Edge]) -> list[Turn]:
    """The anchors' turns, from the world, that agree best with all edges; the first stays.

    turns: where they begin.
    """
    if len(turns) < 2:
        return list(turns)
    R = np.stack([turn.R for turn in turns])
    zoom = np.log([turn.zoom for turn in turns])
    a = np.array([edge.one for edge in edges])
    b = np.array([edge.other for edge in edges])
    measured = np.stack([edge.turn.R for edge in edges])
    ratio = np.log([edge.turn.zoom for edge in edges])
    information = np.stack([edge.information for edge in edges])
    returns = np.array([edge.returns for edge in edges])
    variance = _variance(edges, len(turns))
    for _ in range(STEPS):
        between = R[b] @ transpose(R[a])
        miss = np.empty((len(edges), 4))
        miss[:, :3] = log_rotation(between @ transpose(measured))
        miss[:, 3] = zoom[b] - zoom[a] - ratio
        sigmas = np.sqrt((miss**2).mean(axis=1) / variance)
        weight = np.where(returns, RETURNS.weight(sigmas), 1.0)
        step = _step(a, b, between, miss, information * weight[:, None, None], len(turns))
        R, zoom = exp_rotation(step[:, :3]) @ R, zoom + step[:, 3]
        if np.abs(step).max() < SETTLED:
            break
    return [Turn(r, float(z)) for r, z in zip(R, np.exp(zoom), strict=True)]


def _variance(edges: Sequence[Edge], count: int) -> Array:
    """By how much (E,) an edge may differ from the way along the anchors: its own variance and
    that of all steps between.
    """
    own = np.array([np.trace(np.linalg.inv(edge.information)) / 4 for edge in edges])
    steps = np.zeros(count)
    for edge, variance in zip(edges, own, strict=True):
        if not edge.returns:
            steps[edge.other] = variance
    along = np.cumsum(steps)
    between = [abs(along[edge.other] - along[edge.one]) for edge in edges]
    return np.asarray(own + between + USUAL_DRIFT**2)


def _step(
    a: NDArray[np.int64],
    b: NDArray[np.int64],
    between: Array,
    miss: Array,
    information: Array,
    count: int,
) -> Array:
    """The step (count, 4) of one Gauss–Newton iteration, nothing for the first anchor."""
    to_one = np.zeros((len(a), 4, 4))
    to_one[:, :3, :3], to_one[:, 3, 3] = -between, -1.0
    Ia = transpose(to_one) @ information
    entries = [(a, a, Ia @ to_one), (a, b, Ia), (b, a, transpose(Ia)), (b, b, information)]
    row = np.concatenate([(4 * i[:, None, None] + _ROW).ravel() for i, _, _ in entries])
    column = np.concatenate([(4 * j[:, None, None] + _COLUMN).ravel() for _, j, _ in entries])
    value = np.concatenate([m.ravel() for _, _, m in entries])
    H = coo_matrix((value, (row, column)), shape=(4 * count, 4 * count)).tocsc()[4:, 4:]
    g = np.zeros((count, 4))
    np.add.at(g, a, np.einsum("eab,eb->ea", Ia, miss))
    np.add.at(g, b, np.einsum("eab,eb->ea", information, miss))
    step = np.zeros((count, 4))
    step[1:] = -np.reshape(spsolve(H, g[1:].ravel()), (-1, 4))
    return step


_ROW, _COLUMN = (grid[None] for grid in np.meshgrid(np.arange(4), np.arange(4), indexing="ij"))
