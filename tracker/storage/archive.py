"""NumPy archives (.npz) whose bytes depend on their arrays alone, read without trusting them."""

from __future__ import annotations

import io
import math
import struct
import warnings
import zipfile
import zlib
from collections.abc import Mapping
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

EARLIEST_DATE = (1980, 1, 1, 0, 0, 0)
"""The zip format's first day, used for every entry so that the bytes do not depend on the time."""

LARGEST_PACKED_BYTES: Final = 256 * 2**20
"""What all entries of an archive with compressed entries may hold together."""

_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
_ENCRYPTED = 1
"""This bit of an entry's flags."""


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


def archive_arrays(content: bytes, *, packed: bool = False) -> dict[str, NDArray[Any]]:
    """The arrays of an archive's bytes; ValueError when they are not an archive of plain arrays.

    Objects are refused, and an entry's header must agree with its size before memory is taken.

    packed: compressed entries are read too, up to LARGEST_PACKED_BYTES of all; otherwise it must be
            an archive of `archive_bytes`.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            entries = archive.infolist()
            if packed and sum(entry.file_size for entry in entries) > LARGEST_PACKED_BYTES:
                limit = LARGEST_PACKED_BYTES // 2**20
                raise ValueError(f"its entries hold more than {limit} MB")
            return {_name(entry): _array(archive, entry, packed) for entry in entries}
    except (
        *(zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError),
        *(RuntimeError, NotImplementedError, OverflowError),
    ) as error:
        raise ValueError(str(error)) from None


def _name(entry: zipfile.ZipInfo) -> str:
    if not entry.filename.endswith(".npy"):
        raise ValueError(f"{entry.filename!r} is no array")
    return entry.filename.removesuffix(".npy")


def _array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, packed: bool) -> NDArray[Any]:
    name = entry.filename
    if entry.flag_bits & _ENCRYPTED:
        raise ValueError(f"{name!r} is encrypted")
    if entry.compress_type != zipfile.ZIP_STORED:
        if not packed:
            raise ValueError(f"{name!r} is compressed")
        if entry.compress_type != zipfile.ZIP_DEFLATED:
            raise ValueError(f"{name!r} is compressed in an unusual way")
    with archive.open(entry) as stream:
        content = stream.read(entry.file_size)  # never more, whatever it unpacks to
    shape, by_columns, dtype, start = _header(name, content, packed)
    if dtype.hasobject:
        raise ValueError(f"{name!r} holds objects, not plain numbers or text")
    if min(shape, default=0) < 0 or math.prod(shape) * dtype.itemsize != len(content) - start:
        raise ValueError(f"{name!r} has another size than it says")
    order: Literal["F", "C"] = "F" if by_columns else "C"
    array: NDArray[Any] = np.ndarray(shape, dtype, content, start, order=order)
    return array.copy(order="K")  # the archive's bytes may go, and one may write


def _header(
    name: str, content: bytes, packed: bool
) -> tuple[tuple[int, ...], bool, np.dtype[Any], int]:
    """Shape, whether columns come first, type, and where the numbers start."""
    stream = io.BytesIO(content)
    try:
        version = np.lib.format.read_magic(stream)
    except ValueError:
        raise ValueError(f"{name!r} is no array") from None
    if version not in (_HEADERS if packed else ((1, 0),)):
        raise ValueError(f"{name!r} has another version")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of an age-old header, of an odd literal
            shape, by_columns, dtype = _HEADERS[version](stream)
    except Exception:  # noqa: BLE001 — the header is a piece of Python and may be wrong in any way
        raise ValueError(f"{name!r} has a header that cannot be read") from None
    return shape, by_columns, dtype, stream.tell()
