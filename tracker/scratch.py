"""Folders for work under way. What a process that was killed leaves is removed by the next."""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

PREFIX: Final = "keypose-"
LOCK: Final = "keypose.lock"


class Scratch:
    """A folder of this process for `what`, in the system's place for such."""

    def __init__(self, what: str) -> None:
        self.path = Path(tempfile.mkdtemp(prefix=f"{PREFIX}{what}-"))
        self._lock = FileLock(self.path / LOCK, timeout=0, thread_local=False)
        self._lock.acquire()

    def close(self) -> None:
        """Remove it, with what is in it."""
        self._lock.release(force=True)
        shutil.rmtree(self.path, ignore_errors=True)

    def __enter__(self) -> Path:
        return self.path

    def __exit__(self, *_: object) -> None:
        self.close()


def sweep_scratch() -> None:
    """Remove this user's folders whose processes have ended: nobody holds their locks."""
    for place in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError, Timeout):  # it is in use, gone by now, or not ours to remove
            facts = place.lstat()
            is_own = not hasattr(os, "getuid") or facts.st_uid == os.getuid()
            if is_own and stat.S_ISDIR(facts.st_mode) and (place / LOCK).is_file():
                with FileLock(place / LOCK, timeout=0):
                    pass
                shutil.rmtree(place)
