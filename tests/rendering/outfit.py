"""What colour each part of a mannequin is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body

SKIN = (206, 160, 132)
SHIRT = (164, 86, 74)
TROUSERS = (74, 92, 128)
SHOES = (84, 72, 66)
WOOD = (186, 150, 104)

_WORN = {
    SHIRT: ("chest", "upper_arm"),
    TROUSERS: ("waist", "thigh", "shin"),
    SHOES: ("foot",),
    SKIN: ("neck", "head", "forearm", "hand"),
}


def part_colours(body: Body) -> NDArray[np.float64]:
    """(P, 3) mean RGB of every part; what is no part of a person is wood."""
    return np.array([_colour(name) for name in body.names], dtype=np.float64)


def _colour(name: str) -> tuple[int, int, int]:
    for colour, parts in _WORN.items():
        if name.removeprefix("left_").removeprefix("right_") in parts:
            return colour
    return WOOD
