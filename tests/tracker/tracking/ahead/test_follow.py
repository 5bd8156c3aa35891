"""From one keyframe the body is followed as far as it is seen, and it is said why no farther."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import SessionError
from keypose.tracker.session.annotations import Direction, Stop
from keypose.tracker.session.settings import ALL_CUES, TrackSettings
from keypose.tracker.tracking.ahead import follow
from keypose.tracker.tracking.ahead.follow import FoundAhead, follow_ahead
from keypose.tracker.tracking.ahead.forward_pass import ForwardPass
from keypose.tracker.tracking.ahead.stop_reasons import Stopped
from keypose.tracker.tracking.cues.sources import GivenKeypoints
from keypose.tracker.tracking.pool import Cancelled
from keypose.tracker.tracking.tracker import NO_KEYPOINTS, Tracker
from keypose.tracker.video.clip_loader import ClipLoader
from tests.tracker.tracking.cues.people import CAMERA, SKELETON, Filmed, joints_apart_m, moving
from tests.tracker.tracking_cases import Case, case

WAYS: tuple[Direction, Direction] = ("forward", "backward")
BOX = case("tumbling_box", 0, 24)
PERSON = case("stride", 0, 24)
LAST = len(BOX.truth) - 1


def ahead(
    shown: Case, frame: int, way: Direction = "forward", *, longest: int = 64, **more: Any
) -> FoundAhead:
    """Followed from the true pose of one frame, by brightness alone."""
    tracker = shown.tracker(frame, fewest=1, **more)
    return follow_ahead(tracker, frame, way, TrackSettings(), lambda motion: None, longest)


def off_cm(shown: Case, found: Trajectory) -> float:
    """The largest distance of a joint from the truth, in the picture's plane."""
    truth = shown.truth.joints(shown.skeleton)[found.first_frame : found.last_frame + 1]
    return float(100 * np.abs(found.joints(shown.skeleton) - truth)[..., :2].max())


@pytest.mark.parametrize("way", WAYS)
def test_a_box_is_followed_to_the_end_of_the_video(way: Direction) -> None:
    frame, to = (0, LAST) if way == "forward" else (LAST, 0)
    found = ahead(BOX, frame, way)
    assert (found.frame, found.to_frame, found.stop) == (frame, to, Stop(cause="clip_end"))
    assert (found.motion.first_frame, found.motion.last_frame) == (0, LAST)
    assert off_cm(BOX, found.motion) < 0.5


@pytest.mark.parametrize("way", WAYS)
def test_of_a_person_only_what_is_right_is_kept(way: Direction) -> None:
    frame = 0 if way == "forward" else len(PERSON.truth) - 1
    found = ahead(PERSON, frame, way)
    assert abs(found.to_frame - frame) >= 4
    assert off_cm(PERSON, found.motion) < 6.0
    assert found.motion.pose(frame).p_camera_root.tolist() == pytest.approx(
        PERSON.truth.pose(frame).p_camera_root
    )


@pytest.mark.parametrize("way", WAYS)
def test_it_ends_just_before_the_next_keyframe(way: Direction) -> None:
    tracker = BOX.tracker(4, 12)
    frame, to = (4, 11) if way == "forward" else (12, 5)
    found = follow_ahead(tracker, frame, way, TrackSettings(), lambda motion: None)
    assert (found.to_frame, found.stop.cause) == (to, "keyframe")


def test_it_ends_where_so_many_frames_are_enough() -> None:
    found = ahead(BOX, 3, longest=7)
    assert (found.to_frame, found.stop.cause) == (10, "limit")


def test_it_ends_before_damaged_frames() -> None:
    found = ahead(BOX, 0, missing=(9, 10))
    assert (found.to_frame, found.stop.cause) == (8, "damaged")


@pytest.mark.parametrize("way", WAYS)
def test_it_ends_before_another_scene(way: Direction) -> None:
    pictures = BOX.pictures.copy()
    cut = slice(11, None) if way == "forward" else slice(None, 11)
    pictures[cut] = 255 - pictures[cut, ::-1]
    frame, to = (0, 10) if way == "forward" else (LAST, 11)
    found = ahead(replace(BOX, pictures=pictures), frame, way)
    assert (found.to_frame, found.stop.cause) == (to, "cut")


def test_it_ends_where_something_hides_the_body() -> None:
    """A grey board stands before it from frame 10 on."""
    pictures = BOX.pictures.copy()
    uv = BOX.camera.project(BOX.truth.joints(BOX.skeleton)[10]).mean(axis=0)
    u, v = np.round(uv).astype(int).tolist()
    pictures[10:, max(v - 50, 0) : v + 50, max(u - 50, 0) : u + 50] = 128
    found = ahead(replace(BOX, pictures=pictures), 0)
    assert 4 <= found.to_frame <= 11
    assert (found.stop.cause, found.stop.part) == ("uncertain", BOX.skeleton.body.names[0])


