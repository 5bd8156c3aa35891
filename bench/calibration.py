"""Calibrate predicted errors: fit their median, and compare it with the measured one by bands."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from bench.measures import TALL_PX
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.tracking.cues.joint_evidence import LEAST, LEAST_DRIFT, Weights

BANDS_PX = (0.0, 3.0, 5.0, 7.0, 10.0, 14.0, 20.0, 28.0, 40.0)
"""Ends of predicted errors, px on a person 400 px tall."""
FLOOR = 0.5 / TALL_PX
"""Errors count as no less."""
CORNER = 2.4 / TALL_PX
"""Where a product of powers, a share of the height, begins to count in full."""
LARGEST = (0.5, 0.75, 0.9, 0.97)
"""Quantiles of predicted errors that part small errors from large ones."""
ROUNDS = 60
LEAST_AWAY = 1e-3


def without_marks(error: Array, mark: Array) -> Array:
    """The error without what marks are off themselves, both lengths, in quadrature."""
    return np.asarray(np.sqrt(np.maximum(error**2 - mark**2, 0.0)))


def median_weights(rows: Array, values: Array, importance: Array) -> Array:
    """(C,) by which rows (J, C) give the values' median: the least sum of absolute differences."""
    weights = np.ones(len(values))
    found = np.zeros(rows.shape[1])
    for _ in range(ROUNDS):
        scaled = rows * (importance * weights)[:, None]
        found = np.linalg.lstsq(scaled.T @ rows, scaled.T @ values, rcond=None)[0]
        weights = 1 / np.maximum(np.abs(values - rows @ found), LEAST_AWAY)
    return found


def fitted(
    apart: Array, drift: Array, away: Array, error: Array, clips: NDArray[np.str_]
) -> Weights:
    """Weights by which joints (J,) are expected to be off by the median of their errors.

    Each clip counts alike for errors predicted about as large, as few clips show large
    errors.
    """
    logs = (np.log(apart + LEAST), np.log(drift + LEAST_DRIFT), np.log(away + 1))
    rows = np.stack([np.ones(len(error)), *logs], axis=1)
    true = np.log(np.maximum(error, FLOOR))
    plain = median_weights(rows, true, even(clips, 0.5))
    product = rows @ plain
    bent = np.maximum(product - np.log(CORNER), 0.0)
    bends = np.stack([np.ones(len(true)), product, bent], axis=1)
    large = np.digitize(product, np.quantile(product, LARGEST)).astype(str)
    by_size = np.char.add(np.char.add(clips.astype(str), " "), large)
    shift, scale, steeper = median_weights(bends, true, even(by_size, 1.0)).tolist()
    slope = scale + steeper
    base, by_apart, by_drift, by_away = (slope * plain).tolist()
    corner = float(np.log(CORNER))
    return Weights(
        base + shift - steeper * corner,
        by_apart,
        by_drift,
        by_away,
        floor=float(np.exp(shift + scale * corner)),
        below=scale / slope,
    )


class Band(NamedTuple):
    """What was measured of joints predicted to be off by about so much; px on a person 400 px tall.

    under: share of them that is off by less than predicted.
    """

    name: str
    count: int
    predicted_px: float
    measured_px: float
    under: float

    @property
    def miscalibration(self) -> float:
        """By what share the measured median misses the predicted one."""
        return abs(self.measured_px / self.predicted_px - 1)


def bands(predicted: Array, error: Array, fewest: int) -> Iterator[Band]:
    """The bands of at least so many joints. predicted, error (J,): shares of the height."""
    for least, most in zip(BANDS_PX, (*BANDS_PX[1:], np.inf), strict=True):
        at = (predicted * TALL_PX >= least) & (predicted * TALL_PX < most)
        if at.sum() >= fewest:
            name = f"{least:g}–{most:g} px" if np.isfinite(most) else f"over {least:g} px"
            medians = (float(np.median(each[at])) * TALL_PX for each in (predicted, error))
            yield Band(name, int(at.sum()), *medians, float((error[at] < predicted[at]).mean()))


def auroc(wrong: NDArray[np.bool_], doubt: Array) -> float:
    """Area under the curve: how often a wrong joint is doubted more than a right one."""
    bad = int(wrong.sum())
    if not 0 < bad < len(wrong):
        return float("nan")
    return float((rankdata(doubt)[wrong].sum() - bad * (bad + 1) / 2) / (bad * (len(wrong) - bad)))


def even(groups: NDArray[np.str_], share: float) -> Array:
    """(J,) importance of joints by which groups count alike where `share` is 1, by their size
    where it is 0."""
    _, of, count = np.unique(groups, return_inverse=True, return_counts=True)
    return np.asarray(count[of] ** -share)
