"""From triangles as a file states them to a surface: whole, finite, every place a vertex once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.files.parsing.raw import MeshRefused, RawMesh

FARTHEST = 1e9
SMALLEST = 1e-9
"""In units of the file. Beyond them there is no sensible surface, and squares lose their sense."""
LEAST_AREA = 1e-9
"""Of the square of its longest side: less is a line."""


def tidy(raw: RawMesh) -> RawMesh:
    """The same surface without degenerate faces. Refused where nothing is left, or it is nonsense.

    Vertices at one place become one: files split them at the seams of a texture, which are no
    holes. Faces that then have no three corners go, and vertices of no face; both keep their order.
    Thin faces stay, for without them there would be holes.
    """
    require_range(raw.faces, len(raw.vertices))
    raw = _drop_unused(raw)
    _require_sense(raw.vertices)
    merged = _drop_unused(_merge(raw, _same_rows(raw.vertices)))
    return _require_surface(replace(merged, consistency=_as_zncc(merged.consistency)))


def require_range(faces: NDArray[np.int64], vertices: int) -> None:
    """Refused where a face names a vertex that is not there."""
    if len(faces) and (faces.min() < 0 or faces.max() >= vertices):
        raise MeshRefused("has faces whose corners are not among its vertices: export it again.")


def _require_surface(mesh: RawMesh) -> RawMesh:
    """The mesh. Refused where its vertices are nonsense, or its faces have no extent."""
    _require_sense(mesh.vertices)
    longest = float(np.ptp(mesh.vertices, axis=0).max()) if len(mesh.faces) else 0.0
    if longest < SMALLEST:
        raise MeshRefused("has no face that is larger than a point: export it again.")
    if _area(mesh) < LEAST_AREA * longest**2:
        raise MeshRefused("has no face that is wider than a line: export it again.")
    return mesh


def _area(mesh: RawMesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def _same_rows(table: Array) -> NDArray[np.int64]:
    """(V,) of every row the first one that equals it."""
    table = table + 0.0  # so that −0 is 0
    order = np.lexsort(table.T)
    new = np.ones(len(table), dtype=bool)
    new[1:] = (np.diff(table[order], axis=0) != 0).any(axis=1)
    # lexsort is stable: the first row of every run of equal ones is also the first in the table.
    first = np.empty(len(table), dtype=np.int64)
    first[order] = order[new][np.cumsum(new) - 1]
    return first


def _merge(raw: RawMesh, into: NDArray[np.int64]) -> RawMesh:
    """The mesh with every vertex replaced by another, without faces that have two equal corners.

    into (V,): by vertex the one in its place.
    """
    faces = into[raw.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    consistency = raw.consistency
    if consistency is not None:
        # Of one place under several numbers the mean; −1 where nothing is left.
        count = np.bincount(into, minlength=len(into))
        total = np.bincount(into, consistency, minlength=len(into))
        consistency = np.divide(total, count, out=np.full(len(into), -1.0), where=count > 0)
    return RawMesh(raw.vertices, faces, consistency)


def _drop_unused(raw: RawMesh) -> RawMesh:
    """Without the vertices that no face has."""
    used = np.zeros(len(raw.vertices), dtype=bool)
    used[raw.faces] = True
    number = np.cumsum(used) - 1
    consistency = raw.consistency
    return RawMesh(
        raw.vertices[used],
        number[raw.faces],
        None if consistency is None else consistency[used],
    )


def _require_sense(vertices: Array) -> None:
    if not np.isfinite(vertices).all():
        raise MeshRefused("has vertices that are not finite numbers: export it again.")
    if (np.abs(vertices) > FARTHEST).any():
        raise MeshRefused(f"has vertices farther than {FARTHEST:,.0f} units away: export it again.")


def _as_zncc(consistency: Array | None) -> Array | None:
    """Within −1 to 1; what is no number is what no two cameras see."""
    if consistency is None:
        return None
    return np.clip(np.where(np.isnan(consistency), -1.0, consistency), -1.0, 1.0)
