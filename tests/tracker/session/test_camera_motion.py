"""A camera's motion in a session's file: read back to the last digit, refused where it is none."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from keypose.tracker.body.body import preset
from keypose.tracker.camera_motion import FocalScale, MovedPath
from keypose.tracker.errors import one_sentence
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.operations.find_camera import _with_its_lens
from keypose.tracker.session import Session
from keypose.tracker.session.camera_motion import (
    CameraFinding,
    CameraKeyframe,
    CameraMotion,
    CameraPiece,
    packed,
)
from keypose.tracker.storage.fingerprints import background_turns, segment_keys
from keypose.tracker.storage.stretches import stretch_keys
from tests.tracker import panned_cases as panned


def test_it_is_read_back_as_it_was_written() -> None:
    finding = CameraFinding(kind="no_texture", first_frame=3, last_frame=9, amount=0.2)
    errors = np.full(panned.FRAMES, 0.25)
    errors[4] = np.nan
    pieces = (CameraPiece(first_frame=0), CameraPiece(first_frame=7, metres=None))
    motion = CameraMotion.of("turns", panned.path(), errors, (finding,), pieces=pieces)
    session = panned.session(motion)
    again = Session.model_validate_json(session.model_dump_json())
    assert again == session
    path = again.camera_path
    assert path is not None
    np.testing.assert_allclose(path.Ts_camera_world, panned.path().Ts_camera_world, atol=1e-15)
    np.testing.assert_array_equal(path.Ts_camera_world[0], np.eye(4))
    assert again.view.camera_motion is not None
    np.testing.assert_array_equal(again.view.camera_motion.errors_px, errors)


def test_a_session_without_one_is_written_as_before_there_was_any() -> None:
    written = panned.session().model_dump_json()
    assert "camera_motion" not in written
    assert "camera_keyframes" not in written
    assert panned.session().camera_path is None


def test_a_camera_that_is_said_to_stand_still_does() -> None:
    session = panned.panned()
    still = session.changed(
        {"settings": session.settings.model_copy(update={"static_camera": True})}
    )
    assert still.camera_path is None
    assert still.film_camera.at(5) is still.view.camera


def test_a_persons_correction_is_met_and_outdates_no_segment() -> None:
    session = panned.panned()
    T = panned.path().Ts_camera_world[20].copy()
    T[:3, :3] = T[:3, :3] @ panned.Rs_camera_world()[3]
    key = CameraKeyframe.of(20, T, 1.0)
    after = session.changed({"camera_keyframes": (key,)})
    assert after.camera_path is not None
    np.testing.assert_allclose(after.camera_path.Ts_camera_world[20], T, atol=1e-12)
    assert segment_keys(after) == segment_keys(session)
    assert stretch_keys(after, []) == set()


def test_segments_are_tracked_for_the_camera_as_it_was_found() -> None:
    still = segment_keys(of_person(None))
    turned = segment_keys(of_person(CameraMotion.of("turns", panned.path())))
    assert all(turned[span] != still[span] for span in still)
    zoom = np.ones(panned.FRAMES)
    zoom[15:] = 1.2
    path = CameraPath(panned.path().Ts_camera_world, zoom)
    zoomed = segment_keys(of_person(CameraMotion.of("turns", path)))
    assert [span for span in still if zoomed[span] != turned[span]] == [(12, 22)]


def of_person(motion: CameraMotion | None) -> Session:
    """Somebody, whose keypoints count."""
    given = panned.session(motion)
    bare = [k.model_copy(update={"rotations_wxyz": {}}) for k in given.subject.keyframes]
    settings = given.settings.model_copy(update={"cues": ("brightness", "keypoints")})
    body = preset("adult_male")
    return given.changed({"body": body, "keyframes": tuple(bare), "settings": settings})


def test_the_background_counts_over_the_whole_film_where_keypoints_do_not() -> None:
    Ts, zoom = panned.path().Ts_camera_world, np.ones(panned.FRAMES)
    zoom[-1] = 1.2  # after the last segment
    both = [CameraMotion.of("turns", CameraPath(Ts, each)) for each in (zoom, zoom**0)]
    thing, person = (
        [segment_keys(of(each)) for each in both] for of in (panned.session, of_person)
    )
    assert all(thing[0][span] != thing[1][span] for span in thing[0])
    assert person[0] == person[1]


@pytest.mark.parametrize(
    ("kind", "settings"),
    [("moves", {}), ("turns", {"static_camera": True}), ("turns", {"method": "paper"})],
)
def test_no_background_is_put_together_where_there_is_none_or_it_has_no_say(
    kind: Any, settings: dict[str, Any]
) -> None:
    given = panned.session(CameraMotion.of(kind, panned.path()))
    chosen = given.settings.model_copy(update=settings)
    assert background_turns(panned.panned()) is not None
    assert background_turns(given.changed({"settings": chosen})) is None


def test_a_piece_whose_scale_nothing_tells_is_taken_to_turn_alone_and_that_is_said() -> None:
    away = panned.path().Ts_camera_world.copy()
    away[:, 0, 3] = np.linspace(0, 1, panned.FRAMES)
    pieces = (CameraPiece(first_frame=0, metres=2.0), CameraPiece(first_frame=10, metres=None))
    given = CameraPath(away, np.ones(panned.FRAMES))
    motion = CameraMotion.of("moves", given, pieces=pieces)
    places, went = (path.Ts_world_camera[:, :3, 3] for path in (motion.path, given))
    np.testing.assert_allclose(places[:10], 2.0 * went[:10], atol=1e-12)
    np.testing.assert_allclose(places[10:], places[9:10].repeat(panned.FRAMES - 10, axis=0))
    (finding,) = motion.unscaled
    assert (finding.kind, finding.first_frame, finding.last_frame) == ("no_scale", 10, 23)
    assert np.flatnonzero(motion.untied).tolist() == [9]


ROWS = np.tile([1.0, 0, 0, 0, 0, 0, 0, 1], (panned.FRAMES, 1))


def with_row(place: int, value: float) -> str:
    rows = ROWS.copy()
    rows[3, place] = value
    return packed(rows.ravel())


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        ({"samples": "?"}, "no base64"),
        ({"samples": base64.b64encode(b"1234567").decode()}, "no base64"),
        ({"samples": ""}, "no multiple of 8"),
        ({"samples": packed(ROWS[:4].ravel()[:-1])}, "no multiple of 8"),
        ({"samples": packed(ROWS[:-1].ravel())}, "has 23 frames and the video 24"),
        ({"samples": with_row(0, 2.0)}, "not of unit length"),
        ({"samples": with_row(5, np.nan)}, "not finite"),
        ({"samples": with_row(7, 0.0)}, "zoom"),
        ({"samples": with_row(4, 1e9)}, "farther away"),
        ({"samples": packed(ROWS.ravel()), "error_px": packed(np.ones(3))}, "number of frames"),
        ({"samples": packed(ROWS.ravel()), "kind": "flies"}, "turns"),
        ({"samples": packed(ROWS.ravel()), "pieces": [{"first_frame": 3}]}, "begin at frame 0"),
        ({"samples": packed(ROWS.ravel()), "pieces": []}, "begin at frame 0"),
    ],
)
def test_what_is_no_motion_is_refused_in_a_sentence(motion: dict[str, Any], words: str) -> None:
    data = panned.session().model_dump(mode="json")
    data["views"][0]["camera_motion"] = {"kind": "turns", **motion}
    with pytest.raises(ValidationError) as refused:
        Session.model_validate(data)
    assert words in one_sentence(refused.value)


@pytest.mark.parametrize(
    ("frames", "words"), [((5, 5), "stands after"), ((9, 3), "stands after"), ((3, 24), "beyond")]
)
def test_corrections_are_within_the_film_and_in_order(frames: tuple[int, ...], words: str) -> None:
    data = panned.panned().model_dump(mode="json")
    data["views"][0]["camera_keyframes"] = [
        {"frame": frame, "R_camera_world_wxyz": [1, 0, 0, 0]} for frame in frames
    ]
    with pytest.raises(ValidationError, match=words):
        Session.model_validate(data)


@pytest.mark.parametrize(
    ("scales", "errors", "sound", "adopted"),
    [
        ((1.25, 1.0), (0.6, 0.1), True, 1.25),
        ((1.2, 1.05, 1.0), (0.6, 0.2, 0.1), True, 1.26),
        ((1.25, 1.0), (0.6, 0.1), False, 1.0),  # another kind of motion than asked
        ((1.25, 1.0), (0.6, 0.59), True, 1.0),  # the background agrees no better
        ((1.005,), (0.1,), True, 1.0),  # within its doubt
        ((None,), (0.1,), True, 1.0),
    ],
)
def test_a_lens_is_taken_from_the_motion_where_it_is_sure_and_better(
    scales: Sequence[float | None], errors: Sequence[float], sound: bool, adopted: float
) -> None:
    def motion(scale: float | None, error: float) -> MovedPath:
        focal = None if scale is None else FocalScale(scale, 0.003, 0.0)
        path = CameraPath.standing_still(3)
        known, off = np.ones(3, dtype=np.bool_), np.full(3, error)
        return MovedPath(path, (0,), sound, known, off, (), focal)

    first, *later = [motion(*each) for each in zip(scales, errors, strict=True)]
    rounds = iter(later)
    camera, found = _with_its_lens(
        panned.CAMERA, first, lambda _: next(rounds), lambda one: one.moves
    )
    assert camera.fx == pytest.approx(adopted * panned.CAMERA.fx)
    assert (found is first) == (adopted == 1.0)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"frame": 0}, "greater than or equal to 1"),
        ({"R_camera_world_wxyz": [0, 0, 0, 0]}, "not a unit quaternion"),
        ({"R_camera_world_wxyz": [2, 0, 0, 0]}, "not a unit quaternion"),
        ({"zoom": 0.0}, "greater than or equal to 0.001"),
        ({"p_camera_world": [0, 0, float("nan")]}, "finite"),
    ],
)
def test_a_correction_that_no_camera_has_is_refused_in_a_sentence(
    changed: dict[str, Any], words: str
) -> None:
    data = panned.panned().model_dump(mode="json")
    key = {"frame": 5, "R_camera_world_wxyz": [1, 0, 0, 0]}
    data["views"][0]["camera_keyframes"] = [{**key, **changed}]
    with pytest.raises(ValidationError) as refused:
        Session.model_validate(data)
    assert words in one_sentence(refused.value)
