"""OBJ: only vertices and faces are read. Materials, in other files, are never looked for.

Own code: trimesh counts negative corners from the end, takes 0 for 1, and sorts faces by material.
"""

from __future__ import annotations

import re
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.surface.files.parsing.raw import (
    MeshRefused,
    RawMesh,
    fan,
    numbers,
    require_counts,
    runs,
    table,
)

_VERTEX_OR_FACE = re.compile(rb"^[ \t]*([vf][ \t][^\n]*)", re.MULTILINE)
_BEGINNING = 64 * 1024
_PIECE = 16 * 2**20
"""Bytes in which a zero says that this is no text, and those read at a time."""


def read_obj(file: BinaryIO) -> RawMesh:
    """The mesh of an open OBJ file. Refused where it is none or too large."""
    _require_text(file)
    content = file.read().replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").replace(b"\r", b"\n")
    lines = _VERTEX_OR_FACE.findall(content)
    del content
    is_face = np.array([line.startswith(b"f") for line in lines], dtype=bool)
    is_vertex = ~is_face
    require_counts(int(is_vertex.sum()), int(is_face.sum()))
    vertices = table(_arguments(lines, is_vertex), 3)[:, :3]
    corners, counts, face = _corners(_arguments(lines, is_face))
    before = np.cumsum(is_vertex)[is_face][face]
    # Written from 1; a negative number counts back from the vertices above the face.
    corners = np.where(corners > 0, corners - 1, before + corners)
    return RawMesh(vertices, fan(corners, counts, len(vertices)))


def _require_text(file: BinaryIO) -> None:
    """Refused where the file is no text, or has too many faces: before anything is kept of it."""
    if b"\0" in file.read(_BEGINNING):
        raise MeshRefused("is no text as an OBJ file is: export it again.")
    file.seek(0)
    vertices = faces = 0
    last = b"\n"
    while piece := file.read(_PIECE):
        joined = last + piece
        vertices += joined.count(b"\nv ")
        faces += joined.count(b"\nf ")
        last = joined[-2:]
    require_counts(max(vertices, 1), max(faces, 1))
    file.seek(0)


def _arguments(lines: list[bytes], which: NDArray[np.bool_]) -> list[bytes]:
    """What follows the letter on these lines, without comments."""
    return [lines[k][1:].partition(b"#")[0] for k in np.flatnonzero(which)]


def _corners(
    lines: list[bytes],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """List the corners of all faces as written, how many each has, and the face of every corner."""
    # What stands behind a corner's slash is about texture and normals. 0 numbers no vertex: it may
    # stand between the faces, so that all are read at once.
    text = re.sub(rb"/\S*", b"", b" 0 ".join([b"", *lines]))
    values = numbers(text)
    starts = np.flatnonzero(values == 0)
    if len(starts) != len(lines):
        raise MeshRefused("has a face with a corner numbered 0: export it again.")
    if not (np.isfinite(values).all() and (np.abs(values) < 2**53).all()):
        raise MeshRefused("has a face with an impossible corner: export it again.")
    counts = np.diff(np.append(starts, len(values))) - 1
    corners = runs(values, starts + 1, counts)
    return corners, counts, np.repeat(np.arange(len(lines)), counts)
