"""One world in all files: the same joint of one motion is at the same place in every format."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdSkel
from scipy.spatial.transform import Rotation

from keypose.app.export.motion_files import motion_files
from keypose.app.export.motion_formats import FORMATS
from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.order import read_order
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.units import ORIGINS
from keypose.tracker.geometry.rotations import Array, apply_transform
from tests.tracker.formats import recordings
from tests.tracker.formats.glb_reading import Player

JOINTS = ("left_hand", "right_foot", "head", "left_shin")
IN_AMASS = ("left_wrist", "right_ankle", "head", "left_knee")
FRAMES = (0, 27, 51)
WITHIN_M = 1e-3


@cache
def made() -> Recording:
    """The walk of the sample, whose camera is level and sees her from the side."""
    return recordings.recording("walk")


def files(name: str, origin: str) -> dict[str, bytes]:
    """At the film's mean rate in all formats, and its last frames alone."""
    asked = {"origin": origin, "fps": "25", "filter_hz": "5", "frames": "10-69"}
    return motion_files(name, made(), read_order(MotionOrder, asked))


def places(name: str, origin: str, folder: Path) -> Array:
    """(3, 4, 3) of some joints at some frames, metres, y up, as a reader of the format has them."""
    return READERS[name](files(name, origin), folder)


Read: TypeAlias = Callable[[dict[str, bytes], Path], Array]


def _as_read(file: str, names: tuple[str, ...] = JOINTS) -> Read:
    def read(content: dict[str, bytes], folder: Path) -> Array:
        (folder / file).write_bytes(content[file])
        motion = load_motion(folder / file)
        motion = motion if motion.unit else motion.in_unit("m")
        return motion.ps_world_joint[np.ix_(FRAMES, [motion.names.index(n) for n in names])]

    return read


def _of_amass(content: dict[str, bytes], folder: Path) -> Array:
    x, y, z = np.moveaxis(_as_read("motion_poses.npz", IN_AMASS)(content, folder), -1, 0)
    return np.stack([x, z, -y], axis=-1)


def _of_glb(content: dict[str, bytes], _folder: Path) -> Array:
    player = Player.of(content["motion.glb"])
    at = player.places(player.times_s)
    return np.stack([at[name][list(FRAMES)] for name in JOINTS], axis=1)


def _of_usd(content: dict[str, bytes], folder: Path) -> Array:
    (folder / "motion.usd").write_bytes(content["motion.usd"])
    stage = Usd.Stage.Open(str(folder / "motion.usd"))
    cache_of_stage = UsdSkel.Cache()
    skeleton = UsdSkel.Skeleton(stage.GetDefaultPrim().GetChild("Skeleton"))
    cache_of_stage.Populate(UsdSkel.Root(stage.GetDefaultPrim()), Usd.TraverseInstanceProxies())
    query, names = cache_of_stage.GetSkelQuery(skeleton), list(skeleton.GetJointNamesAttr().Get())
    found = []
    for row in FRAMES:
        Ts = query.ComputeJointSkelTransforms(Usd.TimeCode(stage.GetStartTimeCode() + row))
        found.append([np.array(Ts[names.index(name)])[3, :3] for name in JOINTS])
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    return np.array(found)


def _of_csv(content: dict[str, bytes], _folder: Path) -> Array:
    table = list(csv.DictReader(io.StringIO(content["joints.csv"].decode())))
    return np.array(
        [[[float(table[row][f"{name}_world_{a}_m"]) for a in "xyz"] for name in JOINTS]
         for row in FRAMES]
    )  # fmt: skip


def _of_npz(content: dict[str, bytes], _folder: Path) -> Array:
    with np.load(io.BytesIO(content["motion.npz"])) as file:
        names = file["names"].tolist()
        ps_camera = file["ps_camera_joint"][np.ix_(FRAMES, [names.index(n) for n in JOINTS])]
        return apply_transform(file["T_world_camera"], ps_camera)


