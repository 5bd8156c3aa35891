"""Points spread evenly over a mesh: what the fit pairs, however coarse or uneven the triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array, frozen
from keypose.tracker.surface.mesh import SurfaceMesh

_GOLDEN = np.array([0.7548776662466927, 0.5698402909980532])
"""Multiples of these fill a square evenly, whatever their number."""

LARGE_FACE = 3.0
"""A face longer than so many spacings is flat by intent: its own normal is the surface's."""


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """N points of a mesh, as many on every square centimetre; read-only.

    p, normals:  (N, 3) metres and unit vectors, in the mesh's frame.
    consistency: (N,) agreement of the cameras, −1 to 1; 1 where there are no images.
    face:        (N,) of the mesh that each lies on.
    spacing_m:   between neighbours, about.
    """

    p: Array
    normals: Array
    consistency: Array
    face: NDArray[np.int64]
    spacing_m: float

    @classmethod
    def of(cls, mesh: SurfaceMesh, count: int) -> SurfaceSamples:
        """`count` points, the same ones for the same mesh."""
        corners = mesh.vertices[mesh.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        doubled = np.linalg.norm(normals, axis=1)
        upto = np.cumsum(doubled)
        spacing = float(np.sqrt(upto[-1] / 2 / count))
        face = np.searchsorted(upto, (np.arange(count) + 0.5) * (upto[-1] / count))
        shares = _shares(count)
        consistency = np.ones(count)
        if mesh.consistency is not None:
            consistency = np.einsum("nk,nk->n", shares, mesh.consistency[mesh.faces[face]])
        return cls(
            frozen(np.einsum("nk,nki->ni", shares, corners[face])),
            frozen(_normals(mesh, face, shares, normals, spacing)),
            frozen(consistency),
            face,
            spacing,
        )

    def select(self, which: NDArray[np.bool_]) -> SurfaceSamples:
        """Some of them."""
        return SurfaceSamples(
            frozen(self.p[which]),
            frozen(self.normals[which]),
            frozen(self.consistency[which]),
            self.face[which],
            self.spacing_m,
        )


def _shares(count: int) -> Array:
    """(N, 3) of a face's corners, spread evenly over the triangle."""
    a, b = ((np.arange(1, count + 1)[:, None] * _GOLDEN) % 1.0).T
    folded = a + b > 1
    a, b = np.where(folded, 1 - a, a), np.where(folded, 1 - b, b)
    return np.stack([1 - a - b, a, b], axis=1)


def _normals(
    mesh: SurfaceMesh, face: NDArray[np.int64], shares: Array, of_faces: Array, spacing: float
) -> Array:
    """Take the normals of the corners, which even out noise; on large faces the face's own."""
    smooth = np.einsum("nk,nki->ni", shares, mesh.normals[mesh.faces[face]])
    corners = mesh.vertices[mesh.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    flat = longest[face] > LARGE_FACE * spacing
    normals = np.where(flat[:, None], of_faces[face], smooth)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.divide(normals, length, out=np.zeros_like(normals), where=length > 0))
