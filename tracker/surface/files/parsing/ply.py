"""PLY: the mesh of a scanner or of a visual hull, with its photo-consistency where it has one.

Own code: trimesh refuses binary files of mixed polygons, and takes a text cut short for whole.
"""

from __future__ import annotations

from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.files.parsing.ply_header import Element, read_header
from keypose.tracker.surface.files.parsing.ply_rows import Rows, Values
from keypose.tracker.surface.files.parsing.polygons import fan
from keypose.tracker.surface.files.parsing.raw import RawMesh, Refused

CONSISTENCY: Final = ("zncc", "quality")
"""Names of a vertex's photo-consistency. `quality` is MeshLab's."""
_CORNERS: Final = ("vertex_indices", "vertex_index")


def read_ply(file: BinaryIO) -> RawMesh:
    """The mesh of an open PLY file. Refused where it is none, cut short or too large."""
    header = read_header(file)
    rows = Rows(header, file.read())
    found: dict[str, dict[str, Values]] = {}
    elements = {element.name: element for element in header.elements}
    for element in header.elements:
        found[element.name] = rows.read(element)
        if "vertex" in found and "face" in found:
            break
    vertices = _single(found["vertex"], ("x", "y", "z"), elements["vertex"])
    corners, counts = _corners(elements["face"], found["face"])
    agreement = [name for name in CONSISTENCY if _is_single(elements["vertex"], name)]
    return RawMesh(
        np.stack(vertices, axis=1),
        fan(corners.astype(np.int64), counts, len(vertices[0])),
        _single(found["vertex"], agreement[:1], elements["vertex"])[0] if agreement else None,
    )


def _single(
    found: dict[str, Values], names: tuple[str, ...] | list[str], of: Element
) -> list[Array]:
    """Columns of single numbers."""
    for name in names:
        if not _is_single(of, name):
            raise Refused(f"does not say where its vertices are ({name}): export it again.")
    return [found[name][0].astype(np.float64) for name in names]


def _is_single(element: Element, name: str) -> bool:
    return any(c.name == name and c.counted is None for c in element.columns)


def _corners(
    element: Element, found: dict[str, Values]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    lists = [c.name for c in element.columns if c.counted is not None]
    named = [name for name in lists if name in _CORNERS] or lists
    if not named:
        raise Refused("has faces without corners: export it again.")
    return found[named[0]]
