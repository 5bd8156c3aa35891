"""The motion as GLB, binary glTF 2.0 without extensions: the body itself, moving.

World of the file as in `tracker.formats.axes`: metres, x right, y up, z toward the camera, which is
at the origin. Every part is a node with its mesh, a child of its parent's node at the joint; in the
rest pose all nodes are parallel to the world. Landmarks are nodes without a mesh. One animation
turns every part and moves the root. Its times count from the video's first frame; between two of
them programs turn each part about one axis, the shorter way. The animation's `extras` say its rate
and, where the motion was low-pass filtered, the cut-off.

A perspective camera is the node "camera". glTF knows the angle it sees, but no principal point
beside the middle and no distortion: the exact numbers are in the camera's `extras`. A telephoto
lens has no such angle and is left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracker.body.shapes import Shape
from tracker.body.skeleton import Skeleton
from tracker.errors import FormatError
from tracker.formats.axes import flipped, flipped_rotations
from tracker.formats.glb_file import Numbers
from tracker.formats.glb_mesh import lit_mesh
from tracker.formats.names import column_names
from tracker.formats.recording import Recording
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array, quaternion_wxyz

NEAR_M = 0.01
"""Programs draw nothing that is nearer to the camera."""

ROUGHNESS = 0.75

Node = dict[str, Any]


def glb(
    recording: Recording, sides: Sequence[str], colours: Mapping[str, tuple[int, int, int]]
) -> bytes:
    """The bytes of the file. FormatError where frames are not tracked or times do not ascend.

    sides: which of the colours (sRGB, 0 to 255) each part has.
    """
    recording, numbers = recording.whole("GLB"), Numbers()
    motion = recording.trajectory
    used = {name: colour for name, colour in colours.items() if name in sides}
    rotations = _quaternions_xyzw(motion.Rs_parent_part)
    places = flipped(motion.ps_camera_root).astype(np.float32)
    nodes = _part_nodes(recording.skeleton, rotations[0], places[0])
    nodes += _landmark_nodes(recording.skeleton, nodes)
    roots, cameras = [0], _cameras(recording.camera)
    if cameras:
        roots.append(len(nodes))
        nodes.append({"name": "camera", "camera": 0})
    document = {
        "asset": {"version": "2.0", "generator": "Keypose"},
        "scene": 0,
        "scenes": [{"name": recording.skeleton.body.name, "nodes": roots}],
        "nodes": nodes,
        "meshes": _meshes(recording.skeleton, sides, list(used), numbers),
        "materials": [_material(name, colour) for name, colour in used.items()],
        "animations": [_animation(recording, rotations, places, numbers)],
    }
    return numbers.file(document | ({"cameras": cameras} if cameras else {}))


def _quaternions_xyzw(Rs_parent_part: Array) -> NDArray[np.float32]:
    """(N, P, 4) in the file's frames, each with the sign that is nearer to the one before."""
    q = quaternion_wxyz(flipped_rotations(Rs_parent_part))
    turned = np.where((q[1:] * q[:-1]).sum(axis=-1, keepdims=True) < 0, -1.0, 1.0)
    q[1:] *= np.cumprod(turned, axis=0)
    return np.roll(q, -1, axis=-1).astype(np.float32)


def _part_nodes(
    skeleton: Skeleton, rotations: NDArray[np.float32], place: NDArray[np.float32]
) -> list[Node]:
    """A node for every part, in the pose of the first frame."""
    nodes: list[Node] = [
        {
            "name": name,
            "mesh": i,
            "translation": (flipped(skeleton.joints[i]) + 0.0).tolist(),
            "rotation": rotations[i].tolist(),
        }
        for i, name in enumerate(skeleton.body.names)
    ]
    nodes[0]["translation"] = place.tolist()
    for i, parent in enumerate(skeleton.parents.tolist()):
        if parent >= 0:
            nodes[parent].setdefault("children", []).append(i)
    return nodes


