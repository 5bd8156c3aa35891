"""Refusing a mesh file that cannot be used by its beginning alone.

Little is read, and none of it kept. Whatever is refused here is refused with the same sentence when
the file is read; what is not may still be damaged.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import BinaryIO, Final

import numpy as np

from keypose.tracker.surface.files.parsing.glb import require_whole
from keypose.tracker.surface.files.parsing.obj import require_beginning_of_text
from keypose.tracker.surface.files.parsing.off import require_header
from keypose.tracker.surface.files.parsing.ply_header import Element, read_header
from keypose.tracker.surface.files.parsing.ply_rows import cut_short

_ROWS_LOOKED_AT: Final = 12


def require_good_beginning(file: BinaryIO, kind: str) -> None:
    """Refused where an open file of this kind, such as ".ply", begins as no mesh does, announces
    too much or no faces, or is shorter than what it announces."""
    _DEMANDS[kind](file)


def _require_ply(file: BinaryIO) -> None:
    header = read_header(file)
    if header.form == "text":
        return
    size = os.fstat(file.fileno()).st_size
    names = [element.name for element in header.elements]
    used = max(names.index("vertex"), names.index("face"))
    for element in header.elements[: used + 1]:
        start = file.tell()
        row = _row_bytes(file, element, header.form, size)
        if start + max(element.least_bytes, (row or 0) * element.rows) > size:
            raise cut_short()
        if row is None:
            return
        file.seek(start + row * element.rows)


def _row_bytes(file: BinaryIO, element: Element, order: str, size: int) -> int | None:
    """How long every row is, from here on; None where they are not all as the first one.

    Some rows are looked at, up to the one in which the file ends: where lists differ, those after
    are not where they are looked for.
    """
    start = file.tell()
    first = _row(file, element, order, start)
    if first is None:
        return None
    length = sum(first)
    last = min(element.rows - 1, (size - start) // max(length, 1))
    for number in np.linspace(0, last, _ROWS_LOOKED_AT).astype(int).tolist():
        if _row(file, element, order, start + number * length) not in (None, first):
            return None
    return length


def _row(file: BinaryIO, element: Element, order: str, start: int) -> list[int] | None:
    """The bytes of every column of a row; None where the file ends before they are known."""
    found: list[int] = []
    for column in element.columns:
        if column.counted is None:
            found.append(np.dtype(column.type).itemsize)
            continue
        file.seek(start + sum(found))
        counted = np.dtype(order + column.counted)
        content = file.read(counted.itemsize)
        if len(content) < counted.itemsize:
            return None
        length = max(int(np.frombuffer(content, counted)[0]), 0)
        found.append(counted.itemsize + length * np.dtype(column.type).itemsize)
    return found


_DEMANDS: Final[dict[str, Callable[[BinaryIO], None]]] = {
    ".ply": _require_ply,
    ".obj": require_beginning_of_text,
    ".off": require_header,
    ".glb": require_whole,
}
