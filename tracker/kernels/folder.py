"""Where the compiled loops are kept between runs. What lies there is executed."""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

NEEDED_BYTES: Final = 64 * 2**20
"""All loops of one version take 48 MB."""
MOST_VERSIONS: Final = 8
"""Of the usual folder; beyond so many, those used longest ago are removed."""
MARKS: Final = "warm*"
"""Files that `keypose.tracker.warm` leaves once all loops are there."""


@dataclass(frozen=True)
class LoopFolder:
    """path: the folder; None where they cannot be kept, and are compiled in every process.
    problem: why, as a part of a sentence."""

    path: Path | None
    problem: str = ""


def loop_folder(version: str, chosen: str = "") -> LoopFolder:
    """The folder for loops of this version.

    chosen: where a person wants all versions instead. None where it cannot be had, or others could
    put something into it.
    """
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    versions = Path(chosen) if chosen else home / "keypose" / "kernels"
    place = versions / version
    try:
        place.mkdir(parents=True, exist_ok=True, mode=0o700)
        above = [] if chosen else [versions.parent, home]
        if not _is_own(place) or not all(map(_is_guarded, (versions, *above))):
            raise OSError(f"others may write to {place}")
        _require_room(place)
    except OSError as error:
        why = f"{place} cannot be written to: {error.strerror}" if error.strerror else str(error)
        return LoopFolder(None, why)
    if not chosen:  # which may hold what is no loop of ours
        _tidy(place)
    return LoopFolder(place)


def _is_own(folder: Path) -> bool:
    """Whether this user alone can write to it; as the system says where it is not POSIX."""
    facts = folder.lstat()
    if os.name != "posix":
        return stat.S_ISDIR(facts.st_mode)
    mine = facts.st_uid == os.getuid()
    return stat.S_ISDIR(facts.st_mode) and mine and not facts.st_mode & 0o022


def _is_guarded(folder: Path) -> bool:
    """Whether what this user has in a folder cannot be exchanged by others."""
    if os.name != "posix":
        return True
    facts = folder.stat()
    for_all = facts.st_mode & 0o002 and not facts.st_mode & stat.S_ISVTX
    return facts.st_uid in (0, os.getuid()) and not for_all


def _require_room(folder: Path) -> None:
    """OSError unless the loops fit there, or are there already. Only writing shows it: a quota or
    a full disk still lets files be made."""
    bytes_left = 0 if any(folder.glob(MARKS)) else NEEDED_BYTES
    piece = os.urandom(2**20)  # which no disk can pack
    with tempfile.TemporaryFile(dir=folder) as probe:
        for _ in range(0, bytes_left, len(piece)):
            probe.write(piece)


def _tidy(place: Path) -> None:
    """Remove folders of other versions, beyond so many."""
    with suppress(OSError):  # what is left over does no harm
        os.utime(place)  # used now
        others = [folder for folder in place.parent.iterdir() if folder != place]
        others.sort(key=lambda folder: folder.stat().st_mtime, reverse=True)
        for folder in others[MOST_VERSIONS - 1 :]:
            shutil.rmtree(folder, ignore_errors=True)
