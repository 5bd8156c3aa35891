"""How fast a film's clock runs: headers round their rate, and a phone's clock drifts.

Over a short film a rate that is off moves little, and what residuals say of it with the right
camera is enough. Over a long one no single beginning fits: pieces of the film, each looked for by
itself, then agree on beginning and rate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.films.cameras import OWN_SIGMA, FoundCamera
from keypose.tracker.films.epipolar import epipolar_residuals
from keypose.tracker.films.likeness import alike
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.film_clock import FilmClock, sampled
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.robust import Cauchy

KERNEL = Cauchy()
SHIFT = 2.0
"""Frames of the first film by which a film is moved either way to see how its residuals change: by
less, a detector's trembling is what changes."""
STEPS = 5
SURE_SIGMAS = 4.0
LEAST_DRIFT = 0.4
"""A rate is another than the files' where so many standard deviations say so, and it moves the ends
of what both films show by at least so many frames of the first."""
MOST_OFF = 0.03
"""By which share the rate may be off; beyond it the film was slowed down or sped up."""
FEWEST_RESIDUALS = 100
MOST_CONDITION = 1e12
"""Of the equations of beginning and rate: a person who stands still says nothing of either."""
CLUSTER_S = 2.0
FEWEST_CLUSTERS = 4
"""Pieces whose errors are taken to be independent, and how many say how large these are."""
PIECE_S = 3.0
FEWEST_PIECES = 3
MOST_CLOCKS = 4
"""That pieces propose."""


def found_rate(
    first: Sightings, film: Sightings, clock: FilmClock, camera: FoundCamera, fps: float
) -> FilmClock | None:
    """The clock with the rate that the body shows; None where it shows no other than the clock's.

    clock: about right.  fps: of the first film.
    """
    running, slopes = clock, None
    for _ in range(STEPS):
        slopes = _Slopes.of(first, film, running, camera)
        if slopes is None:
            return None
        shift, share = slopes.step
        running = turned_about(running, slopes.middle, shift, share)
    assert slopes is not None
    share = running.rate / clock.rate - 1
    drift = 0.5 * float(np.ptp(slopes.when)) * abs(share)
    is_sure = drift > LEAST_DRIFT and abs(share) > SURE_SIGMAS * slopes.sigma(fps)
    return running if is_sure and abs(share) <= MOST_OFF else None


