"""Make one path of what was measured: keyframes are met, drift is spread, gaps are bridged.

Errors are never left at a seam. Between two keyframes what the last frame of the one misses of the
other is shared out over the frames: of a camera that turns a step takes the more of it the greater
its own doubt, of one that moves all steps take as much. At frames at which nothing is known the
camera goes evenly from one neighbour to the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.turn import Turn
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
"""Standard deviation of a step over which nothing is known: a hand turns a camera by about so much
from frame to frame."""
LEAST_DOUBT = 1e-6
"""Standard deviation, radians, that every step has: drift between exact steps is spread evenly."""


# --- a camera that turns


@dataclass(frozen=True, eq=False)
class Turns:
    """Rotations R (N, 3, 3) into the camera and log_zoom (N,), which frames are known (N,), and the
    doubts (N,) of the turn of each, radians, and of the zoom.
    """

    R: Array
    log_zoom: Array
    known: NDArray[np.bool_]
    doubt: Array
    zoom_doubt: Array

    def path(self) -> CameraPath:
        """The camera's path, which stays in one place."""
        return CameraPath(transform(self.R, np.zeros((len(self.R), 3))), np.exp(self.log_zoom))

    def bridged(self) -> Turns:
        """The same with frames that are not known between their neighbours that are, or as these
        at the ends."""
        at = np.flatnonzero(self.known)
        if not len(at) or len(at) == len(self.known):
            return self
        log_zoom = np.interp(np.arange(len(self.R)), at, self.log_zoom[at])
        R = self.R.copy()
        R[: at[0]], R[at[-1] + 1 :] = R[at[0]], R[at[-1]]
        for before, after, shares in _gaps(at):
            R[before + 1 : after] = rotation_between(R[before], R[after], shares)
        return Turns(R, log_zoom, self.known, self.doubt, self.zoom_doubt)


def turns_through(
    measured: Turns,
    keyframe: NDArray[np.int64],
    keyframes: Sequence[Turn],
    frames: Sequence[int],
) -> Turns:
    """The turns of all frames from the world, meeting the keyframes exactly.

    Args:
        measured: the turn of each frame (N,) from its keyframe's camera.
        keyframe: (N,) the number of that keyframe.
        keyframes: the turn of each keyframe from the world.
        frames: in which each keyframe was set, in order.
    """
    R_keyframes = np.stack([turn.R for turn in keyframes])
    log_zooms = np.log([turn.zoom for turn in keyframes])
    R = measured.R @ R_keyframes[keyframe]
    log_zoom = measured.log_zoom + log_zooms[keyframe]
    steps = _step_doubts(measured.doubt, measured.known)
    for number, frame in enumerate(frames):
        if keyframe[frame] == number:  # tied to nothing
            continue
        others = np.flatnonzero(keyframe[:frame] != keyframe[frame])
        first = max(others[-1] if len(others) else 0, frames[keyframe[frame]])
        span = slice(first + 1, frame + 1)
        share = _shares(steps[span])
        miss = log_rotation(R_keyframes[number] @ transpose(R[frame]))
        R[span] = exp_rotation(share[:, None] * miss) @ R[span]
        log_zoom[span] += share * (log_zooms[number] - log_zoom[frame])
    return Turns(R, log_zoom, measured.known, measured.doubt, measured.zoom_doubt)


def _shares(doubts: Array) -> Array:
    """The share (N,) of a drift that has come about at each frame, of the doubts (N,) of the steps
    that lead to these; 1 at the last.
    """
    squares = np.cumsum(np.maximum(doubts, LEAST_DOUBT) ** 2)
    return np.asarray(squares / squares[-1])


def _step_doubts(doubt: Array, is_known: NDArray[np.bool_]) -> Array:
    """The doubt (N,) of the step that leads to each frame."""
    own = np.where(is_known, np.minimum(doubt, UNKNOWN_DOUBT), UNKNOWN_DOUBT)
    # a frame that is tied to nothing before it is well tied to what comes after
    begins = is_known & (doubt >= UNKNOWN_DOUBT)
    before = np.where(begins, 0.0, own)
    return np.asarray(np.hypot(own, np.concatenate([before[:1], before[:-1]])))


# --- a camera that moves


def poses_through(Ts: Array, frames: Sequence[int], Ts_keyframes: Array) -> Array:
    """Poses (N, 4, 4) of all frames that meet those (M, 4, 4) of the keyframes in `frames`, in
    order. What these are off by, turn and place in the world, is shared out evenly between them,
    and is the same beyond them.
    """
    Rs, ps = _placed(Ts)
    Rs_wanted, ps_wanted = _placed(Ts_keyframes)
    at = np.asarray(frames)
    turn, shift = transpose(Rs[at]) @ Rs_wanted, ps_wanted - ps[at]
    every = np.arange(len(Ts))
    after = np.clip(np.searchsorted(at, every, side="right"), 1, max(len(at) - 1, 1))
    before, after = after - 1, np.minimum(after, len(at) - 1)
    share = (every - at[before]) / np.maximum(at[after] - at[before], 1)
    share = np.clip(share, 0.0, 1.0)
    R = np.stack(
        [
            rotation_between(turn[i], turn[j], [s])[0]
            for i, j, s in zip(before, after, share, strict=True)
        ]
    )
    R = Rs @ R
    p = ps + (1 - share)[:, None] * shift[before] + share[:, None] * shift[after]
    out = transform(R, -(R @ p[..., None])[..., 0])
    out[at] = Ts_keyframes
    return out


def poses_bridged(Ts: Array, is_known: NDArray[np.bool_]) -> Array:
    """Poses (N, 4, 4), those that are not known on the straight way between their neighbours that
    are, or as these at the ends.
    """
    at = np.flatnonzero(is_known)
    if not len(at) or len(at) == len(Ts):
        return Ts
    (Rs, ps), bridged = _placed(Ts), Ts.copy()
    bridged[: at[0]], bridged[at[-1] :] = Ts[at[0]], Ts[at[-1]]
    for before, after, shares in _gaps(at):
        R = rotation_between(Rs[before], Rs[after], shares)
        p = ps[before] + shares[:, None] * (ps[after] - ps[before])
        bridged[before + 1 : after] = transform(R, -(R @ p[..., None])[..., 0])
    return bridged


def _gaps(at: NDArray[np.int64]) -> Iterator[tuple[int, int, Array]]:
    """Frames that are known with some between them that are not, and how far these are on the
    way."""
    for before, after in pairwise(at.tolist()):
        if after > before + 1:
            yield before, after, np.arange(1, after - before) / (after - before)


def _placed(Ts: Array) -> tuple[Array, Array]:
    """Rs_camera_world (N, 3, 3), and the camera's places (N, 3) in the world."""
    R = Ts[:, :3, :3]
    return R, -np.einsum("nba,nb->na", R, Ts[:, :3, 3])
