"""Which sessions are meant by the paths a person names."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from keypose.app.document.library.files import is_session
from keypose.tracker.errors import SessionError

SESSION = "session.json"


def find_sessions(paths: Sequence[Path]) -> tuple[Path, ...]:
    """The session files, absolute, each once, in the order they were named; a folder's by name.

    A file stands for itself, a folder for all sessions in it and below, without hidden files and
    folders, links, and the copies that `set_aside` makes of what another program wrote.
    SessionError when a path is not there or a folder has none.
    """
    session_of_path: dict[str, Path] = {}
    for path in paths:
        for session in _meant(path):
            real = os.path.realpath(session)
            session_of_path.setdefault(
                real, Path(real) if session.is_symlink() else session.absolute()
            )
    return tuple(session_of_path.values())


def common_folder(sessions: Sequence[Path]) -> Path:
    """The deepest folder that holds all of them; SessionError where they lie on several drives."""
    try:
        return Path(os.path.commonpath([session.parent for session in sessions]))
    except ValueError:
        raise SessionError("The sessions lie on different drives: add --out DIR.") from None


def name_of(session: Path, folder: Path) -> str:
    """What a session is called in a list of those in a folder; no two have the same name."""
    place = session.relative_to(folder)
    if place.name != SESSION:
        return place.as_posix()
    return place.parent.as_posix() if place.parent.name else folder.name or SESSION


def _meant(path: Path) -> list[Path]:
    if path.is_dir():
        sessions = list(_below(path))
        if not sessions:
            raise SessionError(f"There is no session in the folder {str(path)!r}.")
        return sessions
    if not path.exists():
        raise SessionError(f"There is no session file {str(path)!r}.")
    return [path]


def _below(folder: Path) -> Iterator[Path]:
    for here, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(names):
            path = Path(here) / name
            is_shown = not name.startswith(".") and name.lower().endswith(".json")
            if is_shown and not path.is_symlink() and is_session(path):
                yield path
