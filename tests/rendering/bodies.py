"""Bodies of the sequences that are not presets."""

from __future__ import annotations

from itertools import product

from keypose.tracker.body.body import ALL_DOFS, Body, Part
from keypose.tracker.body.shapes import Box


def box_body(half_m: tuple[float, float, float] = (0.32, 0.20, 0.24)) -> Body:
    """One box around its own middle, its corners as landmarks, all six motions tracked."""
    corners = {
        f"corner_{i}": (x * half_m[0], y * half_m[1], z * half_m[2])
        for i, (x, y, z) in enumerate(product((-1, 1), repeat=3))
    }
    low = (-half_m[0], -half_m[1], -half_m[2])
    shape = Box(low_m=low, high_m=half_m)
    part = Part(name="box", shape=shape, tracked=ALL_DOFS, landmarks=corners)
    return Body(name="box", parts=(part,))
