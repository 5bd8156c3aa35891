"""The operations on files that every kind of evidence provides, for a film and for surfaces."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from keypose.tracker.errors import SessionError, SurfaceError
from keypose.tracker.files import read_head
from keypose.tracker.session.evidence import surface_of
from keypose.tracker.session.references import Surface
from keypose.tracker.session.schema import Session

if TYPE_CHECKING:
    from keypose.tracker.surface.picture import SurfaceVideo
    from keypose.tracker.video import Video


class EvidenceFiles(Protocol):
    """Operations on the files of a session's evidence at `path`; `folder` is that of the session's
    file."""

    def open(self, session: Session, path: Path, folder: Path) -> Video:
        """Its pictures. VideoError or SurfaceError in one sentence when it cannot be read."""
        ...

    def open_for_work(self, session: Session, path: Path, folder: Path) -> Video:
        """The same for work on the session, which keeps no more decoded pictures than it needs."""
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
        stat = path.stat()
    except OSError:  # opening it will report what is wrong
        return path, None
    return path, stat.st_dev, stat.st_ino, stat.st_size, stat.st_mtime_ns


class FilmFiles:
    """A film is recognised by its content: another one is never taken for it."""

    def open(self, session: Session, path: Path, folder: Path) -> Video:
        from keypose.tracker.video import Video  # the decoder loads only when needed

        return Video.open(path, deinterlace=session.view.video.deinterlace)

    def open_for_work(self, session: Session, path: Path, folder: Path) -> Video:
        from keypose.tracker.video import READ_ONCE_BYTES, Video

        return Video.open(path, READ_ONCE_BYTES, deinterlace=session.view.video.deinterlace)

    def fingerprint_at(self, session: Session, path: Path) -> str | None:
        from keypose.tracker.video.fingerprint import fingerprint_of_file

        return fingerprint_of_file(path, session.view.video.frame_count) if path.is_file() else None

    def state(self, session: Session, path: Path, folder: Path) -> tuple[Any, ...]:
        return identity(path), session.view.video.deinterlace

    def refresh_fingerprints(self, session: Session, folder: Path, video: Video) -> Session:
        return session


MOST_CAMERA_BYTES = 4 * 2**20
"""A longer file is no file of cameras, and the reader refuses it."""


class SurfaceFiles:
    """Meshes and cameras may have been exported again: their present fingerprints count."""

    def open(self, session: Session, path: Path, folder: Path) -> Video:
        from keypose.tracker.surface.picture import open_surfaces  # loads only when needed

        return open_surfaces(session, path, folder)

    open_for_work = open

    def fingerprint_at(self, session: Session, path: Path) -> str | None:
        from keypose.tracker.surface.files.sequence import MeshSequence

        if not path.is_dir():
            return None
        try:
            with MeshSequence.open(path) as meshes:
                return meshes.fingerprint()
        except SurfaceError:  # no meshes
            return None

    def state(self, session: Session, path: Path, folder: Path) -> tuple[Any, ...]:
        surface = surface_of(session)
        cameras = None if surface.cameras is None else identity(folder / surface.cameras)
        read_as = (surface.units, surface.up, surface.p_camera_surface)
        return (identity(path), *read_as, cameras, _identities(path))

    def refresh_fingerprints(self, session: Session, folder: Path, video: Video) -> Session:
        surface, fingerprint = surface_of(session), video.fingerprint()
        if surface.cameras is not None:
            surface = with_cameras_fingerprint(surface, folder / surface.cameras)
        if (fingerprint, surface) == (session.view.video.fingerprint, session.view.surface):
            return session
        meshes = session.view.video.model_copy(update={"fingerprint": fingerprint})
        return session.changed({"video": meshes, "surface": surface})


def surfaces_of(video: Video) -> SurfaceVideo:
    """The pictures of a session's surfaces, as `open_video_of` opens them, with the surfaces
    themselves; SessionError where it is a film."""
    from keypose.tracker.surface.picture import SurfaceVideo  # a film does without

    if not isinstance(video, SurfaceVideo):
        raise SessionError("The session is about surfaces: open them with open_video_of.")
    return video


def with_cameras_fingerprint(surface: Surface, place: Path) -> Surface:
    """The same with the fingerprint of its cameras' file at `place`; unchanged where that cannot be
    read."""
    try:
        content = read_head(place, MOST_CAMERA_BYTES)
    except (OSError, ValueError):  # ValueError: a NUL character in its name
        return surface
    fingerprint = f"sha256:{hashlib.sha256(content).hexdigest()}"
    return surface.model_copy(update={"cameras_fingerprint": fingerprint})


def _identities(folder: Path) -> tuple[Any, ...]:
    """Equal as long as a folder has the same meshes: overwriting one does not change the folder."""
    from keypose.tracker.surface.files.sources import SUFFIXES

    try:
        files = [file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES]
    except OSError:  # opening it will report what is wrong
        return ()
    return tuple(identity(file) for file in sorted(files))
