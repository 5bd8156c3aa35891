"""How far the observed surface stands out from the body's: solved with the pose and marginalised.

A hull is thicker than what it holds; by how much depends on where the cameras stand and on what
hides what. So is that of t_0, whose surface moves with the body, but by another amount. All round a
limb such a difference pushes nothing, but where one side of it is in contact or unreliable
the rest pushes alone, and a tapering limb slides. So the body's surface may stand out along its
normals n by nᵀ Q n, with one symmetric Q for all of a step: by as much on opposite sides, since
what differs there is a motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.geometry.rotations import Array

OFFSET_TERMS = 6
"""Numbers that make up Q, first in the rows that pairs are summed to."""
EVENNESS = 0.07
"""Prior of no offset: so many pairs without one, as a share of all."""


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """energy: metres².  information (D, D) and slope (D,): of half of it."""

    energy: float
    information: Array
    slope: Array


def normal_equations(A: Array, b: Array, J: Array, energy: float, offset: bool) -> NormalEquations:
    """Those of the free degrees of freedom, from the sums of `pull`.

    A (G, 18, 18), b (G, 18), energy: those sums, of weights that sum to 2.  J: (G, 12, D) of the
    groups' twists.  offset: Q is marginalised, the energy that at the best Q; otherwise Q is 0.
    """
    moving = slice(OFFSET_TERMS, None)
    information = np.einsum("gid,gij,gje->de", J, A[:, moving, moving], J, optimize=True)
    slope = np.einsum("gid,gi->d", J, b[:, moving])
    if not offset:
        return NormalEquations(energy, information, slope)
    own = A[:, :OFFSET_TERMS, :OFFSET_TERMS].sum(axis=0) + 2 * EVENNESS * np.eye(OFFSET_TERMS)
    push = b[:, :OFFSET_TERMS].sum(axis=0)
    shared = np.einsum("gki,gid->kd", A[:, :OFFSET_TERMS, moving], J)
    solved = np.linalg.solve(own, np.column_stack([shared, push]))
    return NormalEquations(
        energy - float(push @ solved[:, -1]),
        information - shared.T @ solved[:, :-1],
        slope - shared.T @ solved[:, -1],
    )
