"""Keypoints become anchors: corrected by the keyframes, and kept off other bodies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.solver.pose_terms import DepthFromRoot, PointsInPicture
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.robust import SQUARED
from keypose.tracker.tracking.cues.anchors import keyframe_off_person, with_free_joints
from tests.tracker.tracking.cues.people import BENT, CAMERA, SKELETON, Filmed, moving


@pytest.mark.parametrize("camera", [CAMERA, BENT], ids=["ideal lens", "distorted lens"])
def test_the_offsets_of_a_detector_are_learned_at_the_keyframes(camera: Camera) -> None:
    film = Filmed(moving(), camera)
    (anchors,) = film.anchors()
    p = anchors.points.at(film.truth.transforms(SKELETON))
    missed = np.linalg.norm(image_points(film.free.camera, p) - anchors.uv, axis=-1)
    plain = (
        Filmed(moving(), camera, np.zeros(3))
        .anchors()[0]
        .points.at(film.truth.transforms(SKELETON))
    )
    unlearned = np.linalg.norm(image_points(film.free.camera, plain) - anchors.uv, axis=-1)
    assert missed.mean() < 0.6 * unlearned.mean()
    assert missed[[0, -1]].max() < 0.5


def test_a_detectors_depth_is_what_the_keyframes_say_at_both_ends_and_linear_between() -> None:
    film = Filmed(moving())
    (anchors,) = film.anchors()
    p = anchors.points.at(film.truth.transforms(SKELETON))
    depth = p[..., 2] - film.truth.ps_camera_root[:, None, 2]
    np.testing.assert_allclose(anchors.depth[[0, -1]], depth[[0, -1]], atol=0.02)
    assert np.abs(anchors.depth - depth).max() < 0.05  # of a detector that is 11 cm off


def test_keypoints_that_lie_on_another_person_are_not_used() -> None:
    film = Filmed(moving())
    height = film.anchors()[0].height_px
    beside = replace(film.keypoints, uv=film.keypoints.uv + np.array([0.15 * height, 0.0]))
    assert film.anchors(beside) == ()
    near = replace(film.keypoints, uv=film.keypoints.uv + np.array([0.05 * height, 0.0]))
    assert len(film.anchors(near)) == 1


def test_a_keyframe_is_told_that_is_off_the_person_whom_the_other_keyframe_is_on() -> None:
    film = Filmed(moving())
    ends = film.segment.first_frame, film.segment.last_frame
    assert off_person(film, []) is None
    for end in (0, 1):
        assert off_person(film, [end]) == ends[end]
    assert off_person(film, [0, 1]) is None, "another person"


def off_person(film: Filmed, shifted: list[int]) -> int | None:
    """The keyframe that is told where keypoints at some ends, 0 or 1, lie beside the body."""
    height, uv = film.anchors()[0].height_px, film.keypoints.uv.copy()
    for end in shifted:
        uv[-end] += np.array([0.15 * height, 0.0])
    seen = replace(film.keypoints, uv=uv)
    return keyframe_off_person(film.free, film.segment, CAMERA, seen)


def test_what_is_not_seen_does_not_count() -> None:
    film = Filmed(moving())
    uv, visibility = film.keypoints.uv.copy(), film.keypoints.visibility.copy()
    uv[4, 2] = np.nan
    visibility[5] = 0.0
    (anchors,) = film.anchors(replace(film.keypoints, uv=uv, visibility=visibility))
    assert anchors.scale[4, 2] == 0.0
    assert anchors.depth_scale[4, 2] == 0.0
    np.testing.assert_allclose(anchors.scale[5] * 3, anchors.scale[6])
    assert np.isfinite(anchors.uv).all()


def test_keypoints_without_depth_are_compared_in_the_picture_alone() -> None:
    film = Filmed(moving())
    (flat,) = film.anchors(replace(film.keypoints, p_hips=None))
    kinds = [type(term) for term in flat.terms(CAMERA, SQUARED, slice(1, -1))]
    assert kinds == [PointsInPicture]
    (deep,) = film.anchors()
    kinds = [type(term) for term in deep.terms(CAMERA, SQUARED, slice(1, -1))]
    assert kinds == [PointsInPicture, DepthFromRoot]


def test_a_body_with_few_of_these_joints_has_no_anchors() -> None:
    film = Filmed(moving())
    some = replace(film.keypoints, names=tuple("nose" if n in JOINTS[:9] else n for n in JOINTS))
    assert film.anchors(some) == ()


def test_parts_that_carry_keypoints_may_turn_in_every_way_and_others_as_before() -> None:
    free = with_free_joints(SKELETON)
    counts = dict(zip(SKELETON.body.names, np.bincount(free.dof_part, minlength=16), strict=True))
    before = np.bincount(SKELETON.dof_part, minlength=16)
    assert counts["waist"] == 6
    assert counts["left_upper_arm"] == counts["right_thigh"] == counts["left_shin"] == 3
    assert counts["head"] == 3
    assert counts["left_hand"] == before[SKELETON.body.index("left_hand")] == 0


def test_a_limb_that_is_seen_elsewhere_for_some_frames_does_not_count_there() -> None:
    film = Filmed(moving())
    (right,) = film.anchors()
    uv = film.keypoints.uv.copy()
    foot = JOINTS.index("right_ankle")
    uv[5:8, foot] += (0.0, 0.2 * right.height_px)
    (anchors,) = film.anchors(replace(film.keypoints, uv=uv))
    expected = right.scale > 0
    expected[5:8, foot] = False
    np.testing.assert_array_equal(anchors.scale > 0, expected)
    assert (anchors.visibility[5:8, foot] == 0).all()
    by_hand = np.zeros(film.keypoints.visibility.shape, np.bool_)
    by_hand[5:8, foot] = True
    (set_there,) = film.anchors(replace(film.keypoints, uv=uv, by_hand=by_hand))
    assert set_there.known.all()
