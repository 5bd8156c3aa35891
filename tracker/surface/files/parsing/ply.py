"""Parse PLY: the mesh of a scanner or a visual hull, with its photo-consistency where it has one.

Nearly always all lists of one column are equally long (triangles): the rows then make one table,
which is read at once. Where they differ, row after row is read. The numbers of a text, wherever its
lines end, are read as if they had been written in binary, each as a double.

Own code: trimesh refuses binary files of mixed polygons, and takes a text cut short for whole.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, BinaryIO, Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.files.parsing.raw import (
    MeshRefused,
    RawMesh,
    fan,
    numbers,
    require_counts,
)

Form: TypeAlias = Literal["text", "<", ">"]

_FORMS: Final[dict[str, Form]] = {
    "ascii": "text",
    "binary_little_endian": "<",
    "binary_big_endian": ">",
}
_TYPES: Final = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
_LONGEST_HEADER: Final = 64 * 1024
_MOST_OTHER_ROWS: Final = 4_000_000
"""Of a file that is read: bytes of its header, and rows of what is neither vertex nor face."""


@dataclass(frozen=True)
class PlyColumn:
    """One property; `counted` is the type of a list's length, None for a single number."""

    name: str
    type: str
    counted: str | None = None


@dataclass(frozen=True)
class Element:
    """So many rows, each with these columns."""

    name: str
    rows: int
    columns: tuple[PlyColumn, ...]

    @property
    def least_bytes(self) -> int:
        """What its rows take at least in a binary file: every list empty."""
        return self.rows * sum(np.dtype(c.counted or c.type).itemsize for c in self.columns)


@dataclass(frozen=True)
class Header:
    """The elements in the order in which they follow."""

    form: Form
    elements: tuple[Element, ...]


def read_header(file: BinaryIO) -> Header:
    """Reads up to where the rows begin. Refused where it is no header, or announces too much."""
    if file.readline(16).strip() != b"ply":
        raise MeshRefused("does not begin as a PLY file does: export it again.")
    form, elements = _statements(_lines(file))
    counts = {element.name: element.rows for element in elements}
    if "tristrips" in counts:
        raise MeshRefused("holds strips of triangles: export it with single faces.")
    require_counts(counts.get("vertex", 0), counts.get("face", 0))
    if sum(counts.values()) - counts["vertex"] - counts["face"] > _MOST_OTHER_ROWS:
        raise MeshRefused("holds much besides vertices and faces: export it with these alone.")
    return Header(form, elements)


def _lines(file: BinaryIO) -> list[list[str]]:
    """The words of every line up to `end_header`."""
    lines: list[list[str]] = []
    left = _LONGEST_HEADER
    while left > 0:
        line = file.readline(left)
        left -= len(line)
        words = line.decode("ascii", "replace").split()
        if words == ["end_header"]:
            return lines
        if not line.endswith(b"\n"):
            break
        lines.append(words)
    raise MeshRefused("has a header without an end: export it again.")


def _statements(lines: list[list[str]]) -> tuple[Form, tuple[Element, ...]]:
    form: Form | None = None
    elements: list[tuple[str, int, list[PlyColumn]]] = []
    for words in lines:
        match words:
            case ["format", name, *_] if name in _FORMS:
                form = _FORMS[name]
            case ["element", name, count] if count.isascii() and count.isdigit():
                elements.append((name, int(count[:18]), []))
            case ["property", "list", counted, type_, name] if elements:
                elements[-1][2].append(PlyColumn(name, _type(type_), _type(counted)))
            case ["property", type_, name] if elements:
                elements[-1][2].append(PlyColumn(name, _type(type_)))
            case [] | ["comment", *_] | ["obj_info", *_]:
                pass
            case _:
                raise MeshRefused("has a header that is not understood: export it again.")
    if form is None:
        raise MeshRefused("does not say how it is written: export it again.")
    return form, tuple(Element(name, rows, tuple(columns)) for name, rows, columns in elements)


def _type(name: str) -> str:
    if name not in _TYPES:
        raise MeshRefused("has numbers of an unknown type: export it again.")
    return _TYPES[name]


Values: TypeAlias = tuple[NDArray[Any], NDArray[np.int64]]
"""Of one column: all its numbers row after row, and how many each row has."""

_DOUBLE: Final = "f8"


