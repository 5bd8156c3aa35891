"""The moving body as GLB, read by pygltflib and trimesh, played by SciPy."""

from __future__ import annotations

import io
import math
from typing import Any

import numpy as np
import pytest
import trimesh

from tests.tracker.formats import recordings
from tests.tracker.formats.glb_reading import Player
from tests.tracker.session_cases import CAMERA
from tracker.body.pose import part_transforms
from tracker.body.shapes import Box, Cylinder
from tracker.errors import FormatError
from tracker.formats.glb import glb
from tracker.formats.glb_mesh import lit_mesh
from tracker.formats.recording import Recording
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import rotation_between

COLOURS = {"left": (0, 0, 255), "middle": (188, 188, 188), "right": (255, 0, 0)}


def written(made: Recording) -> bytes:
    names = made.skeleton.body.names
    sides = [name.split("_")[0] if "_" in name else "middle" for name in names]
    return glb(made, [side if side in COLOURS else "middle" for side in sides], COLOURS)


def altered(made: Recording, **more: Any) -> Recording:
    return Recording(**{**vars_of(made), **more})


def vars_of(made: Recording) -> dict[str, Any]:
    names = ("skeleton", "camera", "tracks", "segments", "times_s", "up_camera")
    return {name: getattr(made, name) for name in names}


@pytest.mark.parametrize("name", recordings.NAMES)
def test_every_joint_is_where_it_is_in_every_frame(name: str) -> None:
    made = recordings.recording(name)
    player = Player.of(written(made))
    np.testing.assert_array_equal(player.times_s, made.times_s.astype(np.float32))
    places = player.places(player.times_s)
    labels = [node.name for node in player.gltf.nodes if node.name != "camera"]
    found = np.stack([places[label] for label in labels], axis=1)
    np.testing.assert_allclose(found, recordings.joints_in_file(made), atol=1e-5)


def test_between_two_frames_every_part_turns_about_one_axis() -> None:
    made = recordings.recording("person")
    player = Player.of(written(made))
    motion, i = made.trajectory, 30
    middle = player.times_s[i : i + 2].mean(keepdims=True)
    Rs = rotation_between(motion.Rs_parent_part[i], motion.Rs_parent_part[i + 1], [0.5])
    p_root = motion.ps_camera_root[i : i + 2].mean(axis=0)
    T = part_transforms(made.skeleton, Rs[0], p_root)
    places = player.places(middle)
    for name, p in zip(made.skeleton.body.names, T[:, :3, 3], strict=True):
        np.testing.assert_allclose(places[name][0], recordings.TO_FILE @ p, atol=1e-5)


def test_quaternions_never_change_their_sign() -> None:
    for (_, path), curve in Player.of(written(recordings.recording("twirl"))).curves().items():
        if path == "rotation":
            assert ((curve[1:] * curve[:-1]).sum(axis=1) > 0).all()
            np.testing.assert_allclose(np.linalg.norm(curve, axis=1), 1, atol=1e-6)


def test_before_it_plays_the_body_stands_in_its_first_frame() -> None:
    made = recordings.recording("person")
    scene = trimesh.load(io.BytesIO(written(made)), file_type="glb")
    expected = recordings.joints_in_file(made)[0]
    for i, part in enumerate(made.skeleton.body.names):
        np.testing.assert_allclose(scene.graph[part][0][:3, 3], expected[i], atol=1e-5)


def test_the_meshes_are_the_parts_own_with_their_outsides_out() -> None:
    made = recordings.recording("person")
    scene = trimesh.load(io.BytesIO(written(made)), file_type="glb")
    T = made.trajectory.transforms(made.skeleton)[0]
    for part, T_camera_part in zip(made.skeleton.body.parts, T, strict=True):
        found = scene.geometry[part.name].copy()
        found.apply_transform(scene.graph[part.name][0])
        found.merge_vertices(merge_norm=True)
        assert found.is_watertight
        assert found.volume > 0
        mesh = part.shape.mesh()
        ours = (mesh.vertices @ T_camera_part[:3, :3].T + T_camera_part[:3, 3]) @ recordings.TO_FILE
        np.testing.assert_allclose(found.bounds, [ours.min(axis=0), ours.max(axis=0)], atol=1e-5)
        own = trimesh.Trimesh(mesh.vertices, mesh.faces)
        assert found.volume == pytest.approx(own.volume, rel=1e-4)


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
    for node in gltf.nodes:
        if node.mesh is not None and node.name.startswith("left"):
            (primitive,) = gltf.meshes[node.mesh].primitives
            assert gltf.materials[primitive.material].name == "left"


def test_the_camera_sees_as_the_video_did() -> None:
    camera = Camera(
        width=640, height=360, fx=700, fy=710, cx=300, cy=170, distortion=(0.1, 0, 0, 0, 0)
    )
    made = altered(recordings.recording("person"), camera=camera)
    gltf = Player.of(written(made)).gltf
    (seen,) = gltf.cameras
    assert seen.type == "perspective"
    assert math.tan(seen.perspective.yfov / 2) * 710 == pytest.approx(180)
    assert seen.perspective.aspectRatio == pytest.approx((640 / 700) / (360 / 710))
    assert seen.extras["cx"] == 300
    assert seen.extras["fx"] == 700
    assert seen.extras["distortion_k1_k2_p1_p2_k3"][0] == 0.1
    (node,) = [n for n in gltf.nodes if n.camera is not None]
    assert node.translation is None
    assert node.rotation is None


def test_a_telephoto_lens_has_no_camera_in_the_file() -> None:
    camera = CAMERA.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 3.0})
    gltf = Player.of(written(altered(recordings.recording("box"), camera=camera))).gltf
    assert gltf.cameras == []
    assert all(node.camera is None for node in gltf.nodes)


def test_the_file_needs_no_extension_and_says_how_large_it_is() -> None:
    content = written(recordings.recording("box"))
    gltf = Player.of(content).gltf
    assert gltf.extensionsUsed == gltf.extensionsRequired == []
    assert int.from_bytes(content[8:12], "little") == len(content)
    assert len(content) % 4 == 0
    assert gltf.materials[0].name == "middle"
    assert len(gltf.materials) == 1


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
    expected = recordings.joints_in_file(made)[24:, : found.shape[1]]
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_times_that_stand_still_are_refused() -> None:
    made = recordings.recording("box")
    with pytest.raises(FormatError, match="times ascend"):
        written(altered(made, times_s=made.times_s + 1e7))