READERS: dict[str, Read] = {
    "bvh": _as_read("motion.bvh"),
    "glb": _of_glb,
    "usd": _of_usd,
    "trc": _as_read("motion.trc"),
    "c3d": _as_read("motion.c3d"),
    "csv": _of_csv,
    "npz": _of_npz,
    "amass": _of_amass,
}
WITHOUT_JOINTS = ("mot", "camera", "chan")
"""Formats of angles, and of the camera alone."""
OF_ANOTHER = ("fbx",)
"""Those whose motion is another format's file."""


def test_every_format_that_places_joints_is_read_here() -> None:
    assert sorted(FORMATS) == sorted((*READERS, *WITHOUT_JOINTS, *OF_ANOTHER))


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("name", READERS)
def test_every_format_has_a_joint_at_the_same_place(name: str, origin: str, tmp_path: Path) -> None:
    off = places(name, origin, tmp_path) - places("npz", origin, tmp_path)
    assert np.abs(off).max() < WITHIN_M


@pytest.mark.parametrize("origin", ORIGINS)
def test_the_camera_stands_in_that_world_in_every_file_that_has_it(
    origin: str, tmp_path: Path
) -> None:
    with np.load(io.BytesIO(files("npz", origin)["motion.npz"])) as file:
        T_world_camera = file["T_world_camera"]
    looks = T_world_camera * [1, -1, -1, 1]  # along −z, y up
    told = json.loads(files("camera", origin)["motion_camera.json"])["T_world_camera"]
    np.testing.assert_allclose(told, T_world_camera, atol=1e-6)
    player = Player.of(files("glb", origin)["motion.glb"])
    np.testing.assert_allclose(player.transforms(None)["camera"][0], looks, atol=1e-6)
    (tmp_path / "motion.usd").write_bytes(files("usd", origin)["motion.usd"])
    stage = Usd.Stage.Open(str(tmp_path / "motion.usd"))
    camera = UsdGeom.Xformable(stage.GetPrimAtPath("/Camera"))
    T = np.array(camera.ComputeLocalToWorldTransform(Usd.TimeCode.Default())).T
    np.testing.assert_allclose(T, looks, atol=1e-6)
    line = [float(word) for word in files("chan", origin)["motion_camera.chan"].split()[:7]]
    R = Rotation.from_euler("zxy", [line[6], line[4], line[5]], degrees=True).as_matrix()
    np.testing.assert_allclose(line[1:4], looks[:3, 3], atol=1e-6)
    np.testing.assert_allclose(R, looks[:3, :3], atol=1e-6)


def test_the_body_begins_at_the_origin_and_faces_along_x_unless_it_is_asked_otherwise() -> None:
    whole = made().with_ground()
    first = whole.T_world_camera @ np.append(whole.tracks.ps_camera_root[0], 1.0)
    assert first[[0, 2]] == pytest.approx([0.0, 0.0], abs=1e-9)
    ps = whole.world.points(whole.ps_camera_joint)
    right, left = (whole.skeleton.body.index(f"{side}_thigh") for side in ("right", "left"))
    across = ps[:, right] - ps[:, left]
    assert (across[:, 2] > 0.1).all()  # z is to her right, so x is ahead of her
    assert np.percentile(ps[..., 1].min(axis=1), 10) == pytest.approx(0.0, abs=0.05)


def test_parts_of_a_motion_lie_in_the_world_of_the_whole() -> None:
    def at_frame_40(frames: str) -> Array:
        order = read_order(MotionOrder, {"frames": frames})
        text = motion_files("csv", made(), order)["joints.csv"].decode()
        table = csv.DictReader(io.StringIO(text))
        row = next(row for row in table if row["frame"] == "40")
        return np.array([float(row[f"head_world_{axis}_m"]) for axis in "xyz"])

    np.testing.assert_array_equal(at_frame_40("0-70"), at_frame_40("30-50"))
