"""Whatever is wrong is said in one sentence, with exit code 2 and nothing written."""

from __future__ import annotations

import errno
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from keypose.app.cli import follow
from keypose.app.cli.main import main
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.tracks import save_result
from tests.app.cli_cases import refused
from tests.tracker import session_cases as cases


def test_files_that_are_there_are_not_overwritten_unless_asked(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("angles.csv", "a.png", "session.json"):
        (tmp_path / name).write_text("mine")
    commands: list[list[str | Path]] = [
        ["export", tracked_path, "--format", "csv", "--out", tmp_path],
        ["shot", tracked_path, "--frame", "3", "--out", tmp_path / "a.png"],
        ["track", tracked_path, "--out", tmp_path],
    ]
    for command in commands:
        assert "exists already" in refused(capsys, tmp_path, command)
        assert main([*(str(a) for a in command), "--overwrite"]) == 0
        capsys.readouterr()
    assert (tmp_path / "session.json.previous").read_text() == "mine"


def _keyframes(*frames: int) -> Callable[[dict[str, Any]], None]:
    """Keep keyframes at these places of the list, in this order."""

    def change(data: dict[str, Any]) -> None:
        data["keyframes"] = [data["keyframes"][i] for i in frames]

    return change


WRONG: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "no keyframes": (_keyframes(), "has no keyframes; tracking needs two"),
    "one keyframe": (_keyframes(1), "has one keyframe; tracking needs two"),
    "keyframes out of order": (_keyframes(1, 0), "sort them by frame"),
    "two keyframes on a frame": (_keyframes(0, 0), "frame 0 has two keyframes"),
    "a keyframe beyond the video": (
        lambda data: data["keyframes"][2].update(frame=1000),
        "beyond the video",
    ),
    "a body behind the camera": (
        lambda data: data["keyframes"][1].update(root_m=[0, 0, -2]),
        "behind the camera",
    ),
    "NaN": (lambda data: data["camera"].update(cx=float("nan")), "camera.cx"),
    "parents in a circle": (
        lambda data: data["body"]["parts"][2].update(parent="left_hand"),
        "its own ancestor",
    ),
    "a missing parent": (
        lambda data: data["body"]["parts"][2].update(parent="tail"),
        "which is missing",
    ),
    "a part of no size": (
        lambda data: data["body"]["parts"][2]["shape"].update(radius_m=0),
        "greater than or equal to 0.000001",
    ),
    "a camera of another size": (
        lambda data: data["camera"].update(width=1920),
        "the sizes must agree",
    ),
    "another fingerprint": (
        lambda data: data["video"].update(fingerprint="sha256:0"),
        "fingerprint differs",
    ),
    "a part left out that is none": (
        lambda data: data["settings"].update(left_out=["tail"]),
        "settings.left_out names 'tail', which the body does not have",
    ),
    "another frame count": (lambda data: data["video"].update(frame_count=99), "9 frames instead"),
    "a missing video": (lambda data: data["video"].update(path="gone.mp4"), "is missing"),
    "a newer version": (lambda data: data.update(schema_version=7), "written by a newer Keypose"),
    "a part with an odd name": (
        lambda data: data["keyframes"][0]["rotations_wxyz"].update({"a\n\x1b[31mb": 1}),
        "rotations_wxyz",
    ),
}


