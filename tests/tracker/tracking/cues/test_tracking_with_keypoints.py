"""A person tracked by brightness and keypoints: found again behind the trunk, never a must."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
import pytest

from keypose.tracker.body.angle_errors import MEDIAN_OF_SIGMA
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.session.annotations import KeypointCorrection
from keypose.tracker.session.settings import ALL_CUES, TrackSettings
from keypose.tracker.tracking.cues.joint_evidence import POSED_S
from keypose.tracker.tracking.cues.sources import CorrectedKeypoints, GivenKeypoints
from keypose.tracker.tracking.pool import Cancelled
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.tracking.tracker import NO_KEYPOINTS, Tracker
from keypose.tracker.video.clip_loader import ClipLoader
from keypose.tracker.video.pyramid import LEVELS, Clip, prepare
from tests.rendering.render import rendered
from tests.rendering.settings import RenderSettings
from tests.tracker.tracking.cues.people import CAMERA, SKELETON, Filmed, joints_apart_m, moving
from tests.tracker.tracking_cases import tracked

FILM = Filmed(moving())
FPS = 30.0
TIMES_S = np.arange(FILM.truth.last_frame + 1) / FPS


@dataclass(frozen=True, eq=False)
class Film:
    """A video of grey pictures: the loader's clips are given."""

    clip: Clip


@pytest.fixture(autouse=True)
def _grey(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ClipLoader, "load", lambda *_: FILM.segment.clip)


def _tracker(
    keypoints: Keypoints | None, skeleton: Skeleton = SKELETON, drafted: Sequence[int] = ()
) -> Tracker:
    segment = FILM.segment
    poses = {segment.first_frame: segment.start, segment.last_frame: segment.end}
    source = None if keypoints is None else GivenKeypoints(keypoints)
    film: Any = Film(segment.clip)
    return Tracker(
        film, CAMERA, skeleton, poses, keypoints=source, drafted=drafted, times_s=TIMES_S
    )


def _motion(keypoints: Keypoints | None, **settings: object) -> Trajectory:
    return tracked(_tracker(keypoints), **settings)[0].trajectory


@pytest.mark.parametrize("cues", [ALL_CUES, ("keypoints",)])
@pytest.mark.parametrize("quality", ["full", "preview"])
def test_where_brightness_shows_nothing_keypoints_lead(cues: object, quality: object) -> None:
    (found,) = tracked(_tracker(FILM.keypoints), cues=cues, quality=quality)
    away = joints_apart_m(found.trajectory, FILM.truth).mean()
    assert away < 0.3 * joints_apart_m(FILM.segment.interpolated(), FILM.truth).mean()
    assert found.closing_error == 0.0
    assert found.verdict is not None


