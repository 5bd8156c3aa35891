"""The library: everything the start screen shows, and the paths behind it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from threading import Lock
from typing import Any, Literal, TypeAlias

from keypose.app.document.library.files import (
    Found,
    file_at,
    find_files,
    is_hidden,
    is_inside,
    kind_of,
    list_folder,
    unquoted,
)
from keypose.app.document.library.names import printable
from keypose.app.document.library.recents import (
    Recent,
    Span,
    forget,
    id_of,
    name_of,
    read_recents,
    remember,
    rename,
    spans_of,
)
from keypose.app.document.library.samples import bundled_samples, own_copy
from keypose.app.document.library.session_files import (
    SESSION,
    TRASH,
    Trash,
    duplicate_session,
    rename_session,
    session_for,
)
from keypose.app.document.library.thumbnails import ThumbCache, of_session
from keypose.app.document.library.uploads import LARGEST_BYTES, Upload
from keypose.tracker.errors import KeyposeError, SessionError
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.video.container import SUFFIXES
from keypose.tracker.video.fingerprint import fingerprint_of_file

Kind: TypeAlias = Literal["recent", "file", "sample", "upload"]

SAMPLE_FOLDER = Path(__file__).resolve().parents[3] / "sample_videos"
_SAMPLE_THUMB = "sample-"


class Library:
    """Sessions, videos and samples of one person.

    workspace: Keypose's own folder: recents, copies of samples, uploads, and the sessions of
               videos whose folders cannot be written to. Made when it is needed.
    roots:     the folders whose files may be listed and opened; the uploads are always among them.
    """

    def __init__(
        self,
        workspace: Path,
        roots: Sequence[Path] = (),
        *,
        samples: Path = SAMPLE_FOLDER,
        largest_upload: int = LARGEST_BYTES,
    ) -> None:
        self.workspace = workspace.absolute()
        self.uploads = self.workspace / "videos"
        self.roots = (*(root.absolute() for root in roots), self.uploads)
        self._samples = samples
        self._largest = largest_upload
        self._book = self.workspace / "recents.json"
        self._thumbs = ThumbCache(self.workspace / "thumbs")
        self._trash = Trash(self.workspace / TRASH)
        self._writing = Lock()
        self._visited: dict[str, Path] = {}

    # --- what there is

    def contents(self) -> dict[str, Any]:
        """All of it as the page wants it; looks into folders, so call it in a thread."""
        listing = find_files(self.roots)
        return {
            "recents": [_recent_json(recent) for recent in self.recents()],
            "samples": [
                {"id": s.name, "words": s.words, "thumb": f"/thumb/{_SAMPLE_THUMB}{s.name}.jpg"}
                for s in bundled_samples(self._samples)
            ],
            "files": [_file_json(f) for f in listing.files],
            "more": listing.more,
            "folders": [printable(str(root)) for root in self.roots if root.is_dir()],
            "suffixes": [*SUFFIXES],
            "largest_upload": self._largest,
        }

    def folder(self, id: str) -> dict[str, Any]:
        """What one folder holds, by its id, as the page wants it; the folders that may be
        looked into for an empty one. KeyposeError when it is none of them.
        """
        listing = list_folder(id, self.roots)
        return {
            "way": [asdict(place) for place in listing.way],
            "folders": [asdict(place) for place in listing.folders],
            "files": [_file_json(f) for f in listing.files],
            "more": listing.more,
        }

    def recents(self) -> list[Recent]:
        """Sessions opened lately whose files are still there, the newest first."""
        return [recent for recent in read_recents(self._book) if recent.is_there]

    def remember(
        self,
        path: Path,
        session: Session,
        spans: Sequence[Span] | None = None,
        source: Path | None = None,
    ) -> None:
        """Put a session first among the recent ones.

        spans: the segments as they stand; left out, they are read from the session.
        source: what it was begun from, where nothing of it is saved yet.
        KeyposeError in one sentence when the disk refuses: no reason to stop.
        """
        if printable(str(path)) != str(path):
            return  # a name that is no text cannot be written down
        segments = spans_of(session) if spans is None else spans
        with self._writing:
            remember(self._book, Recent.of(path, session, segments, time.time(), source))

    def visit(self, session_path: Path, source: Path, session: Session) -> None:
        """A session was opened, from its own file or from a video whose session is not saved yet.
        It is found again as a recent one; KeyposeError where the disk refuses to keep that."""
        self._visited[id_of(str(session_path.absolute()))] = source
        self.remember(session_path, session, source=None if session_path.is_file() else source)

    def forget(self, id: str) -> None:
        """Leave a session out of the recent ones; its files stay."""
        with self._writing:
            forget(self._book, id)

    # --- what a person does with sessions that are not open

    def rename(self, id: str, title: str) -> None:
        """Call a session something else; KeyposeError when it cannot be changed."""
        path = self._saved(id)
        session = rename_session(path, " ".join(title.split()))
        with self._writing:
            rename(self._book, id, name_of(path, session.title))

    def duplicate(self, id: str) -> tuple[str, str]:
        """Copy a session beside itself, without its video; the copy's id and name."""
        path = duplicate_session(self._saved(id))
        session = load_session(path)
        self.remember(path, session)
        return id_of(str(path.absolute())), name_of(path, session.title)

    def delete(self, id: str) -> tuple[str, str]:
        """Move a session to the trash, without its video; its id there, and its name.

        What lies there for too long is gone for good then.
        """
        path = self._saved(id)
        name = next(
            (recent.name for recent in self.recents() if recent.id == id), name_of(path, "")
        )
        in_trash = self._trash.put(path)
        self._visited.pop(id, None)
        self.forget(id)
        return in_trash, name

    def restore(self, id: str) -> tuple[str, str]:
        """Put a session of the trash back where it lay; its id and name."""
        path = self._trash.restore(id)
        session = load_session(path)
        self.remember(path, session)
        return id_of(str(path.absolute())), name_of(path, session.title)

    # --- the paths behind it

    def find(self, kind: Kind, id: str, video: str | None = None) -> Path:
        """The session file or video to open; KeyposeError in one sentence when there is none.

        video: for a recent session whose video was moved: the id of the file it is now.
        """
        if kind == "sample":
            return own_copy(self._samples, id, self.workspace)
        if kind == "upload":
            return self._uploaded_path(id)
        if kind == "file":
            return file_at(id, self.roots)
        path = self._recent(id)
        if video is not None:
            self._move_video(path, self.find("file", video))
        return path

    def session_for(self, video: Path) -> Path:
        """Where the session of a video lives; the file may not exist yet."""
        return session_for(video, self.workspace)

    def _saved(self, id: str) -> Path:
        """The file of a recent session; KeyposeError where it has none yet."""
        path = self._recent(id)
        if not _is_saved(path):
            raise KeyposeError("Nothing of this session is saved yet. Open it and pose a frame.")
        return path

    def _recent(self, id: str) -> Path:
        """What to open: a session's file, or what it was begun from."""
        for recent in self.recents():
            if recent.id == id:
                return Path(recent.path) if Path(recent.path).is_file() else Path(recent.source)
        source = self._visited.get(id)
        if source is not None and source.exists():
            return source
        raise KeyposeError("This session no longer exists.")

    def _uploaded_path(self, id: str) -> Path:
        path = self.uploads / id
        is_plain = "\0" not in id and path.parent == self.uploads and path.name == id
        if is_plain and is_inside(path, [self.uploads]) and path.is_file():
            return path
        raise KeyposeError("This video no longer exists.")

    def _move_video(self, path: Path, video: Path) -> None:
        """Let a session name its video's new place, if that is the same video."""
        session = load_session(path)
        reference = session.view.video.model_copy(update={"path": str(video.absolute())})
        moved = session.changed({"video": reference})
        try:
            open_video_of(moved, path).close()
        except SessionError:
            raise SessionError(
                f"{video.name} is another video. {path.parent.name} was posed on "
                f"{reference.frame_count} frames, {reference.width}×{reference.height}."
            ) from None
        save_session(moved, path)

    # --- uploads

    def upload(self, name: str, size: int | None) -> Upload:
        """Begin an upload into the workspace; see Upload."""
        return Upload(self.uploads, name, size, self._largest)

    def discard(self, id: str) -> None:
        """Remove an upload that turned out to be no video."""
        with suppress(KeyposeError, OSError):
            self._uploaded_path(id).unlink()

    # --- pictures

    def thumb(self, id: str) -> bytes | None:
        """The JPEG behind /thumb/{id}.jpg, None when there is none; decodes, so use a thread."""
        behind_thumb = self._behind_thumb(id)
        if behind_thumb is None:
            return None
        if not _is_saved(behind_thumb):
            with suppress(OSError):
                return self._thumbs.of_file(behind_thumb)
            return None
        return self._thumbs.get(id, lambda: of_session(behind_thumb))

    def file_thumb(self, id: str) -> bytes | None:
        """A small JPEG of a file of the folders: its first picture. None when there is none;
        decodes, so use a thread."""
        try:
            path = file_at(id, self.roots)
            if is_hidden(unquoted(id.partition("/")[2])) or not (path.is_dir() or kind_of(path)):
                return None
            return self._thumbs.of_file(path)
        except (KeyposeError, OSError):
            return None

    def _behind_thumb(self, id: str) -> Path | None:
        """What a picture is of; ids come from a page, so only known ones lead to a file."""
        for sample in bundled_samples(self._samples):
            if id == _SAMPLE_THUMB + sample.name:
                return self._samples / sample.name / SESSION
        return next((self._recent(r.id) for r in self.recents() if _thumb_id(r) == id), None)


