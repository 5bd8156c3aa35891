"""One writer for each session: a lock that ends with the process that holds it, however it ends."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Self

try:
    import fcntl
except ImportError:  # not on Windows, where two Keyposes on one session are not noticed
    fcntl = None  # type: ignore[assignment]

from tracker.errors import SessionError
from tracker.files import NotRegular, open_own
from tracker.storage.leftovers import sweep

NAME = ".keypose.lock"


LONGEST_HOLDER = 20
"""Bytes of a process id, which is all that a lock may hold."""


class HeldElsewhere(SessionError):
    """Another process has the session; the text says which."""


class NotALock(SessionError):
    """Something else has the lock's name, and nothing is written beside it; the text says what."""


class SessionLock:
    """The right to write into a session's folder, until it is released."""

    def __init__(self, descriptor: int | None) -> None:
        self._descriptor = descriptor

    @classmethod
    def take(cls, folder: Path) -> SessionLock:
        """Take the lock of a folder that exists; HeldElsewhere when another process has it.

        NotALock when a link, a pipe or anything but a regular file has its name. What writers left
        there that were killed is removed.

        Where no file can be made, nothing can be saved either, which is told when it is tried.
        """
        if fcntl is None:
            return cls(None)
        try:
            descriptor = open_own(folder / NAME, os.O_RDWR | os.O_CREAT, one_name=False)
        except NotRegular as error:
            what = f"{NAME} in {str(folder)!r} is not a lock of Keypose, {error.strerror}"
            raise NotALock(f"{what}: remove it if you trust this folder.") from None
        except OSError:
            return cls(None)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            holder = _holder(descriptor)
            os.close(descriptor)
            if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
                raise HeldElsewhere(f"open in another Keypose{holder}") from None
            return cls(None)  # a file system without locks
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
    except HeldElsewhere as held:
        raise SessionError(f"{str(session_path)!r} is {held}: {advice}.") from None
    with lock:
        yield


def _write_holder(descriptor: int) -> None:
    """Who holds it, for the words alone. A file that holds anything else, or has another name
    elsewhere, is not written to: it locks as well as any."""
    with suppress(OSError):  # the disk may be full
        there = os.pread(descriptor, LONGEST_HOLDER + 1, 0)
        is_lock = not there or (there.isdigit() and len(there) <= LONGEST_HOLDER)
        if not is_lock or os.fstat(descriptor).st_nlink > 1:
            return
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, str(os.getpid()).encode(), 0)


def _holder(descriptor: int) -> str:
    with suppress(OSError, ValueError):
        return f" (pid {int(os.pread(descriptor, LONGEST_HOLDER, 0))})"
    return ""
