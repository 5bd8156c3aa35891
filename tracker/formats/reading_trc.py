"""TRC files in: marker tables as motion capture and OpenSim write them, tabs between columns.

The unit is the header's, y is up, and an empty place is a marker that was not seen.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import JointMotion, Unit, require_size
from keypose.tracker.geometry.rotations import Array

_UNITS: dict[str, Unit] = {"m": "m", "meters": "m", "metres": "m", "cm": "cm", "mm": "mm"}


def read_trc(file: str, content: bytes) -> JointMotion:
    """The motion in a TRC file's content; FormatError in one sentence."""
    lines = content.decode("utf-8-sig").splitlines()
    if len(lines) < 6 or not lines[0].startswith("PathFileType"):
        raise FormatError(f"{file} does not begin as a TRC file does, with PathFileType.")
    header = dict(zip(lines[1].split(), lines[2].split(), strict=False))
    unit = _UNITS.get(header.get("Units", "").lower())
    if unit is None:
        raise FormatError(f"{file} names the unit {header.get('Units', '')!r}; m, cm or mm is due.")
    names = [name.strip() for name in lines[3].split("\t")[2:] if name.strip()]
    rows = [line for line in lines[5:] if line.strip()]
    _require_counts(file, header, len(rows), len(names))
    require_size(file, len(rows), len(names))
    table = np.array([_numbers(file, line, 2 + 3 * len(names)) for line in rows])
    positions = table[:, 2:].reshape(len(rows), len(names), 3)
    return JointMotion.of(file, names, positions, table[:, 1], "y up", unit)


def _require_counts(file: str, header: dict[str, str], frames: int, markers: int) -> None:
    for key, found, what in (
        ("NumFrames", frames, "frames"),
        ("NumMarkers", markers, "markers"),
    ):
        declared = header.get(key, "")
        if declared and declared != str(found):
            raise FormatError(f"{file} says {declared[:20]} {what} and holds {found}.")


def _numbers(file: str, line: str, count: int) -> Array:
    """A row's numbers, NaN where its cells are empty; missing cells at its end are empty."""
    cells = [cell.strip() for cell in line.rstrip("\r\n").split("\t")]
    while len(cells) > count and not cells[-1]:
        cells.pop()
    cells += [""] * (count - len(cells))
    if len(cells) > count:
        raise FormatError(f"{file} has a row of {len(cells)} columns where {count} are due.")
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        raise FormatError(f"{file} has something else than numbers in its rows.") from None
