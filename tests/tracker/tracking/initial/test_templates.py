"""Points on the limbs followed from both keyframes: where they are, and what is said to be lost."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.tracking.initial.templates import LimbTracks, limb_tracks
from keypose.tracker.tracking.initial.templates.follow_point import Course, combine_courses
from keypose.tracker.tracking.initial.templates.tracks import followed_points, two_link_limbs
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from tests.tracker import tracking_cases as cases

Floats = NDArray[np.float64]

SIDES = ("left", "right")


@lru_cache(maxsize=1)
def shelf() -> tuple[cases.Case, Scene, Segment]:
    """The way of an arm down from a shelf."""
    shown = cases.case("shelf", 16, 34)
    return shown, shown.scene(), cases.segment_of(shown)


@lru_cache(maxsize=1)
def found() -> LimbTracks:
    _, scene, segment = shelf()
    return limb_tracks(scene, segment)


def errors(shown: cases.Case, tracks: LimbTracks) -> Floats:
    """(L, N) pixels from where the points truly are seen; NaN where lost."""
    T = shown.truth.transforms(shown.skeleton)[:, tracks.parts]
    p = np.einsum("nlab,lb->lna", T[..., :3, :3], tracks.points) + T[..., :3, 3].swapaxes(0, 1)
    return np.asarray(np.linalg.norm(tracks.uv - shown.camera.project(p), axis=-1))


def rows(shown: cases.Case, tracks: LimbTracks, part: str) -> NDArray[np.int64]:
    return np.flatnonzero(tracks.parts == shown.skeleton.body.index(part))


def test_hands_feet_head_elbows_and_knees_are_followed_from_both_keyframes() -> None:
    shown, _, _ = shelf()
    names = [shown.skeleton.body.names[part] for part in found().parts]
    once = ["head"] + [f"{s}_{p}" for p in ("hand", "foot", "forearm", "shin") for s in SIDES]
    assert sorted(names) == sorted(2 * once)


def test_what_is_reported_is_reported_to_a_pixel_or_so_and_to_a_fraction_of_one_mostly() -> None:
    shown, _, _ = shelf()
    miss = errors(shown, found())
    seen = np.isfinite(miss)
    assert np.median(miss[seen]) < 0.6
    assert np.percentile(miss[seen], 95) < 3.0
    near = rows(shown, found(), "left_hand")  # the fast one
    assert np.isfinite(miss[near]).any(axis=0).all()
    assert np.nanmin(miss[near], axis=0).max() < 3.0


def test_how_far_a_place_may_be_wrong_is_honest() -> None:
    shown, _, _ = shelf()
    miss, tracks = errors(shown, found()), found()
    seen = np.isfinite(miss)
    assert (np.isfinite(tracks.sigma_px) == seen).all()
    off = miss[seen] / tracks.sigma_px[seen]
    assert np.mean(off > 3.5) < 0.03
    assert np.sqrt(np.mean(off**2) / 2) < 1.5


def test_a_part_that_no_keyframe_shows_is_not_guessed() -> None:
    shown, _, _ = shelf()
    hidden = rows(shown, found(), "right_hand")
    assert np.isnan(found().uv[hidden, 1:-1]).all()
    words = "right hand was not found between the keyframes: followed from both keyframes there"
    assert words in found().notes


def test_a_limb_that_is_left_out_has_no_tracks() -> None:
    shown, scene, segment = shelf()
    tracks = limb_tracks(scene, segment, ("left_upper_arm", "head"))
    for part in ("left_hand", "left_forearm", "head"):
        assert not len(rows(shown, tracks, part))
    assert len(rows(shown, tracks, "right_hand")) == 2


def test_while_nothing_is_to_be_seen_every_place_is_lost_and_found_again_behind() -> None:
    shown, scene, segment = shelf()
    pictures = shown.pictures.copy()
    pictures[8:11] = 0
    tracks = limb_tracks(scene, replace(segment, clip=cases.clip_of(pictures)))
    assert np.isnan(tracks.uv[:, 8:11]).all()
    for foot in rows(shown, tracks, "left_foot"):
        assert np.isfinite(tracks.uv[foot, [6, 12]]).all()
    assert any("left foot lost at frame 8, 3 frames" in note for note in tracks.notes)


def test_a_body_of_one_part_has_no_limbs_to_follow() -> None:
    shown = cases.case("tumbling_box", 0, 4)
    tracks = limb_tracks(shown.scene(), cases.segment_of(shown))
    assert tracks.uv.shape == (0, 5, 2)
    assert tracks.points.shape == (0, 3)
    assert tracks.notes == ()


def test_any_tree_of_parts_has_its_ends_followed() -> None:
    chain = cases.deep_chain(5)
    (limb,) = two_link_limbs(chain)
    assert (limb.upper, limb.lower, limb.leaf) == (2, 3, 4)
    assert [point.part for point in followed_points(chain)] == [4, 3]
    assert followed_points(chain, ("bone1",)) == []


def course(uv: Floats, known: list[int]) -> Course:
    return Course(uv, np.full(len(uv), 0.2), np.isin(np.arange(len(uv)), known))


def straight(count: int = 20) -> Floats:
    return np.column_stack([np.arange(count), np.zeros(count)]).astype(float)


def test_courses_that_meet_bear_each_other_out_and_offset_points_still_meet() -> None:
    offset = np.tile([7.0, -4.0], (20, 1))
    forward, backward = course(straight(), [0]), course(straight() + offset, [19])
    uv, sigma = combine_courses(forward, backward, offset)
    np.testing.assert_array_equal(uv[0], straight())
    np.testing.assert_array_equal(uv[1], straight() + offset)
    assert np.isfinite(sigma).all()
    assert sigma[0, 0] < sigma[0, -1]
    assert sigma[1, -1] < sigma[1, 0]


def test_a_course_that_slips_is_believed_as_far_as_it_was_borne_out() -> None:
    astray = straight()
    astray[8:, 1] += 30.0
    forward, backward = course(astray, [0, 1, 2, 3]), course(straight(), [19])
    uv, sigma = combine_courses(forward, backward, np.zeros((20, 2)))
    assert np.isfinite(uv[0, :8]).all()
    assert np.isnan(uv[0, 12:]).all()  # a few frames beyond are believed a little
    np.testing.assert_array_equal(uv[1, 12:], straight()[12:])
    assert np.isinf(sigma[0, 12:]).all()


def test_two_courses_known_to_be_right_that_contradict_each_other_are_neither_believed() -> None:
    other = straight()
    other[5:15, 1] += 20.0
    everywhere = list(range(20))
    uv, _ = combine_courses(
        course(straight(), everywhere), course(other, everywhere), np.zeros((20, 2))
    )
    assert np.isnan(uv[:, 5:15]).all()
    assert np.isfinite(uv[:, :5]).all()


def test_a_point_that_only_its_keyframe_shows_is_reported_there_alone() -> None:
    alone = Course.at_its_start(np.array([3.0, 4.0]), 12)
    gone = Course.at_its_start(np.array([9.0, 4.0]), 12).reversed()
    uv, _ = combine_courses(alone, gone, np.zeros((12, 2)))
    assert np.isfinite(uv[0, :, 0]).sum() == 1
    assert np.isfinite(uv[1, :, 0]).sum() == 1


def test_a_point_that_its_keyframe_cannot_show_is_reported_nowhere() -> None:
    nowhere = Course(np.full((6, 2), np.nan), np.full(6, np.inf), np.zeros(6, bool))
    uv, sigma = combine_courses(nowhere, course(straight(6), [5]), np.zeros((6, 2)))
    assert np.isnan(uv[0]).all()
    assert np.isinf(sigma[0]).all()


@pytest.mark.parametrize("seed", range(3))
def test_random_bodies_are_followed_or_said_to_be_lost(seed: int) -> None:
    skeleton = cases.random_body(seed)
    truth = cases.random_trajectory(skeleton, seed, 6, size=0.01)
    rng = np.random.default_rng(seed)
    pictures = rng.integers(0, 256, (6, cases.HEIGHT, cases.WIDTH, 3)).astype(np.uint8)
    scene = cases.scene_of(skeleton, poses=[truth.pose(0)])
    segment = Segment(0, 5, truth.pose(0), truth.pose(5), cases.clip_of(pictures))
    tracks = limb_tracks(scene, segment)
    assert np.isnan(tracks.uv[:, 1:-1]).mean() > 0.7  # noise shows nothing
    assert len(tracks.notes) > 0
