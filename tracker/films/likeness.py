"""How alike two films' motions are, whatever their cameras.

How far joints lie from one another in space does not depend on the view: these distances, as the
network has them, rise and fall alike in both films, and correlate where the clocks agree.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.film_clock import FilmClock, sampled
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS

PAIRS = np.array(list(combinations(range(len(JOINTS)), 2)))
LEAST_OVERLAP = 0.3
"""Share of the shorter film that both have to show."""
FEWEST_FRAMES = 12


def correlations(first: Sightings, film: Sightings, rate: float) -> tuple[Array, Array]:
    """Frames of the first film (K,) at which the other may begin, and how alike (K,) the distances
    between joints change in both then, −1 to 1; NaN where too little of both is seen."""
    own, beside = distances_of(first), distances_of(film)
    count, length = len(own), (len(beside) - 1) / rate
    least = least_overlap(count, length)
    grid = np.arange(np.ceil(least - length), np.floor(count - least) + 1.0)
    scores = np.array(
        [alike(own, sampled(beside, FilmClock(begins, rate).frames_at(np.arange(count))), least)
         for begins in grid]
    )  # fmt: skip
    return grid, scores


def least_overlap(count: int, length: float) -> float:
    """The frames that films of two lengths have both to show."""
    return max(FEWEST_FRAMES, LEAST_OVERLAP * min(count, length))


def distances_of(film: Sightings) -> Array:
    """(N, pairs) how far joints lie from one another, NaN where not seen well enough."""
    joints = np.where(film.visibility[..., None] > 0, film.p_hips, np.nan)
    return np.asarray(np.linalg.norm(joints[:, PAIRS[:, 0]] - joints[:, PAIRS[:, 1]], axis=-1))


def alike(a: Array, b: Array, least: float) -> float:
    """The correlation of all series (N, pairs) together, each about its own mean; NaN where none is
    known in both at so many moments."""
    both = np.isfinite(a) & np.isfinite(b)
    used = both.sum(axis=0) >= least
    if not used.any():
        return np.nan
    a, b, both = a[:, used], b[:, used], both[:, used]
    a, b = np.where(both, a, 0.0), np.where(both, b, 0.0)
    count = both.sum(axis=0)
    a, b = (a - a.sum(axis=0) / count) * both, (b - b.sum(axis=0) / count) * both
    size = np.sqrt((a**2).sum() * (b**2).sum())
    return float((a * b).sum() / size) if size > 0 else np.nan
