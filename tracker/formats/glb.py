"""Write the motion as GLB, binary glTF 2.0: one rig with its skin, one animation, one camera.

The world is that of all files (`keypose.tracker.body.ground`): metres, y up, the floor at zero. The
bones (`keypose.tracker.formats.rigs`) are nodes below the node
"Armature", in their rest pose; the body's solids are one mesh, each vertex on one bone. One
animation turns every bone and moves the body. Its times count from the video's first frame; between
two of them programs turn each bone about one axis, the shorter way. The animation's `extras` say
its rate, its frames, the film's timecode and, where the motion was low-pass filtered, the cut-off.

The film's camera is the node "camera", which moves as it did. glTF knows the angle it sees, but no
principal point beside the middle and no distortion: the exact numbers are in the camera's `extras`.
A telephoto lens is an orthographic camera. A lens that zooms has its angle at every frame by
KHR_animation_pointer, which Blender plays and programs without it ignore; the animation's `extras`
have its focal length, too, as a multiple of the camera's.

With the rig of VRM the file is a VRM animation, too: its name may end in .vrma. No extension is
required.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import (
    FLIP,
    ROUGHNESS,
    linear,
    parts_in_world,
)
from keypose.tracker.formats.glb_file import Numbers
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.rigs import OWN
from keypose.tracker.formats.rigs.rig import Rig, rig_of
from keypose.tracker.formats.rigs.skin import Skin
from keypose.tracker.formats.rigs.table import table_of
from keypose.tracker.formats.rotation_curves import smooth_quaternions_xyzw
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, quaternion_wxyz


def bind_matrices(rig: Rig) -> NDArray[np.float32]:
    """(B, 16) from the world at rest into every bone's frame, column by column, as glTF has it."""
    inverse = np.linalg.inv(rig.Ts_world_bone)
    inverse[:, 3] = (0.0, 0.0, 0.0, 1.0)
    return inverse.swapaxes(1, 2).reshape(-1, 16).astype(np.float32)


def primitives(
    body: Body, rig: Rig, sides: Sequence[str], materials: Sequence[str], numbers: Numbers
) -> list[dict[str, Any]]:
    """One primitive for every material, of the parts of that side."""
    return [
        {
            **_skinned(body, rig, [i for i, side in enumerate(sides) if side == name], numbers),
            "material": k,
        }
        for k, name in enumerate(materials)
    ]


def _skinned(body: Body, rig: Rig, parts: Sequence[int], numbers: Numbers) -> dict[str, Any]:
    """These parts as they lie in the rest pose."""
    skin = Skin.of(body, rig, parts)
    count = len(skin.vertices)
    bones = np.zeros((count, 4), dtype=np.uint16)
    bones[:, 0] = skin.bones
    weights = np.zeros((count, 4), dtype=np.float32)
    weights[:, 0] = 1.0
    small = skin.faces.ravel().astype(np.uint16 if count < 2**16 - 1 else np.uint32)
    vertices, normals = (v.astype(np.float32) for v in (skin.vertices, skin.normals))
    return {
        "attributes": {
            "POSITION": numbers.add(vertices, "VEC3", "vertices", bounded=True),
            "NORMAL": numbers.add(normals, "VEC3", "vertices"),
            "JOINTS_0": numbers.add(bones, "VEC4", "vertices"),
            "WEIGHTS_0": numbers.add(weights, "VEC4", "vertices"),
        },
        "indices": numbers.add(small, "SCALAR", "indices"),
    }


POINTER = "KHR_animation_pointer"
YFOV = "/cameras/0/perspective/yfov"
NEAR_M = 0.01
FAR_M = 1000.0
"""Programs draw nothing that is nearer to the camera, or farther where it must be said."""

TURN = np.append(FLIP, 1.0)
"""From the camera frame to glTF's, which looks along −z with y up: the same columns, two reversed.
"""

Node = dict[str, Any]


