"""Walk the folders that may be looked into: videos, surfaces, sessions, folders of images."""

from __future__ import annotations

import json
import os
import re
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal, TypeAlias
from urllib.parse import quote_from_bytes, unquote_to_bytes

from keypose.app.document.library.names import printable
from keypose.tracker.errors import KeyposeError
from keypose.tracker.files import read_head
from keypose.tracker.surface.files.sources import SUFFIXES as MESHES
from keypose.tracker.surface.source import are_meshes
from keypose.tracker.video.container import SUFFIXES
from keypose.tracker.video.folder import SUFFIXES as IMAGES

Kind: TypeAlias = Literal["video", "images", "meshes", "session"]

MOST_FILES = 2000
MOST_ENTRIES = 20_000
DEEPEST = 6
LONGEST_SECONDS = 3.0
"""A folder may be the whole of a slow disk: what was found by then is shown."""

MADE_BY_TOOLS: Final = ("node_modules", "__pycache__", ".egg-info")
"""How folders are called that lie beside a program's source."""

SESSION_FOLDER = ".keypose"
_HEAD_BYTES = 512
"""Of a file, by which its kind is told."""
_PACKETS = ((0, 188), (4, 192))
"""Of a transport stream: where the first one begins, and how far it is to the next."""

_ALSO_CODE = (".ts", ".mts")
"""Endings that TypeScript has, too."""

_TITLE = re.compile(rb'"title": ("(?:[^"\\]|\\.)*")')
"""What a person calls a session; it stands at the beginning of its file."""

_SET_ASIDE = re.compile(r"\.theirs-[0-9a-f]{8}\.json$")
"""The name of what another program wrote into a session, kept beside it."""


@dataclass(frozen=True)
class Found:
    """Something that can be opened. `id` is its place: the root's number and the path in it."""

    id: str
    kind: Kind
    name: str
    folder: str
    bytes: int
    count: int  # of images or meshes in a folder of them
    modified_s: float


@dataclass(frozen=True)
class Listing:
    """What was found, by folder and name; `more`: the search ended before everything was seen."""

    files: tuple[Found, ...]
    more: bool


def find_files(roots: Sequence[Path]) -> Listing:
    """Everything that can be opened in these folders and those inside them; hidden ones and those
    that tools make are not looked into, links to folders not followed, links to files that lie
    outside left out."""
    entry_of_path: dict[Path, Found] = {}
    left = _Budget()
    for number, root in enumerate(roots):
        for folder, folders, names in os.walk(root):
            here = Path(folder)
            folders[:] = sorted(name for name in folders if is_listed(name))
            if len(here.relative_to(root).parts) >= DEEPEST:
                folders.clear()
            if not left.spend(len(folders) + len(names)) or len(entry_of_path) >= MOST_FILES:
                return Listing(_sorted(entry_of_path), more=True)
            for entry in _in_folder(number, root, here, names):
                path = root / unquoted(entry.id.partition("/")[2])
                if is_inside(path, roots):
                    entry_of_path.setdefault(path.resolve(), entry)
    return Listing(_sorted(entry_of_path), more=False)


def file_at(id: str, roots: Sequence[Path]) -> Path:
    """The path behind an id; KeyposeError when it is not in one of the folders."""
    number, _, inner = id.partition("/")
    if len(number) < 6 and number.isascii() and number.isdecimal() and int(number) < len(roots):
        place = unquoted(inner)
        if place and "\0" not in place:
            path = roots[int(number)] / place
            if is_inside(path, roots):
                return path
    raise KeyposeError("This file no longer exists.")


def is_inside(path: Path, roots: Sequence[Path]) -> bool:
    """Whether it is there, in one of the folders once all links are followed."""
    try:
        real = path.resolve(strict=True)
        return any(real.is_relative_to(root.resolve()) for root in roots)
    except (OSError, RuntimeError, ValueError):  # a ring of links, a name no file can have
        return False


def is_listed(name: str) -> bool:
    """Whether a folder may hold what somebody looks for."""
    return not name.startswith(".") and not name.endswith(MADE_BY_TOOLS)


def is_hidden(place: str) -> bool:
    """Whether a part of a relative path is hidden, or leads upward."""
    return any(part.startswith(".") for part in Path(place).parts)


