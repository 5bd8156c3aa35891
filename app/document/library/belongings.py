"""The files of one session: its own file and what lies beside it. Never a video or a mesh."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path

from keypose.tracker.files import read_regular
from keypose.tracker.storage.files import LARGEST_SESSION_BYTES, journal_path

_NAMED = re.compile(rb"(?:tracks|first|keypoints)-[0-9a-f]{12}\.npz")
"""Files that a session names."""


def belongings(session_path: Path) -> list[Path]:
    """Those that are there, the session's own file first. What another session of the folder names
    as well is that one's."""
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
    found: set[str] = set()
    for file in files:
        with suppress(OSError):
            content = read_regular(file, LARGEST_SESSION_BYTES)
            found.update(name.decode() for name in _NAMED.findall(content))
    return found
