"""`keypose import --camera`: what another program knows of the camera, in the session."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keypose.app.cli.main import main
from keypose.tracker.body.pose import joint_positions, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.storage.files import load_session, save_session
from tests.app.cli_cases import refused
from tests.tracker import panned_cases as panned
from tests.tracker import session_cases as cases


@pytest.fixture
def path(tmp_path: Path) -> Path:
    folder = tmp_path / "job"
    folder.mkdir()
    return cases.write_session(folder)


def chan(folder: Path, *lines: str) -> Path:
    file = folder / "shot.chan"
    file.write_text("\n".join(lines))
    return file


def test_the_lens_and_what_is_up_are_the_files(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = load_session(path)
    file = chan(path.parent, "1 0 1.5 0 -10 0 0 30", "2 0 1.5 0 -10 0 0 30")
    assert main(["import", str(path), str(file), "--camera"]) == 0
    made = load_session(path)
    assert made.view.camera.fy == pytest.approx(
        before.view.camera.height / 2 / np.tan(np.radians(15))
    )
    assert made.view.lens_source == "calibration"
    tilt = np.radians(10)
    np.testing.assert_allclose(made.world.up_world, [0, -np.cos(tilt), -np.sin(tilt)], atol=1e-6)
    message = capsys.readouterr().out
    assert "Up: turned by 10.0°." in message
    assert f"Written: {path}" in message


def test_what_was_posed_is_seen_as_large_as_before(path: Path) -> None:
    before = load_session(path)
    assert main(["import", str(path), str(chan(path.parent, "1 0 0 0 0 0 0 20")), "--camera"]) == 0
    made, skeleton = load_session(path), Skeleton.of(before.subject.body)
    for old, new in zip(before.subject.keyframes, made.subject.keyframes, strict=True):
        assert new.root_m[2] / old.root_m[2] == pytest.approx(
            made.view.camera.fx / before.view.camera.fx
        )
        places = [
            session.view.camera.project(
                joint_positions(skeleton, pose_transforms(skeleton, k.pose(skeleton)))[0]
            )
            - (session.view.camera.cx, session.view.camera.cy)
            for session, k in ((before, old), (made, new))
        ]
        np.testing.assert_allclose(*places, atol=1e-6)


def test_the_camera_that_was_exported_outdates_nothing(path: Path, tmp_path: Path) -> None:
    from keypose.tracker.storage.results import save_results
    from tests.app import results_cases

    session = load_session(path)
    tracked = save_results(session, path, results_cases.both(session))
    save_session(tracked.changed({"floor_m": -1.0}), path)
    out = tmp_path / "out"
    command = ["export", str(path), "--format", "camera,chan,glb", "--out", str(out)]
    assert main(command) == 0
    before = load_session(path)
    for name in ("motion_camera.json", "motion.glb"):
        assert main(["import", str(path), str(out / name), "--camera"]) == 0
        made = load_session(path)
        assert made.changed({"lens_source": before.view.lens_source}) == before


def test_json_shows_what_was_set(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = chan(path.parent, "1 0 0 0 0 0 0 30")
    assert main(["import", str(path), str(file), "--camera", "--json"]) == 0
    message = json.loads(capsys.readouterr().out)
    assert message["written"] == str(path)
    assert message["up_camera"] == [0, -1, 0]
    assert message["fx"] == load_session(path).view.camera.fx


def test_a_camera_that_moves_is_taken_over_and_what_the_file_lacks_is_said(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = chan(path.parent, "2 0 0 0 0 0 0 30", "4 0 0 1 0 0 0 30", "5 0 0 2 0 2 0 40")
    assert main(["import", str(path), str(file), "--camera"]) == 0
    words = capsys.readouterr().out
    assert "The camera moves over 3 frames of the file." in words
    assert "Frames 0–1, 3, 6–" in words
    assert words.count("the imported file does not have them.") == 1
    found = load_session(path).camera_path
    assert found is not None
    places = found.Ts_world_camera[:6, :3, 3]
    np.testing.assert_allclose(places[:, 2], [0, 0, 0, -0.5, -1, -2], atol=1e-9)
    assert found.zoom[4] == 1
    assert found.zoom[5] == pytest.approx(np.tan(np.radians(15)) / np.tan(np.radians(20)))


def test_a_camera_of_another_film_leaves_the_session_as_it_was(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = path.read_bytes()
    file = chan(path.parent, "9001 0 0 0 0 0 0 30", "9002 0 0 1 0 0 0 30")
    words = refused(capsys, path.parent, ["import", path, file, "--camera"])
    assert "shot.chan has frames 9001 to 9002, and the film 0 to" in words
    assert path.read_bytes() == before


def test_options_of_motion_are_not_for_a_camera(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = chan(path.parent, "1 0 0 0 0 0 0 30")
    command = ["import", path, file, "--camera", "--fps", "30"]
    assert "--fps is for motion, not for --camera" in refused(capsys, path.parent, command)


def test_a_film_of_numbered_files_takes_a_camera_by_these_numbers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = panned.write(tmp_path)
    for number in reversed(range(panned.FRAMES)):
        file = tmp_path / "film" / f"{number:03}.png"
        file.rename(tmp_path / "film" / f"{number + 20:03}.png")
    flip, truth = np.diag([1.0, -1.0, -1.0]), panned.Rs_camera_world()
    y, x, z = Rotation.from_matrix(flip @ truth.transpose(0, 2, 1) @ flip).as_euler("YXZ", True).T
    seen = 2 * np.degrees(np.arctan(panned.HEIGHT / 2 / panned.CAMERA.fy))
    lines = (f"{n + 20} 0 0 0 {x[n]} {y[n]} {z[n]} {seen}" for n in range(4, 17))
    assert main(["import", str(path), str(chan(tmp_path, *lines)), "--camera"]) == 0
    found = load_session(path).camera_path
    assert found is not None
    turn, was = found.Ts_camera_world[4:17, :3, :3], truth[4:17]
    np.testing.assert_allclose(turn @ turn[0].T, was @ was[0].T, atol=1e-6)
    said = capsys.readouterr()
    assert "frames 24–36 are taken for 4–16 of the film, by the numbers of the film's" in said.err
    assert "are usually 0." in said.out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--unit", "auto"], "--unit auto is not for --camera: choose from m, cm, mm."),
        (["--world", "camera"], "--world camera is not for --camera: choose from y-up, z-up."),
        (["--layout", "COCO_17"], "--layout is for keypoints, not for --camera"),
    ],
)
def test_what_a_camera_cannot_be_read_as_is_refused(
    path: Path, capsys: pytest.CaptureFixture[str], options: list[str], words: str
) -> None:
    file = chan(path.parent, "1 0 0 0 0 0 0 30")
    assert words in refused(capsys, path.parent, ["import", path, file, "--camera", *options])


def test_a_motion_has_no_rotation_order(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["import", path, path, "--rotation-order", "xyz"]
    assert "--rotation-order is for camera, not for motion" in refused(capsys, path.parent, command)


def test_the_first_frame_of_a_camera_can_be_said(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = chan(path.parent, *(f"{1011 + k} 0 0 0 0 {k} 0 30" for k in range(4)))
    command = ["import", str(path), str(file), "--camera", "--offset-frames", "-1009", "--json"]
    assert main(command) == 0
    found = load_session(path).camera_path
    assert found is not None
    turned = np.degrees(np.arccos(found.Ts_camera_world[:, 0, 0]))
    np.testing.assert_allclose(turned[:7], [0, 0, 0, 1, 2, 3, 3], atol=1e-4)
    assert "notes" in json.loads(capsys.readouterr().out)
