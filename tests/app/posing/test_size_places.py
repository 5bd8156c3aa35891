"""The handles of sizes stand on the part."""

from __future__ import annotations

import pytest

from app.posing import part_sizes
from app.posing.size_places import size_place
from tracker.body.body import PRESETS, preset
from tracker.body.shapes import Box, Frustum


@pytest.mark.parametrize("name", PRESETS)
def test_every_size_of_every_part_has_a_place_within_the_part(name: str) -> None:
    body = preset(name)
    for part in body.parts:
        vertices = part.shape.mesh().vertices
        for size in part_sizes(body, part.name):
            place = size_place(part.shape, size.key)
            assert (vertices.min(axis=0) - 1e-9 <= place).all()
            assert (place <= vertices.max(axis=0) + 1e-9).all()


def test_a_length_is_pulled_at_the_end_that_the_part_reaches_to() -> None:
    body = preset("adult_male")
    forearm = body.parts[body.index("left_forearm")].shape
    foot = body.parts[body.index("left_foot")].shape
    assert isinstance(forearm, Frustum)
    assert isinstance(foot, Box)
    assert size_place(forearm, "length") == (0.0, forearm.end_m, 0.0)
    assert size_place(foot, "depth")[2] == foot.low_m[2]
