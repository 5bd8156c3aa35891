"""Being the one who writes the open session, or knowing why that cannot be."""

from __future__ import annotations

from pathlib import Path

from app.editor.refusal import Refused
from app.locking import HeldElsewhere, NotALock, SessionLock
from app.opening import Workpiece


class Holding:
    """The lock of the open session's folder. read_only: why it is not written, a sentence."""

    def __init__(self) -> None:
        self.read_only = ""
        self._lock: SessionLock | None = None

    def take(self, piece: Workpiece) -> None:
        """Take the lock, where there is a folder; else, or where it cannot be had, say so."""
        self.read_only, folder = "", piece.session_path.parent
        if piece.session.is_newer:
            self.read_only = f"Read only: a newer Keypose wrote {piece.session_path.name}."
        elif folder.is_dir():
            try:
                self._lock = SessionLock.take(folder)
            except HeldElsewhere as held:
                self.read_only = f"Read only: {held}. Close it there, then open it here again."
            except NotALock as error:
                self.read_only = f"Read only: {error}"

    def take_new(self, folder: Path) -> None:
        """Take the lock of a folder that was just made, unless one is held; HeldElsewhere."""
        if self._lock is None:
            self._lock = SessionLock.take(folder)

    def release(self) -> None:
        """Let others write."""
        self.read_only = ""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def demand_writable(self) -> None:
        """Refused where it may only be looked at."""
        if self.read_only:
            raise Refused(self.read_only)
