"""Cameras as programs that reconstruct scenes write them, of one that turns, goes and zooms."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.cameras.camera_file import CameraReading
from keypose.tracker.formats.reading_camera import CameraFile, load_camera

SIZE = (640, 360)
FX = 700.0
FY = 690.0
COUNT = 6
T = np.linspace(0, 1, COUNT)
Rs_WORLD_CAMERA = Rotation.from_euler("YXZ", np.stack([20 * T, -9 * T, 3 * T], 1), True).as_matrix()
ps = np.stack([0.4 * T, 1.2 + 0.1 * T, -0.3 * T], axis=1)
FLIP = np.diag([1.0, -1.0, -1.0])
NAMES = [f"images/frame_{n:05}.png" for n in range(1, COUNT + 1)]


def transforms(**changes: Any) -> str:
    """Of nerfstudio; the pictures in no order."""
    rows = [
        {
            "file_path": name,
            "transform_matrix": np.block([[R @ FLIP, p[:, None]], [0, 0, 0, 1]]).tolist(),
        }
        for name, R, p in zip(NAMES, Rs_WORLD_CAMERA, ps, strict=True)
    ]
    lens = {"camera_model": "OPENCV", "fl_x": FX, "fl_y": FY, "cx": 320, "cy": 180, "k1": 0.01}
    return json.dumps({**lens, "w": 640, "h": 360, "frames": rows[::-1], **changes})


def splats() -> str:
    lens = {"width": 640, "height": 360, "fx": FX, "fy": FY}
    return json.dumps(
        [
            {"id": n, "img_name": name, "position": p.tolist(), "rotation": R.tolist(), **lens}
            for n, (name, R, p) in enumerate(zip(NAMES, Rs_WORLD_CAMERA, ps, strict=True))
        ]
    )


def images(points: str = "") -> str:
    lines = ["# Image list with two lines of data per image:"]
    for n, (name, R, p) in enumerate(zip(NAMES, Rs_WORLD_CAMERA, ps, strict=True)):
        x, y, z, w = Rotation.from_matrix(R.T).as_quat()
        a, b, c = -R.T @ p
        lines += [f"{n + 1} {w} {x} {y} {z} {a} {b} {c} 1 {name}", points]
    return "\n".join(lines)


def tum(start: float = 0.0) -> str:
    rows = zip(Rs_WORLD_CAMERA, ps, strict=True)
    return "\n".join(
        f"{start + n / 30:.6f} {p[0]} {p[1]} {p[2]} " + " ".join(map(str, _quaternion(R)))
        for n, (R, p) in enumerate(rows)
    )


def _quaternion(R: Any) -> list[float]:
    return list(Rotation.from_matrix(R).as_quat())


def read(folder: Path, name: str, content: str, **said: Any) -> CameraFile:
    (folder / name).write_text(content)
    return load_camera(folder / name, SIZE, CameraReading(**said))


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("transforms.json", transforms()),
        ("cameras.json", splats()),
        ("images.txt", images()),
        ("images.txt", images("1.5 2.5 -1 3.5 4.5 7")),
        ("tum.txt", "# timestamp tx ty tz qx qy qz qw\n" + tum()),
        ("tum.txt", tum(1_305_031_102.0)),
    ],
)
@pytest.mark.parametrize("unit", [None, "m"])
def test_a_camera_is_where_the_program_had_it(
    tmp_path: Path, name: str, content: str, unit: Any
) -> None:
    way = read(tmp_path, name, content, unit=unit).way
    assert way is not None
    np.testing.assert_allclose(way.Ts_world_camera[:, :3, :3], Rs_WORLD_CAMERA, atol=1e-9)
    np.testing.assert_allclose(way.Ts_world_camera[:, :3, 3], ps, atol=1e-9)
    frames = np.arange(COUNT) / 30 if name == "tum.txt" else 1 + np.arange(COUNT)
    np.testing.assert_allclose(way.frames, frames, atol=1e-6)
    assert way.is_metric is (unit is not None or name == "tum.txt")


def test_the_lens_is_that_of_the_file_or_stays(tmp_path: Path) -> None:
    found = read(tmp_path, "transforms.json", transforms()).camera
    assert found is not None
    assert (found.fx, found.fy, found.cx, found.cy) == (FX, FY, 319.5, 179.5)
    assert found.distortion == (0.01, 0, 0, 0, 0)
    angle = 2 * np.arctan(320 / FX)
    content = transforms(fl_x=None, fl_y=None, camera_angle_x=angle)
    found = read(tmp_path, "transforms.json", content).camera
    assert found is not None
    assert found.fx == found.fy == pytest.approx(FX)
    alone = read(tmp_path, "images.txt", images())
    assert alone.camera is None
    assert "camera lens kept" in [note.oddity for note in alone.notes]
    (tmp_path / "cameras.txt").write_text(f"# list\n1 OPENCV 640 360 {FX} {FY} 320 180 0 0 .1 .2")
    beside = read(tmp_path, "images.txt", images()).camera
    assert beside is not None
    assert (beside.fx, beside.fy, beside.cx, beside.cy) == (FX, FY, 319.5, 179.5)
    assert beside.distortion == (0, 0, 0.1, 0.2, 0)


def test_what_is_up_is_said_by_transforms_alone_or_by_the_person(tmp_path: Path) -> None:
    assert read(tmp_path, "images.txt", images()).up_camera is None
    for name, content, said in (
        ("transforms.json", transforms(), {}),
        ("images.txt", images(), {"world": "y up"}),
    ):
        up = read(tmp_path, name, content, **said).up_camera
        np.testing.assert_allclose(up, Rs_WORLD_CAMERA[0, 1], atol=1e-9)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("transforms.json", transforms(camera_model="OPENCV_FISHEYE"), "fisheye"),
        ("transforms.json", transforms().replace("frame_00003", "third"), "no number"),
        ("transforms.json", transforms().replace("frame_00003", "frame_00002"), "frames twice"),
        ("transforms.json", transforms(w=640, h=640), "640 × 640 pixels"),
        ("transforms.json", transforms(frames=[{"file_path": "1", "transform_matrix": []}]),
         "four rows"),
        ("transforms.json", '{"frames": [{"transform_matrix": 3}]}', "field required"),
        ("cameras.json", splats().replace('"fx": 700.0', '"fx": -1'), "cameras.0.fx"),
        ("images.txt", images().replace("1 images", "one images", 1), "its name"),
        ("images.txt", "1 0 0 0 0 0 0 0 1 a1.png\n\n", "quaternion of zeros"),
        ("notes.txt", "hello", "holds nothing that can be imported"),
        ("notes.txt", "", "holds nothing that can be imported"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_one_sentence(
    tmp_path: Path, name: str, content: str, words: str
) -> None:
    if words == "its name":
        content = content.replace("one images/frame_00001.png", "1 images/first.png")
        words = "no number"
    with pytest.raises(FormatError) as refused:
        read(tmp_path, name, content)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)
    assert "_" not in str(refused.value).split(":")[0].replace(name, "")


def test_a_lens_of_colmap_that_is_not_known_names_those_that_are(tmp_path: Path) -> None:
    (tmp_path / "cameras.txt").write_text("1 OPENCV_FISHEYE 640 360 1 1 1 1 0 0 0 0")
    with pytest.raises(FormatError, match="'OPENCV_FISHEYE', and SIMPLE_PINHOLE"):
        read(tmp_path, "images.txt", images())