def test_keypoints_that_the_pictures_contradict_leave_what_brightness_shows(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A detector puts both legs beside where they are seen, for most of the frames, and is sure."""
    film = Filmed(moving(size=0.25))
    pictures = rendered(SKELETON, film.truth, CAMERA, RenderSettings())
    grey = [prepare(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), None, LEVELS) for rgb in pictures]
    levels = tuple(np.stack(level) for level in zip(*grey, strict=True))
    clip = Clip(film.segment.first_frame, levels)
    monkeypatch.setattr(ClipLoader, "load", lambda *_: clip)
    legs = [k for k, name in enumerate(JOINTS) if name.endswith(("knee", "ankle"))]
    uv = film.keypoints.uv.copy()
    uv[2:-2, legs, 0] += 25.0
    misled, plain = (
        _away_px(film, replace(film.keypoints, uv=uv), cues=cues)
        for cues in (ALL_CUES, ("brightness",))
    )
    assert plain < 1
    assert misled < plain + 0.1


def _away_px(film: Filmed, keypoints: Keypoints, **settings: object) -> float:
    """The mean distance of joints from where they truly are, px."""
    first, last = film.segment.first_frame, film.segment.last_frame
    tracker = _tracker(keypoints).renewed(
        SKELETON,
        {first: film.segment.start, last: film.segment.end},
        keypoints=GivenKeypoints(keypoints),
    )
    motion = tracked(tracker, **settings)[0].trajectory
    away = CAMERA.project(motion.joints(SKELETON)) - CAMERA.project(film.truth.joints(SKELETON))
    return float(np.linalg.norm(away, axis=-1).mean())


def test_off_or_not_there_or_another_persons_everything_is_as_without() -> None:
    without = _motion(None)
    height = FILM.anchors()[0].height_px
    elsewhere = replace(FILM.keypoints, uv=FILM.keypoints.uv + np.array([0.3 * height, 0.0]))
    nowhere = replace(FILM.keypoints, uv=np.full_like(FILM.keypoints.uv, np.nan))
    for motion in (
        _motion(FILM.keypoints, cues=("brightness",)),
        _motion(FILM.keypoints),  # named by nobody
        _motion(elsewhere, cues=ALL_CUES),
        _motion(nowhere, cues=ALL_CUES),
    ):
        np.testing.assert_array_equal(motion.Rs_parent_part, without.Rs_parent_part)
        np.testing.assert_array_equal(motion.ps_camera_root, without.ps_camera_root)


def test_the_papers_method_never_listens_to_them() -> None:
    paper = _motion(FILM.keypoints, cues=ALL_CUES, method="paper")
    np.testing.assert_array_equal(
        paper.Rs_parent_part, _motion(None, method="paper").Rs_parent_part
    )


def test_that_no_keypoints_fit_is_reported() -> None:
    nowhere = replace(FILM.keypoints, uv=np.full_like(FILM.keypoints.uv, np.nan))
    assert tracked(_tracker(nowhere), cues=ALL_CUES)[0].notes == (NO_KEYPOINTS,)
    assert tracked(_tracker(nowhere))[0].notes == ()


def test_the_same_keypoints_give_the_same_motion() -> None:
    one, other = (_motion(FILM.keypoints, cues=ALL_CUES) for _ in range(2))
    np.testing.assert_array_equal(one.Rs_parent_part, other.Rs_parent_part)


def test_a_depth_that_tells_its_deviation_says_how_far_off_joints_may_be_along_the_view() -> None:
    sigma_m = np.full(FILM.keypoints.visibility.shape, 0.05)
    lifted = replace(FILM.keypoints, depth_sigma_m=sigma_m)
    ends = FILM.truth.first_frame, FILM.truth.last_frame
    (found,) = tracked(_tracker(lifted, drafted=ends), cues=ALL_CUES)
    depth = found.diagnostics.expected_depth
    assert depth is not None
    chest, head = (SKELETON.body.index(name) for name in ("chest", "head"))
    np.testing.assert_allclose(depth[:, chest], MEDIAN_OF_SIGMA * 0.05)
    assert np.isnan(depth[:, head]).all()
    (keyed,) = tracked(_tracker(lifted, drafted=ends[1:]), cues=ALL_CUES)
    posed = keyed.diagnostics.expected_depth
    assert posed is not None
    assert (posed[:3, chest] < 0.9 * depth[:3, chest]).all()  # a person posed the first
    assert posed[-1, chest] == pytest.approx(
        depth[-1, chest] * min(1.0, (len(FILM.truth) - 1) / FPS / POSED_S), rel=0.3
    )
    (plain,) = tracked(_tracker(FILM.keypoints), cues=ALL_CUES)
    assert plain.diagnostics.expected_depth is None


def test_every_part_with_a_joint_says_what_error_is_expected_and_none_at_keyframes() -> None:
    (found,) = tracked(_tracker(FILM.keypoints), cues=ALL_CUES)
    error = found.diagnostics.expected_error
    assert error is not None
    assert error.shape == (len(FILM.truth), SKELETON.part_count)
    known = np.isfinite(error).all(axis=0)
    assert {n for n, k in zip(SKELETON.body.names, known, strict=True) if k} >= {
        "left_forearm", "right_upper_arm", "left_shin", "chest",
    }  # fmt: skip
    assert not np.nan_to_num(error[[0, -1]]).any()
    assert (error[1:-1][:, known] > 0).all()


@pytest.mark.parametrize("swapped", [slice(4, 9), slice(1, -1)], ids=["some frames", "all inner"])
def test_exchanged_sides_are_set_right_where_the_whole_evidence_says_so(swapped: slice) -> None:
    other = FILM.keypoints.exchanged()
    uv, p_hips = FILM.keypoints.uv.copy(), np.array(FILM.keypoints.p_hips)
    uv[swapped], p_hips[swapped] = other.uv[swapped], np.array(other.p_hips)[swapped]
    motion = _motion(replace(FILM.keypoints, uv=uv, p_hips=p_hips), cues=ALL_CUES)
    right = _motion(FILM.keypoints, cues=ALL_CUES)
    assert joints_apart_m(motion, FILM.truth).mean() < (
        joints_apart_m(right, FILM.truth).mean() + 0.03
    )


WRIST = JOINTS.index("left_wrist")
ASTRAY = slice(4, 9)


def _wrist_astray() -> Keypoints:
    """For five frames the detector slides onto something else beside the wrist, and is sure."""
    uv = FILM.keypoints.uv.copy()
    uv[ASTRAY, WRIST] += np.outer([0.5, 1.0, 1.0, 1.0, 0.5], [22.0, 9.0])
    return replace(FILM.keypoints, uv=uv)


def _wrist_px(motion: Trajectory, frame: int) -> float:
    """How far the wrist lies from where it truly is."""
    seen = [FILM.wrist_px(path)[frame - path.first_frame] for path in (motion, FILM.truth)]
    return float(np.linalg.norm(seen[0] - seen[1]))


def _corrected(corrections: list[KeypointCorrection], **settings: object) -> Trajectory:
    source = CorrectedKeypoints(GivenKeypoints(_wrist_astray()), corrections)
    tracker = _tracker(None).renewed(SKELETON, _tracker(None).keyposes, keypoints=source)
    return tracked(tracker, cues=ALL_CUES, **settings)[0].trajectory


def test_a_keypoint_that_a_person_corrected_pulls_the_motion_there() -> None:
    first, middle = FILM.truth.first_frame, FILM.truth.first_frame + 6
    u, v = FILM.wrist_px(FILM.truth)[middle - first]
    there = KeypointCorrection(frame=middle, joint="left_wrist", uv=(u, v))
    assert _wrist_px(_corrected([]), middle) > 5.0
    assert _wrist_px(_corrected([there]), middle) < 1.0


def test_keypoints_that_a_person_ignores_count_as_if_nothing_had_been_found() -> None:
    first = FILM.truth.first_frame
    hidden = [KeypointCorrection(frame=first + n, joint="left_wrist") for n in range(4, 9)]
    uv, visibility = FILM.keypoints.uv.copy(), FILM.keypoints.visibility.copy()
    uv[ASTRAY, WRIST], visibility[ASTRAY, WRIST] = np.nan, 0.0
    nothing = _motion(replace(FILM.keypoints, uv=uv, visibility=visibility), cues=ALL_CUES)
    ignored = _corrected(hidden)
    np.testing.assert_array_equal(ignored.Rs_parent_part, nothing.Rs_parent_part)
    assert not np.array_equal(ignored.Rs_parent_part, _corrected([]).Rs_parent_part)


def test_the_search_for_keypoints_is_left_at_once_when_cancelled() -> None:
    class Endless:
        """Looks at frame after frame."""

        looks = 0

        def over(
            self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
        ) -> Keypoints | None:
            while True:
                self.looks += 1
                report()

    source = Endless()
    tracker = _tracker(None).renewed(SKELETON, _tracker(None).keyposes, keypoints=source)

    def emit(*_: object) -> None:
        raise Cancelled

    with pytest.raises(Cancelled):
        tracker.run_segment(tracker.spans[0], TrackSettings(cues=ALL_CUES), emit)
    assert source.looks == 1
