"""Opening files that another program or person may have put there.

A name in a folder from elsewhere may be a link to any file of the user, a pipe that waits for ever
or a device that never ends. Foreign files are read as regular files of at most so many bytes. Files
that Keypose keeps beside a session are opened only where they are its own: regular, reached by no
link, known by no second name.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO

_ALWAYS = getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0)
"""Does not block: a pipe put there after the check would hang."""


class NotRegular(OSError):
    """There is something at this path that is not a regular file, or not Keypose's own."""

    def __init__(self, path: Path, why: str) -> None:
        super().__init__(errno.EINVAL, why, str(path))


class TooLarge(OSError):
    """The file has more bytes than are read of its kind."""

    def __init__(self, path: Path, most_bytes: int) -> None:
        size = f"{most_bytes / 2**20:,.3g} MB"
        super().__init__(errno.EFBIG, f"it is larger than {size}", str(path))


def open_regular(path: Path) -> BinaryIO:
    """A file open for reading. OSError, NotRegular among them, with a reason in `strerror`."""
    # Checked before it is opened: opening a device may already do something.
    _require_regular(path, path.stat())
    file = os.fdopen(os.open(path, os.O_RDONLY | _ALWAYS), "rb")
    try:
        _require_regular(path, os.fstat(file.fileno()))
    except BaseException:
        file.close()
        raise
    return file


def read_regular(path: Path, most_bytes: int) -> bytes:
    """All of a file. OSError as `open_regular`, and TooLarge where it has more bytes than that."""
    with open_regular(path) as file:
        return _read_at_most(path, file, most_bytes)


def read_named(path: Path, most_bytes: int, kind: str, error: type[Exception]) -> bytes:
    """All of a file that somebody named; where there is none to read, `error` in one sentence that
    calls it by its kind, such as "session file"."""
    try:
        if path.is_dir():
            raise error(f"{str(path)!r} is a folder; name the {kind} in it.")
        return read_regular(path, most_bytes)
    except TooLarge:
        raise error(f"{str(path)!r} is too large to be a {kind}.") from None
    except FileNotFoundError:
        raise error(f"There is no {kind} {str(path)!r}.") from None
    except (OSError, ValueError) as reason:  # ValueError: a NUL character in the name
        why = getattr(reason, "strerror", None) or reason
        raise error(f"The {kind} {str(path)!r} cannot be read: {why}.") from None


def read_head(path: Path, most_bytes: int) -> bytes:
    """The first bytes of a file, however long it is. OSError as `open_regular`."""
    with open_regular(path) as file:
        return file.read(most_bytes)


def open_own(path: Path, flags: int, mode: int = 0o644, *, one_name: bool = True) -> int:
    """A descriptor of a file that Keypose keeps for itself; no link is followed.

    flags:    as of os.open, but O_TRUNC, which would act before the file is known to be Keypose's.
    one_name: refuse a file that has another name as well, for writing would change that one too.
    OSError, and NotRegular where something else has the name.
    """
    assert not flags & os.O_TRUNC
    try:
        require_own(path, path.lstat(), one_name=one_name)
    except FileNotFoundError:
        if not flags & os.O_CREAT:
            raise
    file = os.open(path, flags | _ALWAYS | getattr(os, "O_NOFOLLOW", 0), mode)
    try:
        require_own(path, os.fstat(file), one_name=one_name)
    except BaseException:
        os.close(file)
        raise
    return file


def read_own(path: Path, most_bytes: int) -> bytes:
    """All of a file that Keypose keeps for itself, through no link. OSError as `read_regular`.

    A second name, as in a backup with hard links, is harmless for reading.
    """
    _require_no_link(path, path.lstat())
    return read_regular(path, most_bytes)


def read_private(path: Path, most_bytes: int) -> bytes:
    """All of a file that its owner alone may read or change. OSError as `open_own`, TooLarge, and
    NotRegular where others may read it."""
    with os.fdopen(open_own(path, os.O_RDONLY), "rb") as file:
        facts = os.fstat(file.fileno())
        # A home folder is its owner's on systems without POSIX, and modes say nothing there.
        if os.name == "posix" and (facts.st_uid != os.getuid() or facts.st_mode & 0o077):
            raise NotRegular(path, "others may read or change it")
        return _read_at_most(path, file, most_bytes)


def read_unshared(path: Path, most_bytes: int) -> bytes:
    """All of a file that no other user can change or put another in the place of, through no link.
    OSError as `read_own`, and NotRegular where others may write to it or to its folder."""
    _require_no_link(path, path.lstat())
    require_unshared(path.parent)
    with open_regular(path) as file:
        _require_unwritten(path, os.fstat(file.fileno()))
        return _read_at_most(path, file, most_bytes)


def require_unshared(folder: Path) -> None:
    """NotRegular where another user may change what is in a folder, or put another one in its
    place; OSError where there is none."""
    place = folder.resolve()
    _require_unwritten(place, place.stat())
    for above in {place.parent, folder.parent.resolve()}:
        facts = above.stat()
        if not facts.st_mode & stat.S_ISVTX:  # in which nobody moves what is another's
            _require_unwritten(above, facts)


def _require_unwritten(path: Path, facts: os.stat_result) -> None:
    """NotRegular unless it is this user's, or the system's, and nobody else may write to it."""
    if os.name != "posix":  # modes say nothing there, and a home folder is its owner's
        return
    if facts.st_uid not in (0, os.getuid()):
        raise NotRegular(path, "it belongs to another user")
    others = stat.S_IWOTH if _is_own_group(facts.st_gid) else stat.S_IWOTH | stat.S_IWGRP
    if facts.st_mode & others:
        raise NotRegular(path, f"other users may write to {str(path)!r}: run chmod go-w on it")


def _is_own_group(gid: int) -> bool:
    """Whether a group is that of this user alone, as many systems make one for each."""
    import grp
    import pwd

    try:
        user, group = pwd.getpwuid(os.getuid()), grp.getgrgid(gid)
    except KeyError:
        return False
    is_named_so = gid == user.pw_gid and group.gr_name == user.pw_name
    return is_named_so and set(group.gr_mem) <= {user.pw_name}


def require_own(path: Path, facts: os.stat_result, *, one_name: bool = True) -> None:
    """NotRegular unless these facts, read without following a link, are of a file Keypose may
    write to."""
    _require_no_link(path, facts)
    _require_regular(path, facts)
    if one_name and facts.st_nlink > 1:
        raise NotRegular(path, "the same file has another name elsewhere")


def _read_at_most(path: Path, file: BinaryIO, most_bytes: int) -> bytes:
    """Reads at most the limit: the size of a file may be wrong (0 in /proc) or grow."""
    content = file.read(most_bytes + 1)
    if len(content) > most_bytes:
        raise TooLarge(path, most_bytes)
    return content


def _require_no_link(path: Path, facts: os.stat_result) -> None:
    if stat.S_ISLNK(facts.st_mode):
        raise NotRegular(path, "it is a link to another file")


def _require_regular(path: Path, facts: os.stat_result) -> None:
    if stat.S_ISDIR(facts.st_mode):
        raise NotRegular(path, "it is a folder")
    if not stat.S_ISREG(facts.st_mode):
        raise NotRegular(path, "it is not a regular file")
