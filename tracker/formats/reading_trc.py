"""Read TRC files: marker tables as motion capture and OpenSim write them, tabs between columns.

The unit is the header's, y is up, and an empty place is a marker that was not seen. A name stands
over the first of its marker's three columns, or names follow each other. What rows there are is
read, whatever the header counts.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import JointMotion, Unit, require_size
from keypose.tracker.formats.notes import Note, Oddity
from keypose.tracker.formats.text import decoded, with_decimal_points
from keypose.tracker.geometry.rotations import Array

_UNITS: dict[str, Unit] = {"m": "m", "meters": "m", "metres": "m", "cm": "cm", "mm": "mm"}


def read_trc(file: str, content: bytes) -> JointMotion:
    """Read the motion in a TRC file's content; FormatError in one sentence."""
    lines = with_decimal_points(decoded(content)).splitlines()
    if len(lines) < 6 or not lines[0].startswith("PathFileType"):
        raise FormatError(f"{file} does not begin as a TRC file does, with PathFileType.")
    header = dict(zip(lines[1].split(), lines[2].split(), strict=False))
    unit = _UNITS.get(header.get("Units", "").lower())
    if unit is None:
        unit_name = header.get("Units", "")[:20]
        raise FormatError(f"{file} names the unit {unit_name!r}; m, cm or mm is due.")
    names, columns = _markers(lines[3])
    rows = [line for line in lines[5:] if line.strip()]
    require_size(file, len(rows), len(names))
    width = max(columns) + 3
    table = np.array([_numbers(file, line, width) for line in rows])
    positions = table[:, np.add.outer(columns, range(3))]
    notes = _notes(header, len(rows), len(names))
    motion = JointMotion.of(file, names, positions, table[:, 1], "y up", unit, notes=notes)
    return motion.with_joint_centres()


def _markers(line: str) -> tuple[list[str], list[int]]:
    """The markers' names, and the first column of each."""
    cells = [cell.strip() for cell in line.split("\t")]
    at = [i for i, cell in enumerate(cells) if cell and i >= 2]
    if any((i - 2) % 3 for i in at):
        return [cells[i] for i in at], [2 + 3 * k for k in range(len(at))]
    return [cells[i] for i in at], at


def _notes(header: dict[str, str], rows: int, markers: int) -> tuple[Note, ...]:
    counts: tuple[tuple[str, int, Oddity], ...] = (
        ("NumFrames", rows, "row count"),
        ("NumMarkers", markers, "marker count"),
    )
    said = [(header.get(key, "")[:20], found, oddity) for key, found, oddity in counts]
    return tuple(Note(oddity, (word, n)) for word, n, oddity in said if word and word != str(n))


def _numbers(file: str, line: str, count: int) -> Array:
    """A row's numbers, NaN where its cells are empty or missing; what follows is of no marker."""
    cells = [cell.strip() for cell in line.rstrip("\r\n").split("\t")][:count]
    cells += [""] * (count - len(cells))
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        raise FormatError(f"{file} has something else than numbers in its rows.") from None
