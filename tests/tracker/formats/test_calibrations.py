"""Calibrations of several cameras are read as programs write them, and refused in a sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.cameras.calibrations import load_calibration
from keypose.tracker.geometry.rotations import (
    Array,
    log_rotation,
    rotation_from_euler,
    transform,
)

SIZE = 1280, 720
FOCAL = 1000.0, 1010.0
CENTRE = 640.5, 360.25
DISTORTION = 0.1, -0.05, 0.001, -0.002, 0.0
T_FIRST = transform(rotation_from_euler(0.1, -0.3, 0.2), np.array([0.2, -0.1, 3.0]))
T_SECOND = transform(rotation_from_euler(-0.2, 0.9, 0.1), np.array([-0.5, 0.3, 4.0]))


def toml(*cameras: tuple[str, Array]) -> str:
    lines = []
    for number, (name, T) in enumerate(cameras):
        turn = log_rotation(T[:3, :3]).tolist()
        lines += [
            f"[cam_{number}]",
            f'name = "{name}"',
            f"size = [{SIZE[0]}, {SIZE[1]}]",
            f"matrix = [[{FOCAL[0]}, 0.0, {CENTRE[0]}], [0.0, {FOCAL[1]}, {CENTRE[1]}], [0, 0, 1]]",
            f"distortions = {list(DISTORTION)}",
            f"rotation = {turn}",
            f"translation = {T[:3, 3].tolist()}",
            "",
        ]
    return "\n".join([*lines, "[metadata]", "adjusted = false"])


def qualisys(*cameras: tuple[str, Array]) -> str:
    lines = []
    for name, T in cameras:
        R = np.diag([1.0, -1.0, -1.0]) @ T[:3, :3]
        place = -1000 * T[:3, :3].T @ T[:3, 3]
        turns = " ".join(f'r{i + 1}{j + 1}="{R[i, j]}"' for i in range(3) for j in range(3))
        places = " ".join(f'{axis}="{at}"' for axis, at in zip("xyz", place, strict=True))
        lens = {
            "focalLengthU": 64 * FOCAL[0],
            "focalLengthV": 64 * FOCAL[1],
            "centerPointU": 64 * CENTRE[0],
            "centerPointV": 64 * CENTRE[1],
            "radialDistortion1": DISTORTION[0],
            "radialDistortion2": DISTORTION[1],
            "radialDistortion3": 0.0,
            "tangentalDistortion1": DISTORTION[2],
            "tangentalDistortion2": DISTORTION[3],
        }
        values = " ".join(f'{key}="{value}"' for key, value in lens.items())
        fov = f'left="0" top="0" right="{SIZE[0] - 1}" bottom="{SIZE[1] - 1}"'
        lines.append(
            f'<camera serial="{name}"><fov_video {fov}/><transform {turns} {places}/>'
            f"<intrinsic {values}/></camera>"
        )
    return f"<calibration><cameras>{''.join(lines)}</cameras></calibration>"


def matrix(name: str, values: Array) -> str:
    rows, columns = np.atleast_2d(values).shape
    data = ", ".join(f"{value:.12g}" for value in np.ravel(values))
    head = f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n"
    return f"{head}   data: [ {data} ]"


def opencv() -> str:
    K = np.array([[FOCAL[0], 0, CENTRE[0]], [0, FOCAL[1], CENTRE[1]], [0, 0, 1]])
    T = T_SECOND @ np.linalg.inv(T_FIRST)
    parts = [("M1", K), ("D1", np.array(DISTORTION)), ("M2", K), ("D2", np.array(DISTORTION))]
    parts += [("R", T[:3, :3]), ("T", T[:3, 3:])]
    sizes = f"image_width: {SIZE[0]}\nimage_height: {SIZE[1]}"
    return "\n".join(["%YAML:1.0", "---", sizes, *(matrix(*part) for part in parts)])


BOTH = (("left", T_FIRST), ("right", T_SECOND))
FILES = {"rig.toml": toml(*BOTH), "rig.qca.txt": qualisys(*BOTH), "stereo.yml": opencv()}
MILLIMETRES = {"rig.qca.txt": 1000.0}


@pytest.mark.parametrize("name", FILES)
def test_a_calibration_is_read_as_its_program_means_it(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(FILES[name], encoding="utf-8")
    first, second = load_calibration(tmp_path / name)
    T = second.T_camera_world @ np.linalg.inv(first.T_camera_world)
    expected = T_SECOND @ np.linalg.inv(T_FIRST)
    expected[:3, 3] *= MILLIMETRES.get(name, 1.0)
    np.testing.assert_allclose(T[:3, :3], expected[:3, :3], atol=1e-7)
    np.testing.assert_allclose(T[:3, 3], expected[:3, 3], rtol=1e-6)
    camera = second.seeing(name, SIZE)
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == pytest.approx((*FOCAL, *CENTRE))
    assert camera.distortion == pytest.approx(DISTORTION)


def test_it_serves_films_of_another_size_of_the_same_shape_and_no_other(tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(FILES["rig.toml"], encoding="utf-8")
    first, _ = load_calibration(path)
    assert first.seeing(path.name, (640, 360)).fx == pytest.approx(FOCAL[0] / 2)
    with pytest.raises(FormatError, match=r"is for pictures of 1280 × 720 pixels"):
        first.seeing(path.name, (720, 1280))


WRONG = {
    "no calibration": ("rig.toml", "title = 'a rig'", "fewer than two cameras"),
    "one camera": ("rig.toml", toml(BOTH[0]), "fewer than two cameras"),
    "no TOML": ("rig.toml", "[cam", "damaged, or no calibration"),
    "a lens of two numbers": (
        "rig.toml",
        FILES["rig.toml"].replace("[0, 0, 1]]", "]"),
        "damaged, or no calibration",
    ),
    "a place that is none": (
        "rig.toml",
        FILES["rig.toml"].replace("translation = [0.2", "translation = [nan"),
        "a camera has no place",
    ),
    "no XML": ("rig.qca.txt", "cameras", "damaged, or no calibration"),
    "entities": ("rig.xml", "<!DOCTYPE x>" + FILES["rig.qca.txt"], "damaged, or no calibration"),
    "no stereo": ("stereo.yml", "%YAML:1.0\n---\n", "damaged, or no calibration"),
    "another ending": ("rig.csv", "", "a Qualisys calibration"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_what_is_no_calibration_is_said_in_one_sentence(tmp_path: Path, wrong: str) -> None:
    name, text, words = WRONG[wrong]
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(FormatError) as refused:
        load_calibration(tmp_path / name)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="cannot be read"):
        load_calibration(tmp_path / "gone.toml")
