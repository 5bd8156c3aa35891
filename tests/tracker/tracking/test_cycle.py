"""One segment: better than interpolation, better than printed, and honest where it fails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.tracking.method import (
    FULL,
    PREVIEW,
    WITH_KEYPOINTS,
    Keypose,
    Method,
    Paper,
    method_of,
)
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.video.pyramid import Clip
from tests.rendering.settings import RenderSettings
from tests.tracker.tracking_cases import Case, case, clip_of, plain, segment_of, worked

NAMES = ("box", "person")
every_case = pytest.mark.parametrize("name", NAMES)
METHODS: dict[str, Method] = {"full": FULL, "preview": PREVIEW, "paper": Paper()}
every_method = pytest.mark.parametrize("method", METHODS)


@pytest.fixture(scope="module")
def cases() -> dict[str, Case]:
    return {"box": case("tumbling_box", 30, 50), "person": case("stride", 30, 50)}


@every_case
def test_keypose_beats_interpolation_by_far_and_the_printed_method_clearly(
    cases: dict[str, Case], name: str
) -> None:
    shown = cases[name]
    full = worked(shown, segment_of(shown), FULL)[1].trajectory
    paper = worked(shown, segment_of(shown), Paper())[1].trajectory
    straight = shown.error_cm(plain(shown))
    assert shown.error_cm(full) < straight / 4
    assert shown.error_cm(paper) < 0.8 * straight
    assert shown.error_cm(full) < 0.8 * shown.error_cm(paper)


@every_case
@every_method
def test_every_method_does_better_than_interpolation_and_meets_the_keyframes_exactly(
    cases: dict[str, Case], name: str, method: str
) -> None:
    shown = cases[name]
    steps, outcome = worked(shown, segment_of(shown), METHODS[method])
    assert shown.error_cm(outcome.trajectory) < 0.8 * shown.error_cm(plain(shown))
    assert not outcome.diverged
    assert tuple(steps) == outcome.passes
    for step in steps:
        for k in (0, len(shown.truth) - 1):
            found, truth = step.trajectory.pose(k), shown.truth.pose(k)
            np.testing.assert_allclose(found.Rs_parent_part, truth.Rs_parent_part, atol=1e-12)
            np.testing.assert_allclose(found.p_camera_root, truth.p_camera_root, atol=1e-12)
    best = outcome.trajectory
    np.testing.assert_allclose(best.Rs_parent_part[[0, -1]], shown.truth.Rs_parent_part[[0, -1]],
                               atol=1e-14)  # fmt: skip
    np.testing.assert_array_equal(best.ps_camera_root[-1], shown.truth.ps_camera_root[-1])


@every_case
def test_following_from_both_keyframes_is_far_better_than_interpolation(
    cases: dict[str, Case], name: str
) -> None:
    shown = cases[name]
    steps, _ = worked(shown, segment_of(shown), FULL)
    both = next(step for step in steps if step.what == "both ways")
    assert shown.error_cm(both.trajectory) < 0.7 * shown.error_cm(plain(shown))


@every_method
def test_the_best_score_is_taken_unless_the_refinement_is_worth_a_little_more(
    cases: dict[str, Case], method: str
) -> None:
    shown = cases["person"]
    steps, outcome = worked(shown, segment_of(shown), METHODS[method])
    whats = [step.what for step in steps]
    assert whats[0] in ("interpolation", "both ways", "templates")
    assert set(whats) <= {"interpolation", "both ways", "templates", "pass", "refinement"}
    if method == "preview":
        assert all(step.score is None for step in steps[1:])
        return
    scores = [step.score for step in steps]
    assert all(score is not None and np.isfinite(score) and score >= 0 for score in scores)
    unrefined = [s for s, w in zip(scores, whats, strict=True) if w != "refinement"]
    if whats[outcome.best] == "refinement":
        assert scores[outcome.best] < 1.5 * min(unrefined)  # type: ignore[operator, type-var]
    else:
        assert scores[outcome.best] == min(unrefined)  # type: ignore[type-var]


def test_more_passes_and_finer_settings_are_those_asked_for() -> None:
    for quality, method in (("full", FULL), ("preview", PREVIEW)):
        assert method_of(TrackSettings(quality=quality)) == method
    beside = method_of(TrackSettings(quality="full"), with_keypoints=True)
    assert beside == WITH_KEYPOINTS != FULL
    many = method_of(TrackSettings(passes=7))
    assert isinstance(many, Keypose)
    assert many.passes == 7
    assert method_of(TrackSettings(method="paper", passes=2)) == Paper(2)
    assert method_of(TrackSettings(method="paper")) == Paper()


@every_case
@every_method
def test_the_same_work_gives_the_same_bytes(cases: dict[str, Case], name: str, method: str) -> None:
    shown = cases[name]
    first, second = (
        worked(shown, segment_of(shown), METHODS[method])[1].trajectory for _ in range(2)
    )
    assert first.Rs_parent_part.tobytes() == second.Rs_parent_part.tobytes()
    assert first.ps_camera_root.tobytes() == second.ps_camera_root.tobytes()


@every_case
def test_the_video_run_backwards_gives_the_motion_backwards(
    cases: dict[str, Case], name: str
) -> None:
    shown = cases[name]
    truth = shown.truth
    turned = Case(
        shown.skeleton, shown.camera,
        Trajectory(0, truth.Rs_parent_part[::-1], truth.ps_camera_root[::-1]),
        np.ascontiguousarray(shown.pictures[::-1]),
    )  # fmt: skip
    there = worked(shown, segment_of(shown), FULL)[1].trajectory
    back = worked(turned, segment_of(turned), FULL)[1].trajectory
    joints = there.joints(shown.skeleton), back.joints(shown.skeleton)[::-1]
    apart = np.linalg.norm(joints[0] - joints[1], axis=-1)
    assert 100 * apart.mean() < 0.25 * shown.error_cm(plain(shown))


@every_method
def test_two_neighbouring_keyframes_leave_nothing_to_find(
    cases: dict[str, Case], method: str
) -> None:
    shown = cases["person"]
    pair = Segment(0, 1, shown.truth.pose(0), shown.truth.pose(1), shown.clip())
    _, outcome = worked(shown, pair, METHODS[method])
    np.testing.assert_allclose(
        outcome.trajectory.joints(shown.skeleton), shown.truth.joints(shown.skeleton)[:2],
        atol=1e-12,
    )  # fmt: skip
    assert not outcome.diverged


def test_flicker_and_noise_are_borne() -> None:
    settings = RenderSettings(noise=8.0, flicker=0.06, illumination_ramp=0.15)
    shown = case("stride", 30, 50, settings)
    _, outcome = worked(shown, segment_of(shown), FULL)
    assert shown.error_cm(outcome.trajectory) < 0.5 * shown.error_cm(plain(shown))


def test_a_telephoto_camera_tracks_across_the_picture() -> None:
    shown = case("stride", 30, 50, telephoto=True)
    _, outcome = worked(shown, segment_of(shown), FULL)

    def miss_px(path: Trajectory) -> float:
        uv: list[NDArray[np.float64]] = [
            shown.camera.project(p.joints(shown.skeleton)) for p in (path, shown.truth)
        ]
        return float(np.linalg.norm(uv[0] - uv[1], axis=-1)[1:-1].mean())

    assert miss_px(outcome.trajectory) < 0.35 * miss_px(plain(shown))


def test_frames_are_counted_in_the_video_and_not_in_the_segment(cases: dict[str, Case]) -> None:
    shown = cases["box"]
    clip = clip_of(shown.pictures)
    here = worked(shown, segment_of(shown, clip), FULL)[1].trajectory
    shifted = Clip(98, tuple(np.concatenate([np.zeros_like(x[:2]), x]) for x in clip.levels))
    later = Segment(100, 120, shown.truth.pose(0), shown.truth.pose(20), shifted)
    there = worked(shown, later, FULL)[1].trajectory
    assert (there.first_frame, there.last_frame) == (100, 120)
    np.testing.assert_array_equal(there.Rs_parent_part, here.Rs_parent_part)


def own_segment(shown: Case, own: Trajectory, clip: Clip | None = None) -> Segment:
    """With a motion of before, which meets both keyframes."""
    return replace(segment_of(shown, clip), imported=own, own=own)


@pytest.mark.parametrize("quality", [FULL, PREVIEW])
def test_where_the_film_shows_nothing_the_motion_of_before_stays(
    cases: dict[str, Case], quality: Keypose
) -> None:
    shown = cases["person"]
    clip = clip_of(np.full_like(shown.pictures, 128))
    segment = own_segment(shown, shown.truth, clip)
    outcome = worked(shown, segment, replace(quality, initial="import"))[1]
    np.testing.assert_allclose(
        outcome.trajectory.joints(shown.skeleton), shown.truth.joints(shown.skeleton), atol=1e-3
    )


def test_a_motion_of_before_that_is_wrong_is_corrected_by_the_film(cases: dict[str, Case]) -> None:
    shown = cases["person"]
    share = np.linspace(0, 1, len(shown.truth))
    away = 0.06 * np.sin(np.pi * share)[:, None] * np.array([1.0, 0.5, 0.0])
    wrong = Trajectory(0, shown.truth.Rs_parent_part, shown.truth.ps_camera_root + away)
    outcome = worked(shown, own_segment(shown, wrong), replace(FULL, initial="import"))[1]
    assert shown.error_cm(outcome.trajectory) < 0.2 * shown.error_cm(wrong)
    assert outcome.passes[outcome.best].what == "refinement"


def test_from_a_motion_of_before_no_start_that_leads_elsewhere_is_a_candidate(
    cases: dict[str, Case],
) -> None:
    shown = cases["person"]
    steps, _ = worked(shown, own_segment(shown, shown.truth), replace(FULL, initial="import"))
    assert {step.what for step in steps} <= {"import", "pass", "refinement"}
