"""`keypose camera`: how the film's camera turned, in the session's file."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from keypose.app.cli import camera
from keypose.app.cli.main import main
from keypose.app.document.folder_lock import locked
from keypose.app.words.camera import finding_sentences, unscaled_words
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import transpose
from keypose.tracker.operations.find_camera import FoundCamera, points_of
from keypose.tracker.session.camera_motion import CameraFinding, CameraMotion, CameraPiece
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import segment_keys
from tests.scenes import sample
from tests.tracker import panned_cases as panned

pytestmark = pytest.mark.usefixtures("own_cache")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return panned.write(tmp_path / "panned")


def test_a_pan_is_found_kept_and_told(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["camera", str(path)]) == 0
    assert capsys.readouterr().out.startswith("The camera turns: background points agree within 0.")
    session = load_session(path)
    found = session.camera_path
    assert found is not None
    miss = found.Ts_camera_world[:, :3, :3] @ transpose(panned.Rs_camera_world())
    cosine = (np.trace(miss, axis1=1, axis2=2) - 1) / 2
    assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).max() < 0.05
    assert not found.zooms
    assert not found.moves
    motion = session.view.camera_motion
    assert motion is not None
    points = points_of(motion)
    assert points is not None
    uv, good = points.of(5)
    assert len(uv) == len(good) > 20
    assert good.mean() > 0.8


def test_as_json_it_says_how_far_it_turned_and_a_dry_run_writes_nothing(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = path.read_bytes()
    assert main(["camera", str(path), "--dry-run", "--json"]) == 0
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert path.read_bytes() == before
    assert {event["event"] for event in events[:-1]} == {"progress"}
    assert events[-1]["kind"] == "turns"
    assert events[-1]["turned_deg"] == pytest.approx(9.0, abs=0.3)
    assert events[-1]["session"] is None


def test_tracking_finds_it_first_where_that_is_asked_for(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    track = ["track", str(path), "--find-camera", "yes", "--frames", "2-12", "--quality", "preview"]
    assert main(track) in (0, 1)
    assert "The camera turns" in capsys.readouterr().err
    session = load_session(path)
    assert session.camera_path is not None
    assert session.subject.results is not None
    assert segment_keys(session)[2, 12] == session.subject.results.segments[0].key
    assert main(track) in (0, 1)
    assert "The camera turns" not in capsys.readouterr().err


def test_a_batch_finds_it_where_the_session_says_so(path: Path) -> None:
    session = load_session(path)
    wanting = session.settings.model_copy(update={"find_camera": True, "quality": "preview"})
    save_session(session.changed({"settings": wanting}), path)
    assert main(["batch", str(path.parent)]) in (0, 1)
    assert load_session(path).camera_path is not None


def test_what_is_doubtful_in_several_stretches_is_said_once_and_cuts_first() -> None:
    moving, cut = "not_rigid", "cut"
    kinds = ((moving, 24, 26), (moving, 40, 40), (cut, 60, 60))
    found = [CameraFinding(kind=k, first_frame=a, last_frame=b) for k, a, b in kinds]
    one, other = finding_sentences(found)
    assert one.startswith("Frame 60: another scene")
    assert other.startswith("Frames 24–26, 40: the background moves")


@pytest.mark.parametrize("share", [0.6, 0.8, 1.4])
def test_a_lens_that_was_a_guess_is_told_by_the_turns_and_the_body_is_seen_as_before(
    path: Path, share: float, capsys: pytest.CaptureFixture[str]
) -> None:
    guess = panned.CAMERA.zoomed(share)
    before = load_session(path).changed({"camera": guess, "lens_source": "guess"})
    save_session(before, path)
    assert main(["camera", str(path)]) == 0
    assert "The lens is set to" in capsys.readouterr().out
    after = load_session(path)
    assert after.view.camera.fx == pytest.approx(panned.CAMERA.fx, rel=0.02)
    assert after.view.lens_source == "turns"
    found = after.camera_path
    assert found is not None
    assert not found.zooms
    roots = [
        session.view.camera.project(np.array([k.root_m for k in session.subject.keyframes]))
        for session in (before, after)
    ]
    assert np.allclose(*roots, atol=1e-6)


def test_a_lens_that_somebody_knows_stays(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = load_session(path).changed({"camera": panned.CAMERA.zoomed(0.8)})
    save_session(before, path)
    assert main(["camera", str(path)]) == 0
    assert "the session has" in capsys.readouterr().out
    assert load_session(path).view.camera == before.view.camera


def test_the_background_is_written_once_the_camera_is_known(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = path.parent / "wall.png"
    assert main(["camera", str(path), "--background", str(out)]) == 2
    assert "find it first" in capsys.readouterr().err
    assert main(["camera", str(path)]) == 0
    before = path.read_bytes()
    assert main(["camera", str(path), "--background", str(out)]) == 0
    assert path.read_bytes() == before
    wide = cv2.imread(str(out))
    assert wide is not None
    assert wide.shape[1] > panned.WIDTH
    assert main(["camera", str(path), "--background", str(out)]) == 2
    assert "exists already" in capsys.readouterr().err


def test_one_word_leaves_the_camera_as_it_was(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = load_session(path)
    assert main(["camera", str(path), "--kind", "turns"]) == 0
    assert load_session(path).camera_path is not None
    assert main(["camera", str(path), "--forget"]) == 0
    assert "as it was" in capsys.readouterr().out
    assert load_session(path) == before


def test_a_camera_that_stands_still_has_no_motion_and_every_digit_stays(tmp_path: Path) -> None:
    path = sample(tmp_path, "box")
    before = load_session(path)
    assert main(["camera", str(path)]) == 0
    after = load_session(path)
    assert after.view.camera_motion is None
    assert after.has_static_camera
    assert after.subject == before.subject
    assert after.view.camera == before.view.camera


def test_a_session_that_is_open_elsewhere_is_left_alone(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = path.read_bytes()
    with locked(path, ""):
        assert main(["camera", str(path)]) == 2
    assert "close it there first" in capsys.readouterr().err
    assert path.read_bytes() == before


def test_found_anew_it_keeps_what_a_person_corrected(path: Path) -> None:
    assert main(["camera", str(path)]) == 0
    session = load_session(path)
    motion = session.view.camera_motion
    assert motion is not None
    key = {"frame": 9, "R_camera_world_wxyz": (1.0, 0.0, 0.0, 0.0)}
    data = session.model_dump(mode="json")
    data["views"][0]["camera_keyframes"] = [key]
    save_session(type(session).model_validate(data), path)
    assert main(["camera", str(path)]) == 0
    again = load_session(path).camera_path
    assert again is not None
    np.testing.assert_array_equal(again.Ts_camera_world[9], np.eye(4))


def walks(path: Path, starts: tuple[int, ...] = (0,)) -> None:
    """The session's camera goes a way whose scale nothing tells."""
    away = panned.path().Ts_camera_world.copy()
    away[:, 0, 3] = np.linspace(0, 1, panned.FRAMES)
    pieces = tuple(CameraPiece(first_frame=first, metres=None) for first in starts)
    given = CameraPath(away, np.ones(panned.FRAMES))
    motion = CameraMotion.of("moves", given, pieces=pieces)
    save_session(load_session(path).changed({"camera_motion": motion}), path)


