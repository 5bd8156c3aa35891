"""The motion as USD (Universal Scene Description), written by usd-core.

That is an extra: who imports this module has it installed.

A stage in metres, y up, in the world of all files (`keypose.tracker.body.ground`). A time
code is a frame of the video, or the number of its image file, and `timeCodesPerSecond` its rate;
between two of them programs turn each bone about one axis, the shorter way. The default prim,
called as the body, holds

    Skeleton   a UsdSkel skeleton of the rig's bones (`keypose.tracker.formats.rigs`) in its rest
    pose Motion     a UsdSkel animation: all bones' rotations, and the place of the one that moves
    the
               body
    Skin       the body's solids as one mesh, each vertex on one bone, a subset of faces for every
               material
    Looks      the materials

of several bodies each is such a prim below the default prim, Bodies,

and beside it stands Camera, the film's, with its principal point and without its distortion; its
film back is 36 mm wide. A telephoto lens is an orthographic camera. Names that USD cannot have in a
path are bent there, and whole in the skeleton's `jointNames`. The layer's custom data name the rig
and, where the motion was low-pass filtered, the cut-off.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdShade, UsdSkel, Vt

from keypose.tracker.formats.conventions import (
    FLIP,
    ROUGHNESS,
    linear,
    parts_in_world,
    single_words,
)
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.rigs import OWN
from keypose.tracker.formats.rigs.rig import Rig, rig_of
from keypose.tracker.formats.rigs.skin import Skin
from keypose.tracker.formats.rotation_curves import smooth_quaternions_xyzw
from keypose.tracker.geometry.rotations import Array

TENTHS = 10.0
"""USD measures lens and film back in tenths of the scene's unit."""

FILM_BACK_M = 0.036
NEAR_M = 0.01
FAR_M = 1000.0
DIGITS = 9
"""Of the rate: a quotient of times is 30 to rounding alone."""

_TURN = np.append(FLIP, 1.0)
"""From the camera frame to USD's, which looks along −z with y up."""


def usd(
    recording: Recording,
    sides: Sequence[str],
    colours: Mapping[str, tuple[int, int, int]],
    rig_name: str = OWN,
    beside: Sequence[tuple[Recording, Sequence[str]]] = (),
) -> bytes:
    """The bytes of the file. FormatError where frames are not tracked, or the body is not one for
    the rig.

    sides: which of the colours (sRGB, 0 to 255) each part has.  beside: the other bodies of the
    scene, of the same frames and world, each with its sides.
    """
    whole = recording if beside else recording.whole("USD")
    rig = rig_of(whole.skeleton, rig_name)
    stage = Usd.Stage.CreateInMemory(".usda")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    rate = round(whole.frames_per_second, DIGITS)
    stage.SetTimeCodesPerSecond(rate)
    stage.SetFramesPerSecond(rate)
    stage.SetStartTimeCode(whole.numbers[0])
    stage.SetEndTimeCode(whole.numbers[-1])
    stage.GetRootLayer().customLayerData = _facts(whole, rig)
    top = f"/{_identifiers([whole.skeleton.body.name])[0]}"
    if beside:
        top = UsdGeom.Xform.Define(stage, "/Bodies").GetPath().pathString
        _put_bodies(stage, top, [(recording, sides), *beside], colours, rig_name)
    else:
        _put_body(stage, top, whole, rig, (sides, colours))
    _put_camera(stage, "/Camera" if top != "/Camera" else "/Camera_", whole)
    stage.SetDefaultPrim(stage.GetPrimAtPath(top))
    with tempfile.TemporaryDirectory() as folder:  # usd-core writes to a path and nowhere else
        path = Path(folder) / "motion.usd"
        stage.GetRootLayer().Export(str(path))
        return path.read_bytes()


