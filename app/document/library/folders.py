"""Walking the folders that may be looked into, one at a time."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from keypose.app.document.library.files import (
    MOST_FILES,
    SESSION_FOLDER,
    Found,
    found_at,
    is_hidden,
    is_inside,
    is_listed,
    kind_of,
    kind_of_folder,
    quoted,
    unquoted,
)
from keypose.app.document.library.names import printable
from keypose.tracker.errors import KeyposeError

MOST_PEEKED = 400
"""Entries of a folder inside that are looked at to see what it holds."""

SESSION = "session.json"


@dataclass(frozen=True)
class Place:
    """A folder. `id` is the root's number and the path in it, as of files."""

    id: str
    name: str


@dataclass(frozen=True)
class FolderListing:
    """What one folder holds. way: from its root to itself; empty for the list of roots.
    more: there is more than is listed."""

    way: tuple[Place, ...]
    folders: tuple[Place, ...]
    files: tuple[Found, ...]
    more: bool


def list_folder(id: str, roots: Sequence[Path]) -> FolderListing:
    """One folder of these; the folders themselves for an empty id. KeyposeError when it is not one
    of them or inside one, or is hidden."""
    if not id:
        there = [(number, root) for number, root in enumerate(roots) if root.is_dir()]
        places = (Place(f"{n}/", _root_name(root)) for n, root in there)
        return FolderListing((), tuple(places), (), False)
    number, root, folder = _folder_at(id, roots)
    try:
        names = sorted((path.name for path in folder.iterdir()), key=str.casefold)
    except OSError as problem:
        why = problem.strerror or problem
        raise KeyposeError(f"{printable(folder.name)!r} cannot be looked into: {why}.") from None
    seen = [name for name in names if not name.startswith(".")]
    folders: list[Place] = []
    files: list[Found] = []
    for name in seen[:MOST_FILES]:
        path = folder / name
        if not is_inside(path, roots):
            continue
        if not path.is_dir():
            kind = kind_of(path)
            files.extend(found_at(number, root, path, kind) if kind else ())
        elif is_listed(name) and not path.is_symlink():
            files.extend(_what_it_is(number, root, path))
            if not name.endswith(SESSION_FOLDER):
                folders.append(Place(_id(number, root, path), printable(name)))
    way = _way(number, root, folder)
    return FolderListing(way, tuple(folders), tuple(files), len(seen) > MOST_FILES)


def _folder_at(id: str, roots: Sequence[Path]) -> tuple[int, Path, Path]:
    number, slash, inner = id.partition("/")
    if slash and number.isascii() and number.isdecimal() and len(number) < 6:
        place = unquoted(inner)
        if int(number) < len(roots) and "\0" not in place:
            root = roots[int(number)]
            folder = root / place
            if not is_hidden(place) and is_inside(folder, [root]) and folder.is_dir():
                return int(number), root, folder
    raise KeyposeError("This folder no longer exists.")


def _what_it_is(number: int, root: Path, folder: Path) -> Iterator[Found]:
    """A folder that opens as one thing: a session's own, or images or meshes."""
    if folder.name.endswith(SESSION_FOLDER):
        session = folder / SESSION
        if session.is_file() and kind_of(session) == "session":
            yield from found_at(number, root, session, "session")
        return
    names = []
    try:
        with os.scandir(folder) as entries:
            names = [e.name for _, e in zip(range(MOST_PEEKED), entries, strict=False)]
    except OSError:
        return
    what, count = kind_of_folder([name for name in names if not name.startswith(".")])
    if count > 1:
        yield from found_at(number, root, folder, what, count)


def _way(number: int, root: Path, folder: Path) -> tuple[Place, ...]:
    inner = folder.relative_to(root)
    places = [root, *(root / Path(*inner.parts[: n + 1]) for n in range(len(inner.parts)))]
    names = [_root_name(root), *(printable(part) for part in inner.parts)]
    return tuple(Place(_id(number, root, p), n) for p, n in zip(places, names, strict=True))


def _id(number: int, root: Path, path: Path) -> str:
    inner = path.relative_to(root)
    return f"{number}/{quoted(inner) if inner.parts else ''}"


def _root_name(root: Path) -> str:
    return printable(root.name or str(root))
