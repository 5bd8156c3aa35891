"""Find how two films' clocks lie beside each other, from the motion that both saw.

How far joints lie from one another in space does not depend on the view: these distances, as the
network has them, rise and fall alike in both films, and correlate where the clocks agree. About
each such offset cameras and offset are then found in turn, the latter by how far joints lie from
where the other film's rays would have them (Sampson's distance). Where a motion repeats itself
several offsets explain it nearly as well: all are kept.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from keypose.tracker.films.cameras import OWN_SIGMA, FoundCamera, at_limbs_length, find_camera
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.camera_path import rigid_inverse
from keypose.tracker.geometry.film_clock import FilmClock, sampled
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.solver.robust import Cauchy

PAIRS = np.array(list(combinations(range(len(JOINTS)), 2)))
LEAST_OVERLAP = 0.3
"""Share of the shorter film that both have to show."""
FEWEST_FRAMES = 12
LIKELY = 0.7
"""Share of the best correlation from which an offset is looked at closer."""
MOST_TRIED = 8
APART_S = 0.067
"""Offsets that lie nearer to one another are one."""
HEARD_S = 0.12
"""How far sound and motion may lie apart that are one: phones record one beside the other."""
ROUNDS = 4
REACH_S = 0.05
"""How far from where it is an offset is looked for in one round."""
CLOSE = 1.15
"""An offset that costs at most so many times as much as the best one may be the true one: on walks
the next stride costs 3 to 12 % more."""
MOST_COST = 15.0
"""Of a moment of a motion that both films show: of recorded motions and one real pair 4 to 8, of
two different ones 25 and more."""
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

    rate: frames of the film per frame of the first.
    """
    offsets: list[FoundOffset] = []
    likely = likely_begins(search.first, search.film, rate, search.fps)
    for begins in [*(() if search.heard is None else (search.heard,)), *likely]:
        if cancelled():
            break
        offset = search.about(FilmClock(begins, rate))
        if offset is not None and offset.cost < MOST_COST:
            offsets.append(offset)
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


def correlations(first: Sightings, film: Sightings, rate: float) -> tuple[Array, Array]:
    """Frames of the first film (K,) at which the other may begin, and how alike (K,) the distances
    between joints change in both then, −1 to 1; NaN where too little of both is seen."""
    own, beside = _distances(first), _distances(film)
    count, length = len(own), (len(beside) - 1) / rate
    least = max(FEWEST_FRAMES, LEAST_OVERLAP * min(count, length))
    grid = np.arange(np.ceil(least - length), np.floor(count - least) + 1.0)
    alike = np.array(
        [_alike(own, sampled(beside, FilmClock(begins, rate).frames_at(np.arange(count))), least)
         for begins in grid]
    )  # fmt: skip
    return grid, alike


def _distances(film: Sightings) -> Array:
    """(N, pairs) how far joints lie from one another, NaN where not seen well enough."""
    joints = np.where(film.visibility[..., None] > 0, film.p_hips, np.nan)
    return np.asarray(np.linalg.norm(joints[:, PAIRS[:, 0]] - joints[:, PAIRS[:, 1]], axis=-1))


def _alike(a: Array, b: Array, least: float) -> float:
    """The correlation of all series (N, pairs) together, each about its own mean."""
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

    def about(self, clock: FilmClock) -> FoundOffset | None:
        """Camera and offset found in turn, from about the right offset; None where nothing tells
        where the camera is."""
        near: Array | None = None
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
    """How far joints lie from the rays of the other film (Sampson), in the mean of squares over
    variances, weighed by Cauchy's kernel; and of how many that is."""
    film = film.at(clock, np.arange(len(first)))
    a_scale, b_scale = first.scale, film.scale
    used = (a_scale > 0) & (b_scale > 0)
    if used.sum() < FEWEST_FRAMES:
        return np.inf, 0.0
    a, b = (np.concatenate([f.xy[used], np.ones((used.sum(), 1))], axis=1) for f in (first, film))
    a = a / np.array([camera.first_focal, camera.first_focal, 1.0])
    b = b / np.array([camera.focal, camera.focal, 1.0])
    Ts_film = film.Ts_camera_base(camera.metres) @ camera.T_camera_first
    Ts = Ts_film @ rigid_inverse(first.Ts_camera_base())
    E = essential(Ts)[np.nonzero(used)[0]]
    Ea, Eb = np.einsum("nij,nj->ni", E, a), np.einsum("nij,ni->nj", E, b)
    off = (b * Ea).sum(axis=1)
    variance = (Ea[:, :2] ** 2).sum(axis=1) / b_scale[used] ** 2
    variance += (Eb[:, :2] ** 2).sum(axis=1) / a_scale[used] ** 2
    away = np.abs(off) / np.sqrt(np.maximum(variance, 1e-30))
    return float(KERNEL.loss(away).mean()), float(used.sum())


def essential(T_camera_first: Array) -> Array:
    """(..., 3, 3) E with bᵀ E a = 0 of rays a of the first camera and b of the other that meet."""
    x, y, z = np.moveaxis(T_camera_first[..., :3, 3], -1, 0)
    nought = np.zeros_like(x)
    cross = np.stack([nought, -z, y, z, nought, -x, -y, x, nought], axis=-1)
    return np.asarray(cross.reshape(*x.shape, 3, 3) @ T_camera_first[..., :3, :3])
