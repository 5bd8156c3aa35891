"""Keypoints as DeepLabCut writes them: a table under a head of several rows, as CSV or in HDF5.

The rows of the head are `scorer`, with several animals `individuals`, then `bodyparts` and
`coords`: x, y and, but for what a person labelled, likelihood. A row of the table is a frame by its
number, or a labelled picture by its name.
HDF5 is what pandas writes there, in its `table` layout or its `fixed` one.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from keypose.tracker.errors import FormatError, listed
from keypose.tracker.formats.hdf5 import Group
from keypose.tracker.formats.people import People, chosen_individual, frame_numbers, person_numbers
from keypose.tracker.formats.reading_csv import number
from keypose.tracker.geometry.rotations import Array

HEAD: Final = ("scorer", "individuals", "bodyparts", "coords")
COORDS: Final = ("x", "y", "likelihood")
SINGLE: Final = "single"
"""DeepLabCut's name for keypoints that belong to no animal."""


class TableColumn(NamedTuple):
    """What the head says of a column."""

    scorer: str
    individual: str
    bodypart: str
    coord: str


class Table(NamedTuple):
    """C columns of N rows; values (N, C), NaN where empty; frames names the rows."""

    columns: list[TableColumn]
    frames: list[str]
    values: Array


# --- CSV


def is_table(heads: list[str]) -> bool:
    """Whether the first row of a CSV is that of DeepLabCut."""
    return heads[0].strip() == "scorer"


def read_table(file: str, rows: list[list[str]], individual: str | None) -> People:
    """One animal of a CSV; FormatError in one sentence."""
    head = {row[0].strip(): row for row in rows[:4] if row[0].strip() in HEAD}
    body = rows[len(head) :]
    _require_head(file, list(head))
    width = len(rows[0])
    short = next((n for n, row in enumerate(rows) if len(row) != width), None)
    if short is not None:
        raise FormatError(
            f"{file}: row {short + 1} has {len(rows[short])} columns where {width} are due."
        )
    first = next((i for i in range(1, width) if rows[0][i].strip()), width)
    levels = [[cell.strip() for cell in head[name][first:]] for name in HEAD if name in head]
    values = np.array([[number(file, cell) for cell in row[first:]] for row in body])
    values = values.reshape(len(body), width - first)
    index = [next((c for c in reversed(row[:first]) if c.strip()), "") for row in body]
    columns = _columns(file, list(zip(*levels, strict=True)))
    return _people(file, Table(columns, index, values), individual)


def _require_head(file: str, head: list[str]) -> None:
    missing = [name for name in HEAD if name not in head and name != "individuals"]
    if missing:
        raise FormatError(f"{file} has no row {missing[0]!r} in its head, as DeepLabCut writes it.")


# --- HDF5


def table_name(root: Group) -> str | None:
    """The name of the table that pandas wrote, where there is one."""
    for name in root.names:
        group = root.group(name)
        if group is not None and group.text("pandas_type").startswith("frame"):
            return name
    return None


def read_hdf(root: Group, individual: str | None) -> People:
    """One animal of a file with a table that pandas wrote; FormatError in one sentence."""
    name = table_name(root)
    group = root.group(name) if name is not None else None
    if group is None:
        raise FormatError(f"{root.file} holds no table of keypoints.")
    table = _table_layout(group) if group.has("table") else _fixed_layout(group)
    return _people(root.file, table, individual)


def _table_layout(group: Group) -> Table:
    file, rows = group.file, group.values("table")
    if set(rows.dtype.names or ()) != {"index", "values_block_0"}:
        raise FormatError(f"{file} holds columns of several kinds: use DeepLabCut's CSV.")
    names = group.dataset_literal("table", "values_block_0_kind")
    values = np.asarray(rows["values_block_0"], dtype=np.float64).reshape(len(rows), -1)
    return Table(_columns(file, names), [_word(label) for label in rows["index"].tolist()], values)


def _fixed_layout(group: Group) -> Table:
    file = group.file
    if not group.has("block0_values") or group.has("block1_values"):
        raise FormatError(f"{file} holds columns of several kinds: use DeepLabCut's CSV.")
    names = list(zip(*_levels(group, "block0_items"), strict=True))
    values = group.numbers("block0_values")
    if values.ndim == 2 and values.shape[0] == len(names) != values.shape[1]:
        values = values.T
    index = _levels(group, "axis1")[-1]
    return Table(_columns(file, names), [_word(label) for label in index], values)


