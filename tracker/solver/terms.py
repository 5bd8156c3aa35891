"""Terms: what a pose is compared with, each as a cost and its normal equations.

To add a term, write a frozen dataclass with `cost` and `equations`. Where it is made of residuals,
give `rows` and let `RowTerm` do the rest; where each residual is about one degree of freedom, give
`diagonal` and let `DiagonalTerm` do it; where time counts, let `SummedTerm` have a loop for many
poses (`placed.py`) and its plain twin for one (`plain_placed.py`). `BodyPoints` (`posed.py`) says
where points of the body are and how they move. Put it into the list of the solve it belongs to
(`MotionProblem`, `OnePose`), and into `TERMS` of the test that compares all terms with finite
differences, and their loops with the twins.

Terms of points and turns are in `pose_terms.py`, links between frames in `smoothness.py`, terms
that many frames share in `space_terms.py`. Residuals are in standard deviations, so that terms of
different kinds can be summed, and are half squared. Terms here work on one pose or on many at once:
batch axes come first, equations are those of every pose by itself, and a cost is that of all of
them.

What is found at one pose and kept (edges in a picture, pairs of points, noise) belongs to the term:
terms of pictures and surfaces are made again at every pose, for one pose at a time.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, transpose
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.robust import Kernel


@dataclass(frozen=True, eq=False)
class Equations:
    """Normal equations of the tracked degrees of freedom: A (..., D, D), gradient b (..., D).

    cost: of all poses; NaN where it is expensive and not needed (`Criteria.rejects`).
    """

    A: Array
    b: Array
    cost: float

    @classmethod
    def none(cls, *shape: int) -> Equations:
        """Where nothing is compared: (..., D)."""
        return cls(np.zeros((*shape, shape[-1])), np.zeros(shape), 0.0)

    @classmethod
    def of(cls, rows: Rows) -> Equations:
        """Take the equations of some rows."""
        A = transpose(rows.J) @ rows.J
        return cls(A, np.einsum("...md,...m->...d", rows.J, rows.r), rows.cost)

    def of_batch(self, batch: tuple[int, ...]) -> Equations:
        """The equations of poses one after another as those of poses with these axes."""
        A, b = self.A.reshape(*batch, *self.A.shape[-2:]), self.b.reshape(*batch, -1)
        return Equations(A, b, self.cost)

    def __add__(self, equations: Equations) -> Equations:
        return Equations(self.A + equations.A, self.b + equations.b, self.cost + equations.cost)


@dataclass(frozen=True, eq=False)
class Diagonal:
    """Normal equations whose matrix is diagonal: precision (..., D), gradient b (..., D), cost."""

    precision: Array
    b: Array
    cost: float


@dataclass(frozen=True, eq=False)
class Rows:
    """Residuals r (..., M), weighted if robust, their Jacobian J (..., M, D), and their cost."""

    r: Array
    J: Array
    cost: float

    @classmethod
    def stacked(cls, blocks: Sequence[Rows]) -> Rows:
        """All of them, to be multiplied out at once."""
        blocks = [rows for rows in blocks if rows.r.size] or blocks[:1]
        if len(blocks) == 1:
            return blocks[0]
        r, J = [rows.r for rows in blocks], [rows.J for rows in blocks]
        cost = sum(rows.cost for rows in blocks)
        return cls(np.concatenate(r, axis=-1), np.concatenate(J, axis=-2), cost)


class Term(Protocol):
    """A residual that a pose is compared with."""

    def cost(self, posed: Posed) -> float:
        """Half the sum of squares, robust ones by their kernel; infinite where no pose can be."""

    def equations(self, posed: Posed) -> Equations:
        """Linearized at a pose, with the cost there: b is its gradient, A as Gauss and Newton."""


class Link(Protocol):
    """A residual that links neighbouring frames of a motion."""

    def cost(self, motion: Trajectory) -> float:
        """Half the sum of squares, robust ones by their kernel."""

    def width(self, dofs: int) -> int:
        """So many columns its rows have, the diagonal the first, where D = dofs."""

    def add_to(self, motion: Trajectory, unknown: slice, rows: Array, b: Array) -> None:
        """rows (u D, w) of a symmetric matrix from its diagonal on, b (u D,) of the u unknown poses
        += its own."""


@dataclass(frozen=True, eq=False)
class SharedRows:
    """Residuals r (n, M) of poses and shared unknowns, weighted if robust.

    frames: n neighbouring ones.  J (n, M, D): by their poses.  unknown (s,), K (n, M, s): which of
    the shared unknowns, and by these.
    """

    frames: slice
    r: Array
    J: Array
    unknown: NDArray[np.int64]
    K: Array

    @classmethod
    def alone(cls, dofs: int, r: Array, unknown: NDArray[np.int64], K: Array) -> SharedRows:
        """Make rows r (M,), K (M, s) of shared unknowns that are compared with no pose."""
        return cls(slice(0, 1), r[None], np.zeros((1, len(r), dofs)), unknown, K[None])


class SharedTerm(Protocol):
    """What poses and shared unknowns are compared with."""

    def cost(self, posed: Posed, shared: Array) -> float:
        """Half the sum of squares, robust ones by their kernel."""

    def rows(self, posed: Posed, shared: Array) -> SharedRows:
        """Linearized there."""


class RowTerm(ABC):
    """A term that is made of residuals."""

    @abstractmethod
    def cost(self, posed: Posed) -> float: ...

    @abstractmethod
    def rows(self, posed: Posed) -> Rows: ...

    def equations(self, posed: Posed) -> Equations:
        return Equations.of(self.rows(posed))


class SummedTerm(ABC):
    """A term whose normal equations a loop adds to what is there."""

    @abstractmethod
    def cost(self, posed: Posed) -> float: ...

    @abstractmethod
    def add_to(self, posed: Posed, A: Array, b: Array) -> float:
        """A (N, D, D), b (N, D) of all poses += its own; the cost there comes back."""

    def equations(self, posed: Posed) -> Equations:
        count, dofs = posed.placed.twists.shape[:2]
        A, b = np.zeros((count, dofs, dofs)), np.zeros((count, dofs))
        cost = self.add_to(posed, A, b)
        return Equations(A, b, cost).of_batch(posed.batch)


class DiagonalTerm(ABC):
    """A term that compares every degree of freedom by itself."""

    @abstractmethod
    def cost(self, posed: Posed) -> float: ...

    @abstractmethod
    def diagonal(self, posed: Posed) -> Diagonal: ...

    def equations(self, posed: Posed) -> Equations:
        diagonal = self.diagonal(posed)
        A = diagonal.precision[..., None] * np.eye(diagonal.precision.shape[-1])
        return Equations(A, diagonal.b, diagonal.cost)


def total_cost(terms: Sequence[Term], posed: Posed) -> float:
    """The cost of all terms."""
    return sum(term.cost(posed) for term in terms)


def total_equations(terms: Sequence[Term], posed: Posed) -> Equations:
    """Their equations. Rows of different terms are multiplied out together, and what has loops or a
    diagonal is added on top of what is there, which is quicker."""
    rows = [term.rows(posed) for term in terms if isinstance(term, RowTerm)]
    count, dofs = posed.placed.twists.shape[:2]
    whole = Equations.of(Rows.stacked(rows)) if rows else Equations.none(*posed.batch, dofs)
    for term in terms:
        if not isinstance(term, RowTerm | SummedTerm | DiagonalTerm):
            whole = whole + term.equations(posed)
    A = np.ascontiguousarray(whole.A).reshape(count, dofs, dofs)
    b = np.ascontiguousarray(whole.b).reshape(count, dofs)
    summed = [term.add_to(posed, A, b) for term in terms if isinstance(term, SummedTerm)]
    whole = Equations(A, b, whole.cost + sum(summed)).of_batch(posed.batch)
    diagonals = [term.diagonal(posed) for term in terms if isinstance(term, DiagonalTerm)]
    return _with_diagonals(whole, diagonals) if diagonals else whole


def _with_diagonals(own: Equations, diagonals: Sequence[Diagonal]) -> Equations:
    """Add diagonals to the arrays that are given, in place."""
    on = np.einsum("...dd->...d", own.A)
    b, cost = own.b, own.cost
    for diagonal in diagonals:
        on += diagonal.precision
        b, cost = b + diagonal.b, cost + diagonal.cost
    return Equations(own.A, b, cost)


def robust_cost(kernel: Kernel, away: Array) -> float:
    """The cost of distances, each 0 or more."""
    return 0.5 * float(kernel.loss(away).sum())


def half_squares(r: Array) -> float:
    """The cost of residuals without a kernel."""
    return 0.5 * float((r**2).sum())
