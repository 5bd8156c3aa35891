"""`keypose hull`: surfaces from silhouettes, on the command line."""

from __future__ import annotations

import json
import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.tracker import warm
from keypose.tracker.kernels import carving, patches
from keypose.tracker.keypoints.blazepose import BlazePose
from keypose.tracker.surface.cameras import hulls
from keypose.tracker.surface.files.sequence import MeshSequence
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.placing import Placement
from tests.rendering.studio import write_studio
from tests.tracker.surface.ball_cases import P_BALL, RADIUS_M, studio
from tests.tracker.surface.test_person import Disc

PLACED = Placement("cm", "+z", np.array([0.0, 0.5, 3.8]))
VOXEL = ["--voxel", "0.03"]


@pytest.fixture
def cameras(tmp_path: Path) -> Path:
    views, shots = studio(4)
    return write_studio(tmp_path / "studio", views, [shots] * 3, PLACED)


def test_silhouettes_become_meshes_that_open_and_show_how_the_cameras_agree(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "meshes"
    assert main(["hull", str(cameras), "--out", str(out), *VOXEL]) == 0
    assert "step_0000.ply to step_0002.ply, 3 of 3" in capsys.readouterr().out
    with MeshSequence.open(out) as sequence:
        assert sequence.frame_count == 3
        mesh = sequence.mesh(1)
    assert mesh.consistency is not None
    assert np.ptp(mesh.consistency) > 0.5
    p_camera = PLACED.points(mesh.vertices)  # centimetres, z up, as the cameras' file says
    assert np.linalg.norm(p_camera - P_BALL, axis=1).min() == pytest.approx(RADIUS_M, abs=0.02)


def test_json_shows_what_was_written_and_nothing_else(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "meshes"
    assert main(["hull", str(cameras), "--out", str(out), "--json", *VOXEL]) == 0
    reported = json.loads(capsys.readouterr().out)
    assert reported["written"] == [str(out / f"step_000{i}.ply") for i in range(3)]
    assert reported["steps"] == 3
    assert reported["refused"] == []
    assert reported["interrupted"] is False


def test_a_step_without_a_hull_is_reported_and_left_out(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shape = cameras.parent / "camera_01" / "silhouettes" / "0001.png"
    import cv2

    cv2.imwrite(str(shape), np.zeros((480, 640), np.uint8))
    out = tmp_path / "meshes"
    assert main(["hull", str(cameras), "--out", str(out), *VOXEL]) == 1
    assert sorted(path.name for path in out.iterdir()) == ["step_0000.ply", "step_0002.ply"]
    assert "step 1 is left out. No place lies" in capsys.readouterr().err


def test_a_camera_whose_silhouette_cannot_be_read_is_left_out_and_told(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (cameras.parent / "camera_02" / "silhouettes" / "0001.png").write_bytes(b"no picture")
    assert main(["hull", str(cameras), "--out", str(tmp_path / "meshes"), *VOXEL]) == 0
    expected = "camera 'camera_02' is left out at step 1: its picture cannot be read."
    assert expected in capsys.readouterr().err


def test_a_person_that_is_found_needs_no_silhouettes(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    (cameras.parent / "camera_02" / "images" / "0001.png").write_bytes(b"no picture")
    data = json.loads(cameras.read_bytes())
    for camera in data["cameras"]:
        camera["silhouettes"] = None
    cameras.write_text(json.dumps(data))
    monkeypatch.setattr(BlazePose, "open", Disc)
    command = ["hull", str(cameras), "--out", str(tmp_path / "meshes"), *VOXEL]
    assert main(command) == 2
    assert "have silhouettes: at least two must name theirs, or --person" in capsys.readouterr().err
    assert main([*command, "--person"]) == 0
    out, err = capsys.readouterr()
    assert "step_0000.ply to step_0002.ply, 3 of 3" in out
    assert "camera 'camera_02' is left out at step 1: its picture shows nobody or cannot" in err
    assert main([*command, "--person", "--json", "--overwrite"]) == 0
    assert json.loads(capsys.readouterr().out)["left_out"] == {"camera_02": [1]}


def test_ctrl_c_keeps_what_is_done(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    make = hulls.Hulls.mesh

    def interrupted(self: hulls.Hulls, step: int) -> SurfaceMesh:
        if step == 1:
            signal.raise_signal(signal.SIGINT)
        return make(self, step)

    monkeypatch.setattr(hulls.Hulls, "mesh", interrupted)
    out = tmp_path / "meshes"
    assert main(["hull", str(cameras), "--out", str(out), *VOXEL]) == 130
    assert sorted(path.name for path in out.iterdir()) == ["step_0000.ply", "step_0001.ply"]
    assert "2 of 3 steps are kept" in capsys.readouterr().err


def test_meshes_that_are_there_are_not_written_over_unasked(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "meshes"
    out.mkdir()
    (out / "step_0002.ply").write_bytes(b"mine")
    assert main(["hull", str(cameras), "--out", str(out), *VOXEL]) == 2
    assert "step_0002.ply" in capsys.readouterr().err
    assert (out / "step_0002.ply").read_bytes() == b"mine"
    assert main(["hull", str(cameras), "--out", str(out), "--overwrite", *VOXEL]) == 0
    assert (out / "step_0002.ply").read_bytes() != b"mine"


@pytest.mark.parametrize(
    ("drop", "more", "words"),
    [
        ("silhouettes", [], "Only 0 of the 4 cameras have silhouettes"),
        ("", ["--voxel", "0"], "is not a length"),
        ("", ["--voxel", "nan"], "is not a length"),
    ],
)
def test_what_cannot_be_done_is_reported_in_one_sentence(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    drop: str, more: list[str], words: str,
) -> None:  # fmt: skip
    data = json.loads(cameras.read_bytes())
    for camera in data["cameras"]:
        camera[drop] = None
    cameras.write_text(json.dumps(data))
    try:
        code = main(["hull", str(cameras), "--out", str(tmp_path / "meshes"), *more])
    except SystemExit as refused:
        code = int(str(refused.code))
    assert code == 2
    reported = capsys.readouterr().err
    assert words in reported
    assert reported.count("\n") == 1
    assert not (tmp_path / "meshes").exists()


def test_without_images_the_surfaces_say_nothing_of_agreement(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = json.loads(cameras.read_bytes())
    for camera in data["cameras"]:
        camera["images"] = None
    cameras.write_text(json.dumps(data))
    out = tmp_path / "meshes"
    assert main(["hull", str(cameras), "--out", str(out), *VOXEL]) == 0
    assert "names no images" in capsys.readouterr().err
    with MeshSequence.open(out) as sequence:
        assert sequence.mesh(0).consistency is None


def test_what_takes_its_time_is_said_before_it_is_done(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """The first run compiles the loops, and each step is told as it is done."""
    compiled = []
    monkeypatch.setattr(warm, "are_hulls_warm", lambda: False)
    monkeypatch.setattr(warm, "warm_hulls", lambda: compiled.append(capsys.readouterr().err))
    assert main(["hull", str(cameras), "--out", str(tmp_path / "meshes"), *VOXEL]) == 0
    assert compiled == ["Preparing hulls for this computer, once: some ten seconds.\n"]
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(":")[0] for line in lines] == [f"step {i}, {i + 1} of 3" for i in range(3)]
    assert all(line.endswith(" faces") for line in lines)


def test_loops_that_are_compiled_already_are_not_prepared_again(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr(warm, "are_hulls_warm", lambda: True)
    out = ["--out", str(tmp_path / "meshes")]
    assert main(["hull", str(cameras), *out, *VOXEL, "--json"]) == 0
    assert capsys.readouterr().err == ""


def test_at_a_terminal_a_bar_counts_the_steps(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main(["hull", str(cameras), "--out", str(tmp_path / "meshes"), *VOXEL]) == 0
    reported = capsys.readouterr().err
    assert "0/3" in reported
    assert "3/3" in reported
    assert "1 of 3" not in reported


def test_preparing_compiles_all_that_a_hull_needs(cameras: Path, tmp_path: Path) -> None:
    """What the command does after it said so compiles nothing more."""
    warm.warm_hulls()
    assert warm.are_hulls_warm()
    loops = (carving.judge_cells, carving.measure_cells, patches.correlate)
    before = [len(loop.signatures) for loop in loops]  # type: ignore[attr-defined]
    assert all(before)
    out = ["--out", str(tmp_path / "meshes")]
    assert main(["hull", str(cameras), *out, *VOXEL]) == 0
    assert [len(loop.signatures) for loop in loops] == before  # type: ignore[attr-defined]