def _landmark_nodes(skeleton: Skeleton, parts: list[Node]) -> list[Node]:
    """A node for every landmark, hung below its part's."""
    names = iter(column_names(skeleton)[len(parts) :])
    nodes: list[Node] = []
    for node, part in zip(parts, skeleton.body.parts, strict=True):
        for p_part in part.landmarks.values():
            node.setdefault("children", []).append(len(parts) + len(nodes))
            translation = (flipped(np.array(p_part)) + 0.0).tolist()
            nodes.append({"name": next(names), "translation": translation})
    return nodes


def _meshes(
    skeleton: Skeleton, sides: Sequence[str], materials: list[str], numbers: Numbers
) -> list[dict[str, Any]]:
    parts = zip(skeleton.body.parts, sides, strict=True)
    return [
        {
            "name": part.name,
            "primitives": [{**_surface(part.shape, numbers), "material": materials.index(side)}],
        }
        for part, side in parts
    ]


def _surface(shape: Shape, numbers: Numbers) -> dict[str, Any]:
    vertices, normals, faces = lit_mesh(shape)
    places, directions = (flipped(v).astype(np.float32) for v in (vertices, normals))
    indices = faces.ravel().astype(np.uint16)
    return {
        "attributes": {
            "POSITION": numbers.add(places, "VEC3", "vertices", bounded=True),
            "NORMAL": numbers.add(directions, "VEC3", "vertices"),
        },
        "indices": numbers.add(indices, "SCALAR", "indices"),
    }


def _material(name: str, colour: tuple[int, int, int]) -> dict[str, Any]:
    looks = {
        "baseColorFactor": [*(round(_linear(channel / 255), 6) for channel in colour), 1.0],
        "metallicFactor": 0.0,
        "roughnessFactor": ROUGHNESS,
    }
    return {"name": name, "pbrMetallicRoughness": looks}


def _linear(value: float) -> float:
    """Light, 0 to 1, of an sRGB value, 0 to 1."""
    return value / 12.92 if value <= 0.04045 else float(((value + 0.055) / 1.055) ** 2.4)


def _animation(
    recording: Recording,
    rotations: NDArray[np.float32],
    places: NDArray[np.float32],
    numbers: Numbers,
) -> dict[str, Any]:
    times_s = recording.times_s.astype(np.float32)
    if not (np.diff(times_s) > 0).all():
        raise FormatError("GLB needs frames whose times ascend, to a ten-millionth of the last.")
    clock = numbers.add(times_s, "SCALAR", "animation", bounded=True)
    outputs = [(0, "translation", numbers.add(places, "VEC3", "animation"))]
    for i in range(rotations.shape[1]):
        turns = np.ascontiguousarray(rotations[:, i])
        outputs.append((i, "rotation", numbers.add(turns, "VEC4", "animation")))
    return {
        "name": "motion",
        "channels": [
            {"sampler": k, "target": {"node": node, "path": path}}
            for k, (node, path, _) in enumerate(outputs)
        ],
        "samplers": [
            {"input": clock, "output": output, "interpolation": "LINEAR"}
            for _, _, output in outputs
        ],
        "extras": _facts(recording),
    }


def _facts(recording: Recording) -> dict[str, float]:
    """What the animation says of itself."""
    facts: dict[str, float] = {"first_frame": recording.frames[0], "frame_count": len(recording)}
    if recording.is_even and recording.rate is not None:
        facts["frames_per_second"] = round(recording.rate, 9)
    if recording.filter_hz is not None:
        facts["low_pass_filter_hz"] = recording.filter_hz
    return facts


def _cameras(camera: Camera) -> list[dict[str, Any]]:
    """The camera of a perspective lens: glTF's looks along −z with y up, as F turns ours."""
    if camera.projection != "perspective":
        return []
    fields = camera.model_dump(include={"width", "height", "fx", "fy", "cx", "cy"})
    perspective = {
        "yfov": 2 * math.atan(camera.height / 2 / camera.fy),
        "aspectRatio": camera.width * camera.fy / (camera.height * camera.fx),
        "znear": NEAR_M,
    }
    exact = fields | {"distortion_k1_k2_p1_p2_k3": list(camera.distortion)}
    exact["pixel_centres"] = "at integers"
    return [{"name": "camera", "type": "perspective", "perspective": perspective, "extras": exact}]
