"""A camera is found in one picture by points whose places are known more or less."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion import resection
from keypose.tracker.camera_motion.bundle import nudged
from keypose.tracker.camera_motion.resection import SeenPoints, resected
from keypose.tracker.geometry.rotations import exp_rotation, transform
from tests.tracker.camera_motion.place_cases import NOISE, Place, off_by


def _seen(place: Place, view: int, outliers: int = 0) -> SeenPoints:
    """What the first camera knows of all points, seen by another."""
    rng = np.random.default_rng(2)
    xy, z = place.seen
    at = xy[view] + NOISE * rng.standard_normal(xy[view].shape)
    at[:outliers] += rng.normal(0, 0.05, (outliers, 2))
    depths, nothing = 1 / z[0], np.zeros(len(z[0]))
    return SeenPoints(place.X * depths[:, None], depths, nothing, np.zeros((len(z[0]), 3)), at)


def test_a_camera_is_found_where_a_third_of_the_points_are_outliers():
    place = Place.of()
    found = resected(place.Ts[5], _seen(place, 7, outliers=66), NOISE, step_sd=1.0)
    turn, shift = off_by(found.T, place.Ts[7])
    assert turn < 0.02
    assert shift < 0.003
    assert found.agree[66:].mean() > 0.95
    assert found.agree[:66].mean() < 0.1
    assert 0.5 < found.error < 2.0


def test_one_camera_is_moved_as_many_are():
    T = Place.of().Ts[5]
    for step in np.random.default_rng(6).normal(0, 0.3, (5, 6)):
        np.testing.assert_allclose(resection._nudged(T, step), nudged(T, step), atol=1e-12)
    np.testing.assert_allclose(resection._nudged(T, np.zeros(6)), T, atol=1e-15)


def test_depths_that_are_wrong_and_known_to_be_do_no_harm_beside_few_that_are_right():
    place = Place.of()
    seen = _seen(place, 7)
    rng = np.random.default_rng(3)
    depths = seen.depths.copy()
    depths[20:] = 0.15 * np.exp(rng.normal(0, 0.3, len(depths) - 20))
    rays = seen.world / seen.depths[:, None] / place.X[:, 2:]
    spread = np.where(np.arange(len(depths)) < 20, 1e-4, 0.1)
    guessed = SeenPoints(rays, depths, spread, seen.eyes, seen.xy)
    sure = SeenPoints(rays, depths, 0 * spread, seen.eyes, seen.xy)
    honest, naive = (resected(place.Ts[6], s, NOISE, 1.0).T for s in (guessed, sure))
    assert off_by(honest, place.Ts[7])[1] < 0.01 < off_by(naive, place.Ts[7])[1]


def test_points_at_infinity_tell_how_the_camera_turned_and_leave_it_where_it_was():
    place = Place.of()
    R = exp_rotation([0.02, -0.15, 0.03])
    rays = np.concatenate([place.seen[0][0], np.ones((len(place.X), 1))], axis=1)
    Y = rays @ R.T
    none = np.zeros(len(rays))
    seen = SeenPoints(rays, none, none, np.zeros_like(rays), Y[:, :2] / Y[:, 2:])
    found = resected(np.eye(4), seen, NOISE, step_sd=0.1)
    np.testing.assert_allclose(found.T, transform(R, np.zeros(3)), atol=1e-5)


@pytest.mark.parametrize("off", [0.001, 0.02, 0.06])
def test_a_camera_is_found_from_as_far_as_the_start_may_be(off: float) -> None:
    place = Place.of()
    start = nudged(place.Ts[5], np.random.default_rng(0).normal(0, off, 6))
    found = resected(start, _seen(place, 5), NOISE, step_sd=1.0)
    turn, shift = off_by(found.T, place.Ts[5])
    assert turn < 0.02
    assert shift < 0.003


def test_without_steps_the_camera_stays_and_says_how_far_points_are_off() -> None:
    place = Place.of()
    found = resected(place.Ts[6], _seen(place, 6), NOISE, 1.0, ())
    np.testing.assert_array_equal(found.T, place.Ts[6])
    assert found.error == pytest.approx(1.18, rel=0.15)  # the median of two normal numbers
    assert found.agree.mean() > 0.97


def test_a_step_that_is_unlikely_is_taken_where_points_show_it_and_not_where_they_do_not() -> None:
    place = Place.of()
    seen = _seen(place, 6)
    near, far = (resected(place.Ts[5], seen, NOISE, step_sd).T for step_sd in (1e-7, 1.0))
    assert off_by(far, place.Ts[6])[1] < 0.003
    here = np.linalg.inv(near)[:3, 3] - np.linalg.inv(place.Ts[5])[:3, 3]
    assert np.linalg.norm(here) < 0.01  # it is held where it was


def test_points_and_how_far_a_camera_goes_agree_on_one_pose_however_many_the_steps() -> None:
    place = Place.of()
    seen, noise = _seen(place, 6), 300 * NOISE
    few, many = (resected(place.Ts[4], seen, noise, 0.1, (1.0,) * n).T for n in (6, 30))
    way, whole = (off_by(T, place.Ts[4])[1] for T in (few, place.Ts[6]))
    assert 0.1 * whole < way < 0.9 * whole
    assert off_by(few, many)[1] < 0.02 * whole


def test_points_behind_the_camera_do_not_agree() -> None:
    place = Place.of()
    seen = _seen(place, 4)
    seen.world[:20] *= -1
    found = resected(place.Ts[4], seen, NOISE, 1.0)
    assert not found.agree[:20].any()
    assert off_by(found.T, place.Ts[4])[0] < 0.02


def test_by_no_point_the_camera_stays_where_it_is_and_no_error_is_said() -> None:
    none = np.zeros(0)
    seen = SeenPoints(np.zeros((0, 3)), none, none, np.zeros((0, 3)), np.zeros((0, 2)))
    T = Place.of().Ts[3]
    found = resected(T, seen, NOISE, 0.1)
    np.testing.assert_allclose(found.T, T, atol=1e-12)
    assert np.isnan(found.error)


def test_three_points_tell_a_pose_and_one_leaves_it_near_the_start() -> None:
    place = Place.of()
    exact = _seen(place, 5)
    names = ("world", "depths", "spread", "eyes", "xy")
    few = [SeenPoints(**{name: getattr(exact, name)[:count] for name in names}) for count in (3, 1)]
    start = nudged(place.Ts[5], np.full(6, 0.002))
    by_three, by_one = (resected(start, seen, NOISE, 0.1).T for seen in few)
    assert off_by(by_three, place.Ts[5])[0] < 0.5
    assert off_by(by_one, start)[1] < 0.1
