"""What one keyframe more is expected to mend, for evidence made up to be clear."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass, interpolate
from keypose.tracker.tracking.cycle import Outcome
from keypose.tracker.tracking.diagnostics.expected_gain import LOST_EXTENT, expected_gain
from keypose.tracker.tracking.diagnostics.observability import Observation, unobserved
from keypose.tracker.video.pyramid import Clip
from tests.tracker.tracking_cases import scene_of

N = 20
SKELETON = Skeleton.of(preset("adult_male"))
POSE = Pose.rest(SKELETON, (0.0, 0.0, 6.0))
SCENE = scene_of(SKELETON, poses=[POSE])
MARKS = len(SCENE.marks[1])
PATH = interpolate(POSE, Pose.rest(SKELETON, (0.2, 0.0, 6.0)), 100, 100 + N)
NOBODY_LOOKED = unobserved(SCENE, Clip(100, ()), PATH)


def gain(
    drift: NDArray[np.float64], apart_px: float = 3.0, seen: Observation = NOBODY_LOOKED,
    followed: bool = True,
) -> NDArray[np.float64]:  # fmt: skip
    """drift: (N,) pixels of every pair of frames, alike at all marks."""
    drift_px = np.tile(np.asarray(drift, float)[:, None], (1, MARKS))
    apart = np.full((N + 1, MARKS), apart_px)
    passes = (Pass("pass", PATH, 3.0),)
    return expected_gain(
        SCENE, Outcome(passes, 0, apart, drift_px, followed, False, 0.0), seen
    )  # fmt: skip


def seen_by(share: float) -> Observation:
    observability = np.full((N, SKELETON.part_count), share)
    found = replace(NOBODY_LOOKED.diagnostics, observability=observability)
    return replace(NOBODY_LOOKED, diagnostics=found)


def test_where_there_is_a_keyframe_another_one_mends_nothing() -> None:
    found = gain(np.ones(N))
    assert found.shape == (N + 1,)
    assert found[0] == found[-1] == 0
    assert (found[1:-1] > 0).all()


def test_even_drift_is_best_mended_in_the_middle() -> None:
    found = gain(np.ones(N))
    assert found.argmax() == N // 2
    np.testing.assert_allclose(found, found[::-1], atol=1e-9)


def test_a_keyframe_helps_more_where_the_drift_was() -> None:
    early = np.full(N, 0.1)
    early[2:5] = 4.0
    assert gain(early).argmax() < N // 2
    assert gain(early[::-1]).argmax() == N - gain(early).argmax()


def test_the_more_drift_and_the_further_apart_the_chains_the_more_is_to_be_mended() -> None:
    ones = np.ones(N)
    assert gain(3 * ones).max() > 1.5 * gain(ones).max()
    assert gain(ones, apart_px=12).max() > 1.5 * gain(ones, apart_px=1.0).max()


def test_where_nothing_drifted_nothing_is_to_be_mended() -> None:
    assert gain(np.zeros(N)).max() == 0


def test_drift_alone_gives_where_nothing_was_followed_from_both_keyframes() -> None:
    assert gain(np.ones(N), apart_px=0.0).max() > gain(np.ones(N)).max()


def test_what_the_picture_does_not_decide_may_be_further_off() -> None:
    ones = np.ones(N)
    assert gain(ones, seen=seen_by(0.2)).max() > 1.3 * gain(ones, seen=seen_by(0.9)).max()
    assert gain(ones, seen=seen_by(1.0)).max() == gain(ones).max()


def test_where_both_chains_were_lost_the_body_may_be_anywhere_about() -> None:
    lost = gain(np.zeros(N), followed=False)
    extent = np.ptp(SCENE.mark_pixels(PATH)[0], axis=0).max()
    assert lost.argmax() == N // 2
    assert 0.3 * LOST_EXTENT * extent < lost.max() / N < LOST_EXTENT * extent


def test_what_is_no_number_counts_as_far() -> None:
    found = gain(np.r_[np.ones(N - 1), np.nan])
    assert np.isfinite(found).all()
    assert found.max() > gain(np.ones(N)).max()
