"""OFF: counts, vertices, faces, as text.

Own code: trimesh takes a file cut short for whole, and four times as long.
"""

from __future__ import annotations

from typing import BinaryIO, Final

import numpy as np

from keypose.tracker.surface.files.parsing.ply_rows import cut_short
from keypose.tracker.surface.files.parsing.polygons import fan, runs
from keypose.tracker.surface.files.parsing.raw import RawMesh, Refused, require_counts
from keypose.tracker.surface.files.parsing.text import numbers, table

_HEADERS: Final = (b"OFF", b"COFF", b"NOFF", b"CNOFF", b"STOFF", b"STCOFF", b"STNOFF")
_BEGINNING: Final = 64 * 1024


def read_off(file: BinaryIO) -> RawMesh:
    """The mesh of an open OFF file. Refused where it is none, cut short or too large."""
    require_header(file)
    file.seek(0)
    lines = _lines(file.read())
    vertex_count, face_count, rest = _counts(lines)
    if len(rest) < vertex_count + face_count:
        raise cut_short()
    vertices = table(rest[:vertex_count], 3)[:, :3]
    # No number of a face is −1: it may stand between the faces, so that all are read at once.
    values = numbers(b" -1 ".join([b"", *rest[vertex_count : vertex_count + face_count]]))
    starts = np.flatnonzero(values == -1)
    if len(starts) != face_count:
        raise Refused("has a face with a negative corner: export it again.")
    space = np.diff(np.append(starts, len(values))) - 2
    if (space < 0).any() or not (values[starts + 1] <= space).all():
        raise cut_short()
    if not (np.isfinite(values).all() and (values[starts + 1] >= 0).all()):
        raise Refused("has a face with an impossible corner: export it again.")
    counts = values[starts + 1].astype(np.int64)
    return RawMesh(vertices, fan(runs(values, starts + 2, counts), counts, vertex_count))


def require_header(file: BinaryIO) -> None:
    """Refused where the file does not begin as such a file does, or announces too much."""
    _counts(_lines(file.read(_BEGINNING)))


def _lines(content: bytes) -> list[bytes]:
    """The lines that say something."""
    lines = (line.partition(b"#")[0].strip() for line in content.splitlines())
    return [line for line in lines if line]


def _counts(lines: list[bytes]) -> tuple[int, int, list[bytes]]:
    """How many vertices and faces are announced, and the lines behind that."""
    header, *same_line = lines[0].split() if lines else [b""]
    if header not in _HEADERS:
        raise Refused("does not begin as an OFF file does: export it again.")
    if same_line and same_line[0].upper() == b"BINARY":
        raise Refused("is a binary OFF file: save it as text, or as PLY.")
    words = same_line or (lines[1].split() if len(lines) > 1 else [])
    if len(words) < 2 or not all(word.isdigit() for word in words[:2]):
        raise Refused("does not say how many vertices and faces it has: export it again.")
    vertices, faces = (int(word[:18]) for word in words[:2])
    require_counts(vertices, faces)
    return vertices, faces, lines[1 if same_line else 2 :]
