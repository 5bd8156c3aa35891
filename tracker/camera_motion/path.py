"""Make one path of what was measured: anchors in agreement, gaps bridged, corrections met.

Errors are spread, never left at a seam. Between two anchors what the last frame of the one misses
of the other is shared out over the frames, and so is what the path misses of a person's
corrections, from both sides: a step takes the more of it the greater its own doubt.
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
class Correction:
    """How the camera is turned from the world, and its zoom, at one frame, as a person says; None
    where nothing is said.
    """

    frame: int
    R_camera_world: Array | None = None
    zoom: float | None = None


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


def corrected(turns: Turns, corrections: Sequence[Correction]) -> Turns:
    """The same path with corrections met exactly and what it missed of these spread between.

    Frame 0 counts as right unless it is corrected; beyond the last correction the path keeps what
    that changed.
    """
    count = len(turns.R)
    R = {c.frame: c.R_camera_world for c in corrections if c.R_camera_world is not None}
    zoom = {c.frame: np.log(c.zoom) for c in corrections if c.zoom is not None}
    new_R, new_zoom = turns.R.copy(), turns.log_zoom.copy()
    steps = _step_doubts(turns.doubt, turns.known)
    if R:
        miss = {f: log_rotation(turns.R[f].T @ np.asarray(given)) for f, given in R.items()}
        drift = _between(miss, np.zeros(3), steps, count)
        new_R = turns.R @ exp_rotation(drift)
        for frame, given in R.items():
            new_R[frame] = given
    if zoom:
        misses = {f: np.array([given - turns.log_zoom[f]]) for f, given in zoom.items()}
        steps = _step_doubts(turns.zoom_doubt, turns.known)
        new_zoom = turns.log_zoom + _between(misses, np.zeros(1), steps, count)[:, 0]
        for frame, value in zoom.items():
            new_zoom[frame] = value
    known = turns.known.copy()
    known[[f for f in R if f < count]] = True
    return Turns(new_R, new_zoom, known, turns.doubt, turns.zoom_doubt)


def _step_doubts(doubt: Array, known: NDArray[np.bool_]) -> Array:
    """The doubt (N,) of the step that leads to each frame."""
    own = np.where(known, np.minimum(doubt, UNKNOWN_DOUBT), UNKNOWN_DOUBT)
    # a frame that is tied to nothing before it is well tied to what comes after
    begins = known & (doubt >= UNKNOWN_DOUBT)
    before = np.where(begins, 0.0, own)
    return np.asarray(np.hypot(own, np.concatenate([before[:1], before[:-1]])))


def _between(miss: dict[int, Array], at_start: Array, steps: Array, count: int) -> Array:
    """What is missed at every frame (count, ...), of what is missed at some, by steps' doubts."""
    miss = {0: at_start} | miss
    drift = np.empty((count, *at_start.shape))
    frames = sorted(miss)
    for one, other in pairwise(frames):
        share = np.concatenate([[0.0], shares_of(steps[one + 1 : other + 1])])[:, None]
        drift[one : other + 1] = miss[one] + share * (miss[other] - miss[one])
    drift[frames[-1] :] = miss[frames[-1]]
    return drift


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