def _facts(recording: Recording, rig: Rig) -> dict[str, Any]:
    """What the file says of itself."""
    facts: dict[str, Any] = {"generator": "Keypose", "rig": rig.name}
    if recording.filter_hz is not None:
        facts["low_pass_filter_hz"] = recording.filter_hz
    if recording.unscaled:
        spans = (f"{first}-{last}" for first, last in recording.unscaled)
        facts["camera_path_without_scale"] = ", ".join(spans)
    return facts


def _identifiers(names: Sequence[str]) -> tuple[str, ...]:
    """The names as a path of USD can have them; still different."""
    return single_words([Tf.MakeValidIdentifier(name) for name in names])


# --- the body


def _put_bodies(
    stage: Any,
    top: str,
    bodies: Sequence[tuple[Recording, Sequence[str]]],
    colours: Mapping[str, tuple[int, int, int]],
    rig_name: str,
) -> None:
    """Several bodies, each below the prim of this path as its own."""
    names = _identifiers([recording.body_id for recording, _ in bodies])
    for name, (recording, sides) in zip(names, bodies, strict=True):
        whole, rig = recording.whole("USD"), rig_of(recording.skeleton, rig_name)
        _put_body(stage, f"{top}/{name}", whole, rig, (sides, colours))


def _put_body(
    stage: Any,
    path: str,
    recording: Recording,
    rig: Rig,
    painted: tuple[Sequence[str], Mapping[str, tuple[int, int, int]]],
) -> None:
    root = UsdSkel.Root.Define(stage, path)
    joints = Vt.TokenArray(_joint_paths(rig))
    skeleton = UsdSkel.Skeleton.Define(stage, f"{path}/Skeleton")
    skeleton.CreateJointsAttr(joints)
    skeleton.CreateJointNamesAttr(Vt.TokenArray(list(rig.names)))
    skeleton.CreateBindTransformsAttr(_matrices(rig.Ts_world_bone))
    skeleton.CreateRestTransformsAttr(_matrices(rig.Ts_parent_bone))
    motion = UsdSkel.Animation.Define(stage, f"{path}/Motion")
    motion.CreateJointsAttr(joints)
    _put_curves(motion, recording, rig)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().AddTarget(
        motion.GetPath()
    )
    mesh = _put_skin(stage, path, recording, rig, painted)
    UsdSkel.BindingAPI.Apply(mesh.GetPrim()).CreateSkeletonRel().AddTarget(skeleton.GetPath())
    UsdSkel.BindingAPI.Apply(root.GetPrim()).CreateSkeletonRel().AddTarget(skeleton.GetPath())


def _joint_paths(rig: Rig) -> list[str]:
    paths: list[str] = []
    for name, parent in zip(_identifiers(rig.names), rig.parents.tolist(), strict=True):
        paths.append(name if parent < 0 else f"{paths[parent]}/{name}")
    return paths


def _put_curves(motion: Any, recording: Recording, rig: Rig) -> None:
    Rs, ps = rig.motion(parts_in_world(recording, recording.T_world_camera))
    turns = smooth_quaternions_xyzw(Rs)
    places = np.tile(rig.Ts_parent_bone[:, :3, 3].astype(np.float32), (len(ps), 1, 1))
    places[:, rig.mover] = ps
    motion.CreateScalesAttr(Vt.Vec3hArray.FromNumpy(np.ones((len(rig), 3), np.float16)))
    translations, rotations = motion.CreateTranslationsAttr(), motion.CreateRotationsAttr()
    for frame, place, turn in zip(recording.numbers, places, turns, strict=True):
        translations.Set(Vt.Vec3fArray.FromNumpy(place), frame)
        rotations.Set(Vt.QuatfArray.FromNumpy(turn), frame)