@dataclass(frozen=True, eq=False)
class _Slopes:
    """How R residuals (R,) change with a film's beginning and with its rate about the middle of
    what both films show, J (R, 2); weight (R,).  when: (R,) at which moment each is."""

    when: Array
    J: Array
    residuals: Array
    weight: Array

    @classmethod
    def of(
        cls, first: Sightings, film: Sightings, clock: FilmClock, camera: FoundCamera
    ) -> _Slopes | None:
        """None where the films say nothing of both."""
        moments = np.arange(len(first), dtype=float)
        before, at, later = (
            epipolar_residuals(
                first, film.at(FilmClock(clock.begins + by, clock.rate), moments), camera
            )
            for by in (-SHIFT, 0.0, SHIFT)
        )
        used = np.isfinite(before) & np.isfinite(at) & np.isfinite(later)
        if used.sum() < FEWEST_RESIDUALS:
            return None
        when = np.broadcast_to(moments[:, None], at.shape)[used]
        by_begins = (later - before)[used] / (2 * SHIFT)
        # running faster by a share, it is earlier by that share of the time since the middle
        J = np.stack([by_begins, -(when - when.mean()) * by_begins], axis=1)
        slopes = cls(when, J, at[used], KERNEL.weight(np.abs(at[used])))
        return slopes if np.linalg.cond(slopes.information) < MOST_CONDITION else None

    @property
    def middle(self) -> float:
        """The moment about which the rate turns the clock."""
        return float(self.when.mean())

    @property
    def information(self) -> Array:
        """(2, 2) of beginning and rate."""
        return np.asarray((self.J * self.weight[:, None]).T @ self.J)

    @property
    def step(self) -> tuple[float, float]:
        """By how much later the film begins, and by which share it runs faster."""
        pull = (self.J * self.weight[:, None]).T @ self.residuals
        shift, share = -np.linalg.solve(self.information, pull)
        return float(shift), float(share)

    def sigma(self, fps: float) -> float:
        """Standard deviation of the rate, a share: by the residuals' own size, or by how much the
        pieces of the film disagree, where that is more. (A detector's own places of joints shift
        the time of one gesture by half a frame this way and of the next that way.)"""
        inverse = np.linalg.inv(self.information)
        own = OWN_SIGMA * np.sqrt(inverse[1, 1])
        pieces = (self.when // (CLUSTER_S * fps)).astype(int)
        pulls = self.J * (self.weight * self.residuals)[:, None]
        of_pieces = np.stack([pulls[pieces == piece].sum(axis=0) for piece in np.unique(pieces)])
        if len(of_pieces) < FEWEST_CLUSTERS:
            return float(own)
        spread = inverse @ (of_pieces.T @ of_pieces) @ inverse
        spread *= len(of_pieces) / (len(of_pieces) - 2)
        return float(max(own, np.sqrt(spread[1, 1])))


def turned_about(clock: FilmClock, middle: float, shift: float, share: float) -> FilmClock:
    """A clock that begins later by a shift and runs faster by a share, the frame shown at a moment
    in the middle kept but for the shift."""
    rate = clock.rate * (1 + share)
    since = middle - clock.begins
    return FilmClock(middle - since / (1 + share) + shift, rate)


def clocks_by_pieces(own: Array, beside: Array, rate: float, fps: float) -> list[FilmClock]:
    """Clocks on which the pieces of a film agree, the likeliest first; none of a short film.

    own, beside: (N, pairs) distances between joints in both films.  rate: as the files say.
    """
    piece = int(PIECE_S * fps * rate)
    starts = np.arange(0, len(beside) - piece + 1, piece)
    if len(starts) < FEWEST_PIECES:
        return []
    grid, alike = _by_piece(own, beside, rate, starts, piece)
    length = len(beside) / rate
    shares = np.linspace(-MOST_OFF, MOST_OFF, 2 * max(1, int(np.ceil(MOST_OFF * length))) + 1)
    begins = np.arange(np.ceil(grid[0] - length), grid[-1] + 1.0)
    votes = np.zeros((len(shares), len(begins)))
    for row, share in enumerate(shares):
        for start, score in zip(starts, alike, strict=True):
            where = begins + start / (rate * (1 + share))
            votes[row] += np.interp(where, grid, score, left=0.0, right=0.0)
    clocks: list[FilmClock] = []
    for at in np.argsort(-votes, axis=None):
        row, column = np.unravel_index(at, votes.shape)
        begin = float(begins[column])
        if all(abs(begin - each.begins) > 0.5 * fps for each in clocks):
            clocks.append(FilmClock(begin, rate * (1 + float(shares[row]))))
        if len(clocks) == MOST_CLOCKS:
            break
    return clocks


def _by_piece(
    own: Array, beside: Array, rate: float, starts: NDArray[np.int64], piece: int
) -> tuple[Array, list[Array]]:
    """Frames of the first film (K,) at which a piece of the other may begin, and how alike (K,)
    they are then, of each piece; 0 where too little is known."""
    length = piece / rate
    grid = np.arange(0.0, max(len(own) - length, 0.0) + 1.0)
    scores = []
    for start in starts:
        part = beside[start : start + piece]
        rows = [np.arange(int(at), min(int(at + length), len(own))) for at in grid]
        scores.append(
            np.nan_to_num(
                [
                    alike(own[row], sampled(part, FilmClock(at, rate).frames_at(row)), 0.5 * length)
                    for at, row in zip(grid, rows, strict=True)
                ]
            )
        )
    return grid, scores
