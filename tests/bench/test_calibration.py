"""Predicted errors are fitted to the measured median, and calibrated by bands."""

from __future__ import annotations

import numpy as np
import pytest

from bench.calibration import auroc, bands, even, fitted, median_weights, without_marks
from bench.measures import TALL_PX
from keypose.tracker.tracking.cues.joint_evidence import Weights

TRUE = Weights(1.7, 0.6, 0.7, 0.2, 0.004, 0.15)
COUNT = 20_000


def test_half_of_the_errors_are_under_what_is_told_in_every_band_whatever_their_spread() -> None:
    rng = np.random.default_rng(0)
    apart, drift = np.exp(rng.uniform(np.log(1e-3), np.log(0.2), COUNT)), rng.gamma(1, 4e-3, COUNT)
    away, clips = rng.uniform(1, 40, COUNT), rng.choice(["one", "two", "three"], COUNT)
    error = TRUE.median(apart, drift, away) * rng.lognormal(0.0, 0.7, COUNT)
    error[::50] *= 20.0  # a few are lost
    predicted = fitted(apart, drift, away, error, clips).median(apart, drift, away)
    found = list(bands(predicted, error, 200))
    assert len(found) >= 7
    for band in found:
        assert band.miscalibration < 0.12, band
        assert band.under == pytest.approx(0.5, abs=0.07), band


def test_few_that_are_far_off_do_not_move_a_median() -> None:
    x = np.linspace(0.0, 1.0, 101)
    values = 2.0 + 3.0 * x
    values[::10] += 100.0
    rows = np.stack([np.ones(101), x], axis=1)
    np.testing.assert_allclose(median_weights(rows, values, np.ones(101)), (2.0, 3.0), atol=0.02)


def test_what_marks_are_off_themselves_is_taken_out_and_leaves_nothing_below_it() -> None:
    found = without_marks(np.array([5.0, 2.0]), np.array([3.0, 3.0]))
    np.testing.assert_allclose(found, (4.0, 0.0))


def test_a_band_tells_what_was_told_and_measured() -> None:
    predicted = np.full(100, 8.0 / TALL_PX)
    (band,) = bands(predicted, np.linspace(0.0, 8.0, 100) / TALL_PX, 50)
    assert (band.name, band.count) == ("7–10 px", 100)
    assert (band.predicted_px, band.measured_px) == (pytest.approx(8.0), pytest.approx(4.0))
    assert band.miscalibration == pytest.approx(0.5)
    assert band.under == pytest.approx(0.99)
    assert not list(bands(predicted, predicted, 101))


def test_the_area_under_the_curve_is_one_where_all_wrong_joints_are_doubted_most() -> None:
    wrong = np.array([False, False, True, True])
    assert auroc(wrong, np.array([1.0, 2.0, 3.0, 4.0])) == 1.0
    assert auroc(wrong, np.array([1.0, 1.0, 1.0, 1.0])) == 0.5
    assert np.isnan(auroc(~wrong | wrong, np.zeros(4)))


def test_groups_count_alike_or_by_their_size() -> None:
    groups = np.array(["a"] * 9 + ["b"])
    alike, by_size = even(groups, 1.0), even(groups, 0.0)
    assert alike[:9].sum() == pytest.approx(alike[9])
    np.testing.assert_array_equal(by_size, 1.0)
