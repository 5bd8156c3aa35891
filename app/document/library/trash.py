"""Sessions that were deleted, kept in the workspace so that they can be put back."""

from __future__ import annotations

import re
import secrets
import shutil
from contextlib import suppress
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from keypose.app.document.folder_lock import NAME as LOCK
from keypose.app.document.folder_lock import locked
from keypose.app.document.library.belongings import belongings
from keypose.tracker.errors import KeyposeError, SessionError
from keypose.tracker.files import read_own
from keypose.tracker.storage.atomic import make_folder, write_file

FOLDER = ".trash"
KEPT_DAYS = 30
"""So long a deleted session can be put back; the next one that is deleted ends older ones."""
_ORIGIN = "origin.json"
_LARGEST_BYTES = 1 << 20
_ID = re.compile(r"[0-9a-f]{16}")


class _Origin(BaseModel):
    """Where the files of one session lay, the session's own first."""

    model_config = ConfigDict(frozen=True)

    folder: str
    names: tuple[str, ...]


class Trash:
    """folder: where deleted sessions lie, each in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def put(self, session_path: Path) -> str:
        """Move a session's files there, never its video; the id by which they come back.

        SessionError when another Keypose has it, or the disk refuses: then all is as it was.
        """
        with locked(session_path, "close it there first"):
            files = belongings(session_path)
            id = secrets.token_hex(8)
            place = self._folder / id
            make_folder(place, error=SessionError)
            origin = _Origin(folder=str(session_path.parent), names=tuple(f.name for f in files))
            write_file(place / _ORIGIN, origin.model_dump_json(indent=1).encode())
            _move([(file, place / file.name) for file in files])
        with suppress(OSError):  # anything else that lies there keeps its folder
            if [f.name for f in session_path.parent.iterdir()] == [LOCK]:
                (session_path.parent / LOCK).unlink()
                session_path.parent.rmdir()
        return id

    def empty_old(self, now_s: float) -> None:
        """Remove for good what has lain there for more than `KEPT_DAYS`; now_s: since 1970.

        What cannot be removed stays, as does all that was not put there by `put`.
        """
        with suppress(OSError):
            for origin in self._folder.glob(f"*/{_ORIGIN}"):
                age_s = now_s - origin.stat().st_mtime
                if _ID.fullmatch(origin.parent.name) and age_s > KEPT_DAYS * 86400:
                    shutil.rmtree(origin.parent, ignore_errors=True)

    def restore(self, id: str) -> Path:
        """Put a session's files back where they lay; its path. KeyposeError when they are gone, or
        something else lies there by now."""
        place = self._folder / id
        try:
            if not _ID.fullmatch(id):
                raise ValueError(id)
            origin = _Origin.model_validate_json(read_own(place / _ORIGIN, _LARGEST_BYTES))
        except (OSError, ValueError, ValidationError):
            raise KeyposeError("This session is not in the trash any more.") from None
        folder = Path(origin.folder)
        names = [name for name in origin.names if Path(name).name == name]
        taken = [name for name in names if (folder / name).exists()]
        if taken:
            raise KeyposeError(
                f"{str(folder / taken[0])!r} is there again: move it away to restore the session."
            )
        make_folder(folder, error=SessionError)
        _move([(place / name, folder / name) for name in names if (place / name).is_file()])
        shutil.rmtree(place, ignore_errors=True)
        return folder / names[0]


def _move(ways: list[tuple[Path, Path]]) -> None:
    """All of them or none; to another disk as well."""
    done: list[tuple[Path, Path]] = []
    try:
        for source, place in ways:
            shutil.move(source, place)
            done.append((source, place))
    except OSError as problem:
        for source, place in reversed(done):
            with suppress(OSError):
                shutil.move(place, source)
        why = problem.strerror or problem
        raise SessionError(f"{str(source)!r} cannot be moved: {why}.") from None
