"""What was measured of many frames is kept, and put together to the turns of all."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.measurements import Measured, Measurements
from keypose.tracker.camera_motion.turn import Turn
from keypose.tracker.geometry.rotations import Array
from tests.tracker.camera_cases import off_deg, turned


def measured(frame: int, turn: Turn | None = None, **changes: object) -> Measured:
    """A frame that was measured well from the first keyframe."""
    usual = {
        "keyframe": 0,
        "turn": turn or Turn.none(),
        "known": True,
        "cause": "",
        "covariance": np.diag([1e-8, 1e-8, 1e-8, 4e-8]),
        "error_px": 0.1 * frame,
        "uv": np.zeros((0, 2), np.float32),
        "good": np.zeros(0, bool),
        "share": 0.5,
    }
    return Measured(**{**usual, **changes})  # type: ignore[arg-type]


def test_of_many_frames_each_keeps_its_own_points() -> None:
    measurements, rng = Measurements(), np.random.default_rng(0)
    every = [rng.normal(size=(int(rng.integers(0, 5)), 2)).astype(np.float32) for _ in range(900)]
    for frame, uv in enumerate(every):
        good = np.full(len(uv), frame % 2 == 0)
        measurements.add(measured(frame, keyframe=frame // 9, uv=uv, good=good))
    points = measurements.points()
    for frame, uv in enumerate(every):
        there, good = points.of(frame)
        assert (there == uv).all()
        assert (good == (frame % 2 == 0)).all()
    assert len(measurements) == 900
    np.testing.assert_array_equal(measurements.error_px, 0.1 * np.arange(900))
    np.testing.assert_array_equal(measurements.keyframe, np.arange(900) // 9)
    np.testing.assert_array_equal(measurements.share, 0.5)


def test_frames_that_are_not_known_keep_their_cause() -> None:
    measurements = Measurements()
    for frame in range(5):
        is_known = frame != 2
        cause = "" if is_known else "not_rigid"
        measurements.add(measured(frame, known=is_known, cause=cause))
    assert measurements.causes == ["", "", "not_rigid", "", ""]
    assert measurements.known.tolist() == [True, True, False, True, True]


def test_of_no_frame_there_is_nothing() -> None:
    measurements = Measurements()
    assert len(measurements) == 0
    points = measurements.points()
    assert points.uv.shape == (0, 2)
    assert points.starts.tolist() == [0]


STEP_DEG = 1.0
FRAMES = 8


def panned(**changes: object) -> Measurements:
    """A pan of 1° a frame with a zoom of 2 %, measured from the first frame."""
    measurements = Measurements()
    for frame in range(FRAMES):
        turn = Turn(turned(STEP_DEG * frame), 1.02**frame)
        measurements.add(measured(frame, turn, **changes))
    return measurements


def all_turns(measurements: Measurements, readout: Array) -> tuple[Array, Array]:
    known = np.ones(FRAMES, bool)
    turns = measurements.turns(known, [Turn.none()], [0], readout)
    return turns.R, turns.log_zoom


def test_turns_are_those_that_were_measured() -> None:
    R, log_zoom = all_turns(panned(), np.zeros(2))
    assert off_deg(R, [turned(STEP_DEG * k) for k in range(FRAMES)]).max() < 1e-6
    np.testing.assert_allclose(log_zoom, np.log(1.02) * np.arange(FRAMES))


def test_the_doubts_are_the_standard_deviations() -> None:
    turns = panned().turns(np.ones(FRAMES, bool), [Turn.none()], [0], np.zeros(2))
    np.testing.assert_allclose(turns.doubt, 1e-4)
    np.testing.assert_allclose(turns.zoom_doubt, 2e-4)


@pytest.mark.parametrize("before", [0.0, 0.2])
def test_a_readout_that_became_known_turns_all_frames(before: float) -> None:
    """A lever of 0.1 rad of roll for each readout along v."""
    lever = np.zeros((4, 2))
    lever[2, 1], lever[3, 1] = 0.1, 0.05
    measurements = panned(lever=lever, readout=np.array([0.0, before]))
    R, log_zoom = all_turns(measurements, np.array([0.0, 0.5]))
    change = 0.5 - before
    expected = [
        turned(0.0, 0.0, np.degrees(0.1 * change)) @ turned(STEP_DEG * k) for k in range(FRAMES)
    ]
    assert off_deg(R, expected).max() < 1e-6
    np.testing.assert_allclose(log_zoom, np.log(1.02) * np.arange(FRAMES) + 0.05 * change)
