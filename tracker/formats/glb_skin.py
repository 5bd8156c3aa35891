"""The skin of a rig (`keypose.tracker.formats.rigs.skin`) in the numbers of a GLB file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.formats.glb_file import Numbers
from keypose.tracker.formats.rigs.rig import Rig
from keypose.tracker.formats.rigs.skin import Skin


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
