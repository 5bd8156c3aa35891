"""Take repeated frames out of a motion: a copy of a picture is no evidence that a body stood still.

A body followed over copies stops at each and catches up after it. Where it is to be shown over the
film, its poses at copies alone are replaced; where speeds and accelerations are measured, all poses
are taken at the moments at which the film was recorded.
"""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise

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


def filled(motion: Trajectory, repeats: Repeats | None, exact: Collection[int] = ()) -> Trajectory:
    """The motion with poses at repeated frames that lie between those of the frames beside them;
    those at `exact` frames stay."""
    distinct = _distinct(motion, repeats, exact)
    if repeats is None or distinct.all():
        return motion
    rows = np.arange(len(motion), dtype=np.float64)
    between = _taken(motion, distinct, rows[distinct])
    Rs, ps = motion.writable()
    Rs[~distinct] = between.Rs_parent_part[~distinct]
    ps[~distinct] = between.ps_camera_root[~distinct]
    return Trajectory(motion.first_frame, Rs, ps)


def evened(motion: Trajectory, repeats: Repeats | None) -> Trajectory:
    """The motion as without repeated frames: its other poses at the moments they were recorded, a
    fraction of a frame away from those they are shown at, and between them.

    Poses that are not known are NaN, and stay so.
    """
    distinct = _distinct(motion, repeats)
    if repeats is None or distinct.all():
        return motion
    Rs, ps = motion.writable()
    for first, last in runs(np.isfinite(ps[:, 0])):
        rows = slice(first, last + 1)
        piece = Trajectory(motion.first_frame + first, Rs[rows].copy(), ps[rows].copy())
        own = _distinct(piece, repeats)
        times = np.flatnonzero(own).astype(np.float64)
        piece = _taken(piece, own, _evenly(times) if repeats.even else times)
        Rs[rows], ps[rows] = piece.Rs_parent_part, piece.ps_camera_root
    return Trajectory(motion.first_frame, Rs, ps)


def _distinct(
    motion: Trajectory, repeats: Repeats | None, exact: Collection[int] = ()
) -> NDArray[np.bool_]:
    """(N,) which frames are no copies; the ends of a motion count as none."""
    distinct = np.ones(len(motion), dtype=np.bool_)
    inside = range(motion.first_frame + 1, motion.last_frame)
    for frame in () if repeats is None else repeats.frames:
        if frame in inside and frame not in exact:
            distinct[frame - motion.first_frame] = False
    return distinct


def _taken(motion: Trajectory, distinct: NDArray[np.bool_], at: Array) -> Trajectory:
    """The motion through its distinct poses, which lie `at` these rows, ascending."""
    if distinct.sum() < FEWEST:
        return motion
    rows = np.clip(np.arange(len(motion), dtype=np.float64), at[0], at[-1])
    Rs, ps = motion.Rs_parent_part[distinct], motion.ps_camera_root[distinct]
    return Trajectory(motion.first_frame, *resampled(Rs, ps, at, rows))


def _evenly(rows: Array) -> Array:
    """Space out rows that copies stand between, the ends as they are."""
    from scipy.ndimage import gaussian_filter1d  # scipy: loads longer than a page needs to start

    pad = min(len(rows) - 1, int(np.ceil(4 * EVENLY_OVER)))
    continued = np.pad(rows, pad, mode="reflect", reflect_type="odd")
    even = gaussian_filter1d(continued, EVENLY_OVER)[pad : pad + len(rows)]
    even[[0, -1]] = rows[[0, -1]]
    return np.asarray(even if all(a < b for a, b in pairwise(even)) else rows)
