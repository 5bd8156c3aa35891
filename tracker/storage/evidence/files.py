"""The operations on files that every kind of evidence provides."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from keypose.tracker.session.schema import Session

if TYPE_CHECKING:
    from keypose.tracker.video import Video


class EvidenceFiles(Protocol):
    """Operations on the files of a session's evidence at `path`; `folder` is that of the session's
    file."""

    def open(self, session: Session, path: Path, folder: Path) -> Video:
        """Its pictures. VideoError or SurfaceError in one sentence when it cannot be read."""
        ...

    def fingerprint_at(self, session: Session, path: Path) -> str | None:
        """The fingerprint of what lies at a path; None where it is not of this kind. OSError where
        it cannot be read."""
        ...

    def state(self, session: Session, path: Path, folder: Path) -> tuple[Any, ...]:
        """Equal as long as opening it again would give the same; reads no file contents."""
        ...

    def refresh_fingerprints(self, session: Session, folder: Path, video: Video) -> Session:
        """The session with the present fingerprints of what may have been exported again; the same
        session where nothing differs. video: as it was opened."""
        ...


def identity(path: Path) -> Any:
    """Equal as long as the same file is at a path."""
    try:
        found = path.stat()
    except OSError:  # opening it will report what is wrong
        return path, None
    return path, found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns
