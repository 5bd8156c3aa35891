"""The small pictures of files that are kept: those seen lately."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

FILE_THUMB = "file-"
"""How their names begin; those of sessions stay."""

MOST = 500


def tidy_thumbs(folder: Path) -> None:
    """Remove the oldest pictures of files beyond so many."""
    with suppress(OSError):  # what is left over does no harm
        kept = sorted(folder.glob(f"{FILE_THUMB}*.jpg"), key=lambda f: -f.stat().st_mtime)
        for old in kept[MOST:]:
            old.unlink()
