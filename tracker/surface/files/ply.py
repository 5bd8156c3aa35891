"""Observed surfaces as PLY files, binary, with the photo-consistency of every vertex."""

from __future__ import annotations

import numpy as np

from keypose.tracker.surface.mesh import SurfaceMesh


def ply_bytes(mesh: SurfaceMesh) -> bytes:
    """The file of a mesh, in the mesh's own units; `zncc` is there where it is known."""
    columns = [*mesh.vertices.T]
    names = ["x", "y", "z"]
    if mesh.consistency is not None:
        columns, names = [*columns, mesh.consistency], [*names, "zncc"]
    small = len(mesh.vertices) <= 0xFFFF
    corner = np.dtype("<u2" if small else "<i4")
    faces = np.zeros(len(mesh.faces), [("count", "u1"), ("corners", corner, 3)])
    faces["count"], faces["corners"] = 3, mesh.faces
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(mesh.vertices)}",
        *(f"property float {name}" for name in names),
        f"element face {len(mesh.faces)}",
        f"property list uchar {'ushort' if small else 'int'} vertex_indices",
        "end_header\n",
    ]
    vertices = np.stack(columns, axis=1).astype("<f4")
    return "\n".join(header).encode() + vertices.tobytes() + faces.tobytes()
