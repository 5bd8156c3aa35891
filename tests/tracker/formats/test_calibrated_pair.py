"""Which of a calibration's cameras took a film is known by its name where that names one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from keypose.tracker.formats.cameras.calibrated_pair import CalibratedPair, calibrated_pairs
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session.references import VideoReference
from keypose.tracker.session.views import View

SIZE = 640, 360


def view_of(name: str) -> View:
    video = VideoReference(path=name, fingerprint="", frame_count=10, width=SIZE[0], height=SIZE[1])
    return View(video=video, camera=Camera.guess(*SIZE))


@pytest.mark.parametrize(
    ("names", "films", "count"),
    [
        (("cam1", "cam2", "cam3"), ("walk_cam3.mp4", "walk_cam1.mp4"), 1),
        (("1", "2", "3"), ("take-1.mp4", "take-3.mp4"), 1),
        (("1", "2", "3"), ("IMG_1044.mp4", "IMG_2031.mp4"), 6),
        (("cam1", "cam10", "cam2"), ("cam10.mp4", "cam2.mp4"), 1),
        (("a", "b", "c"), ("front.mp4", "side.mp4"), 6),
        (("Left", "Right"), ("left.mov", "RIGHT.mov"), 1),
        (("int_cam1_img", "int_cam2_img"), ("cam1.mp4", "cam2.mp4"), 2),
    ],
)
def test_a_camera_is_a_film_s_where_its_name_is_a_word_of_the_file_s(
    tmp_path: Path, names: tuple[str, ...], films: tuple[str, str], count: int
) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text(
        "\n".join(
            f'[cam_{number}]\nname = "{name}"\nsize = {list(SIZE)}\n'
            f"matrix = {Camera.guess(*SIZE).K.tolist()}\ndistortions = [0, 0, 0, 0]\n"
            f"rotation = [0, {number}, 0]\ntranslation = [{number}, 0, 0]\n"
            for number, name in enumerate(names)
        ),
        encoding="utf-8",
    )
    pairs = calibrated_pairs(rig, *(view_of(film) for film in films))
    assert len(pairs) == count


@pytest.mark.parametrize(
    ("apart", "about_m", "told_m"),
    [
        (4100.0, 4.0, 4.1),
        (410.0, 4.3, 4.1),
        (4.1, 3.7, 4.1),
        (137.0, 4.1, None),  # squares of a board
        (4.1, 2.0, None),
        (0.0, 4.0, None),
    ],
)
def test_how_far_cameras_stand_apart_is_told_where_a_unit_agrees_with_the_body(
    apart: float, about_m: float, told_m: float | None
) -> None:
    T = np.eye(4)
    T[0, 3] = apart
    lens = Camera.guess(*SIZE)
    found = CalibratedPair("rig.toml", ("a", "b"), lens, lens, T).apart_m(about_m)
    assert found == (None if told_m is None else pytest.approx(told_m))
