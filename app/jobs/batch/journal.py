"""What a batch has done so far, on disk, so that an interrupted one can continue.

`.keypose-batch/journal.jsonl` in the batch's folder: a line for what was asked for, one for every
session begun or done, one for the end; each is forced to the disk before the work goes on. Whoever
asks for the same before the end has been written goes on with that batch; whoever asks for
something else, or after the end, begins a new one.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from keypose.app.document.folder_lock import LockedElsewhere, SessionLock
from keypose.tracker.errors import SessionError
from keypose.tracker.files import open_own, read_own
from keypose.tracker.storage.atomic import make_folder

FOLDER = ".keypose-batch"
NAME = "journal.jsonl"
LARGEST_BYTES = 64 * 2**20
"""Of a journal that is read."""


class Journal:
    """The journal of one batch. `done`: sessions that it had finished before; `begun`: all it had
    touched. One batch at a time has a folder; SessionError when it is another's.

    What an earlier batch has left is there until a session of this one begins.
    """

    def __init__(self, out: Path, asked: Mapping[str, Any]) -> None:
        folder = out / FOLDER
        make_folder(folder, error=SessionError)
        if folder.is_symlink():
            words = f"{str(folder)!r} is a link: remove it, or choose another --out."
            raise SessionError(words)
        try:
            self._lock = SessionLock.take(folder)
        except LockedElsewhere as held:
            words = f"A batch with this folder is {held}: wait for it, or choose another --out."
            raise SessionError(words) from None
        self._path = folder / NAME
        self._asked = json.loads(json.dumps(asked))
        self._file: IO[bytes] | None = None
        lines = _lines(self._path)
        self._goes_on = lines[:1] == [{"asked": self._asked}] and lines[-1] != {"end": True}
        self.begun = _named("begun", lines if self._goes_on else [])
        self.done = _named("done", lines if self._goes_on else [])

    def begin(self, session: Path) -> None:
        self._add({"begun": str(session)})

    def finish(self, session: Path) -> None:
        self._add({"done": str(session)})

    def end(self) -> None:
        """All sessions have had their turn: the next batch is a new one."""
        self._add({"end": True})

    def close(self) -> None:
        with suppress(OSError):  # what the disk did not take was raised when it was added
            if self._file is not None:
                self._file.close()
        self._lock.release()

    def _add(self, line: Mapping[str, Any]) -> None:
        try:
            if self._file is None:
                self._file = self._open()
                first = {} if self._goes_on else {"asked": self._asked}
                self._file.write(b"\n" + _encoded(first))  # after one that may have been cut off
            self._file.write(_encoded(line))
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as problem:
            why = problem.strerror or problem
            raise SessionError(f"{str(self._path)!r} cannot be written: {why}.") from None

    def _open(self) -> IO[bytes]:
        """Emptied, unless this batch goes on, only once it is known to be the batch's own."""
        file = os.fdopen(open_own(self._path, os.O_WRONLY | os.O_CREAT | os.O_APPEND), "ab")
        if not self._goes_on:
            file.truncate(0)
        return file


def _encoded(line: Mapping[str, Any]) -> bytes:
    return json.dumps(line).encode() + b"\n"


def _lines(path: Path) -> list[dict[str, Any]]:
    """The whole lines; one that was cut off is as if it had not been written."""
    try:
        content = read_own(path, LARGEST_BYTES)
    except OSError:
        return []
    lines = []
    for line in content.splitlines():
        try:
            entry = json.loads(line)
        except ValueError:
            continue
        if isinstance(entry, dict) and entry:
            lines.append(entry)
    return lines


def _named(key: str, lines: list[dict[str, Any]]) -> frozenset[str]:
    return frozenset(line[key] for line in lines if isinstance(line.get(key), str))
