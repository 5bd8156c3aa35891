"""Opening mesh files: only regular ones of a sensible size."""

from __future__ import annotations

import os
from pathlib import Path
from typing import BinaryIO, Final

from keypose.tracker.files import NotRegular, open_regular
from keypose.tracker.surface.files.parsing.raw import Refused

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
        raise Refused("is not a regular file: put a mesh in its place.") from error
    except FileNotFoundError as error:
        raise Refused("is no longer there: put it back, or open the folder again.") from error
    except PermissionError as error:
        raise Refused("may not be read by you: change its permissions.") from error
    except OSError as error:
        raise Refused("cannot be read: check the disk or connection it is on.") from error
    try:
        _require_sensible_size(os.fstat(file.fileno()).st_size)
        _require_no_archive(file)
    except BaseException:
        file.close()
        raise
    return file


def _require_sensible_size(size: int) -> None:
    if size == 0:
        raise Refused("is empty: export it again.")
    if size > LARGEST_BYTES:
        raise Refused(
            f"is {size / 2**20:,.0f} MB large, and no more than "
            f"{LARGEST_BYTES // 2**20} MB are read: simplify it, or save it in a binary form."
        )


def _require_no_archive(file: BinaryIO) -> None:
    head = file.read(8)
    file.seek(0)
    for start, what in _ARCHIVES.items():
        if head.startswith(start):
            raise Refused(f"is a {what}, not a mesh: unpack it.")
