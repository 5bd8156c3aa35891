"""The files that lie beside a session and belong to it, when the session goes to another folder."""

from __future__ import annotations

from pathlib import Path

from keypose.tracker.errors import SessionError
from keypose.tracker.files import read_regular
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.archive import LARGEST_PACKED_BYTES
from keypose.tracker.storage.atomic import write_file


def carry_beside(session: Session, folder: Path, other: Path) -> None:
    """Copy the session's imported motion and its keypoints to another folder; SessionError when
    one cannot be written there."""
    for reference in (session.first_motion, session.keypoints):
        if reference is not None:
            _carry(folder / reference.file, other / reference.file)


def _carry(source: Path, place: Path) -> None:
    if place.exists():  # named by its content
        return
    try:
        content = read_regular(source, LARGEST_PACKED_BYTES)
    except OSError:  # tracking will report that it is missing
        return
    write_file(place, content, overwrite=True, error=SessionError)
