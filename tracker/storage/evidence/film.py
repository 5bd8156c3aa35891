"""A film's file, or its folder of images."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from keypose.tracker.session.schema import Session
from keypose.tracker.storage.evidence.files import identity

if TYPE_CHECKING:
    from keypose.tracker.video import Video


class FilmFiles:
    """A film is recognised by its content: another one is never taken for it."""

    def open(self, session: Session, path: Path, folder: Path) -> Video:
        from keypose.tracker.video import Video  # the decoder loads only when needed

        return Video.open(path, deinterlace=session.video.deinterlace)

    def fingerprint_at(self, session: Session, path: Path) -> str | None:
        from keypose.tracker.video.fingerprint import fingerprint_of_file

        return fingerprint_of_file(path, session.video.frame_count) if path.is_file() else None

    def state(self, session: Session, path: Path, folder: Path) -> tuple[Any, ...]:
        return identity(path), session.video.deinterlace

    def refresh_fingerprints(self, session: Session, folder: Path, video: Video) -> Session:
        return session