def glb(
    recording: Recording,
    sides: Sequence[str],
    colours: Mapping[str, tuple[int, int, int]],
    rig_name: str = OWN,
) -> bytes:
    """The bytes of the file. FormatError where frames are not tracked or times do not ascend, or
    the body is not one for the rig.

    sides: which of the colours (sRGB, 0 to 255) each part has.
    """
    recording, numbers = recording.whole("GLB"), Numbers()
    rig = rig_of(recording.skeleton, rig_name)
    T_world_camera, T_first = recording.T_world_camera, recording.Ts_world_camera[0]
    used = {name: colour for name, colour in colours.items() if name in sides}
    bones = _bone_nodes(rig)
    armature, body, camera = len(bones), len(bones) + 1, len(bones) + 2
    nodes = [
        *bones,
        {"name": "Armature", "children": [0]},
        {"name": "body", "mesh": 0, "skin": 0},
        {"name": "camera", "camera": 0, **_placed(T_first[:3, 3], T_first * TURN)},
    ]
    mesh = primitives(recording.skeleton.body, rig, sides, list(used), numbers)
    document = {
        "asset": {"version": "2.0", "generator": "Keypose"},
        "scene": 0,
        "scenes": [{"name": recording.skeleton.body.name, "nodes": [armature, body, camera]}],
        "nodes": nodes,
        "cameras": [_camera(recording.camera_at(0))],
        "meshes": [{"name": recording.skeleton.body.name, "primitives": mesh}],
        "materials": [_material(name, colour) for name, colour in used.items()],
        "skins": [_skin(rig, numbers)],
        "animations": [_animation(recording, rig, T_world_camera, numbers)],
    }
    extensions = _vrm_animation(rig)
    used_extensions = [*extensions, *([POINTER] if _zooms(recording) else [])]
    if extensions:
        document["extensions"] = extensions
    if used_extensions:
        document["extensionsUsed"] = used_extensions
    return numbers.file(document)


def _bone_nodes(rig: Rig) -> list[Node]:
    """A node for every bone, in the rest pose; the root first."""
    nodes = [
        {"name": name, **_placed(T[:3, 3], T)}
        for name, T in zip(rig.names, rig.Ts_parent_bone, strict=True)
    ]
    for i, parent in enumerate(rig.parents.tolist()):
        if parent >= 0:
            nodes[parent].setdefault("children", []).append(i)
    return nodes


def _placed(p: Array, T: Array) -> Node:
    """A node's translation, and the rotation of T."""
    q = quaternion_wxyz(T[:3, :3])
    return {"translation": (p + 0.0).tolist(), "rotation": (np.roll(q, -1) + 0.0).tolist()}


def _skin(rig: Rig, numbers: Numbers) -> dict[str, Any]:
    matrices = numbers.add(bind_matrices(rig), "MAT4", "skin")
    return {"joints": list(range(len(rig))), "skeleton": 0, "inverseBindMatrices": matrices}


def _material(name: str, colour: tuple[int, int, int]) -> dict[str, Any]:
    looks = {
        "baseColorFactor": [*(round(light, 6) for light in linear(colour)), 1.0],
        "metallicFactor": 0.0,
        "roughnessFactor": ROUGHNESS,
    }
    return {"name": name, "pbrMetallicRoughness": looks}


