"""A session's video, found again by its fingerprint where it was moved or renamed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tracker.session.schema import Session

MOST_FILES = 500
NOT_FILMS = (".json", ".jsonl", ".npz", ".csv", ".txt", ".md", ".py", ".previous", ".part")


def found_again(session: Session, session_path: Path, was: Path) -> Path | None:
    """The same film near the session or near where it was; None where there is none.

    Looked at are the files of three folders: the session's, the one above, and that of `was`.
    """
    from tracker.video.fingerprint import fingerprint_of_file

    wanted = session.video
    if not wanted.fingerprint:
        return None
    for place in _nearby(Path(session_path).absolute().parent, was):
        try:
            if fingerprint_of_file(place, wanted.frame_count) == wanted.fingerprint:
                return place
        except OSError:  # it cannot be read, so it is not the one
            continue
    return None


def _nearby(folder: Path, was: Path) -> Iterator[Path]:
    for place in dict.fromkeys((folder, folder.parent, was.parent)):
        try:
            files = sorted(place.iterdir())[:MOST_FILES]
        except OSError:
            continue
        # One of the old name first; it is the likeliest.
        for file in sorted(files, key=lambda file: file.name != was.name):
            if file.is_file() and not file.name.lower().endswith(NOT_FILMS):
                yield file
