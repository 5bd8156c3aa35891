"""A session's video, found again by its fingerprint where it was moved or renamed; and surfaces,
known as they are now."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

from tracker.errors import SurfaceError
from tracker.files import read_head
from tracker.session.schema import Session, Surface

MOST_FILES = 500
MOST_CAMERA_BYTES = 4 * 2**20
"""What is longer is no file of cameras, and is refused by who reads it."""
NOT_FILMS = (".json", ".jsonl", ".npz", ".csv", ".txt", ".md", ".py", ".previous", ".part")


def find_moved(session: Session, session_path: Path, was: Path) -> Path | None:
    """The same film near the session or near where it was; None where there is none.

    Looked at are the files of three folders: the session's, the one above, and that of `was`; and
    the folders in them, where the session is about a folder of meshes.
    """
    if not session.video.fingerprint:
        return None
    told = _film if session.surface is None else _surfaces
    for place in _nearby(Path(session_path).absolute().parent, was):
        try:
            if told(place, session) == session.video.fingerprint:
                return place
        except OSError:  # it cannot be read, so it is not the one
            continue
    return None


def with_present_fingerprints(session: Session, session_path: Path, fingerprint: str) -> Session:
    """With the fingerprints of meshes and cameras as they are now, for both may have been exported
    again; a session about a film as it is.

    fingerprint: of the meshes that were opened.
    """
    surface = session.surface
    if surface is None:
        return session
    if surface.cameras is not None:
        surface = cameras_seen(surface, session_path.absolute().parent / surface.cameras)
    if (fingerprint, surface) == (session.video.fingerprint, session.surface):
        return session
    video = session.video.model_copy(update={"fingerprint": fingerprint})
    return session.model_copy(update={"video": video, "surface": surface})


def cameras_seen(surface: Surface, place: Path) -> Surface:
    """The same with the fingerprint of its cameras' file, which lies there; a file that cannot be
    read tells nothing new."""
    try:
        content = read_head(place, MOST_CAMERA_BYTES)
    except (OSError, ValueError):  # ValueError: a NUL character in its name
        return surface
    fingerprint = f"sha256:{hashlib.sha256(content).hexdigest()}"
    return surface.model_copy(update={"cameras_fingerprint": fingerprint})


def _film(place: Path, session: Session) -> str | None:
    from tracker.video.fingerprint import fingerprint_of_file

    return fingerprint_of_file(place, session.video.frame_count) if place.is_file() else None


def _surfaces(place: Path, session: Session) -> str | None:
    from tracker.surface.files.sequence import MeshSequence

    if not (place.is_dir() or place.suffix.lower() == ".glb"):
        return None
    try:
        with MeshSequence.open(place) as meshes:
            return meshes.fingerprint()
    except SurfaceError:  # no meshes
        return None


def _nearby(folder: Path, was: Path) -> Iterator[Path]:
    for place in dict.fromkeys((folder, folder.parent, was.parent)):
        try:
            there = [file for file in place.iterdir() if not file.name.lower().endswith(NOT_FILMS)]
        except (OSError, ValueError):  # ValueError: a NUL character in its name
            continue
        # One of the old name first; it is the likeliest.
        yield from sorted(there, key=lambda file: (file.name != was.name, file))[:MOST_FILES]