class Rows:
    """What is not read yet of the rows that follow a header."""

    def __init__(self, header: Header, content: bytes) -> None:
        self._is_text = header.form == "text"
        self._order = "=" if self._is_text else header.form
        self._content = numbers(content).data.cast("B") if self._is_text else memoryview(content)
        self._at = 0

    def read(self, element: Element) -> dict[str, Values]:
        """The columns of the next element. Refused where the file ends before."""
        if self._is_text:
            element = _as_doubles(element)
        if self._at + element.least_bytes > len(self._content):
            raise _cut_short()
        return self._table(element) or _join_rows(element, self._row_by_row(element))

    def _table(self, element: Element) -> dict[str, Values] | None:
        if element.rows == 0 or not element.columns:
            return _join_rows(element, iter(()))
        start = self._at
        first = next(self._row_by_row(element))
        self._at = start
        fields: list[Any] = []
        for number, (column, values) in enumerate(zip(element.columns, first, strict=True)):
            if column.counted is not None:
                fields.append((f"n{number}", self._order + column.counted))
            fields.append((f"v{number}", self._order + column.type, (len(values),)))
        layout = np.dtype(fields)
        end = start + element.rows * layout.itemsize
        if end > len(self._content):
            return None
        block = np.frombuffer(self._content, layout, element.rows, start)
        for number, (column, values) in enumerate(zip(element.columns, first, strict=True)):
            if column.counted is not None and (block[f"n{number}"] != len(values)).any():
                return None
        self._at = end
        return {c.name: _flatten(block[f"v{number}"]) for number, c in enumerate(element.columns)}

    def _row_by_row(self, element: Element) -> Iterator[list[NDArray[Any]]]:
        for _ in range(element.rows):
            yield [self._next(column) for column in element.columns]

    def _next(self, column: PlyColumn) -> NDArray[Any]:
        length = 1
        if column.counted is not None:
            length = _list_length(float(self._take(column.counted, 1)[0]))
        return self._take(column.type, length)

    def _take(self, type_: str, count: int) -> NDArray[Any]:
        layout = _layout(self._order + type_)
        start = self._at
        self._at += count * layout.itemsize
        if self._at > len(self._content):
            raise _cut_short()
        return np.frombuffer(self._content, layout, count, start)


_layout = cache(np.dtype)  # asked for twice a row


def _cut_short() -> MeshRefused:
    """The refusal of a file that ends before what its header announces."""
    return MeshRefused("is cut short, it ends before its last face: export it again.")


def _as_doubles(element: Element) -> Element:
    """The element with every number, and every list's length, a double."""
    columns = [
        PlyColumn(column.name, _DOUBLE, None if column.counted is None else _DOUBLE)
        for column in element.columns
    ]
    return replace(element, columns=tuple(columns))


def _list_length(length: float) -> int:
    """A list's length."""
    if not 0 <= length <= 1_000_000:  # not a number is neither
        raise MeshRefused("has a list of impossible length: export it again.")
    return int(length)


def _flatten(block: NDArray[Any]) -> Values:
    """The values of a column whose rows are equally long: block (rows, length)."""
    return block.ravel(), np.full(len(block), block.shape[1], dtype=np.int64)


def _join_rows(element: Element, rows: Iterator[list[NDArray[Any]]]) -> dict[str, Values]:
    """The columns of rows that were read one by one."""
    pieces: list[list[NDArray[Any]]] = [[] for _ in element.columns]
    for row in rows:
        for kept, values in zip(pieces, row, strict=True):
            kept.append(values)
    return {
        column.name: (
            np.concatenate(kept) if kept else np.empty(0),
            np.array([len(values) for values in kept], dtype=np.int64),
        )
        for column, kept in zip(element.columns, pieces, strict=True)
    }


CONSISTENCY: Final = ("zncc", "quality")
"""Names of a vertex's photo-consistency. `quality` is MeshLab's."""
_CORNERS: Final = ("vertex_indices", "vertex_index")


def read_ply(file: BinaryIO) -> RawMesh:
    """The mesh of an open PLY file. Refused where it is none, cut short or too large."""
    header = read_header(file)
    rows = Rows(header, file.read())
    columns_of: dict[str, dict[str, Values]] = {}
    elements = {element.name: element for element in header.elements}
    for element in header.elements:
        columns_of[element.name] = rows.read(element)
        if "vertex" in columns_of and "face" in columns_of:
            break
    vertices = _single(columns_of["vertex"], ("x", "y", "z"), elements["vertex"])
    corners, counts = _corners(elements["face"], columns_of["face"])
    agreement = [name for name in CONSISTENCY if _is_single(elements["vertex"], name)]
    return RawMesh(
        np.stack(vertices, axis=1),
        fan(corners.astype(np.int64), counts, len(vertices[0])),
        _single(columns_of["vertex"], agreement[:1], elements["vertex"])[0] if agreement else None,
    )


def _single(
    columns: dict[str, Values], names: tuple[str, ...] | list[str], of: Element
) -> list[Array]:
    """Columns of single numbers."""
    for name in names:
        if not _is_single(of, name):
            raise MeshRefused(f"does not say where its vertices are ({name}): export it again.")
    return [columns[name][0].astype(np.float64) for name in names]


def _is_single(element: Element, name: str) -> bool:
    return any(c.name == name and c.counted is None for c in element.columns)


def _corners(
    element: Element, columns: dict[str, Values]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    lists = [c.name for c in element.columns if c.counted is not None]
    named = [name for name in lists if name in _CORNERS] or lists
    if not named:
        raise MeshRefused("has faces without corners: export it again.")
    return columns[named[0]]
