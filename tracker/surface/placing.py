"""From the frame and units of the meshes' files to metres in the camera frame."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.settings import Units, UpAxis
from keypose.tracker.surface.mesh import SurfaceMesh

METRES: dict[Units, float] = {
    "m": 1.0,
    "dm": 0.1,
    "cm": 0.01,
    "mm": 0.001,
    "in": 0.0254,
    "ft": 0.3048,
}

# Rows: the camera's x (right), y (down) and z (away) in the file's axes. +y as in glTF, whose front
# faces +z; +z as in Blender, whose front faces −y.
_R_CAMERA_SURFACE: dict[UpAxis, list[list[int]]] = {
    "+y": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
    "-y": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "+z": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
    "-z": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
    "+x": [[0, 0, 1], [-1, 0, 0], [0, -1, 0]],
    "-x": [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
}


@dataclass(frozen=True, eq=False)
class Placement:
    """p_camera = R · metres · p_file + p_camera_surface."""

    units: Units
    up: UpAxis
    p_camera_surface: Array

    @property
    def R_camera_surface(self) -> Array:
        """(3, 3)."""
        return np.array(_R_CAMERA_SURFACE[self.up], dtype=np.float64)

    def points(self, p_surface: Array) -> Array:
        """Points (..., 3) of the files in the camera frame, metres."""
        scaled = METRES[self.units] * np.asarray(p_surface, dtype=np.float64)
        return np.asarray(scaled @ self.R_camera_surface.T + self.p_camera_surface)

    def place(self, mesh: SurfaceMesh) -> SurfaceMesh:
        """A mesh of the files in the camera frame, metres."""
        return replace(mesh, vertices=self.points(mesh.vertices))
