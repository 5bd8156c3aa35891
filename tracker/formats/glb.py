"""Write the motion as GLB, binary glTF 2.0: one rig with its skin, one animation, one camera.

Of several bodies each has a rig and a skin of its own, its nodes named apart as `NAME:bone` and its
armature as the body, and the one animation moves all.

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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

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
from keypose.tracker.formats.recording import Recording, named_apart
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
        if name in sides
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


@dataclass(frozen=True, eq=False)
class _Figure:
    """A body of the scene.  recording: without gaps.  sides: of its parts.  first: the number of
    its first node.  names: of its armature, its mesh and its bones."""

    recording: Recording
    rig: Rig
    sides: Sequence[str]
    first: int
    names: tuple[str, ...]

    def nodes(self, number: int) -> list[Node]:
        """Its bones, its armature and its mesh, the skin of this number."""
        armature, mesh, *bones = self.names
        return [
            *_bone_nodes(self.rig, bones, self.first),
            {"name": armature, "children": [self.first]},
            {"name": mesh, "mesh": number, "skin": number},
        ]

    @property
    def roots(self) -> tuple[int, int]:
        """The nodes of armature and mesh."""
        armature = self.first + len(self.rig)
        return armature, armature + 1


def glb(
    recording: Recording,
    sides: Sequence[str],
    colours: Mapping[str, tuple[int, int, int]],
    rig_name: str = OWN,
    beside: Sequence[tuple[Recording, Sequence[str]]] = (),
) -> bytes:
    """The bytes of the file. FormatError where frames are not tracked or times do not ascend, or
    the body is not one for the rig.

    sides: which of the colours (sRGB, 0 to 255) each part has.  beside: the other bodies of the
    scene, of the same frames and world, each with its sides.
    """
    figures, numbers = _figures([(recording, sides), *beside], rig_name), Numbers()
    scene = recording if beside else figures[0].recording
    T_first = scene.Ts_world_camera[0]
    all_sides = {side for figure in figures for side in figure.sides}
    used = {name: colour for name, colour in colours.items() if name in all_sides}
    nodes = [node for number, figure in enumerate(figures) for node in figure.nodes(number)]
    camera, roots = len(nodes), [root for figure in figures for root in figure.roots]
    nodes.append({"name": "camera", "camera": 0, **_placed(T_first[:3, 3], T_first * TURN)})
    meshes = [_mesh(figure, list(used), numbers) for figure in figures]
    title = "bodies" if beside else recording.skeleton.body.name
    document = {
        "asset": {"version": "2.0", "generator": "Keypose"},
        "scene": 0,
        "scenes": [{"name": title, "nodes": [*roots, camera]}],
        "nodes": nodes,
        "cameras": [_camera(scene.camera_at(0))],
        "meshes": meshes,
        "materials": [_material(name, colour) for name, colour in used.items()],
        "skins": [_skin(figure, numbers) for figure in figures],
        "animations": [_animation(scene, figures, camera, numbers)],
    }
    extensions = _vrm_animation(figures)
    used_extensions = [*extensions, *([POINTER] if _zooms(scene) else [])]
    if extensions:
        document["extensions"] = extensions
    if used_extensions:
        document["extensionsUsed"] = used_extensions
    return numbers.file(document)


def _figures(bodies: Sequence[tuple[Recording, Sequence[str]]], rig_name: str) -> list[_Figure]:
    figures, first = list[_Figure](), 0
    for recording, sides in bodies:
        rig = rig_of(recording.skeleton, rig_name)
        names: tuple[str, ...] = ("Armature", "body", *rig.names)
        if len(bodies) > 1:
            names = (recording.body_id, *named_apart(recording, names[1:]))
        figures.append(_Figure(recording.whole("GLB"), rig, sides, first, names))
        first += len(names)
    return figures


def _mesh(figure: _Figure, materials: Sequence[str], numbers: Numbers) -> dict[str, Any]:
    """The body's solids, of those materials that it has."""
    body = figure.recording.skeleton.body
    name = figure.recording.body_id if figure.names[0] != "Armature" else body.name
    return {
        "name": name,
        "primitives": primitives(body, figure.rig, figure.sides, materials, numbers),
    }


def _bone_nodes(rig: Rig, names: Sequence[str], first: int) -> list[Node]:
    """A node for every bone, in the rest pose; the root first, which has this number."""
    nodes = [
        {"name": name, **_placed(T[:3, 3], T)}
        for name, T in zip(names, rig.Ts_parent_bone, strict=True)
    ]
    for i, parent in enumerate(rig.parents.tolist()):
        if parent >= 0:
            nodes[parent].setdefault("children", []).append(first + i)
    return nodes


