"""Being the one who writes the open session, or knowing why that cannot be.

The session's folder is known by its device and number: one that was renamed, or is gone, is not
made anew, which would leave half a session there and the other half elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

from keypose.app.document.folder_lock import LockedElsewhere, NotALock, SessionLock
from keypose.app.document.open import OpenSession
from keypose.app.editor.refusal import Refused
from keypose.tracker.errors import SessionError
from keypose.tracker.storage.atomic import make_folder

Identity: TypeAlias = tuple[int, int]


class WriteLock:
    """The lock of the open session's folder. read_only: why it is not written, a sentence."""

    def __init__(self) -> None:
        self.read_only = ""
        self._lock: SessionLock | None = None
        self._folder: Identity | None = None

    def take(self, opened: OpenSession) -> None:
        """Take the lock, where there is a folder; else, or where it cannot be had, say so."""
        self.read_only, folder = "", opened.session_path.parent
        if opened.session.is_newer:
            self.read_only = f"Read only: a newer Keypose wrote {opened.session_path.name}."
        elif folder.is_dir():
            try:
                self._hold(folder)
            except LockedElsewhere as held:
                self.read_only = f"Read only: {held}. Close it there, then open it here again."
            except NotALock as error:
                self.read_only = f"Read only: {error}"

    def require_folder(self, folder: Path, is_ours: Callable[[], bool]) -> None:
        """SessionError unless the session can be written into its folder, which is made for a
        session that has none yet; LockedElsewhere where it is another's by now.

        is_ours: whether another folder in its place holds what this program wrote last: then the
        session was put back from a copy.
        """
        if self._folder is None:
            make_folder(folder, error=SessionError)
            self._hold(folder)
        elif _identity(folder) != self._folder:
            if not is_ours():
                raise SessionError(
                    f"The session's folder is gone or was renamed: put {str(folder)!r} back. "
                    "Your edits stay here and are written once it is back."
                )
            self._release()
            self._hold(folder)

    def release(self) -> None:
        """Let others write."""
        self.read_only = ""
        self._release()

    def _hold(self, folder: Path) -> None:
        self._lock = SessionLock.take(folder)
        self._folder = _identity(folder)

    def _release(self) -> None:
        self._folder = None
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    @property
    def is_held(self) -> bool:
        """Whether this program alone writes there."""
        return self._lock is not None

    def require_writable(self) -> None:
        """Refused where it may only be looked at."""
        if self.read_only:
            raise Refused(self.read_only)


def _identity(folder: Path) -> Identity | None:
    try:
        facts = folder.stat()
    except OSError:
        return None
    return facts.st_dev, facts.st_ino
