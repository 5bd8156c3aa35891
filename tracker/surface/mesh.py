"""An observed surface: the triangle mesh of one time step, and where meshes come from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array, frozen


@dataclass(frozen=True, eq=False)
class SurfaceMesh:
    """Triangles, counter-clockwise seen from outside; read-only.

    vertices:    (V, 3), metres in the camera frame once placed, before that as in the file.
    faces:       (F, 3) vertex indices.
    consistency: (V,) how well the cameras agree on each vertex, mean ZNCC −1 to 1; −1 where fewer
                 than two see it. None where there are no images.  SURFACE §3.2
    """

    vertices: Array
    faces: NDArray[np.int64]
    consistency: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", frozen(self.vertices))
        faces = np.array(self.faces, dtype=np.int64).reshape(-1, 3)
        faces.setflags(write=False)
        object.__setattr__(self, "faces", faces)
        if self.consistency is not None:
            object.__setattr__(self, "consistency", frozen(self.consistency))

    @cached_property
    def normals(self) -> Array:
        """(V, 3) outward unit normals, faces counting by their area; zero where there is none."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        area = np.cross(b - a, c - a)
        total = np.stack(
            [
                np.bincount(self.faces.ravel(), np.repeat(area[:, k], 3), len(self.vertices))
                for k in range(3)
            ],
            axis=1,
        )
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return frozen(np.divide(total, length, out=np.zeros_like(total), where=length > 0))

    @cached_property
    def extent(self) -> Array:
        """(3,) size of the box around it."""
        return np.asarray(np.ptp(self.vertices, axis=0))

    @cached_property
    def rim(self) -> NDArray[np.int64]:
        """(R, 2) vertices of the edges that have a face on one side only: the rims of holes."""
        ends = np.sort(self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        edges, counts = np.unique(ends[:, 0] * len(self.vertices) + ends[:, 1], return_counts=True)
        return np.stack(np.divmod(edges[counts == 1], len(self.vertices)), axis=1)


class Steps(Protocol):
    """The surfaces of a moving thing, one for each step of time."""

    @property
    def frame_count(self) -> int: ...

    def mesh(self, frame: int) -> SurfaceMesh:
        """The surface of a step in the camera frame, metres.

        SurfaceError in one sentence where that step cannot be used; the others can.
        """
        ...

    def cut_by(self, frame: int) -> tuple[str, ...]:
        """Names of the cameras whose pictures do not hold all of a step's surface."""
        ...
