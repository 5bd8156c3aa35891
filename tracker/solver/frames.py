"""Compare poses in another frame than the one they are found in: another view's, or the world's.

Motions are composed on the right, in each part's own frame, so that what a pose is compared with
elsewhere has the same degrees of freedom, and its equations are added as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.terms import Equations, Link, SharedRows, SharedTerm, Term


@dataclass(frozen=True, eq=False)
class TermIn(Term):
    """A term in another frame.  Ts (..., 4, 4): of that frame and the one of the poses (...)."""

    term: Term
    Ts: Array

    def cost(self, posed: Posed) -> float:
        return self.term.cost(carried(posed, self.Ts))

    def equations(self, posed: Posed) -> Equations:
        return self.term.equations(carried(posed, self.Ts))


@dataclass(frozen=True, eq=False)
class LinkIn(Link):
    """A link in another frame.  Ts (N, 4, 4): of that frame and the one of the motion."""

    link: Link
    Ts: Array

    def cost(self, motion: Trajectory) -> float:
        return self.link.cost(motion.carried(self.Ts))

    def width(self, dofs: int) -> int:
        return self.link.width(dofs)

    def add_to(self, motion: Trajectory, unknown: slice, rows: Array, b: Array) -> None:
        self.link.add_to(motion.carried(self.Ts), unknown, rows, b)


@dataclass(frozen=True, eq=False)
class SharedTermIn(SharedTerm):
    """A term of poses and shared unknowns in another frame, which the unknowns are in."""

    term: SharedTerm
    Ts: Array

    def cost(self, posed: Posed, shared: Array) -> float:
        return self.term.cost(carried(posed, self.Ts), shared)

    def rows(self, posed: Posed, shared: Array) -> SharedRows:
        return self.term.rows(carried(posed, self.Ts), shared)


def carried(posed: Posed, Ts: Array) -> Posed:
    """The poses in another frame.  Ts (..., 4, 4): of that frame and theirs."""
    R = posed.Rs_parent_part.copy()
    R[..., 0, :, :] = Ts[..., :3, :3] @ R[..., 0, :, :]
    p = (Ts[..., :3, :3] @ posed.p_camera_root[..., None])[..., 0] + Ts[..., :3, 3]
    return Posed(posed.skeleton, R, p)
