"""The clock of a film beside another's: which of its frames shows a moment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True)
class FilmClock:
    """When the frames of a film were taken, on the clock of the first film.

    begins: the frame of the first film, with its fraction, at which frame 0 was taken.
    rate:   frames of it per frame of the first film; the drift of the clock is in it.
    """

    begins: float = 0.0
    rate: float = 1.0

    def frames_at(self, moments: ArrayLike) -> Array:
        """Its frames, with their fractions, at frames of the first film."""
        return (np.asarray(moments, np.float64) - self.begins) * self.rate

    def moments_of(self, frames: ArrayLike) -> Array:
        """Frames of the first film, with their fractions, at which its own were taken."""
        return np.asarray(frames, np.float64) / self.rate + self.begins

    def overlap(self, frame_count: int, first_count: int) -> range:
        """The frames of the first film, of so many, that lie within its own."""
        first, last = self.moments_of([0, frame_count - 1])
        return range(max(0, int(np.ceil(first))), min(first_count - 1, int(np.floor(last))) + 1)


def sampled(values: Array, frames: ArrayLike) -> Array:
    """Values (N, …) of frames 0 … N − 1 at frames (M,) with fractions, linear between two; NaN
    beyond them, and beside what is NaN."""
    frames = np.asarray(frames, np.float64)
    inside = (frames >= 0) & (frames <= len(values) - 1)
    at = np.where(inside, frames, 0.0)
    below: NDArray[np.int64] = np.minimum(at.astype(np.int64), max(len(values) - 2, 0))
    above = np.minimum(below + 1, len(values) - 1)
    share = (at - below).reshape(-1, *(1,) * (values.ndim - 1))
    # a frame that is met exactly needs no other
    between = np.where(
        share > 0, (1 - share) * values[below] + share * values[above], values[below]
    )
    between = np.where(share == 1, values[above], between)
    return np.where(inside.reshape(share.shape), between, np.nan)
