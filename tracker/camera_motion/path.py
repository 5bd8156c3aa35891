"""Make one path of what was measured: anchors in agreement, gaps bridged.

Errors are spread, never left at a seam. Between two anchors what the last frame of the one misses
of the other is shared out over the frames: a step takes the more of it the greater its own doubt.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import (
    Array,
    exp_rotation,
    log_rotation,
    rotation_between,
    transform,
    transpose,
)

UNKNOWN_DOUBT = np.radians(1.0)
"""Standard deviation of a step over which nothing is known."""
LEAST_DOUBT = 1e-6


@dataclass(frozen=True, eq=False)
class Turns:
    """Rotations R (N, 3, 3) from the world into the camera, log_zoom (N,), which frames are known
    (N,), and the doubts (N,) of the turn of each, radians, and of the zoom.
    """

    R: Array
    log_zoom: Array
    known: NDArray[np.bool_]
    doubt: Array
    zoom_doubt: Array

    def path(self) -> CameraPath:
        """The camera's path, which stays in one place."""
        return CameraPath(transform(self.R, np.zeros((len(self.R), 3))), np.exp(self.log_zoom))


def bridged(turns: Turns) -> Turns:
    """The same with frames that are not known between their neighbours that are, or as these at
    the ends.
    """
    known = np.flatnonzero(turns.known)
    if not len(known) or len(known) == len(turns.known):
        return turns
    R, frames = turns.R.copy(), np.arange(len(turns.R))
    for one, other in pairwise(known.tolist()):
        if other > one + 1:
            shares = np.arange(1, other - one) / (other - one)
            R[one + 1 : other] = rotation_between(R[one], R[other], shares)
    R[: known[0]], R[known[-1] + 1 :] = R[known[0]], R[known[-1]]
    log_zoom = np.interp(frames, known, turns.log_zoom[known])
    return Turns(R, log_zoom, turns.known, turns.doubt, turns.zoom_doubt)


def spread(R: Array, miss: Array, shares: Array) -> Array:
    """Rotations (N, 3, 3) turned on, in the camera's own axes, by shares (N,) of `miss` (3,)."""
    return np.asarray(exp_rotation(shares[:, None] * miss) @ R)


def shares_of(doubts: Array) -> Array:
    """The share (N,) of a drift that has come about at each frame, of the doubts (N,) of the steps
    that lead to these; 1 at the last.
    """
    squares = np.cumsum(np.maximum(doubts, LEAST_DOUBT) ** 2)
    return np.asarray(squares / squares[-1])


def _step_doubts(doubt: Array, known: NDArray[np.bool_]) -> Array:
    """The doubt (N,) of the step that leads to each frame."""
    own = np.where(known, np.minimum(doubt, UNKNOWN_DOUBT), UNKNOWN_DOUBT)
    # a frame that is tied to nothing before it is well tied to what comes after
    begins = known & (doubt >= UNKNOWN_DOUBT)
    before = np.where(begins, 0.0, own)
    return np.asarray(np.hypot(own, np.concatenate([before[:1], before[:-1]])))


def joined(
    anchor: NDArray[np.int64],
    rel_R: Array,
    rel_zoom: Array,
    doubt: Array,
    zoom_doubt: Array,
    known: NDArray[np.bool_],
    anchor_R: Array,
    anchor_zoom: Array,
    anchor_frames: Sequence[int],
) -> Turns:
    """The turns of all frames: measured from their anchors (N,), and meeting these exactly.

    rel_R (N, 3, 3), rel_zoom (N,) logarithms, from the anchor.  anchor_R (A, 3, 3), anchor_zoom
    (A,) logarithms, from the world.
    """
    R = rel_R @ anchor_R[anchor]
    log_zoom = rel_zoom + anchor_zoom[anchor]
    steps = _step_doubts(doubt, known)
    for number, frame in enumerate(anchor_frames):
        if anchor[frame] == number:  # tied to nothing
            continue
        others = np.flatnonzero(anchor[:frame] != anchor[frame])
        first = max(others[-1] if len(others) else 0, anchor_frames[anchor[frame]])
        span = slice(first + 1, frame + 1)
        share = shares_of(steps[span])
        R[span] = spread(R[span], log_rotation(anchor_R[number] @ transpose(R[frame])), share)
        log_zoom[span] += share * (anchor_zoom[number] - log_zoom[frame])
    return Turns(R, log_zoom, known, doubt, zoom_doubt)
