"""The moving body as GLB, read by pygltflib and trimesh, played by SciPy."""

from __future__ import annotations

import io
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh

from keypose.tracker.body.pose import part_transforms
from keypose.tracker.body.shapes import Box, Cylinder
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.glb import glb
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.rigs import OWN, RIGS
from keypose.tracker.formats.rigs.rig import rig_of
from keypose.tracker.formats.rigs.skin import lit_mesh
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import apply_transform, rotation_between
from tests.tracker.formats import recordings
from tests.tracker.formats.glb_reading import Player
from tests.tracker.session_cases import CAMERA

COLOURS = {"left": (0, 0, 255), "middle": (188, 188, 188), "right": (255, 0, 0)}


def written(made: Recording, rig: str = OWN) -> bytes:
    names = made.skeleton.body.names
    sides = [name.split("_")[0] if "_" in name else "middle" for name in names]
    return glb(made, [side if side in COLOURS else "middle" for side in sides], COLOURS, rig)


def joints_in_world(made: Recording) -> Any:
    """Joints and landmarks (N, J, 3) on the floor, by our own forward kinematics."""
    return apply_transform(made.T_world_camera, made.trajectory.joints(made.skeleton))


@pytest.mark.parametrize("name", recordings.NAMES)
def test_every_joint_is_where_it_is_in_every_frame(name: str) -> None:
    made = recordings.recording(name)
    player = Player.of(written(made))
    np.testing.assert_array_equal(player.times_s, made.times_s.astype(np.float32))
    places = player.places(player.times_s)
    found = np.stack([places[label] for label in player.bones], axis=1)
    np.testing.assert_allclose(found, joints_in_world(made), atol=1e-5)


@pytest.mark.parametrize("rig", [name for name in RIGS if name != OWN])
def test_solids_move_as_the_body_s_with_the_bones_of_every_rig(rig: str) -> None:
    made = recordings.recording("twirl")
    content = written(made, rig)
    player, T_world_camera = Player.of(content), made.T_world_camera
    skinned = player.skinned(player.times_s)
    bones = rig_of(made.skeleton, rig)
    Ts = made.trajectory.transforms(made.skeleton)
    for i, part in enumerate(made.skeleton.body.parts):
        own = apply_transform(T_world_camera, apply_transform(Ts[:, i], part.shape.mesh().vertices))
        found = skinned[bones.names[bones.bone_of_part[i]]]
        np.testing.assert_allclose(found.min(axis=1), own.min(axis=1), atol=2e-5)
        np.testing.assert_allclose(found.max(axis=1), own.max(axis=1), atol=2e-5)
    assert b'"VRMC_vrm_animation"' in content or rig != "vrm"


def test_between_two_frames_every_part_turns_about_one_axis() -> None:
    made = recordings.recording("person")
    player = Player.of(written(made))
    motion, i = made.trajectory, 30
    middle = player.times_s[i : i + 2].mean(keepdims=True)
    Rs = rotation_between(motion.Rs_parent_part[i], motion.Rs_parent_part[i + 1], [0.5])
    p_root = motion.ps_camera_root[i : i + 2].mean(axis=0)
    T = made.T_world_camera @ part_transforms(made.skeleton, Rs[0], p_root)
    places = player.places(middle)
    for name, p in zip(made.skeleton.body.names, T[:, :3, 3], strict=True):
        np.testing.assert_allclose(places[name][0], p, atol=1e-5)


def test_quaternions_never_change_their_sign() -> None:
    for (_, path), curve in Player.of(written(recordings.recording("twirl"))).curves().items():
        if path == "rotation":
            assert ((curve[1:] * curve[:-1]).sum(axis=1) > 0).all()
            np.testing.assert_allclose(np.linalg.norm(curve, axis=1), 1, atol=1e-6)


@pytest.mark.parametrize("rig", RIGS)
def test_before_it_plays_the_body_stands_on_the_floor_in_its_rest_pose(rig: str) -> None:
    made = recordings.recording("person")
    player = Player.of(written(made, rig))
    skinned = np.concatenate(list(player.skinned(None).values()), axis=1)[0]
    assert skinned[:, 1].min() == pytest.approx(0, abs=1e-6)
    body = made.skeleton.body
    height = sum(-body.parts[body.index(name)].joint_m[1] for name in ("chest", "neck", "head"))
    foot = body.parts[body.index("left_foot")].shape.mesh().vertices[:, 1].max()
    legs = sum(body.parts[body.index(f"left_{n}")].joint_m[1] for n in ("thigh", "shin", "foot"))
    head = -body.parts[body.index("head")].shape.mesh().vertices[:, 1].min()
    assert skinned[:, 1].max() == pytest.approx(height + legs + foot + head, abs=1e-5)
    rest, nodes = rig_of(made.skeleton, rig), player.transforms(None)
    found = np.stack([nodes[name][0] for name in rest.names])
    np.testing.assert_allclose(found, rest.Ts_world_bone, atol=1e-6)


