"""Read .chan: a line of numbers for every frame, as Nuke and what exports for it write them."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.cameras.camera_file import (
    MOST_NUMBER,
    CameraFile,
    CameraReading,
    CameraWay,
    Size,
    ascending,
    camera_file,
    of_focal,
)
from keypose.tracker.formats.conventions import FLIP
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, transform

COLUMNS: Final = 8
WITHOUT_LENS: Final = 7
FILM_MM: Final = 36.0
"""Width of the film that a focal length in millimetres is for."""


def read_chan(file: str, content: bytes, size: Size, reading: CameraReading) -> CameraFile:
    """The camera of a .chan file; lines that begin with # are left out."""
    text = content.decode("utf-8-sig")
    lines = [words for line in text.splitlines() if (words := line.split())]
    if "#" in text:
        lines = [words for words in lines if not words[0].startswith("#")]
    width = len(lines[0]) if lines else 0
    if width not in (WITHOUT_LENS, COLUMNS) or any(len(line) != width for line in lines):
        raise FormatError(
            f"{file} should have {COLUMNS} numbers in every line: frame, position, rotation "
            f"and the vertical field of view; or {WITHOUT_LENS}, without the last."
        )
    try:
        columns = np.array(lines, dtype=np.float64)
    except ValueError:
        raise FormatError(f"{file} has lines that are not numbers.") from None
    if not np.isfinite(columns).all() and np.isnan(columns).any():
        raise FormatError(f"{file} has lines that are not numbers.")
    if not np.isfinite(columns).all() or not (np.abs(columns[:, 0]) < MOST_NUMBER).all():
        raise FormatError(f"{file} has a number that is too large for a camera.")
    return camera_of_columns(file, columns, size, reading)


def camera_of_columns(file: str, columns: Array, size: Size, reading: CameraReading) -> CameraFile:
    """The camera of numbers (K, 7 or 8), read in this way."""
    camera, zoom = _lens(file, columns, size, reading)
    Rs = rotations(reading.rotation_order or "zxy", np.radians(columns[:, 4:7]))
    frames = np.rint(columns[:, 0]).astype(np.int64)
    camera_way = CameraWay(frames, transform(Rs * FLIP, columns[:, 1:4]), zoom)
    read = camera_file(file, camera, camera_way, reading)
    if read.way is not None:
        ascending(file, read.way)
    return replace(read, columns=columns)


def _lens(
    file: str, columns: Array, size: Size, reading: CameraReading
) -> tuple[Camera | None, Array]:
    """The lens of the first line, and the focal length of each as a multiple of it (K,)."""
    column = reading.lens_column or "vertical"
    if column == "session" or columns.shape[1] == WITHOUT_LENS:
        return None, np.ones(len(columns))
    last = columns[:, WITHOUT_LENS]
    if not ((last > 0) & ((last < 180) | (column == "mm"))).all():
        raise FormatError(
            f"{file} has numbers that no camera has: the last column should be the vertical "
            "field of view, from 0 to 180 degrees."
        )
    if np.ptp(last) == 0:
        last = last[:1]  # as long in every line
    if column == "mm":
        focal = last / FILM_MM * size[0]
    else:
        side = size[0] if column == "horizontal" else size[1]
        focal = side / 2 / np.tan(np.radians(last) / 2)
    if not np.isfinite(focal).all():
        raise FormatError(f"{file} has numbers that no camera has.")
    zoom = np.broadcast_to(focal / focal[0], len(columns))
    return of_focal(file, size, float(focal[0])), zoom


def rotations(order: str, angles: Array) -> Array:
    """(K, 3, 3) of angles (K, 3) about x, y, z, radians, one after another as the order says."""
    first, second, third = (_about(axis, angles[:, axis]) for axis in map("xyz".index, order))
    return np.asarray(third @ second @ first)


def _about(axis: int, angles: Array) -> Array:
    R = np.tile(np.eye(3), (len(angles), 1, 1))
    i, k = (axis + 1) % 3, (axis + 2) % 3
    cosines, sines = np.cos(angles), np.sin(angles)
    R[:, i, i] = R[:, k, k] = cosines
    R[:, k, i], R[:, i, k] = sines, -sines
    return R
