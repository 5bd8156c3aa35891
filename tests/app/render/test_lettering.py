"""Words stay on the plates they are written on, whatever their size."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.render.lettering import plate, write, written_width

WORDS = "Frames 31-47 are damaged in the file"


@pytest.mark.parametrize("height_px", [6.0, 11.0, 17.0, 26.0, 40.0, 60.0])
def test_words_are_no_wider_than_they_are_said_to_be(height_px: float) -> None:
    picture = np.zeros((200, 4000, 3), np.uint8)
    left = 100
    write(picture, WORDS, left, 120, height_px)
    columns = np.flatnonzero(picture.any(axis=(0, 2)))
    assert columns[0] >= left - 1
    assert columns[-1] <= left + written_width(WORDS, height_px)


@pytest.mark.parametrize("height_px", [11.0, 26.0, 60.0])
def test_no_letter_stands_beside_its_plate(height_px: float) -> None:
    picture = np.full((300, 4000, 3), 200, np.uint8)
    plate(picture, WORDS, 10, 10, height_px)
    dark = (picture < 120).all(axis=2)
    light = (picture > 220).all(axis=2)
    assert light.any()
    assert np.flatnonzero(light.any(axis=0))[-1] < np.flatnonzero(dark.any(axis=0))[-1]