def _levels(group: Group, name: str) -> list[list[object]]:
    """The values of an index, level by level: of one level plainly, else by their codes."""
    if group.has(name):
        return [group.values(name).ravel().tolist()]
    count = next(i for i in range(9) if not group.has(f"{name}_level{i}"))
    if not count:
        raise FormatError(f"{group.file} does not name its columns or rows: use its CSV.")
    out = []
    for i in range(count):
        words = group.values(f"{name}_level{i}").ravel()
        codes = group.values(f"{name}_label{i}").ravel()
        has_words = codes.dtype.kind in "iu" and ((codes >= 0) & (codes < len(words))).all()
        if not has_words:
            raise FormatError(f"{group.file} does not name its columns or rows: use its CSV.")
        out.append(words[codes].tolist())
    return out


def _word(value: object) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


# --- of either


def _columns(file: str, names: object) -> list[TableColumn]:
    """Columns by their levels, scorer, individuals where there are any, bodyparts, coords."""
    columns = []
    for levels in names if isinstance(names, list) else []:
        words = [_word(level) for level in levels] if isinstance(levels, tuple) else []
        if len(words) not in (3, 4):
            raise FormatError(f"{file} has a column that no scorer, bodypart and coord name.")
        columns.append(
            TableColumn(words[0], words[1] if len(words) == 4 else "", words[-2], words[-1])
        )
    return columns


def _people(file: str, table: Table, individual: str | None) -> People:
    columns, index, values = table
    _require_table(file, table)
    scorers = list(dict.fromkeys(column.scorer for column in columns))
    if len(scorers) > 1:
        raise FormatError(f"{file} has keypoints of several scorers, {listed(scorers[:6])}.")
    individuals = list(dict.fromkeys(column.individual for column in columns))
    animals = [animal for animal in individuals if animal != SINGLE] or individuals
    chosen = chosen_individual(file, animals if individual != SINGLE else individuals, individual)
    mine = {(c.bodypart, c.coord): i for i, c in enumerate(columns) if c.individual == chosen}
    names = tuple(dict.fromkeys(bodypart for bodypart, _ in mine))
    for name in names:
        if (name, "x") not in mine or (name, "y") not in mine:
            raise FormatError(f"{file} has the bodypart {name!r} without x and y.")
    uv = np.stack([values[:, mine[name, axis]] for name in names for axis in "xy"], axis=1)
    likelihoods, nothing = (
        [mine.get((name, "likelihood")) for name in names],
        np.full(len(values), np.nan),
    )
    sure = [nothing if i is None else values[:, i] for i in likelihoods]
    rows = person_numbers(file, uv.reshape(len(values), -1, 2), np.stack(sure, axis=1))
    return People(_by_frame(file, index, rows), names, program="DeepLabCut")


def _require_table(file: str, table: Table) -> None:
    columns, index, values = table
    if not columns or not index:
        raise FormatError(f"{file} holds no {'bodypart' if not columns else 'frame'}.")
    if values.shape != (len(index), len(columns)):
        raise FormatError(
            f"{file} has {' × '.join(map(str, values.shape))} numbers for {len(index)} frames of "
            f"{len(columns)} columns."
        )
    if len(set(columns)) < len(columns):
        raise FormatError(f"{file} has a column twice.")
    if any(column.coord == "z" for column in columns):
        raise FormatError(
            f"{file} has coordinates in space: export the keypoints of one camera, in its picture."
        )
    unexpected = sorted({column.coord for column in columns} - set(COORDS))
    if unexpected:
        raise FormatError(
            f"{file} has the coord {unexpected[0]!r}; x, y and likelihood are expected."
        )


def _by_frame(
    file: str, index: Sequence[str], rows: list[list[float]]
) -> dict[int, list[list[float]]]:
    row_of_frame: dict[int, list[list[float]]] = {}
    numbers = frame_numbers(index)
    for word, row in zip(index, rows, strict=True):
        if not re.search(r"\d", word) or word.strip().startswith("-"):
            raise FormatError(f"{file} has a row {word[:40]!r} that names no frame.")
        frame = numbers[word]
        if frame in row_of_frame:
            raise FormatError(
                f"{file} has frame {frame} twice; it may hold pictures of several videos."
            )
        row_of_frame[frame] = [row]
    return row_of_frame
