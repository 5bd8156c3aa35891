"""How far the observed surface stands out from the body's, found with the pose and left out of it.

A hull is thicker than what it holds; by how much depends on where the cameras stand and on what
hides what. So is that of t_0, whose surface moves with the body, but by another amount. All round a
limb such a difference pushes nothing, but where one side of it is in contact or not to be believed
the rest pushes alone, and a tapering limb slides. So the body's surface may stand out along its
normals n by nᵀ Q n, with one symmetric Q for all of a step: by as much on opposite sides, since
what differs there is a motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracker.geometry.rotations import Array

SWELLINGS = 6
"""Numbers that make up Q, first in the rows that pairs are summed to."""
EVENNESS = 0.07
"""Pairs that see no swelling, put beside those that are there: as a share of them."""


@dataclass(frozen=True, eq=False)
class Normal:
    """energy: metres².  information (D, D) and slope (D,): of half of it."""

    energy: float
    information: Array
    slope: Array


def normal_equations(A: Array, b: Array, J: Array, energy: float, swell: bool) -> Normal:
    """Those of the free degrees of freedom, from the sums of `pull`.

    A (G, 18, 18), b (G, 18), energy: those sums, of weights that sum to 2.  J: (G, 12, D) of the
    groups' twists.  swell: the energy is that at the best Q, and what Q may explain is no
    information on the pose; otherwise Q is 0.
    """
    moving = slice(SWELLINGS, None)
    information = np.einsum("gid,gij,gje->de", J, A[:, moving, moving], J, optimize=True)
    slope = np.einsum("gid,gi->d", J, b[:, moving])
    if not swell:
        return Normal(energy, information, slope)
    own = A[:, :SWELLINGS, :SWELLINGS].sum(axis=0) + 2 * EVENNESS * np.eye(SWELLINGS)
    push = b[:, :SWELLINGS].sum(axis=0)
    shared = np.einsum("gki,gid->kd", A[:, :SWELLINGS, moving], J)
    told = np.linalg.solve(own, np.column_stack([shared, push]))
    return Normal(
        energy - float(push @ told[:, -1]),
        information - shared.T @ told[:, :-1],
        slope - shared.T @ told[:, -1],
    )
