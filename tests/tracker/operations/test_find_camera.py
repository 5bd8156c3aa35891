"""What is made of a camera's motion: the lengths of its units, and the scene behind the body."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera_path import CameraPath, rigid_inverse
from keypose.tracker.geometry.rotations import exp_rotation, transform
from keypose.tracker.operations.find_camera import (
    FoundCamera,
    background_picture,
    with_known_way,
    with_scale,
)
from keypose.tracker.operations.solve_space import solved
from keypose.tracker.operations.track import track_session
from keypose.tracker.session import Session
from keypose.tracker.session.camera_motion import CameraKeyframe, CameraMotion, CameraPiece
from keypose.tracker.session.references import Repeats
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.storage.fingerprints import Span, segment_keys
from keypose.tracker.storage.stretches import stretches
from keypose.tracker.tracking.pool import TrackFinished
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video
from tests.tracker import panned_cases as panned
from tests.tracker.operations.standing_cases import KEYS, session_of, tracked, walk

COUNT = KEYS[-1] + 1
CUT = 45
UNITS = (2.0, 0.5)


def carried(metres: tuple[float | None, float | None]) -> tuple[Session, dict[Span, SegmentResult]]:
    """Somebody who stands before a hand-held camera whose path has another unit after a cut, and
    what was tracked in its frame."""
    shown, _ = walk()
    t = np.linspace(0, 1, COUNT)
    p = np.stack([0.8 * t, 0.03 * np.sin(25 * t), 0.3 * t + 0.02 * np.sin(31 * t)], axis=1)
    R = exp_rotation(np.stack([0.02 * np.sin(19 * t), -0.2 * t, 0 * t], axis=1))
    path = CameraPath(rigid_inverse(transform(R, p)), np.ones(COUNT))
    in_units = path.in_metres((0, CUT), [1 / unit for unit in UNITS])
    pieces = tuple(
        CameraPiece(first_frame=first, metres=each)
        for first, each in zip((0, CUT), metres, strict=True)
    )
    pose = shown.truth.pose(0)
    stays = Trajectory(
        0,
        np.repeat(pose.Rs_parent_part[None], COUNT, 0),
        np.repeat(pose.p_camera_root[None], COUNT, 0),
    )
    motion = stays.carried(path.Ts_camera_world)
    session = session_of(
        shown, motion, camera_motion=CameraMotion.of("moves", in_units, pieces=pieces)
    )
    return session, tracked(session, motion)


def lengths(session: Session) -> list[float | None]:
    assert session.view.camera_motion is not None
    return [piece.metres for piece in session.view.camera_motion.pieces]


def test_every_piece_has_the_unit_that_its_own_stances_tell() -> None:
    session, fitting = carried((None, None))
    found = with_scale(session, fitting)
    assert lengths(found) == pytest.approx(UNITS, rel=0.01)
    assert found.view.camera_motion is not None
    assert found.view.camera_motion.unscaled == ()


def test_how_far_the_camera_went_comes_with_its_deviation_and_gives_way_to_what_is_known() -> None:
    session, fitting = carried((None, None))
    found = with_scale(session, fitting).view.camera_motion
    assert found is not None
    assert all(way.sigma is not None and way.sigma < 0.1 for way in found.ways)
    known = with_known_way(session, CUT, 3.0)
    assert known.view.camera_motion is not None
    first, second = known.view.camera_motion.ways
    assert first.farthest_m is None
    assert second.farthest_m == pytest.approx(3.0)
    assert second.sigma is None
    places = known.camera_path
    assert places is not None
    centres = places.Ts_world_camera[CUT:, :3, 3]
    assert np.linalg.norm(centres - centres[0], axis=1).max() == pytest.approx(3.0)
    assert with_scale(known, fitting).view.camera_motion.ways[1] == second  # type: ignore[union-attr]


def wandering(metres: float, **changes: Any) -> Session:
    """Somebody before a camera that goes so far."""
    p = np.linspace(0, metres, COUNT)[:, None] * [1.0, 0.0, 0.0]
    path = CameraPath(
        rigid_inverse(transform(np.tile(np.eye(3), (COUNT, 1, 1)), p)), np.ones(COUNT)
    )
    pieces = (CameraPiece(first_frame=0, metres=None),)
    session, _ = carried((None, None))
    return session.changed(
        {"camera_motion": CameraMotion.of("moves", path, pieces=pieces), **changes}
    )


PANS = CameraMotion.of("turns", CameraPath.standing_still(COUNT))
STILL = TrackSettings(smooth=True, static_camera=True)
NO_WAY: dict[str, tuple[Callable[[], Session], int, str]] = {
    "no piece": (lambda: wandering(1.0), CUT + 1, "No way of the camera begins"),
    "nowhere": (lambda: wandering(0.0), 0, "The camera stays where it is in frames 0–90"),
    "hardly anywhere": (lambda: wandering(1e-6), 0, "The camera stays where it is in frames 0–90"),
    "turns": (lambda: wandering(1.0, camera_motion=PANS), 0, "The camera turns and goes nowhere"),
    "stands": (lambda: wandering(1.0, settings=STILL), 0, "The camera stands still"),
    "unknown": (lambda: wandering(1.0, camera_motion=None), 0, "find it first"),
}


@pytest.mark.parametrize("case", NO_WAY)
def test_a_way_that_has_no_length_is_refused_in_one_sentence(case: str) -> None:
    make, first, words = NO_WAY[case]
    with pytest.raises(CameraError, match=words) as refused:
        with_known_way(make(), first, 3.0)
    assert str(refused.value).count(".") == 1


def test_a_piece_over_which_nothing_is_tracked_has_none_and_one_that_is_known_keeps_its_own() -> (
    None
):
    session, fitting = carried((1.75, None))
    first = min(fitting)
    assert with_scale(session, {first: fitting[first]}) is session
    assert lengths(with_scale(session, fitting)) == [1.75, pytest.approx(UNITS[1], rel=0.01)]


def test_a_camera_that_was_corrected_before_its_scale_was_known_stays_on_its_way() -> None:
    session, fitting = carried((None, None))
    assert session.camera_path is not None
    keys = []
    for frame in (20, 60):
        T = session.camera_path.Ts_camera_world[frame].copy()
        T[:3] = exp_rotation(np.array([0.0, 0.0, 0.05])) @ T[:3]
        keys.append(CameraKeyframe.of(frame, T, 1.0))
    corrected = with_scale(session.changed({"camera_keyframes": tuple(keys)}), fitting)
    path, found = corrected.camera_path, with_scale(session, fitting).camera_path
    assert path is not None
    assert found is not None
    turned = exp_rotation(np.array([0.0, 0.0, 0.05]))
    for frame in (20, 60):
        R = turned @ session.camera_path.Ts_camera_world[frame, :3, :3]
        np.testing.assert_allclose(path.Ts_camera_world[frame, :3, :3], R, atol=1e-9)
    places, untouched = (one.Ts_world_camera[:, :3, 3] for one in (path, found))
    np.testing.assert_allclose(places[20], untouched[20], atol=1e-9)
    # what is turned from a frame on goes on in another direction, as far as before
    lengths = [np.linalg.norm(np.diff(one, axis=0), axis=1) for one in (places, untouched)]
    assert np.abs(lengths[0] - lengths[1]).max() < 0.1 * lengths[1].max()


def test_a_camera_that_is_found_again_keeps_how_a_person_turned_it_and_goes_its_new_way() -> None:
    session, _ = carried(UNITS)
    assert session.camera_path is not None
    T = session.camera_path.Ts_camera_world[20].copy()
    T[:3] = exp_rotation(np.array([0.0, 0.0, 0.05])) @ T[:3]
    session = session.changed({"camera_keyframes": (CameraKeyframe.of(20, T, 1.0),)})
    anew = carried((None, None))[0].view.camera_motion
    again = FoundCamera("moves", anew, None, (), None).applied(session)
    assert again.camera_path is not None
    here = again.camera_path.Ts_camera_world[20]
    np.testing.assert_allclose(here[:3, :3], T[:3, :3], atol=1e-9)
    np.testing.assert_allclose(here[:3, 3], 0.0, atol=1e-9)  # its way has no scale yet
    still = FoundCamera("static", None, None, (), None).applied(session)
    assert still.view.camera_keyframes == ()


def test_the_background_of_a_pan_is_one_picture_wider_than_the_film(tmp_path: Path) -> None:
    panned.write(tmp_path)
    with Video.open(tmp_path / "film") as video:
        picture = background_picture(panned.panned(), video)
        middle = picture[15:-15, 40:-40]
        assert picture.shape[1] > panned.WIDTH + 5  # an arc is shorter than its chord
        assert (middle > 0).mean() > 0.95
        still = panned.session()
        with pytest.raises(CameraError, match="a camera that turns"):
            background_picture(still, video)


def test_a_thing_before_a_pan_is_tracked_with_its_background(tmp_path: Path) -> None:
    panned.write(tmp_path)
    with Video.open(tmp_path / "film") as video:
        session = panned.panned()
        found = list(track_session(session, video))[-1]
    assert isinstance(found, TrackFinished)
    at = {keyframe.frame: keyframe for keyframe in session.subject.keyframes}
    for segment in found.result.segments:
        assert segment.key == segment_keys(session)[segment.span]
        for frame in segment.span:
            place = segment.trajectory.pose(frame).p_camera_root
            np.testing.assert_allclose(place, at[frame].root_m, atol=1e-9)


@pytest.mark.parametrize("even", [True, False])
def test_pictures_that_are_repeated_before_a_pan_leave_what_stands_where_it_stands(
    even: bool,
) -> None:
    shown, _ = walk()
    copies = tuple(range(4, COUNT - 1, 5))
    copies = tuple(frame for frame in copies if frame not in KEYS)
    moment = np.arange(COUNT)
    moment[list(copies)] -= 1
    turns = exp_rotation(np.radians(1.0) * moment[:, None] * np.array([0.0, -1.0, 0.0]))
    path = CameraPath.of(turns, np.zeros((COUNT, 3)), np.ones(COUNT))
    pose = shown.truth.pose(0)
    stays = Trajectory(
        0,
        np.repeat(pose.Rs_parent_part[None], COUNT, 0),
        np.repeat(pose.p_camera_root[None], COUNT, 0),
    )
    motion = stays.carried(path.Ts_camera_world)
    session = session_of(shown, motion, camera_motion=CameraMotion.of("turns", path))
    video = session.view.video.model_copy(update={"repeats": Repeats(frames=copies, even=even)})
    session = session.changed({"video": video})
    (stretch,) = stretches(session, tracked(session, motion))
    found = session.film_camera.motion_to_world(solved(session, stretch).motion)
    away = np.linalg.norm(found.ps_camera_root - pose.p_camera_root, axis=1)
    assert away.max() < 1e-3
