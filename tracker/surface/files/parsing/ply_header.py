"""The header of a PLY file: what rows of what columns follow, and how they are written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import BinaryIO, Final, Literal, TypeAlias

import numpy as np

from keypose.tracker.surface.files.parsing.raw import Refused, require_counts

Form: TypeAlias = Literal["text", "<", ">"]

_FORMS: Final[dict[str, Form]] = {
    "ascii": "text",
    "binary_little_endian": "<",
    "binary_big_endian": ">",
}
_TYPES: Final = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "int64": "i8", "uint64": "u8",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_LONGEST_HEADER: Final = 64 * 1024
_MOST_OTHER_ROWS: Final = 4_000_000


@dataclass(frozen=True)
class Column:
    """One property; `counted` is the type of a list's length, None for a single number."""

    name: str
    type: str
    counted: str | None = None


@dataclass(frozen=True)
class Element:
    """So many rows, each with these columns."""

    name: str
    rows: int
    columns: tuple[Column, ...]

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
        raise Refused("does not begin as a PLY file does: export it again.")
    form, elements = _statements(_lines(file))
    counts = {element.name: element.rows for element in elements}
    if "tristrips" in counts:
        raise Refused("holds strips of triangles: export it with single faces.")
    require_counts(counts.get("vertex", 0), counts.get("face", 0))
    if sum(counts.values()) - counts["vertex"] - counts["face"] > _MOST_OTHER_ROWS:
        raise Refused("holds much besides vertices and faces: export it with these alone.")
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
    raise Refused("has a header without an end: export it again.")


def _statements(lines: list[list[str]]) -> tuple[Form, tuple[Element, ...]]:
    form: Form | None = None
    elements: list[tuple[str, int, list[Column]]] = []
    for words in lines:
        match words:
            case ["format", name, *_] if name in _FORMS:
                form = _FORMS[name]
            case ["element", name, count] if count.isascii() and count.isdigit():
                elements.append((name, int(count[:18]), []))
            case ["property", "list", counted, type_, name] if elements:
                elements[-1][2].append(Column(name, _type(type_), _type(counted)))
            case ["property", type_, name] if elements:
                elements[-1][2].append(Column(name, _type(type_)))
            case [] | ["comment", *_] | ["obj_info", *_]:
                pass
            case _:
                raise Refused("has a header that is not understood: export it again.")
    if form is None:
        raise Refused("does not say how it is written: export it again.")
    return form, tuple(Element(name, rows, tuple(columns)) for name, rows, columns in elements)


def _type(name: str) -> str:
    if name not in _TYPES:
        raise Refused("has numbers of an unknown type: export it again.")
    return _TYPES[name]