def _is_saved(path: Path) -> bool:
    """Whether it is a session's own file, not what one was begun from."""
    return path.suffix == ".json"


def _file_json(f: Found) -> dict[str, Any]:
    return {
        **{"id": f.id, "kind": f.kind, "name": f.name, "folder": f.folder},
        **{"bytes": f.bytes, "count": f.count, "modified_at": f.modified_s},
    }


def _thumb_id(recent: Recent) -> str:
    """Another middle keyframe makes another picture, so browsers may keep each for ever."""
    return f"{recent.id}-{recent.middle_frame}"


def _recent_json(recent: Recent) -> dict[str, Any]:
    exchanged = _was_replaced(recent)
    return {
        "id": recent.id,
        "name": printable(recent.name),
        "path": printable(recent.path),
        "video": printable(Path(recent.video).name),
        "keyframes": recent.keyframes,
        "frames": recent.frames,
        "strip": [list(run) for run in recent.strip],
        "opened_at": recent.opened_at,
        "thumb": f"/thumb/{_thumb_id(recent)}.jpg",
        "missing": exchanged or not Path(recent.video).exists(),
        "exchanged": exchanged,
    }


def _was_replaced(recent: Recent) -> bool:
    """Whether another video lies where the session's was."""
    video = Path(recent.video)
    try:
        if not recent.fingerprint or not video.is_file():
            return False
        return fingerprint_of_file(video, recent.frames) != recent.fingerprint
    except (OSError, ValueError):
        return False
