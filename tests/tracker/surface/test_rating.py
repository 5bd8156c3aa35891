"""A session's cameras: what they say of its surfaces, and what is said of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh

from keypose.tracker.errors import SurfaceError
from keypose.tracker.session.references import Surface
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.source import SurfaceSteps
from tests.tracker.surface.test_picture import Meshes

WIDTH = 96
HEIGHT = 72
STEPS = 2


def images(folder: Path, count: int = STEPS) -> str:
    """Pictures of a fine random pattern, the same for every camera."""
    folder.mkdir(parents=True)
    grey = np.random.default_rng(1).integers(0, 255, (HEIGHT, WIDTH, 3)).astype(np.uint8)
    for step in range(count):
        good, content = cv2.imencode(".png", grey)
        assert good
        (folder / f"{step}.png").write_bytes(content.tobytes())
    return folder.name


def rig(folder: Path, *shown: str | None) -> str:
    """Cameras at one and the same place, 8 m before the meshes' origin, with these images."""
    cameras = [
        {
            "name": f"camera {number}", "width": WIDTH, "height": HEIGHT, "fx": 120.0, "fy": 120.0,
            "cx": 47.5, "cy": 35.5, "R_camera_world": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
            "t_camera_world": [0.0, 0.0, 800.0], "images": name,
        }
        for number, name in enumerate(shown)
    ]  # fmt: skip
    reported: dict[str, Any] = {"units": "cm", "up": "+z", "cameras": cameras}
    (folder / "rig.json").write_text(json.dumps(reported), encoding="utf-8")
    return "rig.json"


class Balls(Meshes):
    """Balls of 1 m radius."""

    def mesh(self, frame: int) -> SurfaceMesh:
        ball = trimesh.creation.icosphere(2, 100.0)
        return SurfaceMesh(np.array(ball.vertices), np.array(ball.faces))


def steps(folder: Path, cameras: str | None) -> SurfaceSteps:
    surface = Surface(units="cm", up="+z", p_camera_surface=(0.0, 0.0, 8.0), cameras=cameras)
    return SurfaceSteps(Balls(STEPS), surface, folder)  # type: ignore[arg-type]


def test_cameras_that_see_the_same_agree_on_what_they_see(tmp_path: Path) -> None:
    cameras = rig(tmp_path, images(tmp_path / "one"), images(tmp_path / "other"))
    with steps(tmp_path, cameras) as of:
        assert of.shape(0).consistency is None
        agreed, p = of.mesh(0).consistency, of.mesh(0).vertices
    assert agreed is not None
    before, behind = agreed[p[:, 2] < 7.5], agreed[p[:, 2] > 8.5]
    assert before.min() > 0.99
    assert behind.max() == -1.0  # no camera sees it


def test_without_images_the_surfaces_are_as_they_were_read(tmp_path: Path) -> None:
    with steps(tmp_path, rig(tmp_path, None, None)) as of:
        assert of.mesh(0).consistency is None
        assert of.mesh(1).consistency is None


def test_cameras_that_cannot_be_used_hide_no_surface(tmp_path: Path) -> None:
    with steps(tmp_path, "gone.json") as of:
        assert len(of.shape(0).vertices) > 100
        for _ in range(2):
            with pytest.raises(SurfaceError, match=r"There is no file of cameras"):
                of.mesh(0)


def test_an_image_is_wanted_for_every_mesh(tmp_path: Path) -> None:
    cameras = rig(tmp_path, images(tmp_path / "one", 3), images(tmp_path / "other", 3))
    with (
        steps(tmp_path, cameras) as of,
        pytest.raises(SurfaceError, match=r"took 3 images each, and there are 2 meshes"),
    ):
        of.mesh(0)


def test_images_that_are_gone_are_reported_in_a_sentence(tmp_path: Path) -> None:
    with (
        steps(tmp_path, rig(tmp_path, "one", "other")) as of,
        pytest.raises(SurfaceError, match=r"\.$"),
    ):
        of.mesh(0)


def test_cameras_that_do_not_hold_all_of_a_surface_are_named(tmp_path: Path) -> None:
    name = rig(tmp_path, None, None)
    assert steps(tmp_path, name).cut_by(0) == ()
    reported = json.loads((tmp_path / name).read_text("utf-8"))
    reported["cameras"][1] |= {"fx": 480.0, "fy": 480.0}  # too near to see all of the ball
    (tmp_path / name).write_text(json.dumps(reported), encoding="utf-8")
    assert steps(tmp_path, name).cut_by(0) == ("camera 1",)
    assert steps(tmp_path, None).cut_by(0) == ()
