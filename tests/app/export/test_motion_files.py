"""The motion by both doors, the page's and the command line's: same bytes, same refusals."""

from __future__ import annotations

import ast
import io
import json
import zipfile
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from bench.outputs import OF_A_PERSON
from keypose.app.cli.main import main
from keypose.app.editor.known import KnownMotion
from keypose.app.editor.state import EditorState
from keypose.app.export.motion_files import motion_archive
from keypose.app.export.motion_formats import FORMATS, MotionFormat
from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.order import read_order
from keypose.app.posing import opening_pose
from keypose.tracker.errors import FormatError
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.storage.results import Results, save_results
from keypose.tracker.storage.tracks import save_result
from keypose.tracker.video.fingerprint import fingerprint_of_file
from tests.app import results_cases
from tests.app.cli_cases import refused
from tests.tracker import session_cases as cases
from tests.tracker.formats.glb_reading import Player
from tests.tracker.video_cases import write_numbered

STATIC = Path(__file__).parents[3] / "static"
LAST = 8
ANY_BODY = [name for name in FORMATS if name not in OF_A_PERSON]
"""Formats that do not ask for a person."""
EVERY = ",".join(ANY_BODY)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A session on disk, not yet tracked, with keyframes at 0, 4 and 8."""
    folder = tmp_path / "job"
    folder.mkdir()
    return cases.write_session(folder)


def opened(path: Path, results: Results) -> EditorState:
    """The page's state of a session, with these results, which are saved, too."""
    session = load_session(path)
    save_session(save_results(session, path, results), path)
    with open_video_of(session, path) as video:
        times_s, timecode = video.info.times_s, video.info.timecode
    opening = opening_pose(session.subject.body, session.view.camera, (0.0, -1.0, 0.0))
    motion = KnownMotion(results)
    return EditorState(session, cases.SKELETON, times_s, opening, motion, timecode=timecode)


def exported(path: Path, formats: str, *more: str) -> dict[str, bytes]:
    """What the command line writes, by file name."""
    out = path.parent / "out"
    command = ["export", str(path), "--format", formats, "--out", str(out), "--overwrite", *more]
    assert main(command) == 0
    return {file.name: file.read_bytes() for file in out.iterdir()}


