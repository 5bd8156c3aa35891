"""A session's video, found by its fingerprint after it was moved or renamed; and the present
fingerprints of surfaces."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from keypose.tracker.session.schema import Session
from keypose.tracker.storage.evidence import files_of

if TYPE_CHECKING:
    from keypose.tracker.video import Video

MOST_FILES = 500
NOT_FILMS = (".json", ".jsonl", ".npz", ".csv", ".txt", ".md", ".py", ".previous", ".part")


def find_moved(session: Session, session_path: Path, was: Path) -> Path | None:
    """The same film near the session or near where it was; None where there is none.

    Looked at are the files of three folders: the session's, the one above, and that of `was`; and
    the folders in them, where the session is about a folder of meshes.
    """
    if not session.video.fingerprint:
        return None
    files = files_of(session)
    for place in _nearby(Path(session_path).absolute().parent, was):
        try:
            if files.fingerprint_at(session, place) == session.video.fingerprint:
                return place
        except OSError:  # it cannot be read, so it is not the one
            continue
    return None


def with_present_fingerprints(session: Session, session_path: Path, video: Video) -> Session:
    """The session with the present fingerprints of meshes and cameras, which may have been exported
    again; the same session where nothing differs. video: as it was opened."""
    folder = Path(session_path).absolute().parent
    return files_of(session).refresh_fingerprints(session, folder, video)


def _nearby(folder: Path, was: Path) -> Iterator[Path]:
    for place in dict.fromkeys((folder, folder.parent, was.parent)):
        try:
            there = [file for file in place.iterdir() if not file.name.lower().endswith(NOT_FILMS)]
        except (OSError, ValueError):  # ValueError: a NUL character in its name
            continue
        # One of the old name first; it is the likeliest.
        yield from sorted(there, key=lambda file: (file.name != was.name, file))[:MOST_FILES]
