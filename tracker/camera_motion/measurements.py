"""Keep what was measured of a film's frames in few arrays, some hundred bytes a frame beside its
points, and put it together to the turns of all frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.path import Turns, turns_through
from keypose.tracker.camera_motion.turn import Turn
from keypose.tracker.geometry.rotations import Array, exp_rotation

GROWTH = 1.5
"""By which the table of frames grows where it is full."""
TOGETHER = 256
"""Frames whose points are put into one array at a time."""

_ROW = np.dtype(
    [
        ("R", float, (3, 3)),
        ("log_zoom", float),
        ("variance", float, (2,)),  # of the turn about an axis, and of log_zoom
        ("lever", float, (4, 2)),
        ("readout", float, (2,)),
        ("keyframe", np.int64),
        ("known", np.bool_),
        ("error_px", float),
        ("share", float),
    ]
)
"""What is kept of a frame, see `Measured`."""


Cause: TypeAlias = Literal["", "no_texture", "body_fills", "cut", "not_rigid", "no_picture"]
"""Why the camera is unknown at a frame; nothing where it is known."""


@dataclass(frozen=True, eq=False)
class Measured:
    """One frame, from its keyframe.

    turn: from the keyframe's camera; zoom as a quotient.  covariance (4, 4).  error_px: median of
    the agreeing points' residuals, NaN where unknown.  uv (K, 2) and good (K,): the points tracked.
    share: of the points followed from the frame before, or of those in view, those that moved
    alike, whichever is more.  readout (2,): of a rolling shutter, as it was assumed: the time from
    the first column to the last and from the first row to the last, as a share of that between
    frames.  lever (4, 2): the derivatives of the turn and of the logarithm of the zoom by it.
    """

    keyframe: int
    turn: Turn
    known: bool
    cause: Cause
    covariance: Array
    error_px: float
    uv: NDArray[np.float32]
    good: NDArray[np.bool_]
    share: float = 1.0
    lever: Array = field(default_factory=lambda: np.zeros((4, 2)))
    readout: Array = field(default_factory=lambda: np.zeros(2))


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
        self._rows = np.empty(TOGETHER, _ROW)
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
            grown = np.empty(int(number * GROWTH), _ROW)
            grown[:number] = self._rows
            self._rows = grown
        variance = np.diag(measured.covariance)
        self._rows[number] = (
            measured.turn.R,
            np.log(measured.turn.zoom),
            (variance[:3].mean(), variance[3]),
            measured.lever,
            measured.readout,
            measured.keyframe,
            measured.known,
            measured.error_px,
            measured.share,
        )
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
        return self._column("keyframe")

    @property
    def known(self) -> NDArray[np.bool_]:
        """At which frames (N,) the camera was measured."""
        return self._column("known")

    @property
    def error_px(self) -> Array:
        return self._column("error_px")

    @property
    def share(self) -> Array:
        """Of each frame (N,) the share of points that moved alike."""
        return self._column("share")

    def points(self) -> FollowedPoints:
        """The points of all frames."""
        uv, good = np.concatenate(self._uv), np.concatenate(self._good)
        return FollowedPoints(uv, good, np.cumsum([0, *self._counts], dtype=np.int64))

    def turns(
        self,
        is_known: NDArray[np.bool_],
        keyframes: Sequence[Turn],
        frames: Sequence[int],
        readout: Array,
    ) -> Turns:
        """The turns of all frames from the world, as they would have been measured with the
        readout known from the start.

        Args:
            is_known: (N,) at which frames the camera is known.
            keyframes: the turn of each keyframe from the world.
            frames: in which each keyframe was set.
            readout: (2,) along u and v, as a share of the time between frames.
        """
        rows = self._rows[: len(self)]
        change = (readout - rows["readout"])[:, :, None]
        moved = (rows["lever"] @ change)[..., 0]
        doubt = np.sqrt(rows["variance"])
        R = exp_rotation(moved[:, :3]) @ rows["R"]
        log_zoom = rows["log_zoom"] + moved[:, 3]
        measured = Turns(R, log_zoom, is_known, doubt[:, 0], doubt[:, 1])
        return turns_through(measured, self.keyframe, keyframes, frames)

    def _column(self, name: str) -> NDArray[Any]:
        return self._rows[name][: len(self)].copy()


def _put_together(arrays: list[NDArray[np.float32]] | list[NDArray[np.bool_]]) -> None:
    """Make one array of the latest, and leave those before: each is copied a few times at most."""
    latest = len(arrays) - 1
    while latest > 1 and len(arrays[latest - 1]) <= sum(map(len, arrays[latest:])):
        latest -= 1
    arrays[latest:] = [np.concatenate(arrays[latest:])]
