"""The colours of an observed surface: plain clay, or by what its places count or how far they are.

One ramp for all: clay is as it should be, plum counts for nothing or is far away. It holds no
colour of a verdict, of a side of the body or of what is selected.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.app.orders.drawing import Tint
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.painting import CLAY

Colours: TypeAlias = NDArray[np.uint8]
"""(V, 3) RGB."""

FAR_M = 0.05
"""A place of the surface so far from the body's is as dark as can be."""

_STOPS = np.array([CLAY, (190, 120, 160), (160, 62, 124), (84, 26, 86)], dtype=np.float64)
"""From clay to plum, evenly spaced; each darker than the one before, to read in grey, too."""


@dataclass(frozen=True)
class Legend:
    """What a colouring says: words for its clay end and its plum end."""

    label: str
    title: str
    clay: str
    plum: str


LEGENDS: dict[Tint, Legend] = {
    "clay": Legend("Clay", "The surface without colours", "", ""),
    "contact": Legend(
        "Contact",
        "How far a place is from other parts: near them it counts less",
        "counts in full",
        "hidden by contact",
    ),
    "photo": Legend(
        "Photo",
        "How well the cameras agree on a place: where they do not, it counts less",
        "cameras agree",
        "cameras disagree",
    ),
    "distance": Legend(
        "Distance",
        "How far the surface is from the body's",
        "0 cm",
        f"{100 * FAR_M:g} cm and more",
    ),
}


def clay(count: int) -> Colours:
    """Clay everywhere."""
    return np.tile(np.rint(_STOPS[0]).astype(np.uint8), (count, 1))


def colours_for_tint(kind: Tint, values: Array) -> Colours:
    """The colours of values (V,): weights 0 to 1, or distances in metres; clay where NaN."""
    share = values / FAR_M if kind == "distance" else 1.0 - values
    return ramp(np.nan_to_num(share))


def ramp(share: Array) -> Colours:
    """The colours of shares (V,), 0 clay to 1 plum."""
    at = np.clip(share, 0.0, 1.0) * (len(_STOPS) - 1)
    channels = [np.interp(at, np.arange(len(_STOPS)), _STOPS[:, k]) for k in range(3)]
    return np.rint(np.stack(channels, axis=1)).astype(np.uint8)


def css_stops() -> list[str]:
    """The ramp as a page writes it."""
    return ["#{:02x}{:02x}{:02x}".format(*(round(c) for c in stop)) for stop in _STOPS]
