"""Lines over a picture: those that are seen have a dark halo, those that are hidden are faint."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.render.palette import SIDE_COLOURS
from keypose.app.render.strokes import OCCLUDED_OPACITY, Lines, paint_lines

WHITE = 255
ROW = 20
THICKNESS = 2


def painted(hidden: bool) -> np.ndarray:  # type: ignore[type-arg]
    """A column across a level line of the left side, as shares from white to black."""
    canvas = np.full((40, 60, 3), WHITE, np.uint8)
    uv = np.array([[[5.0, ROW], [55.0, ROW]]])
    paint_lines(canvas, Lines(uv, np.array([0]), np.array([hidden])), ("left",), THICKNESS)
    return canvas[:, 30].astype(float)


def test_a_line_that_is_seen_has_its_colour_and_a_halo_about_it() -> None:
    column = painted(hidden=False)
    np.testing.assert_allclose(column[ROW], SIDE_COLOURS["left"], atol=3)
    for row in (ROW - 3, ROW + 3):  # the halo's soft rim, beyond that of the line
        assert np.ptp(column[row]) <= 3
        assert 225 < column[row].mean() < 250
    assert (column[ROW + THICKNESS + 4] == WHITE).all()


def test_a_line_that_is_hidden_is_faint_and_has_no_halo() -> None:
    column = painted(hidden=True)
    faint = WHITE + OCCLUDED_OPACITY * (np.array(SIDE_COLOURS["left"]) - WHITE)
    np.testing.assert_allclose(column[ROW], faint, atol=3)
    assert column.min() == pytest.approx(column[ROW].min())