def from_page(format_name: MotionFormat, edit: EditorState) -> dict[str, bytes]:
    """What the page saves, unpacked, by the names of the command line."""
    file = motion_archive(format_name, edit)
    if file.media_type != "application/zip":
        return {f"motion{file.suffix}": file.content}
    with zipfile.ZipFile(io.BytesIO(file.content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.mark.parametrize("format_name", ANY_BODY)
def test_the_page_saves_what_the_command_line_writes(format_name: MotionFormat, path: Path) -> None:
    edit = opened(path, results_cases.both(load_session(path)))
    assert from_page(format_name, edit) == exported(path, format_name)


def test_poses_of_a_person_are_refused_for_another_body_by_both_doors(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit = opened(path, results_cases.both(load_session(path)))
    with pytest.raises(FormatError, match="those of a whole person") as reported:
        motion_archive("amass", edit)
    command = ["export", path, "--format", "amass", "--out", path.parent / "out"]
    assert refused(capsys, path.parent, command) == f"{reported.value}\n"


def test_both_doors_refuse_angles_of_a_body_that_is_no_person(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit = opened(path, results_cases.both(load_session(path)))
    with pytest.raises(FormatError, match="this body is no person's") as reported:
        from_page("mot", edit)
    out = path.parent / "out"
    command = ["export", path, "--format", "mot", "--out", out]
    assert str(reported.value) in refused(capsys, path.parent, command)
    command = ["export", path, "--format", "trc", "--markers", "halpe26", "--out", out]
    words = refused(capsys, path.parent, command)
    assert "this body has no Nose: choose the markers keypose" in words
    command = ["export", path, "--format", "trc", "--model", path, "--out", out]
    assert "session.json is not XML" in refused(capsys, path.parent, command)
    command[5] = path.parent / "absent.osim"
    assert "absent.osim cannot be read" in refused(capsys, path.parent, command)


def test_bones_and_unit_are_asked_for_by_both_doors(path: Path) -> None:
    edit = opened(path, results_cases.both(load_session(path)))
    in_cm = motion_archive("bvh", edit, read_order(MotionOrder, {"unit": "cm"})).content
    assert in_cm == exported(path, "bvh", "--unit", "cm")["motion.bvh"]
    assert in_cm != exported(path, "bvh")["motion.bvh"]


def test_a_unit_for_a_format_that_names_its_own_is_refused(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["export", path, "--format", "csv", "--unit", "cm", "--out", path.parent / "out"]
    words = "Unit is for bvh alone.\n"
    assert refused(capsys, path.parent, command) == words


def test_times_begin_at_0_where_that_is_asked_for_by_both_doors(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit = opened(path, results_cases.both(load_session(path)))
    asked = read_order(MotionOrder, {"frames": "4-8", "from_zero": "true"})
    from_zero = motion_archive("glb", edit, asked).content
    files = exported(path, "glb,bvh,csv", "--frames", "4-8", "--from-zero")
    assert files["motion.glb"] == from_zero
    assert "BVH begins at frame 4 of the film" in capsys.readouterr().err
    film = exported(path, "glb,csv", "--frames", "4-8")
    times_s, film_s = (Player.of(one["motion.glb"]).times_s for one in (files, film))
    assert times_s[0] == 0.0
    np.testing.assert_allclose(times_s, film_s - film_s[0], atol=1e-6)
    table = columns(files["frames.csv"])
    assert table["frame"].tolist() == list(range(5))
    assert table["film_frame"].tolist() == list(range(4, 9))


def test_all_formats_are_written_at_once_under_their_names(path: Path) -> None:
    opened(path, results_cases.both(load_session(path)))
    assert sorted(exported(path, EVERY)) == [
        *("angles.csv", "frames.csv", "joints.csv"),
        *("motion.bvh", "motion.c3d", "motion.glb", "motion.npz", "motion.trc", "motion.usd"),
        *("motion_camera.chan", "motion_camera.json", "motion_to_fbx.py"),
    ]


def test_fbx_is_the_glb_and_a_script_for_blender_at_the_rate_of_the_film(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    opened(path, results_cases.both(load_session(path)))
    files = exported(path, "fbx", "--fps", "29.97")
    assert "blender --background --python motion_to_fbx.py" in capsys.readouterr().err
    assert files["motion.glb"] == exported(path, "glb", "--fps", "29.97")["motion.glb"]
    assert b"FPS, FPS_BASE = 30, 1.001001001" in files["motion_to_fbx.py"]
    ast.parse(files["motion_to_fbx.py"])


UNEVEN_MS = [0, 30, 70, 90, 200, 233, 240, 300, 420]


@pytest.fixture
def uneven(path: Path) -> Path:
    """A tracked session about a film whose rate varies."""
    opened(path, results_cases.both(load_session(path)))
    clip = path.parent / "uneven.mkv"
    write_numbered(clip, LAST + 1, pts=UNEVEN_MS, time_base=Fraction(1, 1000))
    cases.altered(path, lambda data: data["video"].update(path=clip.name, fingerprint=""))
    return path


def columns(table: bytes) -> dict[str, np.ndarray]:  # type: ignore[type-arg]
    """The columns of numbers of a table of frames, by name."""
    names, *rows = [line.split(",") for line in table.decode().splitlines()]
    wanted = ("frame", "time_s", "film_frame")
    return {n: np.array([float(row[names.index(n)]) for row in rows]) for n in wanted}


def test_tables_of_a_film_with_an_uneven_rate_keep_every_frame_and_its_time(uneven: Path) -> None:
    files, times_s = exported(uneven, "npz,csv"), np.array(UNEVEN_MS) / 1000
    with np.load(io.BytesIO(files["motion.npz"])) as arrays:
        np.testing.assert_allclose(arrays["time_s"], times_s, atol=1e-12)
        assert arrays["film_frame"].tolist() == arrays["frame"].tolist() == list(range(LAST + 1))
    np.testing.assert_allclose(columns(files["frames.csv"])["time_s"], times_s, atol=1e-6)


def test_other_formats_of_a_film_with_an_uneven_rate_have_its_mean_and_say_so(
    uneven: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = exported(uneven, "bvh,glb,trc")
    rate = LAST / 0.42
    even_s = np.arange(LAST + 1) / rate
    np.testing.assert_allclose(Player.of(files["motion.glb"]).times_s, even_s, atol=1e-6)
    rows = files["motion.trc"].decode().splitlines()[6:]
    np.testing.assert_allclose([float(row.split("\t")[1]) for row in rows], even_s, atol=1e-6)
    assert f"Frame Time: {1 / rate:.9f}" in files["motion.bvh"].decode()
    words = "The film's rate varies: BVH, GLB and TRC have 19.0476 frames a second."
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("rate", [30.0, 10.0])
def test_any_format_can_have_a_rate_of_its_own(rate: float, uneven: Path) -> None:
    files = exported(uneven, "npz,csv,glb", "--fps", f"{rate:g}")
    with np.load(io.BytesIO(files["motion.npz"])) as arrays:
        assert float(arrays["frames_per_second"]) == rate
        count = int(0.42 * rate + 1e-3) + 1
        assert arrays["frame"].tolist() == list(range(count))
        np.testing.assert_allclose(arrays["time_s"], np.arange(count) / rate, atol=1e-12)
        film = np.interp(arrays["time_s"], np.array(UNEVEN_MS) / 1000, np.arange(LAST + 1))
        np.testing.assert_allclose(arrays["film_frame"], film, atol=1e-9)
    table = columns(files["frames.csv"])
    np.testing.assert_allclose(table["film_frame"], film, atol=1e-4)
    assert Player.of(files["motion.glb"]).times_s == pytest.approx(table["time_s"], abs=1e-6)


def test_some_frames_are_exported_alone(path: Path) -> None:
    opened(path, results_cases.both(load_session(path)))
    whole, some = exported(path, "npz"), exported(path, "npz", "--frames", "2-6")
    with (
        np.load(io.BytesIO(some["motion.npz"])) as part,
        np.load(io.BytesIO(whole["motion.npz"])) as every,
    ):
        assert part["frame"].tolist() == [2, 3, 4, 5, 6]
        for name in ("time_s", "ps_camera_joint", "Rs_parent_part", "verdict"):
            np.testing.assert_array_equal(part[name], every[name][2:7])


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--frames", "20-30"], "Of frames 20 to 30 no two have a motion: it goes from 0 to 8."),
        (["--filter", "15Hz"], "choose a cut-off below 15 Hz."),
        (["--filter", "3Hz"], "Frames 0 to 8 are too few to be filtered at 3 Hz: that takes 11."),
        (["--fps", "1"], "At 1 frames a second this motion has no two frames."),
        (["--filter", "loud"], "'loud' is not a cut-off such as 6Hz"),
        (["--fps", "fast"], "'fast' is not a rate"),
    ],
)
def test_what_cannot_be_sampled_is_refused(
    more: list[str], words: str, path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    opened(path, results_cases.both(load_session(path)))
    command = ["export", path, "--format", "npz", "--out", path.parent / "out", *more]
    assert words in refused(capsys, path.parent, command)


def test_page_and_command_line_filter_alike_and_say_it_in_the_file(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit = opened(path, results_cases.both(load_session(path)))
    sampling = read_order(MotionOrder, {"filter_hz": "10", "fps": "50"})
    file = motion_archive("npz", edit, sampling).content
    files = exported(path, "npz,csv,glb,c3d", "--filter", "10Hz", "--fps", "50")
    assert files["motion.npz"] == file
    with np.load(io.BytesIO(file)) as arrays:
        assert float(arrays["filter_hz"]) == 10.0
    assert b'"low_pass_filter_hz":10.0' in files["motion.glb"]
    assert b"LOW_PASS_HZ" in files["motion.c3d"]
    header, row = files["frames.csv"].decode().splitlines()[:2]
    assert row.split(",")[header.split(",").index("filter_hz")] == "10"
    assert "Filtered at 10 Hz, which moves keyframes by up to" in capsys.readouterr().err


def test_a_motion_of_another_rate_is_no_reference(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(path)
    save_session(save_result(session, path, cases.result()), path)
    exported(path, "npz", "--fps", "50")
    capsys.readouterr()
    reference = path.parent / "out" / "motion.npz"
    words = refused(capsys, path.parent, ["evaluate", path, "--reference", reference])
    assert words == (
        "motion.npz has a rate of its own, not the video's frames: export it without --fps.\n"
    )


def test_times_are_those_of_a_video_that_was_renamed(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    opened(path, results_cases.both(load_session(path)))
    pts = [0, 30, 70, 90, 200, 233, 240, 300, 420]
    clip = path.parent / "renamed.mkv"
    write_numbered(clip, LAST + 1, pts=pts, time_base=Fraction(1, 1000))
    fingerprint = fingerprint_of_file(clip, LAST + 1)
    film = {"path": "uneven.mkv", "fingerprint": fingerprint}
    cases.altered(path, lambda data: data["video"].update(film))
    with np.load(io.BytesIO(exported(path, "npz")["motion.npz"])) as arrays:
        np.testing.assert_allclose(arrays["time_s"], np.array(pts) / 1000, atol=1e-12)
    assert "missing" not in capsys.readouterr().err


def with_a_gap(path: Path) -> EditorState:
    """Keyframes at 0, 2, 6 and 8, nothing tracked from 2 to 6."""
    keyframes = cases.session(None, (0, 2, 6, LAST)).subject.keyframes
    session = load_session(path).changed({"keyframes": keyframes})
    save_session(session, path)
    ends = [results_cases.track(session, 0, 2), results_cases.track(session, 6, LAST, kind="lost")]
    return opened(path, Results().with_result(ends[0]).with_result(ends[1]))


@pytest.mark.parametrize("format_name", ["trc", "c3d", "csv", "npz"])
def test_formats_with_room_for_gaps_keep_them_by_both_doors(
    format_name: MotionFormat, path: Path
) -> None:
    edit = with_a_gap(path)
    files = exported(path, format_name)
    assert from_page(format_name, edit) == files
    if format_name == "npz":
        with np.load(io.BytesIO(files["motion.npz"])) as arrays:
            assert arrays["verdict"].tolist() == ["good"] * 3 + [""] * 3 + ["lost"] * 3
            assert np.isnan(arrays["ps_camera_root"]).any(axis=1).tolist() == (
                [False] * 3 + [True] * 3 + [False] * 3
            )


@pytest.mark.parametrize("format_name", ["bvh", "glb", "usd"])
def test_formats_without_room_for_gaps_name_the_frames_by_both_doors(
    format_name: MotionFormat, path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit = with_a_gap(path)
    words = (
        f"Frames 3 to 5 are not tracked, and {format_name.upper()} holds no gaps: track them "
        "first, or choose CSV, NPZ, TRC or C3D."
    )
    with pytest.raises(FormatError) as reported:
        motion_archive(format_name, edit)
    assert str(reported.value) == words
    out = path.parent / "out"
    command = ["export", path, "--format", f"csv,{format_name}", "--out", out]
    assert refused(capsys, path.parent, command) == f"{words}\n"


def test_what_is_tracked_at_one_end_is_exported_without_the_rest(path: Path) -> None:
    session = load_session(path)
    edit = opened(path, Results().with_result(results_cases.track(session, 4, LAST)))
    assert from_page("bvh", edit) == exported(path, "bvh")
    assert b"Frames: 5\n" in from_page("bvh", edit)["motion.bvh"]
    table = exported(path, "csv")["frames.csv"].decode().splitlines()[1:]
    assert [row.split(",")[2] for row in table] == [
        *["missing"] * 4, "keyframe", *["tracked"] * 3, "keyframe",
    ]  # fmt: skip


def test_without_a_motion_the_page_says_what_to_do(path: Path) -> None:
    edit = opened(path, Results())
    with pytest.raises(FormatError, match="There is no motion yet: pose two keyframes and track"):
        motion_archive("npz", edit)


def test_the_words_are_in_the_tables_by_both_doors(path: Path) -> None:
    session = load_session(path)
    lost = results_cases.track(session, 4, LAST, kind="lost")
    edit = opened(path, results_cases.both(session).with_result(lost))
    table = from_page("csv", edit)["frames.csv"].decode()
    assert "lost: add a keyframe near 2" in table
    assert table.encode() == exported(path, "csv")["frames.csv"]


def test_an_archive_is_a_reference_with_no_error_against_its_own_motion(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(path)
    save_session(save_result(session, path, cases.result()), path)
    reference = path.parent / "out" / "motion.npz"
    exported(path, "npz")
    capsys.readouterr()
    assert main(["evaluate", str(path), "--reference", str(reference), "--json"]) == 0
    errors = json.loads(capsys.readouterr().out)["estimate"]["pixels"]["overall"]
    assert errors["count"] > 0
    assert errors["mean"] == 0.0


@pytest.mark.parametrize("formats", ["dae", "bvh,dae", "", "bvh,", "bvh glb"])
def test_a_format_that_is_none_is_refused(
    formats: str, path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["export", path, "--format", formats, "--out", path.parent / "out"]
    words = refused(capsys, path.parent, command)
    assert "There is no format" in words
    assert f"choose from {', '.join(FORMATS)}" in words


def test_json_lists_every_file(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    opened(path, results_cases.both(load_session(path)))
    out = path.parent / "out"
    command = ["export", str(path), "--format", "CSV, glb,csv", "--out", str(out), "--json"]
    assert main(command) == 0
    written = json.loads(capsys.readouterr().out)["written"]
    names = ["motion.glb", "joints.csv", "angles.csv", "frames.csv"]
    assert written == [str(out / name) for name in names]


def test_nothing_is_written_where_one_of_several_is_there_already(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    opened(path, results_cases.both(load_session(path)))
    out = path.parent / "out"
    out.mkdir()
    (out / "motion.trc").write_text("mine")
    command = ["export", path, "--format", EVERY, "--out", out]
    assert "motion.trc" in refused(capsys, path.parent, command)


def test_a_rig_has_the_same_bones_by_both_doors(path: Path) -> None:
    state = opened(path, results_cases.both(load_session(path)))
    given = exported(path, "glb", "--rig", "keypose")["motion.glb"]
    assert motion_archive("glb", state).content == given


@pytest.mark.parametrize(
    ("formats", "rig", "words"),
    [
        ("glb", "mixamo", "The rig mixamo is for a person"),
        ("csv,npz", "vrm", "Rig is for bvh, glb, fbx and usd alone."),
        ("glb", "biped", "invalid choice: 'biped'"),
    ],
)
def test_a_rig_that_cannot_be_is_reported(
    formats: str, rig: str, words: str, path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    opened(path, results_cases.both(load_session(path)))
    command = ["export", path, "--format", formats, "--rig", rig, "--out", path.parent / "out"]
    assert words in refused(capsys, path.parent, command)


def test_a_part_of_the_motion_stands_on_the_floor_of_the_whole(path: Path) -> None:
    opened(path, results_cases.both(load_session(path)))
    whole, part = (
        exported(path, "glb,camera", *more)
        for more in ((), ("--frames", "4-6", "--filter", "10Hz", "--fps", "50"))
    )
    cameras = [json.loads(f["motion_camera.json"])["T_world_camera"] for f in (whole, part)]
    assert cameras[0] == cameras[1]
    stand = [Player.of(f["motion.glb"]).transforms(None)["camera"] for f in (whole, part)]
    np.testing.assert_array_equal(*stand)