def quoted(path: Path) -> str:
    """A relative path as text that survives every transport, whatever bytes its names have."""
    return quote_from_bytes(os.fsencode(path.as_posix()))


def unquoted(text: str) -> str:
    """The path that was quoted."""
    return os.fsdecode(unquote_to_bytes(text))


class _Budget:
    """How much may still be looked at."""

    def __init__(self) -> None:
        self._entries = MOST_ENTRIES
        self._until = time.monotonic() + LONGEST_SECONDS

    def spend(self, entries: int) -> bool:
        self._entries -= entries
        return self._entries >= 0 and time.monotonic() < self._until


def _in_folder(number: int, root: Path, here: Path, names: Sequence[str]) -> Iterator[Found]:
    shown_names = [name for name in names if not name.startswith(".")]
    for name in shown_names:
        kind = kind_of(here / name)
        if kind is not None:
            yield from found_at(number, root, here / name, kind)
    if here != root:
        folder_kind, count = kind_of_folder(shown_names)
        if count > 1:
            yield from found_at(number, root, here, folder_kind, count)


def kind_of_folder(names: Sequence[str]) -> tuple[Kind, int]:
    """What a folder with files of these names opens as, and how many of them there are."""
    kind: Kind = "meshes" if are_meshes(names) else "images"
    suffixes = MESHES if kind == "meshes" else IMAGES
    return kind, sum(name.lower().endswith(suffixes) for name in names)


def kind_of(path: Path) -> Kind | None:
    """What a file opens as; None for what is not opened."""
    suffix = path.suffix.lower()
    if suffix in SUFFIXES:
        return "video" if suffix not in _ALSO_CODE or _is_transport_stream(path) else None
    return "session" if suffix == ".json" and is_session(path) else None


def is_session(path: Path) -> bool:
    """Recognised by its first bytes: a folder may hold many large files of other kinds.

    A version that was set aside is no session of its own.
    """
    if _SET_ASIDE.search(path.name):
        return False
    head = _head(path)
    return b'"schema_version"' in head and b'"video"' in head


def _title(path: Path) -> str:
    match = _TITLE.search(_head(path))
    try:
        return str(json.loads(match[1])) if match else ""
    except ValueError:
        return ""


def _is_transport_stream(path: Path) -> bool:
    """Known by the byte that begins each of its packets, which a recorder's clock may precede."""
    head = _head(path)
    return any(head[at : at + 1] == head[at + size :][:1] == b"G" for at, size in _PACKETS)


def _head(path: Path) -> bytes:
    """The first bytes of a file; none where it cannot be read."""
    try:
        return read_head(path, _HEAD_BYTES)
    except OSError:
        return b""


def found_at(number: int, root: Path, path: Path, kind: Kind, count: int = 0) -> Iterator[Found]:
    """What lies there, of the root of this number; nothing for a link to nowhere."""
    try:
        facts = path.stat()
    except OSError:  # a link to nowhere
        return
    place = path.relative_to(root)
    name, folder = path.name, path.parent
    if kind == "session" and name == "session.json" and path.parent != root:
        name, folder = path.parent.name.removesuffix(SESSION_FOLDER), path.parent.parent
    if kind == "session":
        name = _title(path) or name
    yield Found(
        id=f"{number}/{quoted(place)}",
        kind=kind,
        name=printable(name),
        folder=printable(str(folder)),
        bytes=facts.st_size,
        count=count,
        modified_s=facts.st_mtime,
    )


def _sorted(entry_of_path: dict[Path, Found]) -> tuple[Found, ...]:
    """The roots in their order; in each the folders, and the files in them, by name."""

    def key(entry: Found) -> tuple[int, str, str]:
        return int(entry.id.partition("/")[0]), entry.folder, entry.name.casefold()

    return tuple(sorted(entry_of_path.values(), key=key))


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
    shown_names = [name for name in names if not name.startswith(".")]
    folders: list[Place] = []
    files: list[Found] = []
    for name in shown_names[:MOST_FILES]:
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
    place_path = _way(number, root, folder)
    return FolderListing(place_path, tuple(folders), tuple(files), len(shown_names) > MOST_FILES)


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
    kind, count = kind_of_folder([name for name in names if not name.startswith(".")])
    if count > 1:
        yield from found_at(number, root, folder, kind, count)


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
