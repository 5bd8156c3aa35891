"""Meshes that took long to make, in one file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from keypose.tracker.surface.mesh import SurfaceMesh


def keep_meshes(place: Path, meshes: Sequence[SurfaceMesh]) -> None:
    """All in one archive, there as a whole or not at all."""
    arrays = {}
    for i, mesh in enumerate(meshes):
        arrays[f"vertices_{i:05d}"] = mesh.vertices
        arrays[f"faces_{i:05d}"] = mesh.faces.astype(np.int32)
        if mesh.consistency is not None:
            arrays[f"consistency_{i:05d}"] = mesh.consistency.astype(np.float32)
    part = place.with_name(f".{os.getpid()}-{place.name}")
    np.savez(part, **arrays)
    part.replace(place)


def kept_meshes(place: Path) -> list[SurfaceMesh]:
    """The meshes of such a file."""
    with np.load(place) as kept:
        count = sum(name.startswith("vertices") for name in kept.files)
        return [
            SurfaceMesh(
                kept[f"vertices_{i:05d}"],
                kept[f"faces_{i:05d}"],
                kept[f"consistency_{i:05d}"] if f"consistency_{i:05d}" in kept.files else None,
            )
            for i in range(count)
        ]
