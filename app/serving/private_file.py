"""Small files that their owner alone may read, written whole."""

from __future__ import annotations

import os
import secrets
import stat
from contextlib import suppress
from pathlib import Path

from tracker.errors import KeyposeError

# Not every system has them all.
_NO_FOLLOW = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)
_NO_WAIT = getattr(os, "O_NONBLOCK", 0)


def write_private(path: Path, content: bytes) -> None:
    """Put the bytes at the path, mode 0600. KeyposeError in one sentence when the disk refuses."""
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(6)}.part")
    try:
        handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _NO_FOLLOW, 0o600)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(content)
            temporary.replace(path)
        finally:
            with suppress(FileNotFoundError):
                temporary.unlink()
    except OSError as problem:
        why = problem.strerror or problem
        raise KeyposeError(f"{str(path)!r} cannot be written: {why}.") from None


def read_private(path: Path, most_bytes: int) -> bytes | None:
    """The content; None where there is no such file, or others may read or change it."""
    try:
        handle = os.open(path, os.O_RDONLY | _NO_WAIT | _NO_FOLLOW)
    except OSError:
        return None
    try:
        found = os.fstat(handle)
        if not _is_private(found) or found.st_size > most_bytes:
            return None
        return os.read(handle, most_bytes)
    except OSError:
        return None
    finally:
        os.close(handle)


def _is_private(found: os.stat_result) -> bool:
    if not stat.S_ISREG(found.st_mode):
        return False
    if os.name != "posix":  # a home folder is its owner's there, and modes say nothing
        return True
    return found.st_uid == os.getuid() and stat.S_IMODE(found.st_mode) & 0o077 == 0
