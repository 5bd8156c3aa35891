"""How long a picture is read is learned from frames, and taken out of where points are seen."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.shutter import IN_COMMON, LEAST_SHARE, MOST, Shutter
from keypose.tracker.geometry.camera import Camera
from tests.tracker.camera_cases import SMALL

DISTORTED = SMALL.model_copy(update={"distortion": (-0.2, 0.05, 0.001, -0.001, 0.0)})
RATE = np.radians([0.4, 1.5, -0.6])
"""Radians a frame: a quick pan with some tilt and roll."""
UV = np.random.default_rng(0).uniform((20, 20), (300, 160), (40, 2))


def shutter(u: float = 0.0, v: float = 0.6, sure: float = 1e6) -> Shutter:
    return Shutter((320, 180), np.array([u, v]), np.eye(2) * sure)


@pytest.mark.parametrize("camera", [SMALL, DISTORTED], ids=["ideal", "distorted"])
@pytest.mark.parametrize("zoom", [1.0, 1.7])
def test_what_is_sheared_is_straightened_again(camera: Camera, zoom: float) -> None:
    lens, known = Lens.of(camera), shutter()
    there = known.sheared(lens, UV, zoom, RATE)
    assert np.abs(there - UV).max() > 2
    np.testing.assert_allclose(known.straightened(lens, there, zoom, RATE), UV, atol=0.2)


def test_a_row_is_seen_from_where_the_camera_was_as_it_was_read() -> None:
    """A readout v: the last row is read half of it after the middle one."""
    lens, v = Lens.of(SMALL), 0.6
    rows = np.array([[160.0, -0.5], [160.0, 89.5], [160.0, 179.5]])
    pan = np.array([0.0, 0.01, 0.0])
    shift = shutter(v=v).sheared(lens, rows, 1.0, pan) - rows
    np.testing.assert_allclose(shift[:, 0] / (0.01 * SMALL.fx), [-v / 2, 0.0, v / 2], atol=1e-3)


def test_a_phone_held_upright_reads_columns() -> None:
    lens = Lens.of(SMALL)
    columns = np.array([[-0.5, 90.0], [319.5, 90.0]])
    pan = np.array([0.0, 0.01, 0.0])
    shift = shutter(u=0.6, v=0.0).sheared(lens, columns, 1.0, pan) - columns
    assert shift[0, 0] < -1 < 1 < shift[1, 0]
    rows = np.array([[160.0, -0.5], [160.0, 179.5]])
    np.testing.assert_allclose(shutter(u=0.6, v=0.0).sheared(lens, rows, 1.0, pan), rows, atol=0.02)


def test_a_readout_that_is_not_sure_is_not_taken_out() -> None:
    lens, unsure = Lens.of(SMALL), shutter(v=0.2, sure=25.0)
    np.testing.assert_array_equal(unsure.share, 0.0)
    np.testing.assert_array_equal(unsure.straightened(lens, UV, 1.0, RATE), UV)


@pytest.mark.parametrize("true", [(0.0, 0.5), (0.7, 0.0), (0.0, -0.4)], ids=str)
def test_frames_that_agree_on_a_readout_teach_it(true: tuple[float, float]) -> None:
    learning, rng = Shutter((320, 180)), np.random.default_rng(1)
    information = np.eye(2) * 2e4
    for _ in range(300):
        measured = np.array(true) + rng.normal(0, 1 / np.sqrt(2e4), 2)
        learning.learn(information @ (measured - learning.share), information)
    np.testing.assert_allclose(learning.estimate, true, atol=0.03)
    np.testing.assert_allclose(learning.share, true, atol=0.03)
    assert learning.reported() == pytest.approx(max(map(abs, true)), abs=0.03)


def test_of_nothing_no_readout_is_said() -> None:
    assert Shutter((320, 180)).reported() is None
    learning = Shutter((320, 180))
    for _ in range(300):
        learning.learn(np.zeros(2), np.eye(2) * 2e4)  # every frame says: none
    assert learning.reported() is None
    np.testing.assert_array_equal(learning.share, 0.0)


@pytest.mark.parametrize(("v", "is_said"), [(0.5 * LEAST_SHARE, False), (2 * LEAST_SHARE, True)])
def test_a_readout_that_is_sure_is_said_where_it_is_large_enough(v: float, is_said: bool) -> None:
    assert (shutter(v=v).reported() is not None) == is_said


def test_a_wild_frame_does_not_lead_beyond_what_a_shutter_can_be() -> None:
    learning = Shutter((320, 180))
    learning.learn(np.array([1e9, -1e9]), np.eye(2) * 1e3)
    np.testing.assert_array_equal(learning.estimate, [MOST, -MOST])


def test_what_frames_have_in_common_keeps_it_from_being_too_sure() -> None:
    learning = Shutter((320, 180))
    for _ in range(50):
        learning.learn(np.zeros(2), np.eye(2) * 1e9)
    assert np.sqrt(np.linalg.inv(learning.information)[0, 0]) == pytest.approx(0.01, rel=1e-6)


def test_many_points_and_frames_that_err_alike_count_as_few() -> None:
    learning, before = Shutter((320, 180)), Shutter((320, 180)).information
    learning.learn(np.zeros(2), np.eye(2) * 100.0)
    np.testing.assert_allclose(learning.information - before, np.eye(2) * 100.0 / IN_COMMON)
