"""USD as usd-core itself reads it: bones, skin, camera, clock."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdShade, UsdSkel, UsdValidation

from keypose.app.export.motion_files import motion_files
from keypose.app.orders.motion import MotionOrder
from keypose.tracker.body.body import Body, Part
from keypose.tracker.body.shapes import Cylinder
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import parts_in_world
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.rigs import OWN, RIGS
from keypose.tracker.formats.rigs.rig import rig_of
from keypose.tracker.geometry.rotations import Array
from tests.tracker.formats import recordings

FRAMES = (0, 17, 72)


def recorded(name: str) -> Recording:
    """A sample's motion at a constant rate."""
    made = recordings.recording(name)
    return replace(made, times_s=np.arange(len(made)) / 30, rate=30.0)


def opened(made: Recording, folder: Path, rig: str = OWN) -> Any:
    path = folder / "motion.usd"
    path.write_bytes(motion_files("usd", made, MotionOrder(rig=rig))["motion.usd"])
    return Usd.Stage.Open(str(path))


def skeleton_of(stage: Any) -> Any:
    """What usd-core asks about bones."""
    skeleton = UsdSkel.Skeleton(stage.GetDefaultPrim().GetChild("Skeleton"))
    cache = UsdSkel.Cache()
    cache.Populate(UsdSkel.Root(stage.GetDefaultPrim()), Usd.PrimDefaultPredicate)
    return cache.GetSkelQuery(skeleton)


def transforms(query: Any, frame: int) -> Array:
    """Ts_world_bone (B, 4, 4); the skeleton itself stands at the origin."""
    Ts = query.ComputeJointSkelTransforms(Usd.TimeCode(frame))
    return np.array([np.array(T).T for T in Ts])


@pytest.mark.parametrize("rig_name", RIGS)
def test_every_bone_is_where_the_rig_has_it(rig_name: str, tmp_path: Path) -> None:
    made = recorded("person")
    rig = rig_of(made.skeleton, rig_name)
    stage = opened(made, tmp_path, rig_name)  # queries live as long as it does
    query = skeleton_of(stage)
    Ts_world_part = parts_in_world(made, made.T_world_camera)
    moving = [i for i, part in enumerate(rig.parts) if part >= 0]
    for frame in FRAMES:
        Ts = Ts_world_part[frame, rig.parts[moving]] @ rig.Ts_part_bone[moving]
        np.testing.assert_allclose(transforms(query, frame)[moving], Ts, atol=1e-4)
    names = UsdSkel.Skeleton(query.GetPrim()).GetJointNamesAttr().Get()
    assert tuple(names) == rig.names