def test_the_floor_is_at_zero_and_up_is_y() -> None:
    tilted = np.array([0.05, -1.0, -0.3]) / np.linalg.norm([0.05, -1.0, -0.3])
    made = replace(recordings.recording("person"), up_camera=tilted, origin="camera")
    player = Player.of(written(made))
    lowest = [
        points[..., 1].min(axis=1) for points in player.skinned(player.times_s).values()
    ]  # of every bone
    assert np.percentile(np.min(lowest, axis=0), 10) == pytest.approx(0, abs=1e-5)
    camera = player.transforms(None)["camera"][0]
    assert camera[:3, 3] == pytest.approx([0, camera[1, 3], 0])
    np.testing.assert_allclose(camera[:3, :3] @ (tilted * [1, -1, -1]), [0, 1, 0], atol=1e-6)


def test_a_floor_that_was_set_is_kept() -> None:
    made = recordings.recording("person")
    lower = replace(made, floor_m=-2.0)
    assert Player.of(written(lower)).transforms(None)["camera"][0, 1, 3] == pytest.approx(2.0)


def test_a_camera_that_looks_straight_down_has_the_top_of_its_picture_ahead() -> None:
    up = np.array([0.0, 0.0, -1.0])
    made = replace(recordings.recording("person"), up_camera=up, origin="camera")
    R = made.T_world_camera[:3, :3]
    np.testing.assert_allclose(R @ [0, 0, 1], [0, -1, 0], atol=1e-12)
    np.testing.assert_allclose(R @ [0, -1, 0], [0, 0, -1], atol=1e-12)


def test_the_solids_are_the_parts_own_with_their_outsides_out() -> None:
    made = recordings.recording("person")
    solids = Player.of(written(made)).solids()
    for part in made.skeleton.body.parts:
        found = trimesh.Trimesh(*solids[part.name])
        assert found.is_watertight
        own = part.shape.mesh()
        assert found.volume == pytest.approx(
            trimesh.Trimesh(own.vertices, own.faces).volume, rel=1e-4
        )


def test_trimesh_reads_the_bones_and_one_mesh_for_every_colour() -> None:
    made = recordings.recording("person")
    scene = trimesh.load(io.BytesIO(written(made)), file_type="glb")
    assert len(scene.geometry) == 3
    rest = rig_of(made.skeleton).Ts_world_bone
    np.testing.assert_allclose(scene.graph["head_top"][0], rest[16], atol=1e-6)


def test_round_sides_are_smooth_and_rims_and_edges_sharp() -> None:
    vertices, normals, faces = lit_mesh(Cylinder(end_m=0.5, radius_m=0.1))
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1)
    side = np.abs(normals[:, 1]) < 0.5
    outward = vertices * [1, 0, 1]
    np.testing.assert_allclose(normals[side], outward[side] / 0.1, atol=1e-6)
    np.testing.assert_allclose(np.abs(normals[~side, 1]), 1, atol=1e-9)
    assert len(faces) == 96
    vertices, normals, _ = lit_mesh(Box(low_m=(-1, -1, -1), high_m=(1, 1, 1)))
    assert len(vertices) == 24
    assert sorted(map(tuple, np.unique(normals.round(9), axis=0))) == sorted(
        (sign * x, sign * y, sign * z)
        for sign in (1, -1)
        for x, y, z in ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    )


def test_sides_have_their_colours_as_light() -> None:
    gltf = Player.of(written(recordings.recording("person"))).gltf
    looks = {m.name: m.pbrMetallicRoughness.baseColorFactor for m in gltf.materials}
    assert looks["left"] == [0, 0, 1, 1]
    assert looks["right"] == [1, 0, 0, 1]
    assert looks["middle"] == pytest.approx([0.5028865, 0.5028865, 0.5028865, 1], abs=1e-5)
    (mesh,) = gltf.meshes
    assert [gltf.materials[p.material].name for p in mesh.primitives] == list(looks)
    player = Player(gltf)
    left = player.array(mesh.primitives[list(looks).index("left")].attributes.POSITION)
    assert left[:, 0].mean() > 0.1  # the body's left, where it faces the viewer at rest


