"""What a file does not say of its surfaces: guesses, to be shown to a person."""

from __future__ import annotations

from typing import Final

from keypose.tracker.session.settings import Units, UpAxis
from keypose.tracker.surface.mesh import SurfaceMesh

_PERSON: Final[tuple[tuple[float, float, Units], ...]] = (
    (0.3, 3.0, "m"),
    (30.0, 300.0, "cm"),
    (300.0, 3000.0, "mm"),
)
_BY_FAR: Final = 1.5


def guess_units(longest: float) -> Units | None:
    """The unit in which a surface whose longest extent is this is about as large as a person.

    A guess: 40 may be 40 cm of a child's arm or 40 m of a house. None where no unit fits.
    """
    fitting = [unit for least, most, unit in _PERSON if least <= longest < most]
    return fitting[0] if fitting else None


def guess_up(mesh: SurfaceMesh) -> UpAxis:
    """The axis along which a surface is longest; x only where it is so by far.

    A guess, right for people who stand; it cannot know who hangs upside down or lies. Hardly any
    file has x upward, but arms spread along it often reach farther than a person is tall.
    """
    x, y, z = mesh.extent
    if x > _BY_FAR * max(y, z):
        return "+x"
    return "+y" if y >= z else "+z"
