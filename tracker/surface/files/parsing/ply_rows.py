"""The rows of a PLY file, written as text or as binary numbers.

Nearly always all lists of one column are equally long (triangles): the rows then make one table,
which is read at once. Where they differ, row after row is read. The numbers of a text, wherever its
lines end, are read as if they had been written in binary, each as a double.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.surface.files.parsing.ply_header import Column, Element, Header
from keypose.tracker.surface.files.parsing.raw import Refused
from keypose.tracker.surface.files.parsing.text import numbers

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

    def _next(self, column: Column) -> NDArray[Any]:
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


def _cut_short() -> Refused:
    """The refusal of a file that ends before what its header announces."""
    return Refused("is cut short, it ends before its last face: export it again.")


def _as_doubles(element: Element) -> Element:
    """The element with every number, and every list's length, a double."""
    columns = [
        Column(column.name, _DOUBLE, None if column.counted is None else _DOUBLE)
        for column in element.columns
    ]
    return replace(element, columns=tuple(columns))


def _list_length(length: float) -> int:
    """A list's length."""
    if not 0 <= length <= 1_000_000:  # not a number is neither
        raise Refused("has a list of impossible length: export it again.")
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