def _placed(p: Array, T: Array) -> Node:
    """A node's translation, and the rotation of T."""
    q = quaternion_wxyz(T[:3, :3])
    return {"translation": (p + 0.0).tolist(), "rotation": (np.roll(q, -1) + 0.0).tolist()}


def _skin(figure: _Figure, numbers: Numbers) -> dict[str, Any]:
    matrices = numbers.add(bind_matrices(figure.rig), "MAT4", "skin")
    joints = [figure.first + bone for bone in range(len(figure.rig))]
    return {"joints": joints, "skeleton": figure.first, "inverseBindMatrices": matrices}


def _material(name: str, colour: tuple[int, int, int]) -> dict[str, Any]:
    looks = {
        "baseColorFactor": [*(round(light, 6) for light in linear(colour)), 1.0],
        "metallicFactor": 0.0,
        "roughnessFactor": ROUGHNESS,
    }
    return {"name": name, "pbrMetallicRoughness": looks}


Curve: TypeAlias = tuple[dict[str, Any], int, int]
"""What is animated, and the accessors of its times and values."""


def _animation(
    scene: Recording, figures: Sequence[_Figure], camera: int, numbers: Numbers
) -> dict[str, Any]:
    """The motion of all bodies and of the camera, a node of this number."""
    clocks = _Clocks(numbers)
    curves = [
        curve
        for figure in figures
        for curve in _body_curves(figure, clocks.of(figure.recording), numbers)
    ]
    if scene.seen_from is not None:
        curves += _camera_curves(scene, camera, clocks.of(scene), numbers)
    return {
        "name": "motion",
        "channels": [{"sampler": k, "target": target} for k, (target, _, _) in enumerate(curves)],
        "samplers": [
            {"input": clock, "output": output, "interpolation": "LINEAR"}
            for _, clock, output in curves
        ],
        "extras": _facts(scene) | {"rig": figures[0].rig.name},
    }


class _Clocks:
    """The accessors of times, one for those that are the same."""

    def __init__(self, numbers: Numbers) -> None:
        self._numbers = numbers
        self._accessors: dict[bytes, int] = {}

    def of(self, recording: Recording) -> int:
        times_s = recording.times_s.astype(np.float32)
        if not (np.diff(times_s) > 0).all():
            raise FormatError(
                "GLB needs frames whose times ascend, to a ten-millionth of the last."
            )
        key = times_s.tobytes()
        if key not in self._accessors:
            self._accessors[key] = self._numbers.add(times_s, "SCALAR", "animation", bounded=True)
        return self._accessors[key]


def _body_curves(figure: _Figure, clock: int, numbers: Numbers) -> Iterator[Curve]:
    recording, rig = figure.recording, figure.rig
    Rs_parent_bone, ps_parent_mover = rig.motion(
        parts_in_world(recording, recording.T_world_camera)
    )
    rotations = smooth_quaternions_xyzw(Rs_parent_bone)
    places = numbers.add(ps_parent_mover.astype(np.float32), "VEC3", "animation")
    yield _of_node(figure.first + rig.mover, "translation"), clock, places
    for i in range(len(rig)):
        turns = numbers.add(np.ascontiguousarray(rotations[:, i]), "VEC4", "animation")
        yield _of_node(figure.first + i, "rotation"), clock, turns


def _camera_curves(scene: Recording, node: int, clock: int, numbers: Numbers) -> Iterator[Curve]:
    Ts = scene.Ts_world_camera
    turns = np.ascontiguousarray(smooth_quaternions_xyzw((Ts * TURN)[:, None, :3, :3])[:, 0])
    positions = np.ascontiguousarray(Ts[:, :3, 3]).astype(np.float32)
    yield _of_node(node, "translation"), clock, numbers.add(positions, "VEC3", "animation")
    yield _of_node(node, "rotation"), clock, numbers.add(turns, "VEC4", "animation")
    if _zooms(scene):
        angles = [_yfov(scene.camera_at(row)) for row in range(len(scene))]
        values = numbers.add(np.array(angles, dtype=np.float32), "SCALAR", "animation")
        yield {"path": "pointer", "extensions": {POINTER: {"pointer": YFOV}}}, clock, values


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


def _vrm_animation(figures: Sequence[_Figure]) -> dict[str, Any]:
    """The extension of VRM's rig: which node is which humanoid bone; none of other rigs."""
    rig = figures[0].rig
    if rig.name != "vrm":
        return {}
    if len(figures) > 1:
        raise FormatError("A VRM animation is of one body: choose it with --body.")
    named = {row.name for row in table_of(rig.name).rows()}
    bones = {name: {"node": i} for i, name in enumerate(rig.names) if name in named}
    return {"VRMC_vrm_animation": {"specVersion": "1.0", "humanoid": {"humanBones": bones}}}
