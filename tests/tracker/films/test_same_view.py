"""Films from one side are known as such, however large the picture is and whenever it begins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.films.cameras import lengths_of
from keypose.tracker.films.offset import OffsetSearch
from keypose.tracker.films.same_view import is_same_view
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.film_clock import FilmClock
from tests.rendering.motions import crossing, speech, throw
from tests.tracker.films.film_cases import BODY, sliced, two_films

LENGTHS_M = lengths_of(BODY)
TRUE = two_films(throw, 60.0, FilmClock())


def copied(film: Sightings, *, zoom: float = 1.0, cut: int = 0) -> Sightings:
    """A copy, written anew in a smaller or larger picture, from some frame on."""
    rng = np.random.default_rng(4)
    xy = zoom * film.xy + rng.normal(0.0, 0.2 * zoom * film.sigma, film.xy.shape) + 0.02
    return sliced(replace(film, xy=xy, sigma=zoom * film.sigma), slice(cut, None))


def is_one_view(first: Sightings, film: Sightings) -> bool:
    return is_same_view(OffsetSearch(first, film, 30.0, LENGTHS_M), 1.0)


@pytest.mark.parametrize("cut", [0, 9, 30])
@pytest.mark.parametrize("zoom", [1.0, 0.5, 1.3])
def test_a_copy_of_a_film_shows_the_same_view(zoom: float, cut: int) -> None:
    assert is_one_view(TRUE.first, copied(TRUE.first, zoom=zoom, cut=cut))


@pytest.mark.parametrize("turned_deg", [20.0, 60.0, 90.0, 180.0])
@pytest.mark.parametrize("motion", [throw, crossing, speech])
def test_another_view_is_another(motion: object, turned_deg: float) -> None:
    films = two_films(motion, turned_deg, FilmClock(3.0))  # type: ignore[arg-type]
    assert not is_one_view(films.first, films.film)
