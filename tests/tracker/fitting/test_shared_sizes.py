"""Sizes that several poses share are solved for together with them, to known truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.fitting.sizes.proposals import _between
from keypose.tracker.fitting.sizes.residuals import joint_rows
from keypose.tracker.fitting.sizes.shared import (
    Residuals,
    Shared,
    SharedFit,
    _cost,
    _pose_jacobian,
    _size_jacobian,
    solve,
)
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation
from tests.tracker.tracking_cases import CAMERA, TELEPHOTO

BODY = preset("adult_male")
PROPORTIONS = Proportions.of(BODY)
POSES = 3
STEPS = 12
WIDE_SHARE = 0.3
"""A prior so wide that what is seen decides."""


def poses() -> tuple[Pose, ...]:
    """Somebody before the camera, bent at every joint a little."""
    rng = np.random.default_rng(3)
    parts = len(BODY.parts)
    return tuple(
        Pose(exp_rotation(rng.normal(0, 0.2, (parts, 3))), np.array([0.1 * k, 0.0, 4.0]))
        for k in range(POSES)
    )


def fit(camera: Camera = CAMERA, focal: bool = False, zoom: Array | None = None) -> SharedFit:
    posed = poses()
    perspective = camera.projection == "perspective"
    free = np.ones(PROPORTIONS.count + 2, np.bool_)
    free[-2:] = focal, perspective
    share = np.full(len(free), WIDE_SHARE)
    zoom = np.ones(POSES) if zoom is None else zoom
    allowed = Limits.of(BODY).widened([pose.Rs_parent_part for pose in posed])
    return SharedFit(PROPORTIONS, camera, posed, zoom, allowed, free, share, share)


def start(made: SharedFit) -> Shared:
    return Shared(np.zeros(len(made.free)), made.posed)


def surface_rows(made: SharedFit, truth: Shared, k: int) -> Residuals:
    """Points on all sides of every part, seen along x and y where they truly are."""
    parts, points = [], []
    for i, part in enumerate(BODY.parts):
        length, radius = part.shape.length_m, part.shape.width_m / 2
        for along in (0.1, 0.5, 1.0):
            for x, z in ((radius, 0.0), (-radius, 0.0), (0.0, radius), (0.0, -radius)):
                parts += [i, i]
                points += 2 * [(x, along * length, z)]
    normals = np.tile(np.eye(2), (len(parts) // 2, 1))
    rows = Residuals(
        np.array(parts), np.array(points), normals, np.zeros(len(parts)), np.full(len(parts), 0.3)
    )
    return replace(rows, target=rows.along(made.pixels(truth, k, rows)))


# --- sizes of a body


def test_the_trunk_is_what_has_no_other_side() -> None:
    trunk = {BODY.names[i] for i in np.flatnonzero(PROPORTIONS.is_trunk)}
    assert trunk == {"waist", "chest", "neck", "head"}
    assert not Proportions.of(preset("box")).is_trunk.any(), "a thing has no sides at all"


def test_a_length_stretches_along_the_part_and_a_thickness_across_it() -> None:
    sizes = np.zeros(PROPORTIONS.count)
    group = PROPORTIONS.names.index("forearm")
    sizes[2 * group : 2 * group + 2] = np.log([1.2, 0.9])
    ratios = PROPORTIONS.ratios(sizes)
    for i, name in enumerate(BODY.names):
        expected = (0.9, 1.2, 0.9) if name.endswith("forearm") else (1.0, 1.0, 1.0)
        np.testing.assert_allclose(ratios[i], expected, err_msg=name)


# --- how what is seen follows from what is unknown


@pytest.mark.parametrize("camera", [CAMERA, TELEPHOTO], ids=["perspective", "telephoto"])
def test_slopes_agree_with_differences(camera: Camera) -> None:
    made, rng = fit(camera), np.random.default_rng(5)
    shared = made.with_step(start(made), 0.05 * rng.normal(size=len(made.free)) * made.free)
    rows = surface_rows(made, start(made), 1)
    there = made.pixels(shared, 1, rows)
    J = _pose_jacobian(made, shared, 1, rows)
    skeleton = PROPORTIONS.skeleton
    for d in rng.choice(skeleton.dof_count, 12, replace=False):
        step = np.zeros(skeleton.dof_count)
        step[d] = 1e-5
        pose = moved(skeleton, shared.poses[1], step)
        beside = replace(shared, poses=(shared.poses[0], pose, shared.poses[2]))
        slope = rows.along(made.pixels(beside, 1, rows) - there) / 1e-5
        np.testing.assert_allclose(J[:, d], slope, atol=0.02 * np.abs(slope).max() + 1e-3)
    S = _size_jacobian(made, shared, 1, rows, there)
    step = np.zeros(len(made.free))
    step[2] = 1e-3
    linear = S @ step
    moved_px = rows.along(made.pixels(made.with_step(shared, step), 1, rows) - there)
    np.testing.assert_allclose(linear, moved_px, atol=0.02 * np.abs(moved_px).max())


def test_a_longer_lens_and_a_greater_distance_show_the_body_as_large_as_before() -> None:
    made = fit(focal=True)
    rows = surface_rows(made, start(made), 0)
    step = np.zeros(len(made.free))
    step[-2] = 0.2
    longer = made.with_step(start(made), step)
    assert made.lens(longer, 0).fx == pytest.approx(CAMERA.fx * np.exp(0.2))
    assert longer.poses[0].p_camera_root[2] == pytest.approx(4.0 * np.exp(0.2))
    apart = made.pixels(longer, 0, rows) - made.pixels(start(made), 0, rows)
    assert np.abs(apart).max() < 6.0, "nearly: perspective alone differs"


def test_a_zoomed_picture_is_seen_with_its_own_lens() -> None:
    made = fit(zoom=np.array([1.0, 1.5, 0.8]))
    assert [made.lens(start(made), k).fx for k in range(POSES)] == pytest.approx(
        [CAMERA.fx, 1.5 * CAMERA.fx, 0.8 * CAMERA.fx]
    )


# --- what is found


def true_sizes(made: SharedFit) -> Shared:
    """Longer forearms, thicker thighs."""
    values = np.zeros(len(made.free))
    values[2 * PROPORTIONS.names.index("forearm")] = np.log(1.08)
    values[2 * PROPORTIONS.names.index("thigh") + 1] = np.log(1.15)
    return Shared(values, made.posed)


@pytest.mark.parametrize("camera", [CAMERA, TELEPHOTO], ids=["perspective", "telephoto"])
def test_true_sizes_are_found_from_where_surfaces_are_seen(camera: Camera) -> None:
    made = fit(camera)
    truth = true_sizes(made)
    rows = [surface_rows(made, truth, k) for k in range(POSES)]
    found = solve(made, start(made), rows, STEPS)
    np.testing.assert_allclose(found.shared.sizes, truth.sizes, atol=0.02)
    assert _cost(made, found.shared, rows) < 0.1 * _cost(made, start(made), rows)
    assert (found.spread[:-2] < 0.05).all()


def test_what_is_not_free_stays_to_the_last_digit() -> None:
    made = fit()
    free = made.free.copy()
    free[4:] = False
    truth = true_sizes(made)
    rows = [surface_rows(made, truth, k) for k in range(POSES)]
    found = solve(replace(made, free=free, poses_free=False), start(made), rows, STEPS).shared
    np.testing.assert_array_equal(found.values[4:], 0.0)
    for pose, posed in zip(found.poses, made.posed, strict=True):
        np.testing.assert_array_equal(pose.Rs_parent_part, posed.Rs_parent_part)
        np.testing.assert_array_equal(pose.p_camera_root, posed.p_camera_root)


def test_a_tenth_of_the_points_elsewhere_hardly_matters() -> None:
    made = fit()
    truth = true_sizes(made)
    rows = [surface_rows(made, truth, k) for k in range(POSES)]
    rng = np.random.default_rng(7)
    spoilt = [replace(r, target=r.target + 40.0 * (rng.random(len(r.target)) < 0.1)) for r in rows]
    found = solve(made, start(made), spoilt, STEPS)
    np.testing.assert_allclose(found.shared.sizes, truth.sizes, atol=0.04)


def test_without_anything_seen_all_stays_and_nothing_is_known() -> None:
    made = fit()
    none = Residuals(
        np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 2)), np.zeros(0), np.zeros(0)
    )
    found = solve(made, start(made), [none] * POSES, STEPS)
    np.testing.assert_allclose(found.shared.values, 0.0, atol=1e-12)
    assert found.spread[0] == pytest.approx(WIDE_SHARE, rel=0.35)


def test_behind_the_camera_nothing_can_be() -> None:
    made = fit()
    rows = [surface_rows(made, start(made), k) for k in range(POSES)]
    behind = tuple(Pose(p.Rs_parent_part, p.p_camera_root * (1, 1, -1)) for p in made.posed)
    assert _cost(made, Shared(np.zeros(len(made.free)), behind), rows) == np.inf


def test_joints_as_posed_pull_at_nothing() -> None:
    made = fit(zoom=np.array([1.0, 1.3, 0.9]))
    for k in range(POSES):
        rows = joint_rows(made, k)
        away = rows.along(made.pixels(start(made), k, rows)) - rows.target
        np.testing.assert_allclose(away, 0.0, atol=1e-9)


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_a_share_of_the_way_between_two_poses_is_that_share_of_every_turn(share: float) -> None:
    start_pose, end = poses()[:2]
    between = _between(start_pose, end, share)
    whole, part = (
        log_rotation(np.swapaxes(start_pose.Rs_parent_part, -1, -2) @ pose.Rs_parent_part)
        for pose in (end, between)
    )
    np.testing.assert_allclose(part, share * whole, atol=1e-9)
    way = end.p_camera_root - start_pose.p_camera_root
    np.testing.assert_allclose(between.p_camera_root, start_pose.p_camera_root + share * way)
