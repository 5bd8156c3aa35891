"""Keypoints that were found when a segment was tracked, without a look at the film."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.keypoints.augmented import augmented_fingerprint
from keypose.tracker.keypoints.blazepose import NAMES, Seen
from keypose.tracker.keypoints.detect import DetectionWindow
from keypose.tracker.keypoints.lifted_depth import DepthLifter
from keypose.tracker.keypoints.model_files import FULL, HEAVY
from keypose.tracker.keypoints.region import Region
from keypose.tracker.tracking.cues import sources
from keypose.tracker.tracking.cues.sources import (
    DetectedKeypoints,
    GivenKeypoints,
    LiftedKeypoints,
    found_before,
)
from tests.tracker.keypoints.keypoint_cases import NO_MASK
from tests.tracker.tracking.cues.people import SKELETON, Filmed, moving

FILM = Filmed(moving())
POSED = {3: FILM.segment.start, 15: FILM.segment.end}


class Somebody:
    """A network that sees the same everywhere."""

    fingerprint = augmented_fingerprint(FULL)

    def infer(self, picture: np.ndarray, region: Region) -> Seen:
        uv = region.x + np.arange(66.0).reshape(33, 2)
        return Seen(uv, np.full(33, 0.9), np.zeros((33, 3)), 1.0, region, NO_MASK)


class Pictures:
    def frame(self, number: int) -> np.ndarray:
        return np.zeros((FILM.camera.height, FILM.camera.width, 3), np.uint8)


class Kept(dict[str, DetectionWindow]):
    def put(self, key: str, stretch: DetectionWindow) -> None:
        self[key] = stretch


@pytest.fixture
def kept(monkeypatch: pytest.MonkeyPatch) -> Kept:
    """What was found when the segment was tracked."""
    monkeypatch.setattr(sources, "_network", lambda model: Somebody())
    kept = Kept()
    source = DetectedKeypoints(Pictures(), FILM.camera, "film", kept)  # type: ignore[arg-type]
    assert source.over(FILM.segment, SKELETON, lambda: None) is not None
    return kept


def test_they_are_those_that_tracking_found(kept: Kept) -> None:
    found = found_before(POSED, SKELETON, FILM.camera, "film", kept, FULL)
    assert found is not None
    assert (found.first_frame, found.last_frame, found.names) == (3, 15, NAMES)
    assert (found.visibility == 0.9).all()


def test_there_are_none_of_another_film_network_pose_or_before_the_first_track(kept: Kept) -> None:
    elsewhere = {3: FILM.segment.start, 15: FILM.truth.pose(9)}
    for posed, film, where, model in (
        (POSED, "other", kept, FULL),
        (POSED, "film", kept, HEAVY),
        (elsewhere, "film", kept, FULL),
        (POSED, "film", Kept(), FULL),
    ):
        assert found_before(posed, SKELETON, FILM.camera, film, where, model) is None


def test_a_segments_depth_is_lifted_with_what_is_seen_before_and_after_it() -> None:
    lifter = DepthLifter(FILM.camera, np.arange(30) / 30)
    whole = lifter.of(FILM.keypoints, SKELETON.body)
    inside = replace(FILM.segment, first_frame=6, last_frame=10)
    given = GivenKeypoints(FILM.keypoints)
    for around, as_whole in ((FILM.keypoints, True), (None, False), (whole.over(3, 9), False)):
        source = LiftedKeypoints(given, lifter, around)
        found = source.over(inside, SKELETON, lambda: None)
        assert found is not None
        assert found.p_hips is not None
        assert whole.p_hips is not None
        np.testing.assert_array_equal(found.uv, FILM.keypoints.over(6, 10).uv)
        assert np.allclose(found.p_hips, whole.p_hips[3:8], atol=1e-6) == as_whole