def _animation(
    recording: Recording, rig: Rig, T_world_camera: Array, numbers: Numbers
) -> dict[str, Any]:
    times_s = recording.times_s.astype(np.float32)
    if not (np.diff(times_s) > 0).all():
        raise FormatError("GLB needs frames whose times ascend, to a ten-millionth of the last.")
    Rs_parent_bone, ps_parent_mover = rig.motion(parts_in_world(recording, T_world_camera))
    rotations = smooth_quaternions_xyzw(Rs_parent_bone)
    clock = numbers.add(times_s, "SCALAR", "animation", bounded=True)
    places = numbers.add(ps_parent_mover.astype(np.float32), "VEC3", "animation")
    outputs = [(_of_node(rig.mover, "translation"), places)]
    for i in range(len(rig)):
        turns = np.ascontiguousarray(rotations[:, i])
        outputs.append((_of_node(i, "rotation"), numbers.add(turns, "VEC4", "animation")))
    if recording.seen_from is not None:
        Ts, node = recording.Ts_world_camera, len(rig) + 2
        turns = np.ascontiguousarray(smooth_quaternions_xyzw((Ts * TURN)[:, None, :3, :3])[:, 0])
        positions = np.ascontiguousarray(Ts[:, :3, 3]).astype(np.float32)
        outputs.append((_of_node(node, "translation"), numbers.add(positions, "VEC3", "animation")))
        outputs.append((_of_node(node, "rotation"), numbers.add(turns, "VEC4", "animation")))
    if _zooms(recording):
        angles = [_yfov(recording.camera_at(row)) for row in range(len(recording))]
        angle_accessor = numbers.add(np.array(angles, dtype=np.float32), "SCALAR", "animation")
        outputs.append(
            ({"path": "pointer", "extensions": {POINTER: {"pointer": YFOV}}}, angle_accessor)
        )
    return {
        "name": "motion",
        "channels": [{"sampler": k, "target": target} for k, (target, _) in enumerate(outputs)],
        "samplers": [
            {"input": clock, "output": output, "interpolation": "LINEAR"} for _, output in outputs
        ],
        "extras": _facts(recording) | {"rig": rig.name},
    }


def _of_node(node: int, path: str) -> dict[str, Any]:
    """What a channel animates."""
    return {"node": node, "path": path}


def _zooms(recording: Recording) -> bool:
    """Whether the angle of the camera changes; a telephoto lens has none."""
    path = recording.seen_from
    return path is not None and path.zooms and recording.camera.telephoto_distance_m is None


def _facts(recording: Recording) -> dict[str, Any]:
    """What the animation says of itself."""
    film = recording.film_frames[[0, -1]].round(4).tolist()
    facts: dict[str, Any] = {
        "first_frame": recording.frames[0],
        "frame_count": len(recording),
        "film_frames": film,
    }
    if recording.is_even and recording.rate is not None:
        facts["frames_per_second"] = round(recording.rate, 9)
    if recording.timecode is not None:
        facts["timecode_of_frame_0"] = str(recording.timecode)
    if recording.first_file_number is not None:
        facts["file_number_of_frame_0"] = recording.first_file_number
    if recording.seen_from is not None and recording.seen_from.zooms:
        facts["camera_zoom"] = recording.seen_from.zoom.round(6).tolist()
    if recording.filter_hz is not None:
        facts["low_pass_filter_hz"] = recording.filter_hz
    if recording.unscaled:
        facts["camera_path_without_scale"] = [list(span) for span in recording.unscaled]
    return facts


def _camera(camera: Camera) -> dict[str, Any]:
    fields = camera.model_dump(include={"width", "height", "fx", "fy", "cx", "cy"})
    exact = fields | {"distortion_k1_k2_p1_p2_k3": list(camera.distortion)}
    exact["pixel_centres"] = "at integers"
    if camera.telephoto_distance_m is None:
        projection: dict[str, float] = {
            "yfov": _yfov(camera),
            "aspectRatio": camera.width * camera.fy / (camera.height * camera.fx),
            "znear": NEAR_M,
            "zfar": FAR_M,
        }
        return {"name": "camera", "type": "perspective", "perspective": projection, "extras": exact}
    scale = camera.telephoto_distance_m
    exact["telephoto_distance_m"] = scale
    projection = {
        "xmag": camera.width / 2 / camera.fx * scale,
        "ymag": camera.height / 2 / camera.fy * scale,
        "znear": NEAR_M,
        "zfar": FAR_M,
    }
    return {"name": "camera", "type": "orthographic", "orthographic": projection, "extras": exact}


def _yfov(camera: Camera) -> float:
    """What the picture spans down, radians."""
    return 2 * math.atan(camera.height / 2 / camera.fy)


def _vrm_animation(rig: Rig) -> dict[str, Any]:
    """The extension of VRM's rig: which node is which humanoid bone; none of other rigs."""
    if rig.name != "vrm":
        return {}
    named = {row.name for row in table_of(rig.name).rows()}
    bones = {name: {"node": i} for i, name in enumerate(rig.names) if name in named}
    return {"VRMC_vrm_animation": {"specVersion": "1.0", "humanoid": {"humanBones": bones}}}
