"""The colours of bodies on pictures: left is blue, right is orange, the middle is bone."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.geometry.rotations import Array

Side: TypeAlias = Literal["left", "right", "middle"]
Colour: TypeAlias = tuple[int, int, int]
Picture: TypeAlias = NDArray[np.uint8]
"""(H, W, 3) RGB."""
CutOut: TypeAlias = NDArray[np.uint8]
"""(H, W, 4) RGBA: what is seen, and how much it covers."""
Canvas: TypeAlias = NDArray[np.float32]
"""(H, W, 3) RGB, 0 to 255, while it is being painted; or (H, W, 4) for a picture on nothing, begun
with zeros: then colours are weighed by the fourth, which is how much is covered, 0 to 255."""

SIDE_COLOURS: dict[Side, Colour] = {
    "left": (111, 180, 255),
    "right": (255, 157, 108),
    "middle": (217, 213, 199),
}
BODY_COLOURS: tuple[Colour, ...] = (
    (94, 200, 183),
    (233, 131, 188),
    (222, 197, 84),
    (146, 196, 98),
    (235, 128, 116),
    (128, 158, 240),
    (176, 96, 236),
    (160, 108, 50),
    (64, 136, 150),
    (204, 58, 70),
)
"""Of the bodies of a session that are not posed, by their place among all; then from the start."""
INK: Colour = (24, 27, 33)
PAPER: Colour = (244, 245, 247)
GRID: Colour = (226, 229, 234)
GRID_MIDDLE: Colour = (203, 208, 216)
TEXT: Colour = (67, 74, 84)
GAP: Colour = (16, 17, 20)
WHITE: Colour = (255, 255, 255)
AXIS_COLOURS: dict[str, Colour] = {"x": (205, 72, 66), "y": (58, 143, 74), "z": (58, 112, 206)}


def body_colour(place: int) -> Colour:
    """The colour of a body by its place among all of a session."""
    return BODY_COLOURS[place % len(BODY_COLOURS)]


def side_of(body: Body, name: str) -> Side:
    """The side a part is on: its place in a mirror pair (left, right), else its name."""
    for left, right in body.mirror_pairs:
        if name in (left, right):
            return "left" if name == left else "right"
    if name.startswith("left"):
        return "left"
    return "right" if name.startswith("right") else "middle"


def on_canvas(colours: ArrayLike, canvas: Canvas) -> Array:
    """Colours (..., 3) with as many channels as the canvas has: paint itself covers wholly."""
    rgb = np.asarray(colours, dtype=np.float64)
    if canvas.shape[2] == 3:
        return rgb
    return np.concatenate([rgb, np.full((*rgb.shape[:-1], 1), 255.0)], axis=-1)


def part_sides(body: Body) -> tuple[Side, ...]:
    """The side of every part."""
    return tuple(side_of(body, name) for name in body.names)


def part_colours(body: Body) -> Array:
    """The colour (P, 3) of every part, RGB 0 to 255."""
    return np.array([SIDE_COLOURS[side] for side in part_sides(body)], dtype=np.float64)