def test_how_far_the_camera_went_gives_its_path_a_scale(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    walks(path)
    words = unscaled_words(load_session(path))
    assert words is not None
    assert words.startswith("The scale of the camera's path is not known in frames 0–23: ")
    assert main(["camera", str(path), "--went", "3.2"]) == 0
    assert "it went 3.2 m from where it began" in capsys.readouterr().out
    session = load_session(path)
    assert unscaled_words(session) is None
    assert session.camera_path is not None
    places = session.camera_path.Ts_world_camera[:, :3, 3]
    assert np.linalg.norm(places - places[0], axis=1).max() == pytest.approx(3.2, rel=1e-3)


def exit_code(*arguments: str) -> object:
    """What a shell is given, also where the arguments themselves are refused."""
    try:
        return main(list(arguments))
    except SystemExit as left:
        return left.code


@pytest.mark.parametrize(
    "orders", [("--forget", "--went", "3"), ("--kind", "turns", "--went", "3"),
               ("--forget", "--kind", "moves"), ("--background", "wall.png", "--forget")],
)  # fmt: skip
def test_orders_that_exclude_each_other_are_refused_and_change_nothing(
    path: Path, capsys: pytest.CaptureFixture[str], orders: tuple[str, ...]
) -> None:
    before = path.read_bytes()
    assert exit_code("camera", str(path), *orders) == 2
    assert "not allowed with" in capsys.readouterr().err
    assert path.read_bytes() == before


def test_a_camera_that_is_found_with_how_far_it_went_is_worded_as_it_is_then(
    path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    walks(path)
    motion = load_session(path).view.camera_motion
    save_session(panned.panned().changed({"camera_motion": None}), path)
    found = FoundCamera("moves", motion, None, (), None)
    monkeypatch.setattr(camera, "find_saved", lambda *_: found)
    assert main(["camera", str(path), "--went", "3.2"]) == 0
    said = capsys.readouterr().out
    assert "it went 3.2 m from where it began" in said
    assert "not known yet" not in said
    known = load_session(path).view.camera_motion
    assert known is not None
    assert known.ways[0].farthest_m == pytest.approx(3.2, rel=1e-6)


REFUSED = {
    "a pan goes nowhere": (None, "3", "The camera turns and goes nowhere"),
    "several pieces": ((0, 9), "3", "The camera's path is in several pieces"),
    "no way": ((0,), "0", "is not a number from 0.01 to 10000"),
    "no number": ((0,), "far", "is not a number from 0.01 to 10000"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_gives_no_scale_is_said_in_one_sentence_and_changes_nothing(
    path: Path, capsys: pytest.CaptureFixture[str], case: str
) -> None:
    starts, metres, words = REFUSED[case]
    if starts is None:
        save_session(panned.panned(), path)
    else:
        walks(path, starts)
    before = path.read_bytes()
    assert exit_code("camera", str(path), "--went", metres) == 2
    assert words in capsys.readouterr().err
    assert path.read_bytes() == before
