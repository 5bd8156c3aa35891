"""BVH as Blender, MotionBuilder and Daz Studio take it: unit, axes, channels, ends, bones."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.export.motion_files import motion_files
from keypose.app.orders.motion import MotionOrder
from keypose.tracker.formats.conventions import parts_in_world
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.rigs import OWN, RIGS
from keypose.tracker.formats.rigs.rig import rig_of
from keypose.tracker.formats.rigs.table import table_of
from keypose.tracker.formats.units import PER_METRE, FileUnit
from tests.tracker.formats import recordings

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # it imports its own library by an old name
    import bvhio

UNIT: dict[str, FileUnit] = {"Blender": "m", "MotionBuilder": "cm", "Daz Studio": "cm"}
"""What a length of 1 is to them where nothing else is chosen when a file is opened."""


def recorded(name: str) -> Recording:
    """A sample's motion at a constant rate."""
    made = recordings.recording(name)
    return replace(made, times_s=np.arange(len(made)) / 30, rate=30.0)


def written(made: Recording, rig: str = OWN, unit: FileUnit = "m") -> bytes:
    return motion_files("bvh", made, MotionOrder(rig=rig, unit=unit))["motion.bvh"]


def read(content: bytes, folder: Path) -> tuple[Any, Any]:
    """The file and its joints, by a reader that is not ours."""
    path = folder / "motion.bvh"
    path.write_bytes(content)
    return bvhio.readAsBvh(str(path)), bvhio.readAsHierarchy(str(path))


def places(root: Any, frame: int) -> dict[str, Any]:
    root.loadPose(frame)
    return {joint.Name: np.array(joint.PositionWorld) for joint, _, _ in root.layout()}


@pytest.mark.parametrize("unit", PER_METRE)
@pytest.mark.parametrize("rig_name", RIGS)
def test_every_bone_is_where_the_rig_has_it_whatever_the_unit(
    rig_name: str, unit: FileUnit, tmp_path: Path
) -> None:
    made = recorded("person")
    rig = rig_of(made.skeleton, rig_name)
    Ts_world_part = parts_in_world(made, made.T_world_camera)
    moving = [i for i, part in enumerate(rig.parts) if part >= 0]
    p_bone = (Ts_world_part[:, rig.parts[moving]] @ rig.Ts_part_bone[moving])[..., :3, 3]
    _, root = read(written(made, rig_name, unit), tmp_path)
    for frame in (0, 31, len(made) - 1):
        found = places(root, frame)
        for i, bone in enumerate(moving):
            if rig_name != OWN or bone < made.skeleton.part_count:
                place = found[rig.names[bone]] / PER_METRE[unit]
                np.testing.assert_allclose(place, p_bone[frame, i], atol=1e-4)


@pytest.mark.parametrize("program", UNIT)
def test_a_person_is_as_tall_there_as_in_life(program: str, tmp_path: Path) -> None:
    made, unit = recorded("person"), UNIT[program]
    _, root = read(written(made, unit=unit), tmp_path)
    found = np.stack([*places(root, 0).values()])
    assert 1.4 < np.ptp(found[:, 1]) / PER_METRE[unit] < 1.9


def test_left_out_the_unit_is_blenders() -> None:
    made = recorded("person")
    assert motion_files("bvh", made)["motion.bvh"] == written(made, unit=UNIT["Blender"])


@pytest.mark.parametrize("rig_name", RIGS)
def test_only_the_root_and_what_carries_the_body_have_places(rig_name: str, tmp_path: Path) -> None:
    made = recorded("person")
    rig = rig_of(made.skeleton, rig_name)
    file, _ = read(written(made, rig_name), tmp_path)
    joints = [joint for joint, _, _ in file.Root.layout()]
    turns = ["Zrotation", "Yrotation", "Xrotation"]
    for joint in joints:
        placed = joint.Name in (rig.names[0], rig.names[rig.mover])
        expected = ["Xposition", "Yposition", "Zposition", *turns] if placed else turns
        assert joint.Channels == expected
        assert np.linalg.norm(joint.Offset) == 0 or not placed
        assert joint.Children or np.linalg.norm(joint.EndSite) > 1e-3
    expected_names = rig.names[: made.skeleton.part_count] if rig_name == OWN else rig.names
    assert sorted(joint.Name for joint in joints) == sorted(expected_names)


@pytest.mark.parametrize("rig_name", [name for name in RIGS if name != OWN])
def test_without_turns_it_stands_y_up_and_faces_along_z(rig_name: str, tmp_path: Path) -> None:
    made = recorded("twirl")
    rig = rig_of(made.skeleton, rig_name)
    file, _ = read(written(made, rig_name), tmp_path)
    offsets = {joint.Name: np.array(joint.Offset) for joint, _, _ in file.Root.layout()}
    bone_of = dict(zip(made.skeleton.body.names, rig.bone_of_part, strict=True))

    def rest(part: str) -> Any:
        bone, p = int(bone_of[part]), np.zeros(3)
        while bone >= 0:
            p, bone = p + offsets[rig.names[bone]], int(rig.parents[bone])
        return p

    assert rest("head")[1] > rest("chest")[1] > rest("left_shin")[1] > rest("left_foot")[1]
    hand = rest("left_hand") - rest("left_upper_arm")
    assert hand[0] > 0.35
    below = np.degrees(np.arctan2(-hand[1], hand[0]))
    assert below == pytest.approx(table_of(rig_name).arms_below_horizontal_deg, abs=0.5)
    foot = [i for i, part in enumerate(rig.parts) if part == made.skeleton.body.index("left_foot")]
    assert offsets[rig.names[foot[1]]][2] > 0.05


def test_a_tilted_camera_tilts_nobody(tmp_path: Path) -> None:
    made = recordings.at_rest(recorded("person"))
    up = np.array([0.0, -np.cos(0.4), -np.sin(0.4)])
    Rs = made.tracks.Rs_parent_part.copy()
    c, s = np.cos(0.4), np.sin(0.4)
    Rs[:, 0] = [[1, 0, 0], [0, c, -s], [0, s, c]]  # whose body stands along that up
    made = replace(made, up_camera=up, tracks=replace(made.tracks, Rs_parent_part=Rs))
    _, root = read(written(made), tmp_path)
    found = places(root, 0)
    feet = (found["left_foot"] + found["right_foot"]) / 2
    np.testing.assert_allclose((found["chest"] - feet)[[0, 2]], 0, atol=1e-5)
    assert 0 < feet[1] < 0.2


@pytest.mark.parametrize("unit", PER_METRE)
def test_it_is_read_in_again_whatever_the_unit(unit: FileUnit, tmp_path: Path) -> None:
    made = recorded("person")
    path = tmp_path / "a.bvh"
    path.write_bytes(written(made, "mixamo", unit))
    motion = load_motion(path)
    hips = motion.names.index("mixamorig:Hips")
    own = parts_in_world(made, made.T_world_camera)[:, 0, :3, 3]
    scale = 0.01 * PER_METRE[unit]  # read as centimetres, and scaled to the body by who imports
    np.testing.assert_allclose(motion.ps_world_joint[:, hips] / scale, own, atol=1e-4)
