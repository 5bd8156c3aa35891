"""What is left of keypoints when their shaking is taken out: errors that last, and what is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from keypose.tracker.solver.projection import image_points
from keypose.tracker.tracking.cues.anchors import Anchors
from keypose.tracker.tracking.cues.reweighting import smoothed_keypoints
from tests.tracker.tracking.cues.people import Filmed, Floats, moving

FILM = Filmed(moving(count=61))
ANCHORS = FILM.anchors()[0]
TRUE_UV = image_points(
    FILM.free.camera, ANCHORS.points.at(FILM.truth.transforms(FILM.free.skeleton))
)


def with_errors(off: Floats) -> Anchors:
    """Anchors that are off the true motion by so many pixels, (N, K, 2)."""
    return replace(ANCHORS, uv=TRUE_UV + off)


def left(anchors: Anchors) -> Floats:
    """(N, K, 2) by how much they are off the true motion once they are steadied beside it."""
    return np.asarray(smoothed_keypoints(anchors, FILM.free, FILM.truth).uv - TRUE_UV)


def test_shaking_goes_and_what_lasts_stays() -> None:
    shaking = np.random.default_rng(3).normal(0.0, 1.0, TRUE_UV.shape)
    assert left(with_errors(shaking)).std() < 0.4
    lasting = np.broadcast_to((1.5, -2.0), TRUE_UV.shape)
    np.testing.assert_allclose(left(with_errors(lasting)), lasting, atol=1e-9)


def test_a_keypoint_that_is_elsewhere_for_a_frame_moves_none_of_its_neighbours() -> None:
    off = np.zeros(TRUE_UV.shape)
    off[30, 4] = 60.0, 30.0
    found = np.linalg.norm(left(with_errors(off)), axis=-1)
    assert found.max() < 0.5
    assert not found[:, np.arange(found.shape[1]) != 4].any()


def test_what_is_not_seen_says_nothing_and_what_a_person_set_stays() -> None:
    off = np.zeros(TRUE_UV.shape)
    off[20:30] = 40.0, 0.0
    by_hand = np.zeros(ANCHORS.scale.shape)
    by_hand[20:30] = 1.0
    given = replace(with_errors(off), scale=ANCHORS.scale * (by_hand == 0), by_hand=by_hand)
    np.testing.assert_allclose(left(given), off, atol=1e-9)
