"""A film's clock tells which of its frames shows a moment of the first film."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.geometry.film_clock import FilmClock, sampled


@pytest.mark.parametrize("clock", [FilmClock(), FilmClock(3.4, 0.5), FilmClock(-7.25, 1.001)])
def test_frames_and_moments_are_the_same_there_and_back(clock: FilmClock) -> None:
    frames = np.arange(30.0)
    np.testing.assert_allclose(clock.frames_at(clock.moments_of(frames)), frames, atol=1e-9)


@pytest.mark.parametrize(
    ("clock", "count", "first_count", "overlap"),
    [
        (FilmClock(), 10, 10, range(10)),
        (FilmClock(3.4), 10, 10, range(4, 10)),
        (FilmClock(-3.4), 10, 10, range(6)),
        (FilmClock(0.0, 0.5), 5, 20, range(9)),
        (FilmClock(20.0), 10, 10, range(20, 10)),
    ],
)
def test_the_overlap_are_the_frames_of_the_first_film_that_lie_within_the_other(
    clock: FilmClock, count: int, first_count: int, overlap: range
) -> None:
    assert list(clock.overlap(count, first_count)) == list(overlap)


def test_values_between_two_frames_lie_on_the_even_way_and_exact_ones_are_met() -> None:
    values = np.array([[0.0, 1.0], [2.0, np.nan], [4.0, 5.0]])
    found = sampled(values, [-0.5, 0.0, 0.5, 2.0, 2.5])
    np.testing.assert_array_equal(
        found,
        [[np.nan, np.nan], [0.0, 1.0], [1.0, np.nan], [4.0, 5.0], [np.nan, np.nan]],
    )
