"""The body's solids as the skin of a rig: at rest, every vertex wholly on its part's bone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.formats.axes import flipped
from keypose.tracker.formats.glb_mesh import lit_mesh
from keypose.tracker.formats.rigs.rig import Rig
from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True, eq=False)
class Skin:
    """Some parts in the rig's rest pose.

    vertices, normals: (V, 3) in the world, metres.  faces: (F, 3).  bones: (V,) that each follows.
    """

    vertices: Array
    normals: Array
    faces: NDArray[np.int64]
    bones: NDArray[np.int64]

    @classmethod
    def of(cls, body: Body, rig: Rig, parts: Sequence[int]) -> Skin:
        """One part at least."""
        places, directions, faces, bones, count = [], [], [], [], 0
        for i in parts:
            T, (vertices, normals, triangles) = rig.Ts_world_part[i], lit_mesh(body.parts[i].shape)
            places.append(flipped(vertices) @ T[:3, :3].T + T[:3, 3])
            directions.append(flipped(normals) @ T[:3, :3].T)
            faces.append(triangles + count)
            bones.append(np.full(len(vertices), rig.bone_of_part[i]))
            count += len(vertices)
        return cls(*(np.concatenate(stack) for stack in (places, directions, faces, bones)))
