"""Two pictures tell the motion between them but for its length, or that they do not."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.two_views import along_rays, parallax, two_views
from keypose.tracker.geometry.rotations import Array, exp_rotation, transform
from tests.tracker.camera_motion.place_cases import NOISE, Place, off_by


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


def seen_from(X: Array, T: Array, noise: float = 0.0) -> Array:
    """Where points (K, 3) are seen from a camera at T, as x/z and y/z."""
    Y = X @ T[:3, :3].T + T[:3, 3]
    rng = np.random.default_rng(8)
    return np.asarray(Y[:, :2] / Y[:, 2:] + rng.normal(0, noise, (len(X), 2)))


WAYS = {
    "aside": ([0.0, -0.05, 0.0], [0.6, 0.0, 0.0]),
    "ahead": ([0.01, 0.0, 0.02], [0.05, 0.0, -0.9]),
    "up, with a roll": ([0.0, 0.0, 0.3], [0.0, 0.7, 0.1]),
}
"""How the second camera is turned, and where the first one's origin is in it."""


@pytest.mark.parametrize("name", WAYS)
def test_a_motion_in_any_direction_is_found(name: str) -> None:
    w, t = (np.array(part) for part in WAYS[name])
    X, T = Place.of().X, transform(exp_rotation(w), t)
    found = two_views(X[:, :2] / X[:, 2:], seen_from(X, T, NOISE), NOISE)
    assert found is not None
    unit = np.linalg.norm(t) / np.linalg.norm(found.T[:3, 3])
    turn, shift = off_by(transform(found.T[:3, :3], unit * found.T[:3, 3]), T)
    assert turn < 0.1
    assert shift < 0.05 * np.linalg.norm(t)
    assert found.agree.mean() > 0.9
    # the middle depth is the unit
    assert np.median(1 / found.depths[found.agree]) == pytest.approx(1.0, rel=0.1)


def test_depths_say_how_sure_they_are() -> None:
    X, T = Place.of().X, transform(np.eye(3), np.array([0.6, 0.0, 0.0]))
    found = two_views(X[:, :2] / X[:, 2:], seen_from(X, T, NOISE), NOISE)
    assert found is not None
    unit = float(np.median(found.depths[found.agree] * X[found.agree, 2]))
    off = (found.depths - unit / X[:, 2]) / found.spread
    assert 0.3 < np.median(np.abs(off[found.agree])) < 1.5


def test_parallax_is_what_is_left_after_the_best_turn() -> None:
    """Of points of which half are infinitely far: the others' way, in standard deviations."""
    rays = np.random.default_rng(0).uniform(-0.5, 0.5, (200, 2))
    turn = exp_rotation([0.02, 0.05, -0.03])
    later = seen_from(
        np.concatenate([rays, np.ones((200, 1))], axis=1), transform(turn, np.zeros(3))
    )
    assert parallax(rays, later, NOISE) < 1e-6
    later[:60] += (20 * NOISE, 0.0)
    assert parallax(rays, later, NOISE) < 1.0  # a minority that moves by itself
    later[60:140] += (20 * NOISE, 0.0) * np.where(np.arange(80) % 2, 1, -1)[:, None]
    assert parallax(rays, later, NOISE) > 5


def test_inverse_depths_along_rays_are_those_of_the_points() -> None:
    X, T = Place.of().X, Place.of().Ts[6]
    depths = along_rays(T, X[:, :2] / X[:, 2:], seen_from(X, T))
    np.testing.assert_allclose(depths, 1 / X[:, 2], rtol=1e-6)


def test_the_same_pictures_tell_the_same_motion() -> None:
    xy = Place.of().seen[0]
    first, second = (two_views(xy[0], xy[4] + NOISE, NOISE) for _ in range(2))
    assert first is not None
    assert second is not None
    np.testing.assert_array_equal(first.T, second.T)
