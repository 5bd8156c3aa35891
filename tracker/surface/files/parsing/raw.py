"""Open mesh files, refuse what is wrong, read numbers from text, cut polygons into triangles."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.files import NotRegular, open_regular
from keypose.tracker.geometry.rotations import Array

MOST_FACES: Final = 2_000_000
MOST_VERTICES: Final = 1_000_000
"""Of a mesh that is read."""


class MeshRefused(Exception):
    """Why a mesh cannot be used: the end of a sentence whose subject is the file's name."""


@dataclass(frozen=True, eq=False)
class RawMesh:
    """Triangles as a file states them, nothing checked yet.

    vertices: (V, 3), faces: (F, 3) vertex indices, consistency: (V,) mean ZNCC or None.
    """

    vertices: Array
    faces: NDArray[np.int64]
    consistency: Array | None = None


def require_counts(vertices: int, faces: int) -> None:
    """Refused where a file announces more than is read, or no surface at all."""
    if faces > MOST_FACES:
        raise MeshRefused(f"has {faces:,} faces: simplify it to {MOST_FACES:,} at most.")
    if vertices > MOST_VERTICES:
        raise MeshRefused(f"has {vertices:,} vertices: simplify it to {MOST_VERTICES:,} at most.")
    if vertices <= 0:
        raise MeshRefused("holds no vertices: export it again.")
    if faces <= 0:
        raise MeshRefused("holds no faces, only points: make a mesh of them first.")


def numbers(text: bytes) -> Array:
    """All the numbers of a text, blanks between them. Refused where there is anything else."""
    if not text.strip():
        return np.empty(0)
    with warnings.catch_warnings():
        # numpy warns where it met something that is no number, and gives what came before it.
        warnings.simplefilter("error")
        try:
            return np.fromstring(text, sep=" ")
        except (DeprecationWarning, ValueError) as error:
            raise MeshRefused(
                "holds something else where numbers should be: export it again."
            ) from error


def table(lines: list[bytes], least: int) -> Array:
    """(rows, columns) of lines with equally many numbers, at least so many.

    Where lines differ in length, their first `least` columns. Refused where one is too short.
    """
    flat = numbers(b" ".join(lines))
    width = len(lines[0].split()) if lines else least
    if width >= least and flat.size == width * len(lines) and _all_as_wide(lines, width):
        return flat.reshape(len(lines), width)
    rows = [line.split(None, least)[:least] for line in lines]
    if min(map(len, rows), default=least) < least:
        raise MeshRefused(f"has a vertex with fewer than {least} numbers: export it again.")
    return numbers(b" ".join(b" ".join(row) for row in rows)).reshape(len(rows), least)


def _all_as_wide(lines: list[bytes], width: int) -> bool:
    return all(len(line.split()) == width for line in lines)


def fan(corners: NDArray[np.int64], counts: NDArray[np.int64], vertices: int) -> NDArray[np.int64]:
    """(F, 3) triangles around the first corner of every polygon.

    corners: (sum of counts,) vertex indices, polygon after polygon; counts: (P,). Polygons of fewer
    than three corners are none. Refused where there are more triangles than are read.
    """
    triangles = np.maximum(counts - 2, 0)
    total = int(triangles.sum())
    require_counts(vertices, total)
    first = np.repeat(np.cumsum(counts) - counts, triangles)
    place = np.arange(total) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    return np.stack(
        [corners[first], corners[first + place + 1], corners[first + place + 2]], axis=1
    )


def runs(
    values: NDArray[np.float64], starts: NDArray[np.int64], counts: NDArray[np.int64]
) -> NDArray[np.int64]:
    """The integers values[s : s + n] of every start s and count n, one after the other."""
    place = np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.asarray(values[np.repeat(starts, counts) + place], dtype=np.int64)


LARGEST_BYTES: Final = 512 * 2**20

_ARCHIVES: Final = {
    b"PK\x03\x04": "zip archive",
    b"PK\x05\x06": "zip archive",
    b"\x1f\x8b": "gzip archive",
    b"BZh": "bzip2 archive",
    b"\xfd7zXZ": "xz archive",
    b"7z\xbc\xaf": "7z archive",
    b"Rar!": "rar archive",
}


def open_mesh_file(path: Path) -> BinaryIO:
    """The file, open for reading. Refused where it is none, empty, huge or an archive."""
    try:
        file = open_regular(path)
    except NotRegular as error:
        raise MeshRefused("is not a regular file: put a mesh in its place.") from error
    except FileNotFoundError as error:
        raise MeshRefused("is no longer there: put it back, or open the folder again.") from error
    except PermissionError as error:
        raise MeshRefused("may not be read by you: change its permissions.") from error
    except OSError as error:
        raise MeshRefused("cannot be read: check the disk or connection it is on.") from error
    try:
        _require_sensible_size(os.fstat(file.fileno()).st_size)
        _require_no_archive(file)
    except BaseException:
        file.close()
        raise
    return file


def _require_sensible_size(size: int) -> None:
    if size == 0:
        raise MeshRefused("is empty: export it again.")
    if size > LARGEST_BYTES:
        raise MeshRefused(
            f"is {size / 2**20:,.0f} MB large, and no more than "
            f"{LARGEST_BYTES // 2**20} MB are read: simplify it, or save it in a binary form."
        )


def _require_no_archive(file: BinaryIO) -> None:
    head = file.read(8)
    file.seek(0)
    for start, kind in _ARCHIVES.items():
        if head.startswith(start):
            raise MeshRefused(f"is a {kind}, not a mesh: unpack it.")
