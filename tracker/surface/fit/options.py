"""How the fit is done, as data."""

from __future__ import annotations

from dataclasses import dataclass, replace

from keypose.tracker.session.settings import Quality


@dataclass(frozen=True)
class Options:
    """SURFACE's variants and how much work goes into each step.

    contact, photo: whether ρ_c and ρ_p weigh; without both it is plain ICP.
    plane:     1: distances along the observed normal; 0: to the nearest point.
    smooth:    joined parts share the surface about their joint.
    points:    on each of the two surfaces.
    agreement: least product of the normals of a pair; −2 lets all be pairs.
    solves:    at most, of a step.
    mutual: a point counts less whose nearest has a nearer one of its own.
    floor, stiff: whether small parts keep a least weight, and what the surface does not show stays
        as it was.
    trust: a point of the body's surface counts less where the steps before did not confirm it.
    offset: along normals the observed surface may stand out from the body's, by direction.
    """

    contact: bool = True
    photo: bool = True
    plane: float = 1.0
    smooth: bool = False
    points: int = 3000
    agreement: float = 0.5
    solves: int = 30
    mutual: bool = True
    floor: bool = True
    stiff: float = 1.0
    trust: bool = True
    offset: bool = True

    def at(self, quality: Quality) -> Options:
        """Options with less work for a quick look."""
        return replace(self, points=700, solves=10) if quality == "preview" else self
