"""Read files of markers: TRC tables, and C3D by ezc3d, an optional extra.

The unit is the file's own; z is up unless POINT:Y_SCREEN says +Y. A marker with a negative residual
was not seen. Points without a label are left out, and so is a second one of the same label. Time
runs from the trial's first frame, also where the file begins later.

The unit is the header's, y is up, and an empty place is a marker that was not seen. A name stands
over the first of its marker's three columns, or names follow each other. What rows there are is
read, whatever the header counts.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import JointMotion, Unit, World, require_size
from keypose.tracker.formats.text import Note, Oddity, decoded, with_decimal_points
from keypose.tracker.geometry.rotations import Array

_C3D_UNITS: dict[str, Unit] = {"m": "m", "cm": "cm", "mm": "mm"}
_MAGIC = 0x50
"""The second byte of every C3D file."""


def read_c3d(file: str, content: bytes) -> JointMotion:
    """The motion in a C3D file's content; FormatError in one sentence."""
    if len(content) < 512 or content[1] != _MAGIC:
        raise FormatError(f"{file} does not begin as a C3D file does.")
    held = _open(file, content)
    try:
        points, point = held["data"]["points"], held["parameters"]["POINT"]
        names = _labels(point)[: points.shape[1]]
        rate = float(np.ravel(point["RATE"]["value"])[0])
        unit = _C3D_UNITS.get(str(point["UNITS"]["value"][0]).strip().lower())
        screen = point["Y_SCREEN"]["value"] if "Y_SCREEN" in point else [""]
        world: World = "y up" if str(screen[0]).strip().upper() == "+Y" else "z up"
        first = int(held["header"]["points"]["first_frame"])
        is_measured = held["data"]["meta_points"]["residuals"][0] >= 0
    except (KeyError, IndexError, TypeError, ValueError):
        raise FormatError(f"{file} lacks the markers' labels, rate or unit.") from None
    if unit is None or not 1e-4 < rate < 1e6:
        raise FormatError(f"{file} lacks the markers' rate or unit.")
    first_of = {name: i for i, name in reversed(list(enumerate(names))) if name}
    if not first_of:
        raise FormatError(f"{file} has no labels of its points.")
    require_size(file, points.shape[2], len(first_of))
    positions = np.where(is_measured[..., None], np.moveaxis(points[:3], 0, -1), np.nan)
    labelled = sorted(first_of.values())
    names, positions = [names[i] for i in labelled], positions[labelled]
    times_s = (first + np.arange(points.shape[2], dtype=np.float64)) / rate
    motion = JointMotion.of(file, names, np.swapaxes(positions, 0, 1), times_s, world, unit)
    return motion.with_joint_centres()


def _labels(point: Any) -> list[str]:
    """The names of all points: more than 255 go on in LABELS2 and so on."""
    further = sorted((k for k in point if re.fullmatch(r"LABELS\d+", k)), key=lambda k: int(k[6:]))
    return [str(name).strip() for key in ("LABELS", *further) for name in point[key]["value"]]


def _open(file: str, content: bytes) -> Any:
    try:
        import ezc3d
    except ImportError:
        raise FormatError("C3D files need ezc3d: pip install 'keypose[c3d]'.") from None
    try:
        with tempfile.TemporaryDirectory() as folder:  # ezc3d reads from a path and nothing else
            path = Path(folder) / "motion.c3d"
            path.write_bytes(content)
            return ezc3d.c3d(str(path))
    except Exception as error:  # noqa: BLE001 — whatever its reader raises, the file is at fault
        why = " ".join(str(error).split()).rstrip(".")[:120]
        raise FormatError(f"{file} is no C3D file that can be read: {why}.") from None


_TRC_UNITS: dict[str, Unit] = {"m": "m", "meters": "m", "metres": "m", "cm": "cm", "mm": "mm"}


def read_trc(file: str, content: bytes) -> JointMotion:
    """Read the motion in a TRC file's content; FormatError in one sentence."""
    lines = with_decimal_points(decoded(content)).splitlines()
    if len(lines) < 6 or not lines[0].startswith("PathFileType"):
        raise FormatError(f"{file} does not begin as a TRC file does, with PathFileType.")
    header = dict(zip(lines[1].split(), lines[2].split(), strict=False))
    unit = _TRC_UNITS.get(header.get("Units", "").lower())
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
    said = [(header.get(key, "")[:20], actual, oddity) for key, actual, oddity in counts]
    return tuple(Note(oddity, (word, n)) for word, n, oddity in said if word and word != str(n))


def _numbers(file: str, line: str, count: int) -> Array:
    """A row's numbers, NaN where its cells are empty or missing; what follows is of no marker."""
    cells = [cell.strip() for cell in line.rstrip("\r\n").split("\t")][:count]
    cells += [""] * (count - len(cells))
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        raise FormatError(f"{file} has something else than numbers in its rows.") from None