def test_the_camera_sees_as_the_video_did() -> None:
    camera = Camera(
        width=640, height=360, fx=700, fy=710, cx=300, cy=170, distortion=(0.1, 0, 0, 0, 0)
    )
    made = replace(recordings.recording("person"), camera=camera)
    player = Player.of(written(made))
    (seen,) = player.gltf.cameras
    assert seen.type == "perspective"
    assert math.tan(seen.perspective.yfov / 2) * 710 == pytest.approx(180)
    assert seen.perspective.aspectRatio == pytest.approx((640 / 700) / (360 / 710))
    assert seen.extras["cx"] == 300
    assert seen.extras["fx"] == 700
    assert seen.extras["distortion_k1_k2_p1_p2_k3"][0] == 0.1
    (node,) = [n for n in player.gltf.nodes if n.camera is not None]
    places, T = player.places(player.times_s), player.transforms(None)[node.name][0]
    seen_from = [(places[name] - T[:3, 3]) @ T[:3, :3] for name in made.skeleton.body.names]
    p_camera = made.trajectory.transforms(made.skeleton)[:, :, :3, 3]
    np.testing.assert_allclose(np.stack(seen_from, axis=1), p_camera * [1, -1, -1], atol=1e-5)


def test_a_telephoto_lens_is_an_orthographic_camera() -> None:
    camera = CAMERA.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 3.0})
    made = replace(recordings.recording("box"), camera=camera)
    (seen,) = Player.of(written(made)).gltf.cameras
    assert seen.type == "orthographic"
    edge = camera.project(np.array([seen.orthographic.xmag, seen.orthographic.ymag, 9.0]))
    np.testing.assert_allclose(edge - (camera.cx, camera.cy), [CAMERA.width / 2, CAMERA.height / 2])
    assert seen.extras["telephoto_distance_m"] == 3.0


def test_the_file_needs_no_extension_and_says_how_large_it_is() -> None:
    content = written(recordings.recording("box"))
    gltf = Player.of(content).gltf
    assert gltf.extensionsUsed == gltf.extensionsRequired == []
    assert int.from_bytes(content[8:12], "little") == len(content)
    assert len(content) % 4 == 0
    assert gltf.materials[0].name == "middle"
    assert len(gltf.materials) == 1


def test_it_is_one_armature_with_one_mesh_and_one_animation() -> None:
    made = recordings.recording("person")
    gltf = Player.of(written(made, "mixamo")).gltf
    assert [len(x) for x in (gltf.skins, gltf.meshes, gltf.animations, gltf.cameras)] == [1] * 4
    tops = [gltf.nodes[index].name for index in gltf.scenes[0].nodes]
    assert tops == ["Armature", "body", "camera"]
    joints = set(gltf.skins[0].joints)
    assert {channel.target.node for channel in gltf.animations[0].channels} == joints
    facts = gltf.animations[0].extras
    assert facts["rig"] == "mixamo"
    assert facts["first_frame"] == 0
    assert facts["frame_count"] == len(made)


def test_a_rig_of_people_is_refused_for_a_box() -> None:
    with pytest.raises(FormatError, match="is for a person, and the body 'box' has no waist"):
        written(recordings.recording("box"), "ue5")


def test_frames_that_are_not_tracked_are_refused() -> None:
    with pytest.raises(FormatError, match="Frames 25 to 47 are not tracked, and GLB holds no gaps"):
        written(recordings.recording("person", without=(1,)))


def test_of_a_motion_that_begins_late_the_times_stay_the_videos() -> None:
    made = recordings.recording("person", without=(0,))
    player = Player.of(written(made))
    assert len(player.times_s) == 49
    np.testing.assert_array_equal(player.times_s, made.times_s[24:].astype(np.float32))
    places = player.places(player.times_s)
    found = np.stack([places[part] for part in made.skeleton.body.names], axis=1)
    whole = made.between(24, 72)
    np.testing.assert_allclose(found, joints_in_world(whole)[:, : found.shape[1]], atol=1e-5)


def test_times_that_stand_still_are_refused() -> None:
    made = recordings.recording("box")
    with pytest.raises(FormatError, match="times ascend"):
        written(replace(made, times_s=made.times_s + 1e7))
