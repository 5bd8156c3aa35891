"""By how much a motion misses what one film shows of its joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True, eq=False)
class FilmErrors:
    """How far the joints of N frames lie from where one film shows them.

    name: of the film.  first_frame: of the first film.  px (N, J): in its picture, of `JOINTS`; NaN
    where it does not see one.  aside_m (N, J): the same in space, from the ray of its camera.
    """

    name: str
    first_frame: int
    px: Array
    aside_m: Array

    @property
    def median_px(self) -> float:
        """NaN where it sees nothing."""
        known_px = self.px[np.isfinite(self.px)]
        return float(np.median(known_px)) if known_px.size else np.nan

    def rows_at(self, frames: Array) -> NDArray[np.int64]:
        """(M,) its rows nearest to frames of the first film; −1 beyond them."""
        rows = np.round(np.asarray(frames)).astype(np.int64) - self.first_frame
        return np.where((rows >= 0) & (rows < len(self.px)), rows, -1)

    def at(self, frames: Array) -> FilmErrors:
        """The same of other frames, the nearest to each, which need not follow one another."""
        rows = self.rows_at(frames)
        px, aside_m = (
            np.where((rows >= 0)[:, None], each[rows], np.nan) for each in (self.px, self.aside_m)
        )
        return FilmErrors(self.name, 0, px, aside_m)
