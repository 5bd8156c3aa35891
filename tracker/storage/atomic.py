"""Write files that are either the old one or the new one, whole; remove what was left unfinished.

A file is written beside its place, forced to the disk, and put there by one rename, which is
forced to the disk as well.
"""

from __future__ import annotations

import os
import re
import secrets
import stat
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from keypose.tracker.errors import FormatError, KeyposeError

_USUAL = 0o666
_PRIVATE = 0o600
"""Modes of new files, less what the umask takes away."""


def write_file(
    path: Path,
    content: bytes,
    *,
    overwrite: bool = False,
    keep_previous: bool = False,
    private: bool = False,
    error: type[KeyposeError] = FormatError,
) -> None:
    """Put the bytes at the path. Where a link is there, it is replaced; what it leads to stays.

    overwrite:     replace a file that is there; otherwise that is an error.
    keep_previous: the file that was there stays as `<name>.previous`.
    private:       nobody but its owner may read it, not even while it is written.
    error:         the exception raised, with one sentence, when writing fails.
    """
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(6)}.part")
    try:
        try:
            _write_through(temporary, content, _PRIVATE if private else _USUAL)
            _place(temporary, path, overwrite, keep_previous, keep_mode=not private)
            _sync_folder(path.parent)
        finally:
            with suppress(OSError):
                temporary.unlink()
    except FileExistsError:
        raise error(f"{str(path)!r} exists already and is not overwritten.") from None
    except OSError as problem:
        why = problem.strerror or problem  # first, where there is room for a few words only
        raise error(f"{why}: {str(path)!r} cannot be written.") from None


def require_folder(folder: Path, *, error: type[KeyposeError] = FormatError) -> None:
    """Raise, in one sentence, unless files can be written to this folder (or it can be made).

    For use before long work. A file is made and removed, which is the only sure test.
    """
    try:
        nearest = next(p for p in (folder, *folder.absolute().parents) if p.exists())
        probe = nearest / f".{secrets.token_hex(6)}.part"
        _write_through(probe, b"")
        probe.unlink()
    except OSError as problem:
        why = problem.strerror or problem
        raise error(f"{why}: the folder {str(folder)!r} cannot be written to.") from None


def require_absent(paths: Iterable[Path], *, error: type[KeyposeError] = FormatError) -> None:
    """Raise, in one sentence, when one of these files is there already."""
    for path in paths:
        if os.path.lexists(path):
            raise error(f"{str(path)!r} exists already; choose another place or add --overwrite.")


def make_folder(folder: Path, *, error: type[KeyposeError] = FormatError) -> None:
    """Make the folder and those above it where they are missing; `error` in one sentence."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        text = f"The folder {str(folder)!r} cannot be made: {problem.strerror or problem}."
        raise error(text) from None


def _write_through(path: Path, content: bytes, mode: int = _USUAL) -> None:
    """Write a new file and force it to the disk."""
    with open(path, "xb", opener=lambda name, flags: os.open(name, flags, mode)) as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _place(
    temporary: Path, path: Path, overwrite: bool, keep_previous: bool, keep_mode: bool
) -> None:
    if not overwrite:
        _place_new(temporary, path)
        return
    with suppress(FileNotFoundError):
        mode = path.lstat().st_mode
        if stat.S_ISREG(mode) and keep_mode:
            temporary.chmod(mode & 0o777)
        if stat.S_ISREG(mode) and keep_previous:
            _keep(path)
    temporary.replace(path)


def _place_new(temporary: Path, path: Path) -> None:
    """Rename the file, or raise FileExistsError when another one has the name by now."""
    try:
        path.hardlink_to(temporary)
    except FileExistsError:
        raise
    except OSError:  # a file system without links: the look and the rename are two steps there
        if os.path.lexists(path):
            raise FileExistsError from None
        temporary.rename(path)


def _keep(path: Path) -> None:
    """`<name>.previous` becomes the present file, which itself stays where it is."""
    spare = path.with_name(f".{path.name}.{secrets.token_hex(6)}.part")
    try:
        try:
            spare.hardlink_to(path)
        except OSError:
            _write_through(spare, path.read_bytes())
        spare.replace(path.with_name(f"{path.name}.previous"))
    finally:
        # Also after success: a rename between two names of one file leaves both.
        with suppress(OSError):
            spare.unlink()


def _sync_folder(folder: Path) -> None:
    """Force a rename to the disk; only POSIX systems open folders for that."""
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


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
            parts = [entry for entry in entries if _PART.fullmatch(entry.name)]
        for entry in parts:
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
