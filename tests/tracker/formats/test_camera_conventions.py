"""One camera as programs write it in .chan: orders, lenses, units and axes, numbers of frames."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keypose.app.words.imports import note_words
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.cameras.camera_file import CameraReading, CameraWay
from keypose.tracker.formats.cameras.placing import FilmFrames, placed
from keypose.tracker.formats.reading_camera import CameraFile, load_camera

SIZE = (640, 360)
FOCAL = 911.0
COUNT = 9
FLIP = np.diag([1.0, -1.0, -1.0])
TO_Z_UP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])


def truth() -> tuple[Any, Any]:
    """Rotations (N, 3, 3) of a camera that looks along -z, and places, y up, metres."""
    t = np.linspace(0, 1, COUNT)
    R = Rotation.from_euler("ZXY"[::-1], np.stack([-20 * t, -20 + 5 * t, 4 - 2 * t], 1), True)
    return R.as_matrix(), np.stack([0.6 * t, 1.5 + 0 * t, -0.1 * t], axis=1)


def chan(
    order: str = "zxy",
    last: float | None = None,
    scale: float = 1.0,
    z_up: bool = False,
    first: int = 0,
) -> str:
    R, p = truth()
    if z_up:
        R, p = TO_Z_UP @ R, p @ TO_Z_UP.T
    angles = dict(zip(order, Rotation.from_matrix(R).as_euler(order, True).T, strict=True))
    turns = np.stack([angles[axis] for axis in "xyz"], axis=1)
    rows = np.column_stack([first + np.arange(COUNT), scale * p, turns])
    ending = "" if last is None else f" {last:.9f}"
    return "\n".join(" ".join(f"{x:.9f}" for x in row) + ending for row in rows)


def degrees(length: int) -> float:
    return float(2 * np.degrees(np.arctan(length / 2 / FOCAL)))


def read(folder: Path, content: str, **said: Any) -> CameraFile:
    (folder / "shot.chan").write_text(content)
    return load_camera(folder / "shot.chan", SIZE, CameraReading(**said))


VERTICAL = degrees(360)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (chan(last=VERTICAL), {}),
        ("# frame tx ty tz rx ry rz vfov\n\n" + chan(last=VERTICAL), {}),
        ("\ufeff" + chan(last=VERTICAL) + "\n# end", {}),
        *((chan(o, VERTICAL), {"rotation_order": o}) for o in ("xyz", "xzy", "yxz", "yzx", "zyx")),
        (chan(last=FOCAL / 640 * 36), {"lens_column": "mm"}),
        (chan(last=degrees(640)), {"lens_column": "horizontal"}),
        (chan(last=VERTICAL, scale=100), {"unit": "cm"}),
        (chan(last=VERTICAL, scale=1000), {"unit": "mm"}),
        (chan(last=VERTICAL, z_up=True), {"world": "z up"}),
        (chan("xyz", FOCAL / 640 * 36, 100, z_up=True),
         {"rotation_order": "xyz", "lens_column": "mm", "unit": "cm", "world": "z up"}),
    ],
)  # fmt: skip
def test_what_the_columns_mean_can_be_said(
    tmp_path: Path, content: str, said: dict[str, Any]
) -> None:
    found, (R, p) = read(tmp_path, content, **said), truth()
    assert found.camera is not None
    assert found.camera.fx == found.camera.fy == pytest.approx(FOCAL)
    assert found.way is not None
    np.testing.assert_allclose(found.way.Ts_world_camera[:, :3, :3], R @ FLIP, atol=1e-7)
    np.testing.assert_allclose(found.way.Ts_world_camera[:, :3, 3], p, atol=1e-7)
    np.testing.assert_allclose(found.way.zoom, 1.0)
    np.testing.assert_allclose(found.up_camera, (R @ FLIP)[0, 1], atol=1e-7)
    assert found.notes == ()


@pytest.mark.parametrize(
    ("content", "said"),
    [(chan(), {}), (chan(last=7.0), {"lens_column": "session"})],
)
def test_a_lens_that_is_not_said_stays_the_sessions(
    tmp_path: Path, content: str, said: dict[str, Any]
) -> None:
    found = read(tmp_path, content, **said)
    assert found.camera is None
    assert found.way is not None
    np.testing.assert_array_equal(found.way.zoom, 1.0)


@pytest.mark.parametrize(("z_up", "notes"), [(False, []), (True, ["camera upright"])])
def test_a_camera_that_would_be_upright_with_z_up_is_told(
    tmp_path: Path, z_up: bool, notes: list[str]
) -> None:
    found = read(tmp_path, chan(last=VERTICAL, z_up=z_up))
    assert [note.oddity for note in found.notes] == notes
    said = read(tmp_path, chan(last=VERTICAL, z_up=z_up), world="z up" if z_up else "y up")
    assert said.notes == ()


@pytest.mark.parametrize(
    ("turned", "words"),
    [
        ("70 0 0", "by 70° from upright with y up, as the file is read, and by 20° with z up"),
        ("170 0 5", "leans by 169° from upright: check which way is up"),
        ("-90 0 0", ""),  # straight down
        ("40 30 10", ""),
    ],
)
def test_a_camera_that_hardly_anybody_holds_so_is_told(
    tmp_path: Path, turned: str, words: str
) -> None:
    told = note_words(read(tmp_path, f"1 0 0 0 {turned} 30").notes)
    assert bool(told) is bool(words)
    assert words in " ".join(told)


def test_how_chan_is_meant_is_of_chan_alone(tmp_path: Path) -> None:
    (tmp_path / "shot.json").write_text("{}")
    with pytest.raises(FormatError, match=r"are for \.chan alone"):
        load_camera(tmp_path / "shot.json", SIZE, CameraReading(rotation_order="xyz"))


def way(*frames: float, clock: Any = "numbers", begins: float | None = None) -> CameraWay:
    Ts = np.tile(np.eye(4), (len(frames), 1, 1))
    Ts[:, 0, 3] = frames
    return CameraWay(np.array(frames), Ts, np.ones(len(frames)), clock, begins)


FILM = FilmFrames(np.arange(30) / 30)
OF_FILES = FilmFrames(np.arange(30) / 30, 20)
FROM_1001 = FilmFrames(np.arange(30) / 30, 1001)


@pytest.mark.parametrize(
    ("said", "film", "offset", "frames", "why"),
    [
        (way(*range(5, 25)), FILM, None, range(5, 25), ""),
        (way(*range(1, 31)), FILM, None, range(30), "whole"),
        (way(*range(1001, 1031)), FILM, None, range(30), "whole"),
        (way(*range(11, 21)), FILM, -1, range(10, 20), ""),
        (way(*range(1011, 1021)), FILM, -1001, range(10, 20), ""),
        (way(*range(1, 31)), FILM, -5, range(-4, 26), ""),
        (way(*range(25, 46)), OF_FILES, None, range(5, 26), "files"),
        (way(*range(20, 30)), OF_FILES, None, range(10), "files"),
        (way(*range(5, 15)), OF_FILES, None, range(5, 15), ""),
        (way(*range(1005, 1020)), FROM_1001, None, range(4, 19), "files"),
        (way(*range(1005, 1020)), FROM_1001, -1000, range(5, 20), ""),
        (way(*range(1, 11), clock="names"), FILM, None, range(10), "from 1"),
        (way(*range(10), clock="names"), FILM, None, range(10), ""),
        (way(*range(25, 31), clock="names"), OF_FILES, None, range(5, 11), "files"),
        (way(0.1, 0.2, 0.3, clock="seconds"), FILM, None, range(3, 10), "times"),
        (way(0.0, 0.1, clock="seconds"), FILM, 4, range(4, 8), ""),
        (way(0.0, 0.1, clock="seconds", begins=6.0), FILM, None, range(6, 10), ""),
    ],
)  # fmt: skip
def test_lines_of_a_file_are_frames_of_the_film_and_what_was_assumed_is_told(
    said: CameraWay, film: FilmFrames, offset: int | None, frames: range, why: str
) -> None:
    found, notes = placed("shot.chan", said, film, offset)
    assert found.clock == "frames"
    assert found.frames.tolist() == list(frames)
    assert [note.values[0] for note in notes] == ([why] if why else [])


def test_between_two_moments_a_camera_goes_evenly() -> None:
    found, _ = placed("shot.glb", way(0.0, 0.5, clock="seconds"), FILM)
    np.testing.assert_allclose(found.Ts_world_camera[:, 0, 3], np.arange(16) / 30, atol=1e-9)


@pytest.mark.parametrize(
    ("said", "words"),
    [
        (way(*range(1011, 1021)), "frames 1011 to 1020, and the film 0 to 29: say which"),
        (way(100.0, 101.0, clock="seconds"), "seconds 100 to 101, and the film 0 to 0.966"),
    ],
)
def test_a_file_beside_the_film_says_what_to_choose(said: CameraWay, words: str) -> None:
    with pytest.raises(FormatError, match=words):
        placed("shot.chan", said, FILM)
