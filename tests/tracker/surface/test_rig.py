"""The file of calibrated cameras: what it says, and what is wrong with it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.tracker.errors import SurfaceError
from keypose.tracker.geometry.rotations import quaternion_wxyz
from keypose.tracker.session.settings import UpAxis
from keypose.tracker.surface.cameras.rig import Rig
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.placing import Placement
from tests.rendering.ring import ring_of
from tests.rendering.studio import cameras_json

P_CENTRE = np.array([0.1, 0.0, 3.8])
P_SURFACE = np.array([0.0, 0.5, 3.8])


def written(folder: Path, data: Any) -> Path:
    place = folder / "cameras.json"
    place.write_text(data if isinstance(data, str) else json.dumps(data))
    return place


def plain(up: UpAxis = "+z") -> dict[str, Any]:
    views = ring_of(4, P_CENTRE)
    data: dict[str, Any] = json.loads(cameras_json(views, Placement("cm", up, P_SURFACE)))
    return data


@pytest.mark.parametrize("up", ["+x", "-x", "+y", "-y", "+z", "-z"])
def test_cameras_stand_where_the_file_says_whatever_its_units_and_axes(
    tmp_path: Path, up: UpAxis
) -> None:
    rig = Rig.open(written(tmp_path, plain(up)))
    p = P_CENTRE + np.random.default_rng(0).normal(0, 0.4, (20, 3))
    for view, true in zip(rig.views(P_SURFACE), ring_of(4, P_CENTRE), strict=True):
        assert view.name == true.name
        np.testing.assert_allclose(view.project(p), true.project(p), atol=1e-4)
        np.testing.assert_allclose(view.p_world_view, true.p_world_view, atol=1e-7)


def test_a_camera_may_be_turned_by_a_quaternion(tmp_path: Path) -> None:
    data = plain()
    for camera in data["cameras"]:
        R = np.array(camera.pop("R_camera_world"))
        camera["quaternion_wxyz"] = quaternion_wxyz(R).tolist()
    views = Rig.open(written(tmp_path, data)).views(P_SURFACE)
    for view, true in zip(views, ring_of(4, P_CENTRE), strict=True):
        np.testing.assert_allclose(view.T_view_world, true.T_view_world, atol=1e-6)


def test_a_mesh_goes_into_the_file_and_comes_back(tmp_path: Path) -> None:
    rig = Rig.open(written(tmp_path, plain("-x")))
    mesh = SurfaceMesh(P_CENTRE + np.eye(3), np.array([[0, 1, 2]]))
    there = rig.in_file(mesh, P_SURFACE)
    np.testing.assert_allclose(rig.placement(P_SURFACE).place(there).vertices, mesh.vertices)


def without(key: str) -> dict[str, Any]:
    data = plain()
    del data["cameras"][1][key]
    return data


def having(key: str, value: object) -> dict[str, Any]:
    data = plain()
    data["cameras"][1][key] = value
    return data


SENTENCES: list[tuple[Any, str]] = [
    ("{", "not JSON"),
    ([], "cameras.json"),
    ({"units": "cm", "up": "+z"}, "cameras: field required"),
    ({"units": "cm", "up": "+z", "cameras": []}, "cameras"),
    ({**plain(), "units": "miles"}, "units"),
    ({**plain(), "up": "z"}, "up"),
    (without("fx"), "fx: field required"),
    (without("R_camera_world"), "needs either R_camera_world or quaternion_wxyz"),
    (having("quaternion_wxyz", [1, 0, 0, 0]), "needs either"),
    (having("R_camera_world", np.diag([1, 1, -1]).tolist()), "is not a rotation"),
    (having("R_camera_world", (2 * np.eye(3)).tolist()), "is not a rotation"),
    (having("R_camera_world", [[1, 0], [0, 1]]), "R_camera_world"),
    (having("t_camera_world", [1, 2]), "t_camera_world"),
    (having("t_camera_world", [1, 2, 1e300]), "t_camera_world"),
    (having("name", "camera_00"), "appears twice"),
    (having("width", 10**9), "width"),
    ('{"units": "m", "up": "+y", "cameras": [NaN]}', "cameras"),
]


@pytest.mark.parametrize(("data", "words"), SENTENCES)
def test_a_file_that_is_wrong_is_reported_in_one_sentence(
    tmp_path: Path, data: Any, words: str
) -> None:
    with pytest.raises(SurfaceError) as caught:
        Rig.open(written(tmp_path, data))
    text = str(caught.value)
    assert words in text
    assert text.endswith(".")
    assert "\n" not in text


def test_what_is_no_file_is_reported_in_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "big.json").write_bytes(b" " * (5 * 2**20))
    (tmp_path / "text.json").write_bytes(b"\xff\xfe\x00")
    for place, words in (
        (tmp_path, "is a folder"),
        (tmp_path / "absent.json", "no file of cameras"),
        (tmp_path / "big.json", "too large"),
        (tmp_path / "text.json", "not JSON"),
        (Path("/dev/zero"), "not a regular file"),
    ):
        with pytest.raises(SurfaceError, match=words):
            Rig.open(place)
