"""Whether two films look at a body from one side: a copy of a film, or a camera beside another."""

from __future__ import annotations

import numpy as np

from keypose.tracker.films.offset import OffsetSearch, likely_begins
from keypose.tracker.films.sightings import SURE
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import Array

SAME_SIGMAS = 1.0
"""Median way of joints from where one shift and scale of a picture has them, in standard
deviations of a joint: of copies of films 0.2 to 0.6, of a view 5° aside 1.3 and more."""


def is_same_view(search: OffsetSearch, rate: float) -> bool:
    """Whether at a likely offset both films show the body alike, but for where in the picture it
    is and how large: then nothing tells where another camera stands."""
    first = search.first
    for begins in likely_begins(first, search.film, rate, search.fps):
        film = search.film.at(FilmClock(begins, rate), np.arange(len(first)))
        used = (first.visibility > SURE) & (film.visibility > SURE)
        if used.any() and _off(first.xy[used], film.xy[used]) < SAME_SIGMAS * film.sigma:
            return True
    return False


def _off(xy: Array, there: Array) -> float:
    """Median distance of points (N, 2) from others, shifted and scaled onto them."""
    a, b = xy - xy.mean(axis=0), there - there.mean(axis=0)
    scale = (a * b).sum() / max((a * a).sum(), 1e-12)
    return float(np.median(np.linalg.norm(b - scale * a, axis=-1)))
