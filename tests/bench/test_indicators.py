"""What the benchmark of verdicts computes is what it says."""

from __future__ import annotations

import numpy as np
import pytest

from bench.indicators import (
    Record,
    auroc,
    by_segment,
    judged,
    left_out,
    logistic,
    miscalibration,
)


def _pairs(values: np.ndarray, wrong: np.ndarray) -> float:
    """The share of pairs in order, counted one by one."""
    pairs = [(a > b) + 0.5 * (a == b) for a in values[wrong] for b in values[~wrong]]
    return float(np.mean(pairs))


@pytest.mark.parametrize("levels", [3, 1000])
def test_the_auroc_is_the_share_of_pairs_in_the_right_order_with_and_without_ties(
    levels: int,
) -> None:
    rng = np.random.default_rng(levels)
    values = rng.integers(0, levels, 200).astype(float)
    wrong = rng.random(200) < 0.2 + 0.5 * values / levels
    assert auroc(values, wrong) == pytest.approx(_pairs(values, wrong))


def test_the_auroc_of_nothing_wrong_is_not_known() -> None:
    assert np.isnan(auroc(np.arange(4.0), np.zeros(4, dtype=bool)))


def test_a_logistic_curve_is_found_again_from_what_it_predicts() -> None:
    rng = np.random.default_rng(0)
    values = rng.normal(size=20_000)
    wrong = rng.random(20_000) < 1 / (1 + np.exp(1.0 - 2.0 * values))
    assert logistic(values, wrong) == pytest.approx((-1.0, 2.0), abs=0.1)


def test_an_indicator_that_separates_perfectly_still_gets_a_finite_curve() -> None:
    values = np.array([0.0, 0.0, 1.0, 1.0])
    assert np.isfinite(logistic(values, values > 0)).all()


def test_a_clip_is_judged_by_the_other_clips_alone() -> None:
    values, clips = np.array([0.0, 1.0, 0.0, 1.0]), np.array(["a", "a", "b", "b"])
    wrong = np.array([False, True, True, False])
    p = left_out(values, wrong, clips)
    assert p[0] > p[1]  # b says that larger is right
    assert p[3] > p[2]


def test_one_clip_alone_cannot_be_left_out() -> None:
    assert np.isnan(left_out(np.arange(3.0), np.arange(3) > 1, np.full(3, "a"))).all()


def test_probabilities_that_come_true_are_calibrated_and_their_opposites_are_not() -> None:
    rng = np.random.default_rng(1)
    p = rng.random(50_000)
    wrong = rng.random(50_000) < p
    assert miscalibration(p, wrong) < 0.01
    assert miscalibration(1 - p, wrong) == pytest.approx(0.5, abs=0.02)


def _record(
    clip: str, first: int, kind: str, px: float, indicator: float = 0.0, enlarged: float = 1.0
) -> Record:
    """enlarged: pixels of the film to one of a person 400 px tall."""
    off = px * enlarged, px
    return Record(
        clip, "row", "way", 0, (first, first + 9), kind, first + 3, "j", *off, {"t": indicator}
    )


def test_segments_are_right_under_five_pixels_in_the_mean() -> None:
    some = [
        _record("a", 0, "good", 4.0), _record("a", 0, "good", 5.5), _record("a", 10, "good", 9.0),
        _record("a", 20, "check", 1.0), _record("a", 30, "lost", 40.0),
    ]  # fmt: skip
    found = by_segment(some)
    assert (found.count, found.right) == (4, 2)
    assert found.called_good == pytest.approx(0.5)
    assert found.good_is_right == pytest.approx(0.5)


@pytest.mark.parametrize("enlarged", [0.5, 4.0])
def test_a_segment_is_right_in_the_film_or_on_a_person_400_pixels_tall(enlarged: float) -> None:
    nearest = 4.5 / min(enlarged, 1.0)
    assert by_segment([_record("a", 0, "good", nearest, enlarged=enlarged)]).right == 1
    assert by_segment([_record("a", 0, "good", nearest + 1.2, enlarged=enlarged)]).right == 0


def test_an_indicator_is_judged_by_the_error_on_a_person_400_pixels_tall() -> None:
    some = [_record(c, 0, "check", px, px) for c in "ab" for px in (1.0, 9.9, 10.1, 30.0)]
    assert judged(some, "t").auroc == 1.0


def test_what_is_lost_is_distinguished_from_what_is_merely_wrong() -> None:
    some = [
        _record(c, 0, "check", px, indicator)
        for c in "ab"
        for px, indicator in ((1.0, 1.0), (9.0, 2.0), (11.0, 1.5), (30.0, 3.0))
    ]
    found = judged(some, "t")
    assert found.left_out == pytest.approx(0.75)
    assert found.very_far == 1.0


def test_a_left_out_clip_is_ordered_within_itself_however_often_it_is_wrong() -> None:
    rare = [_record("a", 0, "check", px, px) for px in (1.0, 2.0, 3.0, 30.0)]
    often = [_record("b", 0, "check", 10 * px, px) for px in (0.5, 2.0, 3.0, 4.0)]
    assert judged(rare + often, "t").left_out == 1.0
