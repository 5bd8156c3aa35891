"""The command line: what its commands write and print."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from keypose.app.cli import follow
from keypose.app.cli.main import THREADS, grammar, main
from keypose.app.render.palette import Picture
from keypose.app.render.studio import _with_plate
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.tracks import load_trajectory, save_result
from keypose.tracker.video import MissingFrame, Video
from tests.tracker import session_cases as cases
from tests.tracker.damage_cases import FilmKind, write_film
from tests.tracker.video_cases import flip_bit, write_numbered


def test_evaluation_prints_the_tracker_beside_interpolation(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = load_trajectory(load_session(tracked_path), tracked_path)
    np.savez(
        tmp_path / "truth.npz",
        Rs_parent_part=truth.Rs_parent_part,
        ps_camera_root=truth.ps_camera_root,
        first_frame=0,
    )
    command = ["evaluate", str(tracked_path), "--reference", str(tmp_path / "truth.npz")]
    assert main(command) == 0
    text = capsys.readouterr().out
    assert text.startswith("truth.npz: 6 frames between keyframes")
    assert all(word in text for word in ("interpolated", "in space, cm", "joint angles, °", "tip"))
    assert main([*command, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["frames"] == [1, 2, 3, 5, 6, 7]
    assert data["estimate"]["pixels"]["overall"]["mean"] == pytest.approx(0, abs=1e-9)
    assert data["interpolation"]["pixels"]["overall"]["mean"] > 0


def test_marked_joints_evaluate_in_pixels(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    marks = tmp_path / "marks.json"
    marks.write_text(json.dumps({"frames": {"0": {"tip": [1, 2]}, "2": {"tip": [30, 20]}}}))
    assert main(["evaluate", str(tracked_path), "--reference", str(marks), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["frames"] == [2]
    assert data["estimate"]["distance_m"] is None


@pytest.mark.parametrize("view", ["main", "top", "side", "front", "all"])
def test_a_shot_is_a_picture_of_the_height_of_the_video(
    tracked_path: Path, tmp_path: Path, view: str
) -> None:
    out = tmp_path / f"{view}.png"
    command = ["shot", str(tracked_path), "--frame", "3", "--view", view, "--out", str(out)]
    assert main(command) == 0
    picture = cv2.imread(str(out))
    assert picture is not None
    assert picture.shape[0] == cases.HEIGHT
    assert view == "all" or picture.shape[1] == cases.WIDTH


def test_a_keyframe_can_be_drawn_before_tracking(session_path: Path, tmp_path: Path) -> None:
    command = ["shot", str(session_path), "--frame", "4", "--style", "wire"]
    assert main([*command, "--out", str(tmp_path / "a.png")]) == 0


def test_a_distorted_camera_draws_over_the_rectified_frame(
    tracked_path: Path, tmp_path: Path
) -> None:
    plain, bent = tmp_path / "plain.png", tmp_path / "bent.png"
    command = ["shot", str(tracked_path), "--frame", "3", "--out"]
    assert main([*command, str(plain)]) == 0
    distortion = [-0.3, 0.1, 0, 0, 0]
    cases.altered(tracked_path, lambda data: data["camera"].update(distortion=distortion))
    assert main([*command, str(bent)]) == 0
    assert plain.read_bytes() != bent.read_bytes()


def test_tables_are_exported(tracked_path: Path, tmp_path: Path) -> None:
    out = tmp_path / "tables"
    assert main(["export", str(tracked_path), "--format", "csv", "--out", str(out)]) == 0
    names = ["angles.csv", "frames.csv", "joints.csv"]
    assert sorted(path.name for path in out.iterdir()) == names
    assert len((out / "joints.csv").read_text().splitlines()) == 10


def test_bvh_is_exported_without_the_video(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tracked_path.parent / "frames").rename(tmp_path / "elsewhere")
    command = ["export", str(tracked_path), "--format", "bvh", "--out", str(tmp_path)]
    assert main(command) == 0
    assert "the video is missing" in capsys.readouterr().err
    assert "Frame Time: 0.040000000" in (tmp_path / "motion.bvh").read_text()


def test_an_export_shows_which_keyframes_it_does_not_know(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cases.altered(tracked_path, lambda data: data["keyframes"][1].update(root_m=[0, 0, 4]))
    main(["export", str(tracked_path), "--format", "bvh", "--out", str(tmp_path)])
    assert "keyframes were set, changed or removed at frame 4)." in capsys.readouterr().err


COMMANDS_WITH_RESULTS: dict[str, list[str]] = {
    "shot": ["--frame", "3", "--out", "a.png"],
    "export": ["--format", "csv", "--out", "tables"],
    "evaluate": ["--reference", "marks.json"],
}


@pytest.mark.parametrize("command", COMMANDS_WITH_RESULTS)
def test_results_out_of_date_are_used_with_a_note(
    tracked_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: str,
) -> None:
    monkeypatch.chdir(tracked_path.parent)
    Path("marks.json").write_text(json.dumps({"frames": {"2": {"tip": [30, 20]}}}))
    arguments = [command, "session.json", *COMMANDS_WITH_RESULTS[command]]
    assert main(arguments) == 0
    assert capsys.readouterr().err == ""
    cases.altered(tracked_path, lambda data: data["camera"].update(fx=61.0))
    assert main(arguments + (["--overwrite"] if command != "evaluate" else [])) == 0
    note = "Note: the tracked motion is out of date (body, camera or ignore masks have changed).\n"
    assert capsys.readouterr().err == note


def test_evaluation_keeps_to_the_keyframes_of_the_tracking(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    marks = {str(frame): {"tip": [30, 20]} for frame in range(9)}
    (tmp_path / "marks.json").write_text(json.dumps({"frames": marks}))
    command = ["evaluate", str(tracked_path), "--reference", str(tmp_path / "marks.json")]
    assert main([*command, "--json"]) == 0
    before, _ = capsys.readouterr()
    cases.altered(tracked_path, lambda data: data["keyframes"].pop(1))
    assert main([*command, "--json"]) == 0
    after, note = capsys.readouterr()
    assert after == before
    assert json.loads(after)["frames"] == [1, 2, 3, 5, 6, 7]
    assert "removed at frame 4)." in note


@pytest.mark.parametrize("command", ["shot", "export"])
def test_json_lists_the_files_that_were_written(
    tracked_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: str,
) -> None:
    monkeypatch.chdir(tracked_path.parent)
    assert main([command, "session.json", *COMMANDS_WITH_RESULTS[command], "--json"]) == 0
    written = json.loads(capsys.readouterr().out)["written"]
    assert len(written) == {"shot": 1, "export": 3}[command]
    assert all(Path(name).is_file() for name in written)


@pytest.mark.parametrize("view", ["main", "all"])
def test_a_missing_frame_is_drawn_grey_with_the_body_and_says_so(
    tracked_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, view: str
) -> None:
    def lost(_: Video, index: int) -> None:
        raise MissingFrame(f"Frame {index} is damaged.")

    message: list[str] = []

    def plate(_: Picture, words: str, *__: object) -> None:
        message.append(words)

    monkeypatch.setattr(Video, "frame", lost)
    monkeypatch.setattr("keypose.app.render.lettering.plate", plate)
    monkeypatch.setattr("keypose.app.render.pictures.plate", plate)
    monkeypatch.setattr("keypose.app.render.studio.plate", plate)
    out = tmp_path / "a.png"
    command = ["shot", str(tracked_path), "--frame", "3", "--view", view, "--out", str(out)]
    assert main(command) == 0
    assert message == ["Frame 3 is missing"]
    picture = cv2.imread(str(out))
    assert picture is not None
    assert picture[-1, 0].tolist() == [128, 128, 128]
    assert np.ptp(picture[:, : cases.WIDTH]) > 50


@pytest.mark.parametrize("width", [160, 640, 1920])
def test_the_plate_of_a_missing_frame_fits_into_the_picture(width: int) -> None:
    picture = np.full((width * 3 // 4, width, 3), 128, dtype=np.uint8)
    _with_plate(picture, "Frame 12345 is missing")
    columns = np.flatnonzero((picture != 128).any(axis=(0, 2)))
    assert len(columns)
    assert columns[0] > 0
    assert columns[-1] < width - 1


def test_a_tracked_frame_beside_a_gap_is_drawn(session_path: Path, tmp_path: Path) -> None:
    session = load_session(session_path)
    parts = cases.result(cases.segment(6, 8), cases.segment(0, 3))
    save_session(save_result(session, session_path, parts), session_path)
    command = ["shot", str(session_path), "--frame", "7", "--out", str(tmp_path / "a.png")]
    assert main(command) == 0


def test_info_gives_the_facts_of_a_video(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frames = cases.write_frames(tmp_path / "frames")
    assert main(["info", str(frames)]) == 0
    assert "64×48 pixels" in capsys.readouterr().out
    assert main(["info", str(frames), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["frame_count"] == cases.FRAMES
    assert facts["fingerprint"].startswith("sha256:")


def test_info_says_how_images_of_sixteen_bits_and_uneven_numbers_are_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for number in (1, 2, 4):
        assert cv2.imwrite(str(tmp_path / f"{number}.png"), np.full((4, 6), 4000, np.uint16))
    assert main(["info", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "note         12 of 16 bits are used: they are spread to the full range" in said
    assert "note         image numbers 3 missing: the images are read as consecutive" in said
    (tmp_path / "2.png").write_bytes(b"no picture")
    assert main(["info", str(tmp_path), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["depth"], facts["missing_frames"]) == (12, [1])


@pytest.mark.parametrize(
    ("turn", "words"),
    [
        ((90,), "rotated by 90° to be upright"),
        ((0, True, False), "mirrored left to right to be upright"),
        ((0, False, True), "mirrored top to bottom to be upright"),
        ((90, True, False), "rotated by 90°, then mirrored left to right to be upright"),
        (None, ""),
    ],
)
def test_info_says_how_a_picture_is_turned_and_mirrored(
    tmp_path: Path, turn: tuple[Any, ...] | None, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    film = write_numbered(tmp_path / "clip.mp4", 3, turn=turn)
    assert main(["info", str(film)]) == 0
    notes = [line for line in capsys.readouterr().out.splitlines() if "upright" in line]
    assert notes == ([f"  note         {words}"] if words else [])


def test_info_check_decodes_every_frame_and_names_the_damaged_ones(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kind = FilmKind("clip.mp4", options={"x264-params": "keyint=8:min-keyint=8:bframes=0"})
    film = write_film(tmp_path, kind)
    assert main(["info", str(film), "--check"]) == 0
    assert "every frame was decoded, and none is damaged" in capsys.readouterr().out
    flip_bit(film, packet=9, byte=60)
    assert main(["info", str(film)]) == 0
    assert "damaged" not in capsys.readouterr().out
    assert main(["info", str(film), "--check"]) == 0
    assert "7 frames are damaged and not used for tracking: 9–15" in capsys.readouterr().out
    assert main(["info", str(film), "--check", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["checked"], facts["damaged_frames"]) == (True, [*range(9, 16)])


@pytest.mark.parametrize("kind", ["body", "session"])
def test_the_schema_is_json(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", kind]) == 0
    assert json.loads(capsys.readouterr().out)["type"] == "object"


def test_a_fault_of_the_program_is_reported_in_full_with_an_exit_code_of_its_own(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(*_: object, **__: object) -> Iterator[Any]:
        raise ZeroDivisionError

    monkeypatch.setattr(follow, "rerun", broken)
    assert main(["track", str(session_path)]) == 70
    err = capsys.readouterr().err
    assert err.startswith("Traceback")
    assert "ZeroDivisionError" in err
    assert err.endswith("\nThis is an error in Keypose, not in your input.\n")


def loaded_by(code: str) -> set[str]:
    """The modules that a fresh interpreter has loaded after this code."""
    code = f"import sys, atexit; atexit.register(lambda: print(*sys.modules)); {code}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


@pytest.mark.parametrize("words", [["--version"], ["--help"], ["open", "--help"]])
def test_what_answers_at_once_loads_no_heavy_library(words: list[str]) -> None:
    loaded = loaded_by(f"from keypose.app.cli.main import main; main({words})")
    assert "keypose.app.cli.main" in loaded
    heavy = {"av", "cv2", "numba", "numpy", "pydantic", "scipy", "starlette", "uvicorn", "viser"}
    assert not heavy & loaded


PAGE = {"starlette", "uvicorn", "viser", "websockets"}
LOOPS = {"numba", "llvmlite", "scipy"}
NETWORKS = {"ai_edge_litert", "onnxruntime", "keypose.tracker.keypoints.runtimes"}
MESHES = {"trimesh", "keypose.tracker.surface.mesh"}


@pytest.mark.parametrize(
    "words",
    [["export", "--format", "csv,bvh", "--out", "{out}"], ["review"], ["schema", "session"]],
    ids=lambda words: words[0],
)
def test_what_reads_and_writes_files_loads_neither_loops_nor_networks_nor_the_page(
    tracked_path: Path, tmp_path: Path, words: list[str]
) -> None:
    name, *options = (word.format(out=tmp_path / "out") for word in words)
    about = [] if name == "schema" else [str(tracked_path)]
    ended = f"sys.exit(main({[name, *about, *options]}))"
    loaded = loaded_by(f"from keypose.app.cli.main import main; {ended}")
    assert f"keypose.app.cli.{name}" in loaded
    assert not loaded & (PAGE | LOOPS | NETWORKS | MESHES)


@pytest.mark.parametrize("command", ["track", "stand", "draft", "run", "camera"])
def test_what_finds_motion_loads_nothing_of_the_page(command: str) -> None:
    assert not loaded_by(f"import keypose.app.cli.{command}") & PAGE


@pytest.mark.parametrize("module", ["keypose.app.server.server", "keypose.app.store.store"])
def test_the_page_loads_no_compiled_loops_and_no_statistics_before_they_are_wanted(
    module: str,
) -> None:
    assert not {"numba", "scipy"} & loaded_by(f"import {module}")


@pytest.mark.parametrize("chosen", [{}, dict.fromkeys(THREADS, "3")])
def test_blas_and_opencv_have_one_thread_unless_somebody_has_chosen_another_number(
    chosen: dict[str, str],
) -> None:
    code = (
        "from keypose.app.cli.main import main; main(['models', '--json']); "
        "import cv2, os; print(cv2.getNumThreads(), os.environ['OPENBLAS_NUM_THREADS'])"
    )
    usual = {name: value for name, value in os.environ.items() if name not in THREADS}
    done = subprocess.run(
        [sys.executable, "-c", code], env=usual | chosen, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1].split() == ["3" if chosen else "1"] * 2


def test_the_package_runs_as_a_program(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "keypose.app", "track", str(tmp_path / "none.json")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == f"There is no session file '{tmp_path / 'none.json'}'.\n"


def test_a_reader_that_goes_away_is_no_error() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "wb") as out:
        done = subprocess.run(
            [sys.executable, "-m", "keypose.app", "schema", "session"],
            stdout=out,
            stderr=subprocess.PIPE,
            check=False,
        )
    assert (done.returncode, done.stderr) == (141, b"")


def test_without_a_command_one_reads_what_there_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    assert "examples:" in capsys.readouterr().out


def test_it_gives_its_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"keypose {version('keypose')}\n"


def test_a_sessions_folder_stands_for_its_file(tracked_path: Path, tmp_path: Path) -> None:
    out = tmp_path / "a.png"
    assert main(["shot", str(tracked_path.parent), "--frame", "2", "--out", str(out)]) == 0
    assert out.exists()


@pytest.mark.parametrize("given", ["a folder", "a video", "a folder of folders", "nothing"])
def test_a_session_is_found_from_what_a_person_has_at_hand(
    tracked_path: Path, tmp_path: Path, given: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = tmp_path / "films"
    shutil.copytree(tracked_path.parent, here / "jump.keypose")
    (here / "jump.mp4").write_bytes(b"only its name matters")
    monkeypatch.chdir(here / "jump.keypose" if given == "nothing" else here)
    words = {"a folder": ["jump.keypose"], "a video": ["jump.mp4"], "a folder of folders": ["."]}
    out = tmp_path / "tables"
    assert main(["export", *words.get(given, []), "--format", "csv", "--out", str(out)]) == 0
    assert (out / "joints.csv").exists()


@pytest.mark.parametrize(
    ("given", "message"),
    [("new.mp4", "`keypose open new.mp4` begins one"), (".", "a.keypose, b.keypose: give one")],
)
def test_what_has_no_session_or_several_is_reported(
    tracked_path: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    given: str,
    message: str,
) -> None:
    for name in ("a.keypose", "b.keypose"):
        shutil.copytree(tracked_path.parent, tmp_path / "films" / name)
    monkeypatch.chdir(tmp_path / "films")
    Path("new.mp4").touch()
    with pytest.raises(SystemExit) as ended:
        main(["track", given])
    assert ended.value.code == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("name", grammar()[1])
def test_every_option_and_argument_is_explained(name: str) -> None:
    unexplained = [action.dest for action in grammar()[1][name]._actions if not action.help]
    assert unexplained == []
