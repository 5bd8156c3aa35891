"""The body's solids as the skin of a rig: at rest, every vertex wholly on its part's bone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracker.body.body import Body
from tracker.formats.axes import flipped
from tracker.formats.glb_file import Numbers
from tracker.formats.glb_mesh import lit_mesh
from tracker.formats.rigs.rig import Rig


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
    places, directions, faces, joints, count = [], [], [], [], 0
    for i in parts:
        T, (vertices, normals, triangles) = rig.Ts_world_part[i], lit_mesh(body.parts[i].shape)
        places.append(flipped(vertices) @ T[:3, :3].T + T[:3, 3])
        directions.append(flipped(normals) @ T[:3, :3].T)
        faces.append(triangles + count)
        joints.append(np.full(len(vertices), rig.bone_of_part[i]))
        count += len(vertices)
    bones = np.zeros((count, 4), dtype=np.uint16)
    bones[:, 0] = np.concatenate(joints)
    weights = np.zeros((count, 4), dtype=np.float32)
    weights[:, 0] = 1.0
    indices = np.concatenate(faces).ravel()
    small = indices.astype(np.uint16 if count < 2**16 - 1 else np.uint32)
    return {
        "attributes": {
            "POSITION": numbers.add(_single(places), "VEC3", "vertices", bounded=True),
            "NORMAL": numbers.add(_single(directions), "VEC3", "vertices"),
            "JOINTS_0": numbers.add(bones, "VEC4", "vertices"),
            "WEIGHTS_0": numbers.add(weights, "VEC4", "vertices"),
        },
        "indices": numbers.add(small, "SCALAR", "indices"),
    }


def _single(stacks: Sequence[NDArray[np.float64]]) -> NDArray[np.float32]:
    return np.concatenate(stacks).astype(np.float32)
