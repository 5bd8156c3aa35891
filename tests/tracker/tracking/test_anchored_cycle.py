"""Which of the motions counts that different starts led to."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.tracking import anchored_cycle
from keypose.tracker.tracking.anchored_cycle import (
    Candidate,
    cycle,
    joint_evidence,
    track_anchored,
)
from keypose.tracker.tracking.cues.soft_correction import Correction
from keypose.tracker.tracking.initial.choose import Starts
from keypose.tracker.tracking.method import FULL
from keypose.tracker.tracking.segment import distance_px
from tests.tracker.tracking.cues.people import Filmed, moving

FILM = Filmed(moving())


def led_to(by_keypoints: float, monkeypatch: pytest.MonkeyPatch) -> Trajectory:
    """The motion that counts, where evidence contradicts the one from keypoints by so much and the
    other by 100."""
    begun = Starts((Pass("closed", FILM.truth, None),))

    def led(
        correction: Any, _: Any, start: Pass, tried: list[Pass], *given: Any
    ) -> Generator[Pass, None, Candidate]:
        tried.append(start)
        yield start
        cost = 100.0 if start.trajectory is FILM.truth else by_keypoints
        nothing = np.zeros((len(FILM.truth) - 1, len(FILM.free.marks[1])))
        return Candidate(len(tried) - 1, start.trajectory, cost, None, nothing, correction.anchors)

    monkeypatch.setattr(anchored_cycle, "cycle", led)
    work = track_anchored(FILM.free, FILM.free, FILM.segment, FULL, FILM.anchors(), begun)
    while True:
        try:
            next(work)
        except StopIteration as done:
            found: Trajectory = done.value.trajectory
            return found


def test_the_motion_counts_that_is_contradicted_least(monkeypatch: pytest.MonkeyPatch) -> None:
    assert led_to(99.0, monkeypatch) is not FILM.truth
    assert led_to(101.0, monkeypatch) is FILM.truth


def cycled(start: Trajectory, before: Candidate | None = None) -> tuple[Candidate, list[Pass]]:
    """Where the cycle leads, and all that was tried."""
    (anchors,) = FILM.anchors()
    tried: list[Pass] = []
    correction = Correction(FILM.free, FILM.segment, anchors)
    work = cycle(correction, FULL, Pass("keypoints", start, None), tried, None, before)
    while True:
        try:
            next(work)
        except StopIteration as done:
            return done.value, tried


def test_a_start_whose_cycle_meets_anothers_leads_where_that_one_led() -> None:
    first, all_tried = cycled(FILM.truth)
    again, tried = cycled(first.after_passes[0], first)
    assert again.trajectory is first.trajectory
    assert (again.index, again.cost) == (first.index, first.cost)
    assert len(tried) < len(all_tried)
    met = again.met[0]
    assert any(met.there is each for each in first.after_passes)
    found, alone = (
        joint_evidence(FILM.free, [again], again),
        joint_evidence(FILM.free, [first], first),
    )
    assert np.isnan(alone.apart).all()  # nobody has compared it
    away = distance_px(FILM.free, met.here, met.there).max() / first.anchors.height_px
    assert 0 < np.nanmax(found.apart) < 2 * away


def test_a_start_whose_cycle_meets_no_other_is_led_to_its_end() -> None:
    first, all_tried = cycled(FILM.truth)
    R, t = FILM.truth.writable()
    shifted = Trajectory(FILM.truth.first_frame, R, t + np.array([0.3, 0.0, 0.0]))
    elsewhere = replace(first, after_passes=(shifted,))
    other, tried = cycled(FILM.truth, elsewhere)
    assert other.met == ()
    assert len(tried) == len(all_tried)


def test_evidence_has_the_drift_of_a_parts_worst_mark_and_how_far_the_other_motion_lies() -> None:
    (anchors,) = FILM.anchors()
    drift = np.zeros((len(FILM.truth) - 1, len(FILM.free.marks[1])))
    part = int(anchors.parts[-1])
    mark = int(np.flatnonzero(FILM.free.marks[1] == part)[-1])
    drift[3, mark] = 5.0
    ends = [
        Candidate(index, motion, 1.0, None, drift, anchors)
        for index, motion in enumerate((FILM.truth, FILM.segment.interpolated()))
    ]
    found = joint_evidence(FILM.free, ends, ends[0])
    assert found.apart.max() > 0.01
    there = found.drift[:, anchors.parts == part]
    np.testing.assert_allclose(there[3:5], 0.5 * 5.0 / anchors.height_px)
    assert np.count_nonzero(found.drift) == there[3:5].size
