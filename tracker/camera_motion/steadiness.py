"""Judge whether points stay where a turning camera would show them.

The residual of a point that stands still in the world is noise: it changes from frame to frame. Of
one that lies nearer or farther than others, seen from a camera that moves, it grows and stays. What
tells them apart is the residual's mean over the latest frames against the noise of its changes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.turn import Solved

RATE = 0.2
"""Of the running mean: the share of the latest residual."""
FEWEST_FRAMES = 6
"""Over which a point must have been followed."""
SYSTEMATIC_PX = 0.6
"""Of the size looked at: a smaller mean is not called systematic."""
SIGMAS = 3.0
"""Standard deviations of noise by which a point must have moved."""
FEWEST_POINTS = 20
"""Points without which nothing is said."""


@dataclass(frozen=True)
class Summary:
    """Of one keyframe: how many points were followed long enough, the share of them that stays
    aside, their median way aside, and the median of all residuals; pixels of the size looked at.
    """

    points: int
    aside: float
    aside_px: float
    noise_px: float


class Steadiness:
    """Running means of the residuals of a keyframe's points."""

    def __init__(self, count: int) -> None:
        self._mean = np.zeros((count, 2))
        self._before = np.zeros((count, 2))
        self._change = np.zeros(count)
        self._times = np.zeros(count, int)

    def add(self, tracked: NDArray[np.bool_], solved: Solved) -> None:
        """Take the residuals of one frame's points that were tracked (K,)."""
        residual = np.clip(np.nan_to_num(solved.residual_px), -50, 50)
        rate = np.maximum(RATE, 1 / (self._times[tracked] + 1))
        self._mean[tracked] += rate[:, None] * (residual - self._mean[tracked])
        change = ((residual - self._before[tracked]) ** 2).sum(axis=1) / 2
        self._change[tracked] += rate * (change - self._change[tracked])
        self._before[tracked] = residual
        self._times[tracked] += 1

    def summary(self) -> Summary:
        """What the keyframe's points say."""
        long = self._times >= FEWEST_FRAMES
        if long.sum() < FEWEST_POINTS:
            return Summary(int(long.sum()), 0.0, 0.0, 0.0)
        away_px = np.linalg.norm(self._mean[long], axis=1)
        noise = np.sqrt(self._change[long] * RATE / (2 - RATE))
        aside = away_px > np.maximum(SYSTEMATIC_PX, SIGMAS * noise)
        far = float(np.median(away_px[aside])) if aside.any() else 0.0
        return Summary(int(long.sum()), float(aside.mean()), far, float(np.median(noise)))
