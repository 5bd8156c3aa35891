from __future__ import annotations

import numpy as np

from keypose.tracker.camera_motion import resection
from keypose.tracker.camera_motion.bundle import nudged
from keypose.tracker.camera_motion.resection import SeenPoints, resected
from keypose.tracker.camera_motion.two_views import parallax, two_views
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


def test_two_pictures_tell_the_motion_between_them_but_for_its_length():
    place = Place.of()
    (xy, z), rng = place.seen, np.random.default_rng(4)
    other = xy[3] + NOISE * rng.standard_normal(xy[3].shape)
    other[:30] += rng.normal(0, 0.05, (30, 2))
    found = two_views(xy[0], other, NOISE)
    assert found is not None
    way, true = found.T[:3, 3], place.Ts[3, :3, 3]
    unit = np.linalg.norm(true) / np.linalg.norm(way)
    turn, shift = off_by(transform(found.T[:3, :3], unit * way), place.Ts[3])
    assert turn < 0.1
    assert shift < 0.02
    agree = found.agree
    assert not agree[:30].any() or agree[30:].mean() > 5 * agree[:30].mean()
    np.testing.assert_allclose(found.depths[agree] / unit, 1 / z[0][agree], rtol=0.15)


def test_a_turn_has_no_parallax_and_a_step_has():
    xy = Place.of().seen[0]
    rays = np.concatenate([xy[0], np.ones((len(xy[0]), 1))], axis=1)
    Y = rays @ exp_rotation([0.1, 0.2, 0.1]).T
    assert parallax(xy[0], Y[:, :2] / Y[:, 2:], NOISE) < 1e-6
    assert parallax(xy[0], xy[2], NOISE) > 20


def test_too_few_points_and_points_that_go_anywhere_tell_no_motion():
    xy, rng = Place.of().seen[0], np.random.default_rng(5)
    assert two_views(xy[0][:10], xy[3][:10], NOISE) is None
    assert two_views(xy[0], rng.uniform(-0.5, 0.5, xy[0].shape), NOISE) is None
