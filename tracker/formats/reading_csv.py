"""Read tables of joint positions: our own joints.csv, and plain wide tables.

The first line names the columns: a time (`time_s`, `time` or `t`, seconds), a `frame` if one
likes, and `<joint>_x`, `<joint>_y`, `<joint>_z` for every joint, with the unit behind when it is
known, as in `left_hand_x_m`. Without a time a row is a frame of the video, numbered by `fnum` or
`frame` where there is one. A table with `frame`, `time_s` and units is our own: it lies in the
camera frame, and what it repeats in the world of files is left out. Any other is taken to be y up.
An empty place is a joint that was not seen. Columns are parted by commas, semicolons or tabs;
numbers may have a decimal comma.
"""

from __future__ import annotations

import csv
import io
import re

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.csv import IN_WORLD
from keypose.tracker.formats.joint_motion import MOST_FRAMES, JointMotion, Unit, World, require_size
from keypose.tracker.formats.text import decoded

_COLUMN = re.compile(r"(?P<name>.+)[_ .](?P<axis>[xyzXYZ])(?:_(?P<unit>m|cm|mm))?")
_TIMES = {
    "times": 1.0,
    "time": 1.0,
    "t": 1.0,
    "timesec": 1.0,
    "timeseconds": 1.0,
    "seconds": 1.0,
    "timems": 1e-3,
    "tms": 1e-3,
}
"""Seconds in a column's unit by its name's letters: `time_s`, `Time [s]`, `time (ms)`."""
_FRAMES = ("fnum", "frame", "framenumber")


def read_csv(file: str, content: bytes) -> JointMotion:
    """The motion in a table; FormatError in one sentence."""
    rows = rows_of(file, decoded(content))
    heads = [head.strip() for head in rows[0]]
    while len(heads) > 1 and not heads[-1]:  # spreadsheets end every row with a separator
        heads.pop()
    letters = [re.sub(r"[^a-z]", "", head.lower()) for head in heads]
    time = next((i for i, word in enumerate(letters) if word in _TIMES), None)
    frame = next((i for i, word in enumerate(letters) if word in _FRAMES), None)
    clock = frame if time is None else time
    columns, unit = _columns(file, heads)
    ours = unit == "m" and heads[:2] == ["frame", "time_s"]
    if ours:
        columns = {
            k: v for k, v in columns.items() if k.removesuffix(IN_WORLD) not in {*columns} - {k}
        }
    require_size(file, len(rows) - 1, len(columns))
    table = np.full((len(rows) - 1, len(heads)), np.nan)
    wanted = [i for axes in (*columns.values(), [] if clock is None else [clock]) for i in axes]
    for row, cells in enumerate(rows[1:]):
        short = len(heads) - len(cells)
        if short and (short > 0 or any(cells[len(heads) :])):
            raise FormatError(
                f"{file}: row {row + 2} has {len(cells)} columns where {len(heads)} are due."
            )
        for i in wanted:
            table[row, i] = number(file, cells[i])
    positions = table[:, list(columns.values())]
    world: World = "camera" if ours else "y up"
    times = np.arange(len(table), dtype=np.float64) if clock is None else table[:, clock]
    times = times * (1.0 if time is None else _TIMES[letters[time]])
    motion = JointMotion.of(file, list(columns), positions, times, world, unit).with_joint_centres()
    return motion if time is not None else motion.per_frame(file)


def rows_of(file: str, text: str) -> list[list[str]]:
    """The rows of a table that hold anything; FormatError in one sentence."""
    rows: list[list[str]] = []
    first, _, rest = text.partition("\n")
    if first.lower().startswith("sep="):  # a line for spreadsheets
        first, text = rest.partition("\n")[0], rest
    delimiter = max(",;\t", key=first.count)
    try:
        for row in csv.reader(io.StringIO(text, newline=""), delimiter=delimiter):
            if row:
                rows.append(row)
            if len(rows) > MOST_FRAMES + 1:
                raise FormatError(f"{file} has more than {MOST_FRAMES} rows.")
    except csv.Error as error:
        raise FormatError(f"{file} is no table of separated values: {error}.") from None
    if not rows:
        raise FormatError(f"{file} is empty.")
    return rows


def _columns(file: str, heads: list[str]) -> tuple[dict[str, list[int]], Unit | None]:
    """The columns of x, y, z by joint, and the unit that they name, if they do."""
    axes_of_joint: dict[str, dict[str, int]] = {}
    units: set[str | None] = set()
    for i, head in enumerate(heads):
        match = _COLUMN.fullmatch(head)
        if match is None:
            continue
        axes = axes_of_joint.setdefault(match["name"], {})
        if match["axis"].lower() in axes:
            raise FormatError(f"{file} has the column {head!r} twice.")
        axes[match["axis"].lower()] = i
        units.add(match["unit"])
    columns = {
        name: [axes[a] for a in "xyz"] for name, axes in axes_of_joint.items() if len(axes) == 3
    }
    if not columns:
        raise FormatError(f"{file} has no joint with the columns NAME_x, NAME_y and NAME_z.")
    if len(units) > 1:
        raise FormatError(f"{file} has columns in several units; one is expected.")
    unit = units.pop()
    known: dict[str | None, Unit] = {"m": "m", "cm": "cm", "mm": "mm"}
    return columns, known.get(unit)


def number(file: str, word: str) -> float:
    """A cell of a table, NaN where it is empty."""
    try:
        return float(word.replace(",", ".") if "," in word else word) if word.strip() else np.nan
    except ValueError:
        raise FormatError(f"{file} has {word[:40]!r} where a number is expected.") from None
