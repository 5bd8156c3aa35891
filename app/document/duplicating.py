"""A copy of a session beside it, for another try on the same video."""

from __future__ import annotations

import shutil
from pathlib import Path

from keypose.app.document.library.belongings import belongings
from keypose.app.document.library.names import numbered, printable
from keypose.app.document.open import with_paths_from
from keypose.tracker.errors import SessionError
from keypose.tracker.storage.atomic import make_folder
from keypose.tracker.storage.files import load_session, save_session


def duplicate_session(path: Path) -> Path:
    """Copy a session with its motion into a new folder beside its own; the new session's path.

    The video stays where it is, and the copy leads to it. Its history begins anew. SessionError
    when there is nothing to copy or the disk refuses.
    """
    session = load_session(path)
    if session.is_newer:
        raise SessionError(f"{path.name} was written by a newer Keypose: duplicate it there.")
    folder = _free_folder(path)
    make_folder(folder, error=SessionError)
    for file in belongings(path):
        if file.suffix == ".npz":
            _copy(file, folder / file.name)
    copied = with_paths_from(session, path, folder)
    title = f"{session.title} copy" if session.title else ""
    save_session(copied.model_copy(update={"title": title[-120:]}), folder / "session.json")
    return folder / "session.json"


def _free_folder(path: Path) -> Path:
    base = path.parent
    name = base.name if path.name == "session.json" else f"{path.stem}.keypose"
    parent = base.parent if path.name == "session.json" else base
    if printable(name) != name or not name:
        raise SessionError(f"{str(path)!r} has a name that cannot be copied: rename its folder.")
    return next(
        parent / one for one in numbered(name) if one != base.name and not (parent / one).exists()
    )


def _copy(source: Path, place: Path) -> None:
    try:
        shutil.copyfile(source, place)
    except OSError as problem:
        why = problem.strerror or problem
        raise SessionError(f"{str(source)!r} cannot be copied: {why}.") from None
