"""Find how two films' clocks lie beside each other, from the motion that both saw.

About each offset at which the motions are alike (`likeness.py`) camera and offset are found in
turn, the latter by how far joints lie from where the other film's rays would have them (Sampson's
distance). Where a motion repeats itself several offsets explain it nearly as well: all are kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from keypose.tracker.films.cameras import OWN_SIGMA, FoundCamera, at_limbs_length, find_camera
from keypose.tracker.films.epipolar import epipolar_residuals
from keypose.tracker.films.likeness import (
    FEWEST_FRAMES,
    alike,
    correlations,
    distances_of,
    least_overlap,
)
from keypose.tracker.films.rate import clocks_by_pieces, found_rate
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.film_clock import FilmClock, sampled
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.robust import Cauchy

LIKELY = 0.7
"""Share of the best correlation from which an offset is looked at closer."""
MOST_TRIED = 8
APART_S = 0.067
"""Offsets that lie nearer to one another are one."""
HEARD_S = 0.12
"""How far sound and motion may lie apart that are one: phones record one beside the other."""
ROUNDS = 4
RATE_ROUNDS = 2
REACH_S = 0.05
"""How far from where it is an offset is looked for in one round."""
CLOSE = 1.15
"""An offset that costs at most so many times as much as the best one may be the true one: on walks
the next stride costs 3 to 12 % more."""
MOST_COST = 15.0
"""Of a moment of a motion that both films show: of recorded motions and one real pair 4 to 8, of
two different ones 9 and more."""
MOST_COST_ALIKE = 17.0
"""That cost divided by how alike the motions are (1: distances between joints change alike): two
walks of two persons fit one another nearly as well as two films of one, and are less alike. Of real
films of one motion 1 to 9, of two motions 26 and more."""
KERNEL = Cauchy()


@dataclass(frozen=True, eq=False)
class FoundOffset:
    """A way in which the clocks may lie, the camera that goes with it, and what it costs.

    sigma: standard deviation of where the film begins, frames of the first film.
    """

    clock: FilmClock
    sigma: float
    camera: FoundCamera

    @property
    def cost(self) -> float:
        """Of a moment: what offsets are compared by."""
        return self.camera.cost


def find_offsets(
    search: OffsetSearch, rate: float, cancelled: Callable[[], bool] = lambda: False
) -> tuple[FoundOffset, ...]:
    """The offsets that may be true, the likeliest first; none where the films share no motion.

    rate: frames of the film per frame of the first, as their files say; the body may show another.
    """
    likely = likely_begins(search.first, search.film, rate, search.fps)
    begins = [*(() if search.heard is None else (search.heard,)), *likely]
    offsets = _explaining(search, [FilmClock(each, rate) for each in begins], cancelled)
    if not offsets:
        clocks = clocks_by_pieces(*search.distances, rate, search.fps)
        offsets = _explaining(search, clocks, cancelled)
    offsets.sort(key=lambda each: each.cost)
    as_heard = [each for each in offsets if _is_heard(search, each)]
    if as_heard:
        return (as_heard[0],)
    distinct: list[FoundOffset] = []
    for each in offsets:
        away = [abs(each.clock.begins - kept.clock.begins) for kept in distinct]
        near = min(away, default=np.inf) <= APART_S * search.fps
        if each.cost <= CLOSE * offsets[0].cost and not near:
            distinct.append(each)
    return tuple(distinct)


def _is_heard(search: OffsetSearch, offset: FoundOffset) -> bool:
    """Whether the sound of both films says the same."""
    if search.heard is None:
        return False
    return abs(offset.clock.begins - search.heard) <= HEARD_S * search.fps


def _explaining(
    search: OffsetSearch, clocks: Iterable[FilmClock], cancelled: Callable[[], bool]
) -> list[FoundOffset]:
    """The offsets about these clocks that explain what both films show."""
    offsets: list[FoundOffset] = []
    for clock in clocks:
        if cancelled():
            break
        offset = search.about(clock)
        if offset is not None and search.explains(offset):
            offsets.append(offset)
    return offsets


def likely_begins(first: Sightings, film: Sightings, rate: float, fps: float) -> list[float]:
    """Where the film may begin, in frames of the first: the best of what correlates well."""
    grid, correlation = correlations(first, film, rate)
    if not len(grid) or not np.isfinite(correlation).any() or np.nanmax(correlation) <= 0:
        return []
    peaks = [
        k
        for k in range(len(grid))
        if correlation[k] >= LIKELY * np.nanmax(correlation)
        and correlation[k] >= np.nanmax(correlation[max(0, k - 1) : k + 2])
    ]
    chosen: list[float] = []
    for k in sorted(peaks, key=lambda k: -correlation[k]):
        if all(abs(grid[k] - begins) > APART_S * fps for begins in chosen):
            chosen.append(float(grid[k]))
    return chosen[:MOST_TRIED]


@dataclass(frozen=True, eq=False)
class OffsetSearch:
    """Two films whose offset is looked for.

    first, film: each at its own frames.  fps: of the first.  lengths_m, free_focal, keyed: as of
    `find_camera`.  start: T_camera_first to begin from alone, its lengths in any unit; None where
    nobody knows where the cameras stand.  heard: the frame at which the film begins, as the sound
    of both says; None where it says nothing.
    """

    first: Sightings
    film: Sightings
    fps: float
    lengths_m: Array
    free_focal: tuple[bool, bool] = (False, False)
    keyed: Mapping[int, Array] | None = None
    start: Array | None = None
    heard: float | None = None

    @cached_property
    def distances(self) -> tuple[Array, Array]:
        """(N, pairs) between joints in both films."""
        return distances_of(self.first), distances_of(self.film)

    def explains(self, offset: FoundOffset) -> bool:
        """Whether an offset explains what both films show."""
        own, beside = self.distances
        there = sampled(beside, offset.clock.frames_at(np.arange(len(own))))
        score = alike(own, there, least_overlap(len(own), (len(beside) - 1) / offset.clock.rate))
        return bool(offset.cost < MOST_COST and offset.cost < MOST_COST_ALIKE * score)

    @cached_property
    def _offsets(self) -> dict[FilmClock, FoundOffset | None]:
        """What was found about clocks so far."""
        return {}

    def about(self, clock: FilmClock) -> FoundOffset | None:
        """Camera, offset and rate found in turn, from about the right clock; None where nothing
        tells where the camera is."""
        if clock not in self._offsets:
            self._offsets[clock] = self._at_its_rate(self._in_turn(clock, None))
        return self._offsets[clock]

    def _at_its_rate(self, offset: FoundOffset | None) -> FoundOffset | None:
        """An offset with the rate that the body shows."""
        for _ in range(RATE_ROUNDS):
            if offset is None:
                return None
            faster = found_rate(self.first, self.film, offset.clock, offset.camera, self.fps)
            if faster is None:
                break
            offset = self._in_turn(faster, offset.camera.T_camera_first)
        return offset

    def _in_turn(self, clock: FilmClock, near: Array | None) -> FoundOffset | None:
        offset: FoundOffset | None = None
        for _ in range(ROUNDS):
            camera = self.camera_at(clock, near)
            if camera is None:
                return None
            clock, sigma = _minimum(self.first, self.film, clock, camera, REACH_S * self.fps)
            offset, near = FoundOffset(clock, sigma, camera), camera.T_camera_first
        return offset

    def camera_at(self, clock: FilmClock, near: Array | None = None) -> FoundCamera | None:
        """Where the camera is if the clocks lie so."""
        film = self.film.at(clock, np.arange(len(self.first)))
        if near is None and self.start is not None:
            near = at_limbs_length(self.start, self.first, film, self.lengths_m)
        return find_camera(
            self.first,
            film,
            self.lengths_m,
            free_focal=self.free_focal,
            keyed=self.keyed,
            near=near,
        )


def _minimum(
    first: Sightings, film: Sightings, clock: FilmClock, camera: FoundCamera, reach: float
) -> tuple[FilmClock, float]:
    """The offset near one at which both films' rays meet best, and its standard deviation."""
    step = reach / 6
    begins = clock.begins + step * np.arange(-6, 7)
    costs = np.array([_apart(first, film, FilmClock(b, clock.rate), camera) for b in begins])
    if not np.isfinite(costs[:, 0]).all():
        return clock, np.inf
    k = int(np.clip(np.argmin(costs[:, 0]), 1, len(begins) - 2))
    before, here, after = costs[k - 1 : k + 2, 0]
    bend = before - 2 * here + after
    if bend <= 0:
        return FilmClock(float(begins[k]), clock.rate), np.inf
    shift = float(np.clip(0.5 * (before - after) / bend, -1.0, 1.0))
    # half the mean of squares, of so many: its second derivative is the information
    sigma = OWN_SIGMA * step / np.sqrt(0.5 * bend * costs[k, 1])
    return FilmClock(float(begins[k] + shift * step), clock.rate), float(sigma)


def _apart(
    first: Sightings, film: Sightings, clock: FilmClock, camera: FoundCamera
) -> tuple[float, float]:
    """How far joints lie from the rays of the other film, in the mean of squares over variances,
    weighed by Cauchy's kernel; and of how many that is."""
    residuals = epipolar_residuals(first, film.at(clock, np.arange(len(first))), camera)
    away = np.abs(residuals[np.isfinite(residuals)])
    if len(away) < FEWEST_FRAMES:
        return np.inf, 0.0
    return float(KERNEL.loss(away).mean()), float(len(away))
