"""Say where the session of a video lives; rename, duplicate and delete one that is not open.

A video or a mesh is never touched. Deleted sessions lie in the workspace's trash, from where they
can be put back.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import from_json

from keypose.app.document.folder_lock import NAME as LOCK
from keypose.app.document.folder_lock import locked
from keypose.app.document.library.files import SESSION_FOLDER
from keypose.app.document.library.names import numbered, printable
from keypose.app.document.open import with_paths_from
from keypose.tracker.errors import KeyposeError, SessionError
from keypose.tracker.files import read_own, read_regular
from keypose.tracker.session.migrate import migrate
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.atomic import make_folder, require_folder, write_file
from keypose.tracker.storage.edit_history import edit_record, mark_of, saved_record, whole_record
from keypose.tracker.storage.files import (
    LARGEST_SESSION_BYTES,
    journal_path,
    load_session,
    open_session,
    save_session,
)
from keypose.tracker.storage.journal import Journal

SESSION = "session.json"

USUAL = ("Videos", "Movies", "Downloads", "Desktop")
"""Folders of a home where people keep films."""


def usual_folders(home: Path) -> list[Path]:
    """List the usual folders that there are."""
    return [home / name for name in USUAL if (home / name).is_dir()]


def session_for(video: Path, workspace: Path) -> Path:
    """`jump.keypose/session.json` beside jump.mp4; in the workspace where nothing can be written
    there. Another video's session of that name is left alone: then it is `jump 2.keypose`.

    Nothing is made: the path may not exist yet.
    """
    video = video.absolute()
    beside, ours = session_in(video.parent, video), session_in(workspace, video)
    for place in (beside, ours):
        if place.exists():
            return place
    return beside if _is_writable(video.parent) else ours


def session_in(folder: Path, video: Path) -> Path:
    """A video's session in a folder: its own, or the first that is free; it may not exist yet."""
    for name in numbered(session_name(video)):
        place = folder / name / SESSION
        if not place.exists() or _is_about(place, video):
            return place
    raise AssertionError("names never end")


def session_name(video: Path) -> str:
    """What the folder of a video's session is called: `jump.keypose`."""
    stem = video.name if video.is_dir() else video.stem
    return f"{stem}{SESSION_FOLDER}"


def _is_about(session: Path, video: Path) -> bool:
    """A file that cannot be read counts: opening it reports what is wrong with it."""
    try:
        data = migrate(from_json(read_regular(session, LARGEST_SESSION_BYTES)), session.name)
        path = str(data["views"][0]["video"]["path"])
        return os.path.realpath(session.parent / path) == os.path.realpath(video)
    except (OSError, ValueError, LookupError, TypeError, SessionError):
        return True


def _is_writable(folder: Path) -> bool:
    try:
        require_folder(folder, error=KeyposeError)
    except KeyposeError:
        return False
    return True


STEP = "rename"
"""What undo calls it."""
TRASH = ".trash"
_ORIGIN = "origin.json"
_LARGEST_BYTES = 1 << 20
"""Of what the trash knows of where a session came from."""
_ID = re.compile(r"[0-9a-f]{16}")
_NAMED = re.compile(rb"(?:tracks|first|keypoints)-[0-9a-f]{12}\.npz")
"""Files that a session names."""


def session_files(session_path: Path) -> list[Path]:
    """List the session's files that are there, its own first. What another session of the folder
    names as well is that one's.
    """
    folder, stem = session_path.parent, re.escape(session_path.stem)
    own = re.compile(
        rf"{re.escape(session_path.name)}(\.previous|\.v\d+)?"
        rf"|{re.escape(journal_path(session_path).name)}(\.previous)?"
        rf"|{stem}\.theirs-[0-9a-f]{{8}}\.json"
    )
    files = sorted(f for f in folder.iterdir() if f.is_file() and not f.is_symlink())
    mine = [f for f in files if own.fullmatch(f.name)]
    theirs = [f for f in files if f not in mine and ".json" in f.name]
    named = _named_in(mine) - _named_in(theirs)
    if not theirs:  # tracked motion of steps that could be undone is named by none of them
        named |= {f.name for f in files if _NAMED.fullmatch(f.name.encode())}
    beside = [f for f in files if f.name in named]
    return sorted([*mine, *beside], key=lambda f: (f != session_path, f.name))


def _named_in(files: list[Path]) -> set[str]:
    files_named: set[str] = set()
    for file in files:
        with suppress(OSError):
            content = read_regular(file, LARGEST_SESSION_BYTES)
            files_named.update(name.decode() for name in _NAMED.findall(content))
    return files_named


# --- rename


def rename_session(path: Path, title: str) -> Session:
    """Write another title into a session file and its journal; the session as it is then.

    SessionError when another Keypose has it, a newer one wrote it, or the disk refuses.
    """
    with locked(path, "close it there first"):
        opened = open_session(path)
        if opened.session.is_newer:
            raise SessionError(f"{path.name} was written by a newer Keypose: rename it there.")
        renamed = opened.session.changed({"title": title})
        if title == opened.session.title:
            return renamed
        before = opened.recovered.moment
        after = replace(
            before,
            doc=before.doc.changed({"title": title}),
            history=before.history.after(before.doc, STEP, before.frame),
            received=replace(before.received, revision=""),
        )
        follows = opened.recovered.follows and opened.journal.whole
        size = opened.journal.size if follows else 0
        with closing(Journal(journal_path(path), size)) as journal:
            if follows:
                journal.append([edit_record(before, after)])
            else:
                journal.begin_anew(whole_record(after), keep_previous=True)
            save_session(renamed, path)
            journal.append([saved_record(mark_of(renamed))], durable=False)
        return renamed


# --- duplicate


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
    for file in session_files(path):
        if file.suffix == ".npz":
            _copy(file, folder / file.name)
    copied = with_paths_from(session, path, folder)
    title = f"{session.title} copy" if session.title else ""
    save_session(copied.changed({"title": title[-120:]}), folder / "session.json")
    return folder / "session.json"


def _free_folder(path: Path) -> Path:
    base = path.parent
    name = base.name if path.name == "session.json" else f"{path.stem}.keypose"
    parent = base.parent if path.name == "session.json" else base
    if printable(name) != name or not name:
        raise SessionError(f"{str(path)!r} has a name that cannot be copied: rename its folder.")
    return next(
        parent / free_name
        for free_name in numbered(name)
        if free_name != base.name and not (parent / free_name).exists()
    )


def _copy(source: Path, place: Path) -> None:
    try:
        shutil.copyfile(source, place)
    except OSError as problem:
        why = problem.strerror or problem
        raise SessionError(f"{str(source)!r} cannot be copied: {why}.") from None


# --- delete


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
            files = session_files(session_path)
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
