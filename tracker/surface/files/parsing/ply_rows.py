"""The rows of a PLY file, written as text or as binary numbers.

Nearly always all lists of one column are equally long (triangles): the rows then make one table,
which is read at once. Where they differ, row after row is read.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tracker.geometry.rotations import Array
from tracker.surface.files.parsing.ply_header import Column, Element, Header
from tracker.surface.files.parsing.raw import Refused
from tracker.surface.files.parsing.text import numbers

Values: TypeAlias = tuple[NDArray[Any], NDArray[np.int64]]
"""Of one column: all its numbers row after row, and how many each row has."""


class Rows(Protocol):
    """What is not read yet of a file's rows."""

    def read(self, element: Element) -> dict[str, Values]:
        """The columns of the next element. Refused where the file ends before."""


def rows_of(header: Header, content: bytes) -> Rows:
    """The rows that follow the header."""
    if header.form == "text":
        return TextRows(numbers(content))
    return BinaryRows(content, header.form)


class TextRows:
    """Rows of numbers one after the other, wherever lines end."""

    def __init__(self, values: Array) -> None:
        self._values = values
        self._at = 0

    def read(self, element: Element) -> dict[str, Values]:
        return self._table(element) or _joined(element, self._row_by_row(element))

    def _table(self, element: Element) -> dict[str, Values] | None:
        if element.rows == 0:
            return _joined(element, iter(()))
        lengths = self._lengths(element)
        width = sum(lengths) + sum(c.counted is not None for c in element.columns)
        end = self._at + width * element.rows
        if width == 0 or end > len(self._values):
            return None
        block = self._values[self._at : end].reshape(element.rows, width)
        found, at = {}, 0
        for column, length in zip(element.columns, lengths, strict=True):
            if column.counted is not None:
                if (block[:, at] != length).any():
                    return None
                at += 1
            found[column.name] = _equal(block[:, at : at + length])
            at += length
        self._at = end
        return found

    def _lengths(self, element: Element) -> list[int]:
        """How many numbers each column has in the next row."""
        lengths, at = [], self._at
        for column in element.columns:
            lengths.append(1 if column.counted is None else _whole(self._values, at))
            at += lengths[-1] + (column.counted is not None)
        return lengths

    def _row_by_row(self, element: Element) -> Iterator[list[NDArray[Any]]]:
        for _ in range(element.rows):
            row = []
            for column in element.columns:
                length = 1
                if column.counted is not None:
                    length = _whole(self._values, self._at)
                    self._at += 1
                row.append(self._values[self._at : self._at + length])
                self._at += length
            if self._at > len(self._values):
                raise cut_short()
            yield row


class BinaryRows:
    """Rows of packed numbers."""

    def __init__(self, content: bytes, order: str) -> None:
        self._content = content
        self._order = order
        self._at = 0

    def read(self, element: Element) -> dict[str, Values]:
        if self._at + element.least_bytes > len(self._content):
            raise cut_short()
        return self._table(element) or _joined(element, self._row_by_row(element))

    def _table(self, element: Element) -> dict[str, Values] | None:
        if element.rows == 0:
            return _joined(element, iter(()))
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
        return {c.name: _equal(block[f"v{number}"]) for number, c in enumerate(element.columns)}

    def _row_by_row(self, element: Element) -> Iterator[list[NDArray[Any]]]:
        for _ in range(element.rows):
            yield [self._next(column) for column in element.columns]

    def _next(self, column: Column) -> NDArray[Any]:
        length = 1
        if column.counted is not None:
            length = _whole(self._take(column.counted, 1), 0)
        return self._take(column.type, length)

    def _take(self, type_: str, count: int) -> NDArray[Any]:
        layout = np.dtype(self._order + type_)
        start = self._at
        self._at += count * layout.itemsize
        if self._at > len(self._content):
            raise cut_short()
        return np.frombuffer(self._content, layout, count, start)


def cut_short() -> Refused:
    """The refusal of a file that ends before what its header announces."""
    return Refused("is cut short, it ends before its last face: export it again.")


def _whole(values: NDArray[Any], at: int) -> int:
    """A list's length."""
    if at >= len(values):
        raise cut_short()
    length = float(values[at])
    if not 0 <= length <= 1_000_000:  # not a number is neither
        raise Refused("has a list of impossible length: export it again.")
    return int(length)


def _equal(block: NDArray[Any]) -> Values:
    """The values of a column whose rows are equally long: block (rows, length)."""
    return block.ravel(), np.full(len(block), block.shape[1], dtype=np.int64)


def _joined(element: Element, rows: Iterator[list[NDArray[Any]]]) -> dict[str, Values]:
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