@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_session_is_one_sentence_and_nothing_is_written(
    session_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    change, words = WRONG[kind]
    cases.altered(session_path, change)
    sentence = refused(capsys, session_path.parent, ["track", session_path])
    assert words in sentence
    assert sentence[:-1].isprintable()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fly"], "there is no command 'fly'"),
        (["trak", "session.json"], "did you mean track?"),
        (["frames"], "did you mean `keypose open frames`?"),
        (["track", "--qualty", "full"], "there is no option '--qualty'; did you mean --quality?"),
        (["export", "--formt", "bvh"], "did you mean --format?"),
        (["track", "session.json", "twice.json"], "one argument too many, 'twice.json'"),
        (["track", "none.json"], "no session file"),
        (["track", "frames"], "there is no session in the folder 'frames'"),
        (["track", "session.json", "--workers", "0"], "not a whole number from 1 on"),
        (["track", "session.json", "--method", "guess"], "invalid choice"),
        (["track", "session.json", "--out", "session.json/sub"], "cannot be written to"),
        (["shot", "session.json", "--frame", "x", "--out", "a.png"], "not a whole number"),
        (["shot", "session.json", "--frame", "2", "--out", "a.jpg"], "must end in .png"),
        (["shot", "session.json", "--frame", "99", "--out", "a.png"], "There is no frame 99"),
        (["shot", "session.json", "--frame", "2", "--out", "a.png"], "not been tracked yet"),
        (["export", "session.json", "--format", "csv", "--out", "o"], "not been tracked yet"),
        (["export", "session.json", "--format", "dae", "--out", "o"], "There is no format"),
        (["evaluate", "session.json", "--reference", "none.npz"], "no reference file"),
        (["evaluate", "session.json", "--reference", "."], "is a folder"),
        (
            ["open", "frames", "--port", "0", "--out", "o"],
            "--out copies a session: there is no session in",
        ),
        (["info", "none.mp4"], "no file"),
        (["info", "session.json", "--check"], "--check is for a video or meshes"),
        (["schema", "world"], "invalid choice"),
    ],
)
def test_wrong_arguments_are_one_sentence_and_nothing_is_written(
    session_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str | Path],
    words: str,
) -> None:
    monkeypatch.chdir(session_path.parent)
    assert words in refused(capsys, session_path.parent, arguments)


def test_frames_outside_the_tracked_ones_are_not_drawn(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(tracked_path)
    short = save_result(session, tracked_path, cases.result(cases.segment(0, 4)))
    save_session(short, tracked_path)
    command: list[str | Path] = ["shot", tracked_path, "--frame", "6", "--out", tmp_path / "a.png"]
    assert "the tracked frames are 0 to 4" in refused(capsys, tmp_path, command)


def test_the_words_for_a_gap_do_not_span_tracked_frames(
    session_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parts = cases.result(cases.segment(6, 8), cases.segment(0, 2))
    session = save_result(load_session(session_path), session_path, parts)
    save_session(session.changed({"keyframes": ()}), session_path)
    command: list[str | Path] = ["shot", session_path, "--frame", "4", "--out", tmp_path / "a.png"]
    assert "the tracked frames are 0 to 2, 6 to 8." in refused(capsys, tmp_path, command)


def test_a_folder_that_may_not_be_written_is_reported_before_the_work(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def forbidden(self: Path, *_: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(follow, "rerun", pytest.fail)
    with monkeypatch.context() as patch:
        patch.setattr("keypose.tracker.storage.atomic._write_through", forbidden)
        sentence = refused(capsys, session_path.parent, ["track", session_path])
    assert "Permission denied: the folder" in sentence
    assert "cannot be written to" in sentence


@pytest.mark.parametrize("name", ["", "x" * 5000, "a/" * 3000])
def test_a_name_that_no_file_can_have_is_refused(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for command in (["info", name], ["track", name], ["track", "s.json", "--out", name]):
        refused(capsys, tmp_path, list(command))


@pytest.mark.parametrize(
    ("command", "reader"),
    [
        (["import", "FILE"], "import_.load_motion"),
        (["import", "FILE", "--keypoints"], "import_.read_each"),
        (["import", "FILE", "--camera"], "import_camera.load_camera"),
        (["evaluate", "--reference", "FILE"], "evaluate.load_reference"),
    ],
    ids=["motion", "keypoints", "camera", "reference"],
)
def test_a_file_that_ends_its_reader_is_refused_as_any_other(
    tracked_path: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    command: list[str],
    reader: str,
) -> None:
    harm = tmp_path / "harm.npz"
    harm.write_text("import os; os._exit(0)")
    monkeypatch.setattr(f"keypose.app.cli.{reader}", runpy.run_path)
    name, *options = [str(harm) if word == "FILE" else word for word in command]
    assert "harm.npz is damaged" in refused(capsys, tmp_path, [name, tracked_path, *options])
