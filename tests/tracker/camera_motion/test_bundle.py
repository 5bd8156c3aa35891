"""Bundle adjustment: poses and depths that explain best where points are seen."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from keypose.tracker.camera_motion import bundle as bundles
from keypose.tracker.camera_motion.bundle import (
    adjusted,
    cost_of,
    nudged,
    points_in_views,
    residual_lengths,
)
from tests.tracker.camera_motion.place_cases import Place, bundle_of, off_by


def test_places_and_depths_are_found_from_noisy_places_in_pictures_with_outliers():
    place = Place.of()
    start, depths = bundle_of(place, outliers=0.08)
    found, spread = adjusted(start, steps=30)
    errors = [off_by(T, true) for T, true in zip(found.Ts, place.Ts, strict=True)]
    assert max(turn for turn, _ in errors) < 0.03
    assert max(shift for _, shift in errors) < 0.006
    within = np.abs(found.depths - depths) / spread
    assert 0.4 < np.median(within) < 2.0  # more than 0.67: the places are not as well known


def test_the_slopes_are_those_of_finite_differences():
    bundle, _ = bundle_of(Place.of(views=4, points=30))
    J, by_depth, miss, _ = bundles._jacobians(bundle)
    for k in range(6):
        step = np.zeros((4, 6))
        step[2, k] = 1e-7
        moved = bundles._residuals(replace(bundle, Ts=nudged(bundle.Ts, step)))[0]
        own = (bundle.view == 2)[:, None] * J[..., k]
        anchors = (bundle.anchor[bundle.point] == 2)[:, None] * J[..., 6 + k]
        np.testing.assert_allclose((moved - miss) / 1e-7, own + anchors, atol=1e-3)
    moved = bundles._residuals(replace(bundle, depths=bundle.depths + 1e-7))[0]
    np.testing.assert_allclose((moved - miss) / 1e-7, by_depth, atol=2e-3)


def test_sparse_equations_and_those_in_pieces_give_the_same_places(
    monkeypatch: pytest.MonkeyPatch,
):
    start, _ = bundle_of(Place.of())
    dense = adjusted(start, steps=3)[0]
    monkeypatch.setattr(bundles, "DENSE", 0)
    monkeypatch.setattr(bundles, "MOST_AT_ONCE", 100)
    sparse = adjusted(start, steps=3)[0]
    np.testing.assert_allclose(sparse.Ts, dense.Ts, atol=1e-12)
    np.testing.assert_allclose(sparse.depths, dense.depths, atol=1e-12)


def test_a_point_at_infinity_is_seen_in_a_direction_wherever_the_camera_is():
    bundle, _ = bundle_of(Place.of(), off=0.0)
    far = replace(bundle, depths=np.zeros(len(bundle.depths)))
    rays = np.concatenate([far.rays, np.ones((len(far.rays), 1))], axis=1)
    R = far.Ts[:, :3, :3]
    turn = R[far.view] @ np.swapaxes(R[far.anchor[far.point]], 1, 2)
    np.testing.assert_allclose(points_in_views(far), np.einsum("nab,nb->na", turn, rays[far.point]))


def test_a_point_behind_a_camera_is_infinitely_far_from_where_it_is_seen():
    bundle, _ = bundle_of(Place.of(), off=0.0)
    Ts = bundle.Ts.copy()
    Ts[-1, :3, :3] = np.diag([-1.0, 1.0, -1.0]) @ Ts[-1, :3, :3]
    turned = replace(bundle, Ts=Ts)
    assert np.isinf(residual_lengths(turned)[turned.view == len(Ts) - 1]).all()
    assert np.isfinite(cost_of(turned))
    assert np.isfinite(adjusted(turned, steps=2)[0].Ts).all()


def test_an_adjustment_never_raises_the_cost_and_more_steps_lower_it():
    start, _ = bundle_of(Place.of(), outliers=0.05, off=0.03)
    costs = [cost_of(adjusted(start, steps)[0]) for steps in (0, 1, 3, 10, 30)]
    assert costs[0] == cost_of(start)
    assert all(after <= before for before, after in pairwise(costs))
    assert costs[-1] < 0.1 * costs[0]


def test_views_that_are_held_stay_to_the_last_digit():
    start, _ = bundle_of(Place.of())
    end = adjusted(start, steps=10)[0]
    np.testing.assert_array_equal(end.Ts[~start.free], start.Ts[~start.free])
    assert (end.Ts[start.free] != start.Ts[start.free]).any(axis=(1, 2)).all()


def test_with_all_views_held_the_depths_alone_are_found():
    place = Place.of()
    start, depths = bundle_of(place)
    held = replace(start, Ts=place.Ts, free=np.zeros(len(place.Ts), bool))
    end, spread = adjusted(held, steps=20)
    np.testing.assert_array_equal(end.Ts, place.Ts)
    assert 0.4 < np.median(np.abs(end.depths - depths) / spread) < 1.0


def test_a_point_that_few_see_stays_near_what_was_expected_of_its_depth():
    start, _ = bundle_of(Place.of())
    unseen = 3
    rows = np.flatnonzero(start.point != unseen)
    end, spread = adjusted(start.only(rows), steps=20)
    assert end.depths[unseen] == pytest.approx(start.mean[unseen])
    assert spread[unseen] == pytest.approx(start.spread[unseen])


def test_residuals_are_in_standard_deviations():
    start, depths = bundle_of(Place.of(), off=0.0)
    exact = replace(start, depths=depths)
    assert np.median(residual_lengths(exact)) == pytest.approx(1.18, rel=0.05)
    np.testing.assert_allclose(
        residual_lengths(replace(exact, noise=2 * start.noise)), residual_lengths(exact) / 2
    )


def test_an_outlier_hardly_moves_what_others_tell():
    start, _ = bundle_of(Place.of())
    right = adjusted(start, steps=20)[0]
    xy = start.xy.copy()
    xy[5] += 0.2  # 720 standard deviations
    astray = adjusted(replace(start, xy=xy), steps=20)[0]
    errors = [off_by(T, true) for T, true in zip(astray.Ts, right.Ts, strict=True)]
    assert max(turn for turn, _ in errors) < 0.01
    assert max(shift for _, shift in errors) < 0.003
