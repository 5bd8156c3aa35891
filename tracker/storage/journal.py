"""journal.jsonl beside a session: a line for each edit, on the disk before the edit counts.

A line is the CRC-32 of its text in eight hexadecimal digits, a blank, and the text: one JSON
object. A process that dies while it writes leaves part of a line, which is no line. Lines after a
damaged one are not read: their changes apply to a state that is missing.

Not SQLite: a copy of a database that is being written may be broken; a copy of this lacks a line.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from pydantic_core import from_json, to_json

from keypose.tracker.errors import SessionError
from keypose.tracker.files import TooLarge, open_own, read_own, require_own
from keypose.tracker.storage.atomic import write_file

NAME = "journal.jsonl"
LARGEST_BYTES = 256 * 2**20
"""Far above any journal: a new one begins long before."""

Record: TypeAlias = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Read:
    """records: those before the first that is damaged.  size: their bytes.

    whole: nothing follows them but part of a line.  length: bytes of the file.
    """

    records: tuple[Record, ...] = ()
    size: int = 0
    whole: bool = True
    length: int = 0


def read_journal(path: Path) -> Read:
    """Read a journal; nothing where there is none. SessionError when it cannot be read."""
    try:
        content = read_own(path, LARGEST_BYTES)
    except FileNotFoundError:
        return Read()
    except TooLarge:
        raise SessionError(f"{str(path)!r} is too large to be a session's journal.") from None
    except OSError as error:
        why = error.strerror or error
        raise SessionError(f"The journal {str(path)!r} cannot be read: {why}.") from None
    records, size = [], 0
    for line in content.splitlines(keepends=True):
        record = _record(line)
        if record is None:
            break
        records.append(record)
        size += len(line)
    whole = b"\n" not in content[size:]
    return Read(tuple(records), size, whole, len(content))


def lines(records: Iterable[Mapping[str, Any]]) -> bytes:
    """The bytes of these records."""
    return b"".join(_line(record) for record in records)


class Journal:
    """A journal open for writing by one process, which holds the session's lock."""

    def __init__(self, path: Path, size: int) -> None:
        """Continue behind the first `size` bytes; what follows them is an incomplete line."""
        self.path = path
        self.size = size
        self._file: int | None = None

    def is_there(self) -> bool:
        """Whether the file is still the one to continue: not removed or replaced."""
        try:
            there = self.path.lstat()
            require_own(self.path, there)
        except FileNotFoundError:
            return self.size == 0
        except OSError:
            return False
        if self._file is not None and not os.path.samestat(there, os.fstat(self._file)):
            return False
        return there.st_size >= self.size

    def append(self, records: Iterable[Mapping[str, Any]], *, durable: bool = True) -> None:
        """Write records; with `durable` they are on the disk when this returns.

        SessionError in one sentence when the disk refuses; then none of them is there.
        """
        content = lines(records)
        try:
            file = self._open()
            os.lseek(file, self.size, os.SEEK_SET)
            _write_all(file, content)
            if durable:
                os.fsync(file)
        except OSError as error:
            self._truncate()
            why = error.strerror or error
            raise SessionError(f"{why}: {str(self.path)!r} cannot be written.") from None
        self.size += len(content)

    def begin_anew(
        self, records: Iterable[Mapping[str, Any]], *, keep_previous: bool = False
    ) -> None:
        """Let these be all there is, in one step that either happens or does not."""
        content = lines(records)
        self.close()
        write_file(
            self.path, content, overwrite=True, keep_previous=keep_previous, error=SessionError
        )
        self.size = len(content)

    def close(self) -> None:
        """Let go of the file."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def _open(self) -> int:
        if self._file is None:
            self._file = open_own(self.path, os.O_WRONLY | os.O_CREAT)
            os.ftruncate(self._file, self.size)
        return self._file

    def _truncate(self) -> None:
        """Cut off a half-written line; one that cannot be cut off is ignored when read."""
        if self._file is not None:
            with suppress(OSError):
                os.ftruncate(self._file, self.size)
        with suppress(OSError):
            self.close()


def _write_all(file: int, content: bytes) -> None:
    while content:
        content = content[os.write(file, content) :]


def _line(record: Mapping[str, Any]) -> bytes:
    text = to_json(record)
    return b"%08x " % zlib.crc32(text) + text + b"\n"


def _record(line: bytes) -> Record | None:
    """The record of a line, None where it is damaged or not whole."""
    mark, _, text = line.partition(b" ")
    text = text[:-1]
    if not line.endswith(b"\n") or mark != b"%08x" % zlib.crc32(text):
        return None
    try:
        record = from_json(text)
    except ValueError:
        return None
    return record if isinstance(record, dict) else None
