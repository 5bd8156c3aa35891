"""Keep what was measured of a film's frames in few arrays, some hundred bytes a frame beside its
points, and put it together to the turns of all frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.path import Turns, turns_through
from keypose.tracker.camera_motion.turn import Turn
from keypose.tracker.camera_motion.turning_odometry import Measured
from keypose.tracker.geometry.rotations import Array, exp_rotation

GROWTH = 1.5
"""By which the table of frames grows where it is full."""
TOGETHER = 256
"""Frames whose points are put into one array at a time."""

_R = slice(0, 9)
_ZOOM = 9
_VARIANCE = slice(10, 12)
_LEVER = slice(12, 20)
_READOUT = slice(20, 22)
_KEYFRAME = 22
_KNOWN = 23
_ERROR = 24
_SHARE = 25
_COLUMNS = 26
"""Where in a row of measurements what stands."""


@dataclass(frozen=True, eq=False)
class FollowedPoints:
    """Points followed in N frames: those of frame i are [starts[i], starts[i + 1]).

    uv (P, 2) float32, pixels of the film.  good (P,): whether they move as the background does.
    starts (N + 1,).
    """

    uv: NDArray[np.float32]
    good: NDArray[np.bool_]
    starts: NDArray[np.int64]

    def of(self, frame: int) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Places (K, 2) and verdicts (K,) of one frame."""
        span = slice(self.starts[frame], self.starts[frame + 1])
        return self.uv[span], self.good[span]


class Measurements:
    """The frames of a film in order."""

    def __init__(self) -> None:
        self._rows = np.empty((TOGETHER, _COLUMNS))
        self._uv: list[NDArray[np.float32]] = [np.zeros((0, 2), np.float32)]
        self._good: list[NDArray[np.bool_]] = [np.zeros(0, bool)]
        self._counts: list[int] = []
        self.causes: list[str] = []

    def __len__(self) -> int:
        return len(self.causes)

    def add(self, measured: Measured) -> None:
        """Take the next frame."""
        number = len(self)
        if number == len(self._rows):
            grown = np.empty((int(number * GROWTH), _COLUMNS))
            grown[:number] = self._rows
            self._rows = grown
        row, variance = self._rows[number], np.diag(measured.covariance)
        row[_R], row[_ZOOM] = measured.turn.R.ravel(), np.log(measured.turn.zoom)
        row[_VARIANCE] = variance[:3].mean(), variance[3]
        row[_LEVER], row[_READOUT] = measured.lever.ravel(), measured.readout
        row[_KEYFRAME], row[_KNOWN] = measured.keyframe, measured.known
        row[_ERROR], row[_SHARE] = measured.error_px, measured.share
        self.causes.append(measured.cause)
        self._counts.append(len(measured.uv))
        self._uv.append(measured.uv)
        self._good.append(measured.good)
        if number % TOGETHER == 0:
            _put_together(self._uv)
            _put_together(self._good)

    @property
    def keyframe(self) -> NDArray[np.int64]:
        """The keyframe (N,) of each frame."""
        return self._column(_KEYFRAME).astype(np.int64)

    @property
    def known(self) -> NDArray[np.bool_]:
        """At which frames (N,) the camera was measured."""
        return self._column(_KNOWN) > 0

    @property
    def error_px(self) -> Array:
        return self._column(_ERROR)

    @property
    def share(self) -> Array:
        """Of each frame (N,) the share of points that moved alike."""
        return self._column(_SHARE)

    def points(self) -> FollowedPoints:
        """The points of all frames."""
        uv, good = np.concatenate(self._uv), np.concatenate(self._good)
        return FollowedPoints(uv, good, np.cumsum([0, *self._counts], dtype=np.int64))

    def turns(
        self,
        known: NDArray[np.bool_],
        keyframes: Sequence[Turn],
        frames: Sequence[int],
        readout: Array,
    ) -> Turns:
        """The turns of all frames from the world, as they would have been measured with the
        readout known from the start.

        Args:
            known: (N,) at which frames the camera is known.
            keyframes: the turn of each keyframe from the world.
            frames: in which each keyframe was set.
            readout: (2,) along u and v, as a share of the time between frames.
        """
        rows = self._rows[: len(self)]
        change = (readout - rows[:, _READOUT])[:, :, None]
        moved = (rows[:, _LEVER].reshape(-1, 4, 2) @ change)[..., 0]
        doubt = np.sqrt(rows[:, _VARIANCE])
        R = exp_rotation(moved[:, :3]) @ rows[:, _R].reshape(-1, 3, 3)
        log_zoom = rows[:, _ZOOM] + moved[:, 3]
        measured = Turns(R, log_zoom, known, doubt[:, 0], doubt[:, 1])
        return turns_through(measured, self.keyframe, keyframes, frames)

    def _column(self, column: int) -> Array:
        return self._rows[: len(self), column].copy()


def _put_together(arrays: list[NDArray[np.float32]] | list[NDArray[np.bool_]]) -> None:
    """Make one array of the latest, and leave those before: each is copied a few times at most."""
    latest = len(arrays) - 1
    while latest > 1 and len(arrays[latest - 1]) <= sum(map(len, arrays[latest:])):
        latest -= 1
    arrays[latest:] = [np.concatenate(arrays[latest:])]