@pytest.mark.parametrize("name", ["box", "balance", "twirl"])
def test_bodies_of_all_samples_move_as_they_do_here(name: str, tmp_path: Path) -> None:
    made = recorded(name)
    T_world_camera = made.T_world_camera
    stage = opened(made, tmp_path)
    query = skeleton_of(stage)
    joints = made.ps_camera_joint @ T_world_camera[:3, :3].T + T_world_camera[:3, 3]
    for row in (0, len(made) // 2, len(made) - 1):
        found = transforms(query, made.frames[row])[:, :3, 3]
        np.testing.assert_allclose(found, joints[row], atol=1e-4)


def test_the_skin_goes_with_the_bones(tmp_path: Path) -> None:
    made = recorded("person")
    stage = opened(made, tmp_path, "ue5")
    mesh = UsdGeom.Mesh(stage.GetDefaultPrim().GetChild("Skin"))
    Ts_world_part = parts_in_world(made, made.T_world_camera)
    UsdSkel.BakeSkinning(UsdSkel.Root(stage.GetDefaultPrim()), Gf.Interval(17, 17))
    baked = np.array(mesh.GetPointsAttr().Get(17))
    for part, T in zip(made.skeleton.body.parts, Ts_world_part[17], strict=True):
        corners = part.shape.mesh().vertices * [1, -1, -1] @ T[:3, :3].T + T[:3, 3]
        away = np.linalg.norm(baked[:, None] - corners, axis=-1).min(axis=0)
        assert away.max() < 1e-4


def test_the_camera_sees_every_joint_at_its_pixel(tmp_path: Path) -> None:
    made = recorded("person")
    camera = made.camera.model_copy(
        update={"cx": made.camera.cx + 31, "cy": made.camera.cy - 17, "fy": 1.1 * made.camera.fy}
    )
    made = replace(made, camera=camera)
    stage = opened(made, tmp_path)
    seen = UsdGeom.Camera(stage.GetPrimAtPath("/Camera")).GetCamera(Usd.TimeCode(0))
    matrix = seen.frustum.ComputeViewMatrix() * seen.frustum.ComputeProjectionMatrix()
    places = transforms(skeleton_of(stage), 17)[:, :3, 3]
    ndc = np.array([matrix.Transform(Gf.Vec3d(*map(float, p))) for p in places])
    width, height = camera.width, camera.height
    uv = np.stack([(ndc[:, 0] + 1) / 2 * width, (1 - ndc[:, 1]) / 2 * height], axis=1) - 0.5
    expected = camera.without_distortion().project(made.ps_camera_joint[17])
    np.testing.assert_allclose(uv, expected, atol=0.01)


def test_a_telephoto_lens_is_an_orthographic_camera(tmp_path: Path) -> None:
    made = recorded("person")
    far = {"projection": "telephoto", "telephoto_distance_m": 4.0}
    made = replace(made, camera=made.camera.model_copy(update=far))
    stage = opened(made, tmp_path)
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/Camera"))
    assert camera.GetProjectionAttr().Get() == "orthographic"
    window = camera.GetCamera(Usd.TimeCode(0)).frustum.window
    assert window.GetSize()[0] == pytest.approx(made.camera.width / made.camera.fx * 4.0, rel=1e-5)


def test_a_time_code_is_a_frame_of_the_video_in_metres_with_y_up(tmp_path: Path) -> None:
    made = recorded("person").between(5, 40)
    stage = opened(made, tmp_path)
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (5, 40)
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == 30
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert stage.GetDefaultPrim().GetName() == "adult_male"
    motion = UsdSkel.Animation(stage.GetDefaultPrim().GetChild("Motion"))
    assert list(motion.GetRotationsAttr().GetTimeSamples()) == list(range(5, 41))


def test_the_layer_says_the_rig_and_the_filter(tmp_path: Path) -> None:
    stage = opened(replace(recorded("person"), filter_hz=6.0), tmp_path, "vrm")
    message = stage.GetRootLayer().customLayerData
    assert message == {"generator": "Keypose", "rig": "vrm", "low_pass_filter_hz": 6.0}


def test_every_face_has_the_material_of_its_side(tmp_path: Path) -> None:
    stage = opened(recorded("person"), tmp_path)
    mesh = UsdGeom.Mesh(stage.GetDefaultPrim().GetChild("Skin"))
    subsets = UsdShade.MaterialBindingAPI(mesh.GetPrim()).GetMaterialBindSubsets()
    faces = np.concatenate([np.array(s.GetIndicesAttr().Get()) for s in subsets])
    assert sorted(faces) == list(range(len(mesh.GetFaceVertexCountsAttr().Get())))
    for subset in subsets:
        material, _ = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()
        assert material.ComputeSurfaceSource()[0].GetIdAttr().Get() == "UsdPreviewSurface"


@pytest.mark.parametrize("rig_name", [OWN, "mixamo"])
def test_usd_s_own_validators_find_nothing(rig_name: str, tmp_path: Path) -> None:
    stage = opened(recorded("person"), tmp_path, rig_name)
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    assert [error.GetErrorAsString() for error in context.Validate(stage)] == []


def test_any_name_gets_a_path(tmp_path: Path) -> None:
    parts = [
        Part(name=name, parent=parent, shape=Cylinder(end_m=0.3, radius_m=0.1))
        for name, parent in (("1 trunk", None), ("an arm", "1 trunk"), ("an_arm", "1 trunk"))
    ]
    body = Body(name="odd: one", parts=tuple(parts))
    box = recorded("box")
    Rs = np.tile(np.eye(3), (len(box), 3, 1, 1))
    tracks = replace(box.tracks, part_names=body.names, Rs_parent_part=Rs)
    stage = opened(replace(box, skeleton=Skeleton.of(body), tracks=tracks), tmp_path)
    skeleton = UsdSkel.Skeleton(stage.GetDefaultPrim().GetChild("Skeleton"))
    assert stage.GetDefaultPrim().GetName() == "odd__one"
    assert list(skeleton.GetJointsAttr().Get()) == [
        "__trunk",
        "__trunk/an_arm",
        "__trunk/an_arm_",
    ]
    assert list(skeleton.GetJointNamesAttr().Get()) == ["1 trunk", "an arm", "an_arm"]


def test_a_gap_is_refused_by_its_frames(tmp_path: Path) -> None:
    made = recordings.recording("person", without=(1,))
    with pytest.raises(FormatError, match="Frames 24 to 48 are not tracked, and USD holds no gaps"):
        opened(made, tmp_path)


def test_without_usd_core_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "pxr", None)
    monkeypatch.delitem(sys.modules, "keypose.tracker.formats.usd", raising=False)
    with pytest.raises(FormatError, match="need usd-core: pip install 'keypose\\[usd\\]'"):
        motion_files("usd", recorded("person"))
