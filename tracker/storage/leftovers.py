"""Unfinished files of writers that were killed."""

from __future__ import annotations

import os
import re
import time
from contextlib import suppress
from pathlib import Path

OLD_SECONDS = 3600.0
"""A film or an export that is still being written has been written to since."""

_PART = re.compile(r"\.(?:(?P<name>.+)\.)?[0-9a-f]{12}\.part", re.DOTALL)
_OF_SESSION = re.compile(
    r"journal\.jsonl|.+\.journal\.jsonl|.+\.json(\.previous|\.v\d+)?|(tracks|first|keypoints)-[0-9a-f]{12}\.npz"
)
"""Files that only the holder of the session's lock writes."""


def sweep(folder: Path, *, is_locked: bool = False, old_seconds: float = OLD_SECONDS) -> None:
    """Remove the unfinished files of writers that are gone: regular files with exactly such a
    name as Keypose gives them, that are old. Links are neither followed nor removed.

    is_locked: the caller holds the session's lock, so that nobody is writing the session's own
    files; these go however young they are.
    """
    with suppress(OSError):  # a folder that cannot be listed keeps what it has
        with os.scandir(folder) as entries:
            found = [entry for entry in entries if _PART.fullmatch(entry.name)]
        for entry in found:
            with suppress(OSError):  # gone already, or not ours to remove
                if _is_left(entry, is_locked, old_seconds):
                    Path(entry.path).unlink()


def _is_left(entry: os.DirEntry[str], is_locked: bool, old_seconds: float) -> bool:
    if not entry.is_file(follow_symlinks=False):
        return False
    match = _PART.fullmatch(entry.name)
    name = match["name"] if match else None
    if is_locked and name is not None and _OF_SESSION.fullmatch(name):
        return True
    return time.time() - entry.stat(follow_symlinks=False).st_mtime > old_seconds
