"""One writer for each session: a lock that ends with the process that holds it, however it ends."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Self

from filelock import lock_descriptor

from keypose.tracker.errors import SessionError
from keypose.tracker.files import NotRegular, open_own
from keypose.tracker.storage.atomic import sweep

NAME = ".keypose.lock"

LONGEST_HOLDER = 20
"""Bytes of a process id, which is all that a lock may hold."""
_BEFORE_PID = b" " if os.name == "nt" else b""
"""Windows keeps the first byte, which is what is locked, from those who are to read the rest."""


class LockedElsewhere(SessionError):
    """Another process has the session; the text says which."""


class NotALock(SessionError):
    """Something else has the lock's name, and nothing is written beside it; the text says what."""


class SessionLock:
    """The right to write into a session's folder, until it is released."""

    def __init__(self, descriptor: int | None) -> None:
        self._descriptor = descriptor

    @classmethod
    def take(cls, folder: Path) -> SessionLock:
        """Take the lock of a folder that exists; LockedElsewhere when another process has it.

        NotALock when a link, a pipe or anything but a regular file has its name. What writers left
        there that were killed is removed.

        Where no file can be made, nothing can be saved either, which is reported when it is tried.
        """
        try:
            descriptor = open_own(folder / NAME, os.O_RDWR | os.O_CREAT, one_name=False)
        except NotRegular as error:
            problem = f"{NAME} in {str(folder)!r} is not a lock of Keypose, {error.strerror}"
            raise NotALock(f"{problem}: remove it if you trust this folder.") from None
        except OSError:
            return cls(None)
        try:
            # Not filelock's own opening, which would take what it finds for a lock.
            is_ours = lock_descriptor(descriptor, blocking=False)
        except OSError:  # a file system without locks
            os.close(descriptor)
            return cls(None)
        if not is_ours:
            holder = _holder(descriptor)
            os.close(descriptor)
            raise LockedElsewhere(f"open in another Keypose{holder}")
        _write_holder(descriptor)
        sweep(folder, is_locked=True)
        return cls(descriptor)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def release(self) -> None:
        """Let others write; the file stays, since removing it could take another's lock away."""
        if self._descriptor is not None:
            with suppress(OSError):
                os.close(self._descriptor)
            self._descriptor = None


@contextmanager
def locked(session_path: Path, advice: str) -> Iterator[None]:
    """Be the one who writes a session; SessionError, with the advice, when another Keypose is."""
    if not session_path.parent.is_dir():  # a new folder is nobody else's
        yield
        return
    try:
        lock = SessionLock.take(session_path.parent)
    except LockedElsewhere as held:
        raise SessionError(f"{str(session_path)!r} is {held}: {advice}.") from None
    with lock:
        yield


def _write_holder(descriptor: int) -> None:
    """Write who holds it, for the words alone. A file that holds anything else, or has another name
    elsewhere, is not written to: it locks as well as any.
    """
    with suppress(OSError):  # the disk may be full
        there = _content(descriptor)
        is_lock = not there or (
            there.removeprefix(_BEFORE_PID).isdigit() and len(there) <= LONGEST_HOLDER
        )
        if not is_lock or os.fstat(descriptor).st_nlink > 1:
            return
        os.ftruncate(descriptor, 0)
        os.lseek(descriptor, 0, os.SEEK_SET)
        os.write(descriptor, _BEFORE_PID + str(os.getpid()).encode())


def _holder(descriptor: int) -> str:
    with suppress(OSError, ValueError):
        return f" (pid {int(_content(descriptor, len(_BEFORE_PID)))})"
    return ""


def _content(descriptor: int, start: int = 0) -> bytes:
    """What it holds from there on, and no more than shows that it is too long."""
    os.lseek(descriptor, start, os.SEEK_SET)
    return os.read(descriptor, LONGEST_HOLDER + 1)
