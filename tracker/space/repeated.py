"""Take repeated frames out of a motion: a copy of a picture is no evidence that a body stood still.

A body followed over copies stops at each and catches up after it. So a motion is judged and
smoothed by the moments at which its frames were recorded, which copies have none of; frame by frame
it is shown as before, at copies between the poses of the frames beside them.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.resampling import resampled
from keypose.tracker.body.trajectory import Trajectory, runs
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.references import Repeats

EVENLY_OVER = 4.0
"""Distinct frames over which they are taken to be evenly spaced, width of a Gaussian: more than the
distance between two copies."""
FEWEST = 3
"""Distinct frames that a motion is taken from."""


@dataclass(frozen=True, eq=False)
class Moments:
    """When the frames of a motion were recorded.

    distinct: (N,) which frames are no copies.  at: (N,) the moment of each, in frames from the
    first, of copies between those of the frames beside them.
    """

    distinct: NDArray[np.bool_]
    at: Array

    @classmethod
    def of(
        cls, repeats: Repeats | None, first: int, last: int, exact: Collection[int] = ()
    ) -> Self | None:
        """Those of a film's frames first … last; None where none of them is a copy.

        exact: frames that are recorded when they are shown, and count as no copies, as the ends do.
        """
        distinct = np.ones(last - first + 1, dtype=np.bool_)
        for frame in () if repeats is None else repeats.frames:
            if first < frame < last and frame not in exact:
                distinct[frame - first] = False
        if repeats is None or distinct.all() or distinct.sum() < FEWEST:
            return None
        rows = np.arange(len(distinct), dtype=np.float64)
        own = rows[distinct]
        if repeats.even:
            fixed = np.isin(own, [0, last - first, *(frame - first for frame in exact)])
            own = _evenly(own, fixed)
        return cls(distinct, np.interp(rows, rows[distinct], own))

    def evened(self, motion: Trajectory) -> Trajectory:
        """The motion at even moments, from what is shown frame by frame."""
        rows = np.arange(len(motion), dtype=np.float64)
        own = self.distinct
        Rs, ps = motion.Rs_parent_part[own], motion.ps_camera_root[own]
        return Trajectory(motion.first_frame, *resampled(Rs, ps, self.at[own], rows))

    def shown(self, motion: Trajectory) -> Trajectory:
        """The motion frame by frame, from one at even moments."""
        rows = np.arange(len(motion), dtype=np.float64)
        Rs, ps = motion.Rs_parent_part, motion.ps_camera_root
        return Trajectory(motion.first_frame, *resampled(Rs, ps, rows, self.at))


def evened(motion: Trajectory, repeats: Repeats | None) -> Trajectory:
    """The motion at even moments; poses that are not known are NaN, and stay so."""
    Rs, ps = motion.writable()
    changed = False
    for first, last in runs(np.isfinite(ps[:, 0])):
        rows, start = slice(first, last + 1), motion.first_frame + first
        moments = Moments.of(repeats, start, motion.first_frame + last)
        if moments is not None:
            piece = moments.evened(Trajectory(start, Rs[rows].copy(), ps[rows].copy()))
            Rs[rows], ps[rows], changed = piece.Rs_parent_part, piece.ps_camera_root, True
    return Trajectory(motion.first_frame, Rs, ps) if changed else motion


def _evenly(rows: Array, fixed: NDArray[np.bool_]) -> Array:
    """Space out rows that copies stand between, but for those that are fixed."""
    from scipy.ndimage import gaussian_filter1d  # scipy: loads longer than a page needs to start

    pad = min(len(rows) - 1, int(np.ceil(4 * EVENLY_OVER)))
    continued = np.pad(rows, pad, mode="reflect", reflect_type="odd")
    even = gaussian_filter1d(continued, EVENLY_OVER)[pad : pad + len(rows)]
    even = even - np.interp(rows, rows[fixed], (even - rows)[fixed])
    return np.asarray(even if (np.diff(even) > 0.1).all() else rows)
