"""A film that was cut shows on one side what another shows: that side is named, to the frame."""

from __future__ import annotations

from dataclasses import replace

import pytest

from keypose.tracker.films.cameras import lengths_of
from keypose.tracker.films.offset import OffsetSearch, find_offsets
from keypose.tracker.films.parts import part_in_common, part_that_fits
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.film_clock import FilmClock
from tests.rendering.motions import crossing, speech, throw
from tests.tracker.films.film_cases import BODY, joined, sliced, two_films

LENGTHS_M = lengths_of(BODY)
WHOLE = two_films(throw, 60.0, FilmClock(3.4))
ELSEWHERE = two_films(throw, -45.0, FilmClock(3.4))
CROSSING = two_films(crossing, 60.0, FilmClock())
SPEECH = two_films(speech, 60.0, FilmClock())
CUTS = {
    "the camera is elsewhere after it": (
        joined(sliced(WHOLE.film, slice(0, 70)), sliced(ELSEWHERE.film, slice(70, None))),
        range(70),
    ),
    "another motion follows": (
        joined(sliced(WHOLE.film, slice(0, 60)), sliced(CROSSING.film, slice(0, 60))),
        range(60),
    ),
    "another motion comes before": (
        joined(sliced(SPEECH.film, slice(0, 50)), sliced(WHOLE.film, slice(50, None))),
        range(50, 115),
    ),
    "two seconds are left out": (
        joined(sliced(WHOLE.film, slice(0, 40)), sliced(WHOLE.film, slice(75, None))),
        range(40, 80),
    ),
}


def part_of(film: Sightings) -> range | None:
    search = OffsetSearch(WHOLE.first, film, 30.0, LENGTHS_M)
    offsets = find_offsets(search, 1.0)
    return part_that_fits(search, offsets[0]) if offsets else part_in_common(search, 1.0)


@pytest.mark.parametrize(("film", "part"), CUTS.values(), ids=CUTS)
def test_the_side_of_a_cut_that_shows_the_motion_is_named(film: Sightings, part: range) -> None:
    found = part_of(film)
    assert found is not None
    assert abs(found.start - part.start) <= 3
    assert abs(found.stop - part.stop) <= 3


def test_a_film_without_a_cut_is_whole() -> None:
    assert part_of(WHOLE.film) is None


def test_a_body_that_is_hidden_for_a_while_is_no_cut() -> None:
    visibility = WHOLE.film.visibility.copy()
    visibility[60:] = 0.0
    assert part_of(replace(WHOLE.film, visibility=visibility)) is None


def test_of_another_motion_no_part_is_in_common() -> None:
    assert part_of(CROSSING.film) is None