def _put_skin(
    stage: Any,
    path: str,
    recording: Recording,
    rig: Rig,
    painted: tuple[Sequence[str], Mapping[str, tuple[int, int, int]]],
) -> Any:
    """The mesh, with a subset of its faces for every colour."""
    body, (sides, colours) = recording.skeleton.body, painted
    order = sorted(range(len(sides)), key=lambda i: sides[i])
    skin = Skin.of(body, rig, order)
    mesh = UsdGeom.Mesh.Define(stage, f"{path}/Skin")
    vertices = skin.vertices.astype(np.float32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(vertices))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(skin.faces), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(skin.faces.ravel().astype(np.int32)))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(skin.normals.astype(np.float32)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateExtentAttr([Gf.Vec3f(*map(float, v)) for v in (vertices.min(0), vertices.max(0))])
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    bones = Vt.IntArray.FromNumpy(skin.bones.astype(np.int32))
    binding.CreateJointIndicesPrimvar(False, 1).Set(bones)
    binding.CreateJointWeightsPrimvar(False, 1).Set(
        Vt.FloatArray.FromNumpy(np.ones(len(vertices), np.float32))
    )
    binding.CreateGeomBindTransformAttr(Gf.Matrix4d(1.0))
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    side_of_bone = {int(rig.bone_of_part[i]): side for i, side in enumerate(sides)}
    of_face = [side_of_bone[int(bone)] for bone in skin.bones[skin.faces[:, 0]]]
    for side in dict.fromkeys(of_face):
        faces = Vt.IntArray([i for i, own in enumerate(of_face) if own == side])
        subset = UsdGeom.Subset.CreateGeomSubset(
            mesh,
            side,
            UsdGeom.Tokens.face,
            faces,
            UsdShade.Tokens.materialBind,
            UsdGeom.Tokens.partition,
        )
        material = _material(stage, f"{path}/Looks/{side}", colours[side])
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
    return mesh


def _material(stage: Any, path: str, colour: tuple[int, int, int]) -> Any:
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    diffuse = Gf.Vec3f(*linear(colour))
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(diffuse)
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(ROUGHNESS)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material


# --- the camera


def _put_camera(stage: Any, path: str, whole: Recording) -> None:
    """The camera, which moves and zooms as it did."""
    camera, usd_camera = whole.camera, UsdGeom.Camera.Define(stage, path)
    placed = usd_camera.AddTransformOp()
    if whole.seen_from is None:
        placed.Set(Gf.Matrix4d((whole.T_world_camera * _TURN).T.tolist()))
    else:
        for number, T in zip(whole.numbers, whole.Ts_world_camera, strict=True):
            placed.Set(Gf.Matrix4d((T * _TURN).T.tolist()), number)
    usd_camera.CreateClippingRangeAttr(Gf.Vec2f(NEAR_M, FAR_M))
    distance = camera.telephoto_distance_m
    if distance is None:
        focal = FILM_BACK_M * camera.fx / camera.width
        usd_camera.CreateProjectionAttr(UsdGeom.Tokens.perspective)
    else:  # what is that wide there is as wide on the film
        focal = distance
        usd_camera.CreateProjectionAttr(UsdGeom.Tokens.orthographic)
    x, y = TENTHS * focal / camera.fx, TENTHS * focal / camera.fy  # of a pixel
    length = usd_camera.CreateFocalLengthAttr(TENTHS * focal)
    if whole.seen_from is not None and whole.seen_from.zooms:
        for number, zoom in zip(whole.numbers, whole.seen_from.zoom, strict=True):
            length.Set(TENTHS * focal * float(zoom), number)
    usd_camera.CreateHorizontalApertureAttr(camera.width * x)
    usd_camera.CreateVerticalApertureAttr(camera.height * y)
    usd_camera.CreateHorizontalApertureOffsetAttr(((camera.width - 1) / 2 - camera.cx) * x)
    usd_camera.CreateVerticalApertureOffsetAttr((camera.cy - (camera.height - 1) / 2) * y)


def _matrices(Ts: Array) -> Any:
    """Transforms (B, 4, 4) as USD has them, for rows."""
    return Vt.Matrix4dArray.FromNumpy(np.ascontiguousarray(Ts.swapaxes(1, 2)))
