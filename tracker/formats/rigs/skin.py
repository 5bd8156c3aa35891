"""Make the skin of a rig from the body's solids: at rest, a vertex hangs on its part's bone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.shapes import Shape
from keypose.tracker.formats.conventions import flipped
from keypose.tracker.formats.rigs.rig import Rig
from keypose.tracker.geometry.rotations import Array

CREASE_COS = np.cos(np.deg2rad(40.0))
"""Faces that meet at a larger angle meet in an edge; those of a round side meet at 15 degrees."""


def lit_mesh(shape: Shape) -> tuple[Array, Array, NDArray[np.int64]]:
    """Vertices (V, 3) in the part's frame, metres; their unit normals (V, 3); faces (F, 3).

    A corner's normal is the mean over the faces that meet there without an edge, by their angles,
    so that it does not matter how a side is cut into triangles.
    """
    mesh = shape.mesh()
    corners = mesh.vertices[mesh.faces]
    onward = _unit(np.roll(corners, -1, axis=1) - corners)
    back = _unit(np.roll(corners, 1, axis=1) - corners)
    directions = _unit(np.cross(onward[:, 0], back[:, 0]))
    angles = np.arccos(np.clip((onward * back).sum(axis=-1), -1.0, 1.0))
    smooth = directions @ directions.T > CREASE_COS
    same = mesh.faces[:, :, None, None] == mesh.faces
    weights = (same * angles).sum(axis=-1) * smooth[:, None]
    normals = _unit(weights @ directions)
    lit_corners = np.concatenate([corners, normals], axis=-1).reshape(-1, 6)
    rounded = lit_corners.round(9) + 0.0  # so that −0 is 0
    different, index = np.unique(rounded, axis=0, return_inverse=True)
    return different[:, :3], different[:, 3:], index.reshape(-1, 3).astype(np.int64)


def _unit(vectors: Array) -> Array:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(lengths, 1e-300))  # a needle's end has no direction


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
        """The skin of these parts of a body, one at least."""
        places, directions, faces, bones, count = [], [], [], [], 0
        for i in parts:
            T, (vertices, normals, triangles) = rig.Ts_world_part[i], lit_mesh(body.parts[i].shape)
            places.append(flipped(vertices) @ T[:3, :3].T + T[:3, 3])
            directions.append(flipped(normals) @ T[:3, :3].T)
            faces.append(triangles + count)
            bones.append(np.full(len(vertices), rig.bone_of_part[i]))
            count += len(vertices)
        return cls(*(np.concatenate(stack) for stack in (places, directions, faces, bones)))
