"""Orders of a film that nobody has opened yet: who is in it, with which body, by which lens."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Final

from keypose.app.orders.order import option
from keypose.app.orders.tracking import DraftOrder, FilmTaken, YesNo
from keypose.app.orders.values import Choice, FrameRange, Misread, Number, Switch, Value, Whole
from keypose.tracker.body.preset_names import ANIMALS, PEOPLE
from keypose.tracker.errors import FormatError

if TYPE_CHECKING:
    from keypose.tracker.keypoints.region import Box

SHORTEST_CM: Final = 40.0
TALLEST_CM: Final = 260.0
WIDEST_DEG: Final = 170.0
SHORTEST_LENS_MM: Final = 2.0
LONGEST_LENS_MM: Final = 5000.0
"""Of a lens as on 35 mm film."""


@dataclass(frozen=True, eq=False, repr=False)
class _Box(Value):
    """Left, top, right and bottom in pixels, with commas or, as in a table, spaces between."""

    metavar: str | None = "L,T,R,B"

    def read(self, text: str) -> Box:
        try:
            left, top, right, bottom = (float(word) for word in text.replace(",", " ").split())
        except ValueError:
            raise Misread(
                f"{text[:40]!r} is not a box: give left, top, right and bottom in pixels, such as "
                "210,80,420,610"
            ) from None
        return left, top, right, bottom


@dataclass(frozen=True, eq=False, repr=False)
class _FieldOfView(Number):
    metavar: str | None = "DEGREES"
    least: float = 1.0
    most: float = WIDEST_DEG
    noun: str = f"an angle from 1 to {WIDEST_DEG:g} degrees"


@dataclass(frozen=True)
class FilmOrder:
    """What is said of the person in a film and of the camera that took it."""

    box: Box | None = option(
        _Box(),
        "left, top, right and bottom of a box around the person, in pixels; default: looked for in "
        "the film, and you are asked where several are found",
        once=True,
    )
    everyone: bool | None = option(
        Switch(), "draft everybody who is found, each as a body of the session; default: one person"
    )
    frame: int | None = option(
        Whole("N", least=0),
        "the frame of the box; default: the first frame to draft",
    )
    frames: tuple[int, int] | None = option(
        FrameRange(), "first and last frame to draft; default: all"
    )
    body: str | None = option(
        Choice("PRESET", (*PEOPLE, *ANIMALS)),
        f"{', '.join((*PEOPLE, *ANIMALS))}; default: as `keypose config` says",
    )
    height_cm: float | None = option(
        Number("CM", least=SHORTEST_CM, most=TALLEST_CM, unit="cm"),
        "the person's height, with which depth and lengths are right; default: the preset's",
        flag="height",
    )
    field_of_view: float | None = option(
        _FieldOfView(),
        "along the picture's longer side; default: from the file, else of a usual lens",
        group="lens",
    )
    lens_mm: float | None = option(
        Number("MM", least=SHORTEST_LENS_MM, most=LONGEST_LENS_MM, unit="mm"),
        "the same as a focal length on 35 mm film, such as 26 of a phone's main camera",
        flag="lens",
        group="lens",
    )


@dataclass(frozen=True)
class BesideOrder:
    """What is said of a film that shows the motion of another."""

    begins: float | None = option(
        Number("FRAME"),
        "the frame of the first film, with its fraction, at which this one begins; default: found "
        "from the motion that both show",
    )
    box: Box | None = option(
        _Box(),
        "left, top, right and bottom of a box around the person in this film, in pixels; default: "
        "looked for",
    )
    frame: int | None = option(Whole("N", least=0), "the frame of the box; default: the first")


@dataclass(frozen=True)
class FilmToDraft:
    """A film without a session, who is drafted in it and how it was taken.

    name: what its session is called, where not as the film.  beside: films of the same motion.
    """

    path: Path
    order: FilmOrder = field(default_factory=FilmOrder)
    network: DraftOrder = field(default_factory=DraftOrder)
    taken: FilmTaken = field(default_factory=FilmTaken)
    name: str | None = None
    beside: tuple[Path, ...] = ()


def require_whom(order: FilmOrder) -> None:
    """FormatError where one person is named by a box, and everybody is meant as well."""
    if order.box is not None and order.everyone:
        raise FormatError(
            "--box names a person and --everyone means all who are found: give one of them."
        )


FILM_ORDERS: Final = {"order": FilmOrder, "network": DraftOrder, "taken": FilmTaken}
"""What may be said of such a film, by the fields of `FilmToDraft`."""


@dataclass(frozen=True)
class RunOrder:
    """What is done with a film that nobody looks at."""

    stand: bool | None = option(
        YesNo(), "whether the motion is stood on the floor after tracking; default: yes"
    )
