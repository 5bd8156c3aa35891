"""NumPy archives (.npz) whose bytes depend on their arrays alone, read without trusting them."""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

EARLIEST_DATE = (1980, 1, 1, 0, 0, 0)
"""The zip format's first day: every entry carries it, so that the bytes hold no clock."""


def archive_bytes(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """An uncompressed .npz: compressors differ between machines, stored bytes do not."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name in sorted(arrays):
            entry = zipfile.ZipInfo(f"{name}.npy", EARLIEST_DATE)
            entry.create_system = 3  # the same on every operating system
            entry.external_attr = 0o644 << 16
            content = io.BytesIO()
            array = np.asarray(arrays[name], order="C")
            np.lib.format.write_array(content, array, version=(1, 0), allow_pickle=False)
            archive.writestr(entry, content.getvalue())
    return buffer.getvalue()


def archive_arrays(content: bytes) -> dict[str, NDArray[Any]]:
    """The arrays of an archive of `archive_bytes`; ValueError when it is anything else.

    Objects are refused, and an entry's header must agree with its size before memory is taken.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return {
                entry.filename.removesuffix(".npy"): _array(archive, entry)
                for entry in archive.infolist()
            }
    except (zipfile.BadZipFile, EOFError, RuntimeError, NotImplementedError) as error:
        raise ValueError(str(error)) from None


def _array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> NDArray[Any]:
    if entry.compress_type != zipfile.ZIP_STORED:
        raise ValueError(f"{entry.filename} is compressed")
    content = io.BytesIO(archive.read(entry))
    if np.lib.format.read_magic(content) != (1, 0):
        raise ValueError(f"{entry.filename} has another version")
    shape, _, dtype = np.lib.format.read_array_header_1_0(content)
    if math.prod(shape) * dtype.itemsize != entry.file_size - content.tell():
        raise ValueError(f"{entry.filename} has another size than it says")
    content.seek(0)
    return np.lib.format.read_array(content, allow_pickle=False)
