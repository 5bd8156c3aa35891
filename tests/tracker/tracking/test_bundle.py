"""Whole-segment refinement: nearer to the truth, its ends untouched, never wild."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.pose import moved
from keypose.tracker.body.trajectory import Trajectory, interpolate
from keypose.tracker.geometry.rotations import exp_rotation, transpose
from keypose.tracker.tracking.bundle import refine
from keypose.tracker.tracking.method import Refinement
from keypose.tracker.video.pyramid import IGNORED
from tests.tracker.tracking_cases import Case, case, clip_of

HOW = Refinement(solves=4, stride=2)


@pytest.fixture(scope="module")
def box() -> Case:
    return case("tumbling_box", 10, 20)


@pytest.fixture(scope="module")
def person() -> Case:
    return case("stride", 40, 48)


def disturbed(shown: Case, size: float, seed: int = 0) -> Trajectory:
    """The truth with every tracked motion of every inner pose off by about `size`."""
    rng = np.random.default_rng(seed)
    poses = [shown.truth.pose(k) for k in range(len(shown.truth))]
    for k in range(1, len(poses) - 1):
        poses[k] = moved(shown.skeleton, poses[k], rng.normal(0, size, shown.skeleton.dof_count))
    return Trajectory(
        0, np.stack([p.Rs_parent_part for p in poses]), np.stack([p.p_camera_root for p in poses])
    )


def same_ends(found: Trajectory, start: Trajectory) -> None:
    for k in (0, -1):
        np.testing.assert_array_equal(found.Rs_parent_part[k], start.Rs_parent_part[k])
        np.testing.assert_array_equal(found.ps_camera_root[k], start.ps_camera_root[k])


@pytest.mark.parametrize("name", ["box", "person"])
def test_a_disturbed_path_is_brought_back_to_the_truth(
    name: str, request: pytest.FixtureRequest
) -> None:
    shown: Case = request.getfixturevalue(name)
    start = disturbed(shown, 0.02)
    how = Refinement(solves=6, stride=2)
    found = refine(shown.scene(), shown.clip(), start, how)
    assert shown.error_cm(found) < 0.45 * shown.error_cm(start)
    same_ends(found, start)
    R = found.Rs_parent_part
    np.testing.assert_allclose(R @ transpose(R), np.broadcast_to(np.eye(3), R.shape), atol=1e-10)


@pytest.mark.parametrize("frames", [1, 2])
def test_without_inner_frames_there_is_nothing_to_refine(box: Case, frames: int) -> None:
    start = Trajectory(3, box.truth.Rs_parent_part[:frames], box.truth.ps_camera_root[:frames])
    assert refine(box.scene(), box.clip(), start, HOW) is start


@pytest.mark.parametrize("frames", [3, 4])
def test_one_and_two_inner_frames_are_refined(box: Case, frames: int) -> None:
    whole = disturbed(box, 0.02)
    R, t = whole.Rs_parent_part[:frames].copy(), whole.ps_camera_root[:frames].copy()
    R[-1], t[-1] = box.truth.Rs_parent_part[frames - 1], box.truth.ps_camera_root[frames - 1]
    start = Trajectory(0, R, t)
    found = refine(box.scene(), box.clip(), start, Refinement(solves=6, stride=2))
    assert box.error_cm(found) < 0.6 * box.error_cm(start)
    same_ends(found, start)


@pytest.mark.parametrize("value", [128, None], ids=["grey", "ignored"])
def test_without_anything_to_see_the_path_becomes_smooth_and_stays_finite(
    box: Case, value: int | None
) -> None:
    pictures: NDArray[np.uint8] = np.full_like(box.pictures, value or 0)
    usable = None if value else np.full(pictures.shape[1:3], IGNORED, np.uint8)
    start = disturbed(box, 0.02)
    found = refine(box.scene(), clip_of(pictures, usable), start, HOW)
    assert np.isfinite(found.Rs_parent_part).all()
    assert np.isfinite(found.ps_camera_root).all()
    same_ends(found, start)
    bends = [np.abs(np.diff(p.ps_camera_root, n=2, axis=0)).max() for p in (found, start)]
    assert bends[0] < 0.5 * bends[1]


def test_a_path_far_out_of_the_picture_stays_finite(box: Case) -> None:
    ps = box.truth.ps_camera_root + np.array([40.0, 0.0, 0.0])
    found = refine(box.scene(), box.clip(), Trajectory(0, box.truth.Rs_parent_part, ps), HOW)
    assert np.isfinite(found.ps_camera_root).all()


def test_the_refined_path_is_the_same_wherever_the_segment_begins(box: Case) -> None:
    start = disturbed(box, 0.02)
    clip = clip_of(box.pictures[2:9])
    later = Trajectory(102, start.Rs_parent_part[2:9], start.ps_camera_root[2:9])
    shifted = type(clip)(102, clip.levels)
    found = refine(box.scene(), shifted, later, HOW)
    here = refine(
        box.scene(), box.clip(), Trajectory(2, later.Rs_parent_part, later.ps_camera_root), HOW
    )
    assert found.first_frame == 102
    np.testing.assert_array_equal(found.Rs_parent_part, here.Rs_parent_part)


def test_interpolation_over_a_short_stretch_is_improved(person: Case) -> None:
    start = interpolate(person.truth.pose(0), person.truth.pose(8), 0, 8)
    turned = start.Rs_parent_part.copy()
    turned[4] = turned[4] @ exp_rotation([0.01, 0.0, 0.0])
    found = refine(person.scene(), person.clip(), Trajectory(0, turned, start.ps_camera_root), HOW)
    assert person.error_cm(found) < 0.6 * person.error_cm(start)
