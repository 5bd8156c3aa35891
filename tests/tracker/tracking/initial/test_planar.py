"""A first trajectory from templates and planar limbs: nearer than interpolation, or it says why."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.tracking.drift import closing_error
from keypose.tracker.tracking.initial.planar import planar_start, two_link_angles
from keypose.tracker.tracking.initial.templates import Start
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from tests.tracker import tracking_cases as cases


@lru_cache(maxsize=1)
def shelf() -> tuple[cases.Case, Scene, Segment]:
    """An arm reaches up and takes something down; posed at both ends only."""
    shown = cases.case("shelf", 0, 38)
    return shown, shown.scene(), cases.segment_of(shown)


@lru_cache(maxsize=1)
def found() -> Start:
    _, scene, segment = shelf()
    return planar_start(scene, segment)


def joint_cm(shown: cases.Case, start: Start, part: str) -> float:
    """Largest distance of a part's joint from the truth."""
    i = shown.skeleton.body.index(part)
    miss = start.trajectory.joints(shown.skeleton)[:, i] - shown.truth.joints(shown.skeleton)[:, i]
    return float(100 * np.linalg.norm(miss, axis=-1).max())


@pytest.mark.parametrize("seed", range(5))
def test_two_links_end_where_they_are_asked_to_the_second_bent_to_one_side(seed: int) -> None:
    rng = np.random.default_rng(seed)
    L1, L2 = rng.uniform(0.2, 0.5, 2)
    away, angle = rng.uniform(abs(L1 - L2), L1 + L2, 50), rng.uniform(-np.pi, np.pi, 50)
    p = away[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    first, bend = two_link_angles(p, L1, L2)
    assert (bend >= 0).all()
    ends = L1 * np.stack([np.cos(first), np.sin(first)], -1)
    ends += L2 * np.stack([np.cos(first + bend), np.sin(first + bend)], -1)
    np.testing.assert_allclose(ends, p, atol=1e-9)


def test_two_links_stretch_towards_what_is_out_of_reach_and_fold_before_what_is_too_near() -> None:
    first, bend = two_link_angles(np.array([[0.0, 3.0], [0.1, 0.0]]), 0.5, 0.3)
    assert bend[0] == 0.0
    assert first[0] == pytest.approx(np.pi / 2)
    assert bend[1] == pytest.approx(np.pi)


def test_an_arm_that_goes_a_long_way_round_is_followed_where_interpolation_stays_below() -> None:
    shown, _, _ = shelf()
    plain = Start(cases.plain(shown), ())
    assert joint_cm(shown, plain, "left_hand") > 60
    assert joint_cm(shown, found(), "left_hand") < 6
    assert shown.error_cm(found().trajectory) < 0.25 * shown.error_cm(plain.trajectory)


def test_both_keyframes_are_met_exactly() -> None:
    _, _, segment = shelf()
    assert closing_error(found().trajectory, segment.start, segment.end) == 0.0
    assert (found().trajectory.first_frame, found().trajectory.last_frame) == (0, 38)


def test_a_hand_that_the_first_keyframe_hides_is_said_to_be() -> None:
    assert "right hand is hidden at frame 0: interpolated instead" in found().notes


@pytest.mark.parametrize("name", ["left_hand", "left_upper_arm"])
def test_a_limb_that_is_left_out_stays_as_interpolated_and_nothing_is_said(name: str) -> None:
    shown, scene, segment = shelf()
    start = planar_start(scene, segment, (name,))
    plain = cases.plain(shown)
    for part in ("left_upper_arm", "left_forearm"):
        i = shown.skeleton.body.index(part)
        np.testing.assert_array_equal(
            start.trajectory.Rs_parent_part[:, i], plain.Rs_parent_part[:, i]
        )
    assert not any("left hand" in note for note in start.notes)


def test_an_arm_that_points_at_the_camera_does_not_move_in_the_picture_s_plane() -> None:
    shown, scene, segment = shelf()
    i = shown.skeleton.body.index("left_upper_arm")
    Rs = segment.end.Rs_parent_part.copy()
    Rs[i] = exp_rotation([0.0, 0.0, -1.5])  # sideways: the body is seen from the side
    Rs[i + 1] = np.eye(3)
    end = Pose(Rs, segment.end.p_camera_root)
    start = planar_start(scene, replace(segment, end=end))
    words = "left hand does not move in the picture's plane: interpolated instead"
    assert words in start.notes
    assert closing_error(start.trajectory, segment.start, end) == 0.0


def test_a_hand_that_vanishes_on_its_way_is_lost_where_it_does() -> None:
    shown, scene, segment = shelf()
    pictures = shown.pictures.copy()
    pictures[12:30] = 0  # for longer than a hidden part is taken to move on
    start = planar_start(scene, replace(segment, clip=cases.clip_of(pictures)))
    assert "left hand lost at frame 12: interpolated instead" in start.notes
    assert closing_error(start.trajectory, segment.start, segment.end) == 0.0


def test_a_body_without_limbs_is_interpolated() -> None:
    shown = cases.case("tumbling_box", 0, 6)
    start = planar_start(shown.scene(), cases.segment_of(shown))
    assert start.notes == ("the body has no limbs of two links: interpolated instead",)
    np.testing.assert_array_equal(
        start.trajectory.Rs_parent_part, cases.plain(shown).Rs_parent_part
    )


def test_neighbouring_keyframes_need_nothing_in_between() -> None:
    shown = cases.case("shelf", 0, 1)
    segment = cases.segment_of(shown)
    start = planar_start(shown.scene(), segment)
    assert closing_error(start.trajectory, segment.start, segment.end) == 0.0
