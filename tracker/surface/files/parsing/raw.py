"""What a parser returns, and how it refuses a file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

MOST_FACES: Final = 2_000_000
MOST_VERTICES: Final = 1_000_000


class Refused(Exception):
    """Why a mesh cannot be used: the end of a sentence whose subject is the file's name."""


@dataclass(frozen=True, eq=False)
class RawMesh:
    """Triangles as a file states them, nothing checked yet.

    vertices: (V, 3), faces: (F, 3) vertex indices, consistency: (V,) mean ZNCC or None.
    """

    vertices: Array
    faces: NDArray[np.int64]
    consistency: Array | None = None


def require_counts(vertices: int, faces: int) -> None:
    """Refused where a file announces more than is read, or no surface at all."""
    if faces > MOST_FACES:
        raise Refused(f"has {faces:,} faces: simplify it to {MOST_FACES:,} at most.")
    if vertices > MOST_VERTICES:
        raise Refused(f"has {vertices:,} vertices: simplify it to {MOST_VERTICES:,} at most.")
    if vertices <= 0:
        raise Refused("holds no vertices: export it again.")
    if faces <= 0:
        raise Refused("holds no faces, only points: make a mesh of them first.")