def test_it_ends_where_the_body_leaves_the_picture() -> None:
    """The picture ends right beside it, and everything slides there, four pixels a frame."""
    start = BOX.camera.project(BOX.truth.joints(BOX.skeleton)[0])
    width = int(start[:, 0].max()) + 5
    pictures = BOX.pictures.copy()
    for frame, picture in enumerate(pictures):
        picture[:, 4 * frame :] = BOX.pictures[frame][:, : picture.shape[1] - 4 * frame]
    camera = BOX.camera.model_copy(update={"width": width})
    found = ahead(replace(BOX, camera=camera, pictures=pictures[:, :, :width]), 0)
    assert found.to_frame < LAST
    outside = Stop(cause="not_seen", part=BOX.skeleton.body.names[0])
    assert found.stop in (Stop(cause="left_picture"), outside)


def test_cancelled_it_keeps_what_can_be_trusted_until_then() -> None:
    tracker = BOX.tracker(0, fewest=1)

    def emit(motion: Trajectory) -> None:
        raise Cancelled

    found = follow_ahead(tracker, 0, "forward", TrackSettings(), emit)
    assert found.stop.cause == "cancelled"
    assert found.to_frame == LAST
    assert off_cm(BOX, found.motion) < 1.5


def test_it_says_where_it_cannot_begin() -> None:
    with pytest.raises(SessionError, match=r"^Frame 5 has no keyframe; pose it first\.$"):
        follow_ahead(BOX.tracker(0, 9), 5, "forward", TrackSettings(), lambda motion: None)
    with pytest.raises(SessionError, match=r"^Frame 24 is the video's last: there is nothing"):
        ahead(BOX, LAST)
    with pytest.raises(SessionError, match=r"^Frame 0 is the video's first: there is nothing"):
        ahead(BOX, 0, "backward")
    with pytest.raises(SessionError, match="leaves nothing to track between them"):
        follow_ahead(BOX.tracker(4, 5), 4, "forward", TrackSettings(), lambda motion: None)


def test_twice_it_is_the_same() -> None:
    one, other = ahead(BOX, 0), ahead(BOX, 0)
    np.testing.assert_array_equal(one.motion.Rs_parent_part, other.motion.Rs_parent_part)


# --- with keypoints

FILM = Filmed(moving())


@pytest.fixture
def _grey(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures in which brightness tells nothing."""
    monkeypatch.setattr(ClipLoader, "load", lambda *_: FILM.segment.clip)


def _with_keypoints(way: Direction, frame: int, keypoints: Any, **settings: Any) -> FoundAhead:
    class Film:
        class info:
            frame_count = FILM.truth.last_frame + 1

    tracker = Tracker(
        Film(), CAMERA, SKELETON, {frame: FILM.truth.pose(frame)},  # type: ignore[arg-type]
        keypoints=GivenKeypoints(keypoints), fewest=1,
    )  # fmt: skip
    first = FILM.truth.first_frame
    longest = FILM.truth.last_frame - first
    how = TrackSettings(cues=ALL_CUES, **settings)
    return follow_ahead(tracker, frame, way, how, lambda motion: None, longest)


@pytest.mark.usefixtures("_grey")
@pytest.mark.parametrize("way", WAYS)
def test_where_brightness_shows_nothing_keypoints_lead_on(way: Direction) -> None:
    first, last = FILM.truth.first_frame, FILM.truth.last_frame
    frame, to = (first, last) if way == "forward" else (last, first)
    found = _with_keypoints(way, frame, FILM.keypoints)
    assert (found.to_frame, found.notes) == (to, ())
    assert joints_apart_m(found.motion, FILM.truth).mean() < 0.06


@pytest.mark.usefixtures("_grey")
def test_where_nobody_is_found_it_says_so_and_goes_by_brightness() -> None:
    nowhere = replace(FILM.keypoints, uv=np.full_like(FILM.keypoints.uv, np.nan))
    found = _with_keypoints("forward", FILM.truth.first_frame, nowhere)
    assert found.notes == (NO_KEYPOINTS,)


def test_what_was_trusted_stays_when_more_frames_bring_a_doubt(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def doubted(_: object, followed: ForwardPass, **__: object) -> Stopped | None:
        """As soon as there are more than the first 8 steps."""
        doubt = Stopped(2, Stop(cause="uncertain", part="left_hand"))
        return doubt if len(followed.motion) > 9 else None

    monkeypatch.setattr(follow, "BLOCK", 8)
    monkeypatch.setattr(follow, "stopped", doubted)
    found = ahead(BOX, 0)
    assert (found.to_frame, found.stop) == (8, Stop(cause="uncertain", part="left_hand"))
