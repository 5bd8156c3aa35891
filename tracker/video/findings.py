"""What was found in a film's frames by decoding them strictly.

It is kept while the process lives, so that the next one who opens the film need not do it again.
"""

from __future__ import annotations

from collections import OrderedDict
from pathlib import Path
from threading import Lock
from typing import Final, TypeAlias

from keypose.tracker.video.damage import Examined

MOST_FILMS: Final = 8

FileKey: TypeAlias = tuple[str, int, int, int]
"""A file as it is now: its path, its place on the disk, its size and when it was written."""


class Findings:
    """The frames that were examined, those of them that are damaged, and grey levels by which
    frames differ from the one before. All who have a film open have the same ones."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._examined: set[int] = set()
        self._changes: dict[int, float] = {}
        self.damaged: frozenset[int] = frozenset()

    def add(self, examined: Examined) -> None:
        """Take what is known now."""
        with self._lock:
            self._examined.update(range(examined.first, examined.last + 1))
            self._changes.update(examined.changes)
            if not examined.damaged <= self.damaged:
                self.damaged = self.damaged | examined.damaged

    def is_examined(self, frame: int) -> bool:
        return frame in self._examined

    def unknown(self, frames: range) -> list[int]:
        """Those of these frames that nobody has examined."""
        with self._lock:
            return [n for n in frames if n not in self._examined]

    def changes(self) -> dict[int, float]:
        """Of the frames that are sound."""
        with self._lock:
            return {n: c for n, c in self._changes.items() if n not in self.damaged}


def file_key(path: Path) -> FileKey:
    """A file as it is now. OSError where there is none."""
    facts = path.stat()
    return str(path.resolve()), facts.st_ino, facts.st_size, facts.st_mtime_ns


class _Known:
    """Findings of the films used last."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._findings: OrderedDict[FileKey, Findings] = OrderedDict()

    def of(self, key: FileKey) -> Findings:
        """Those of a file, which whoever asks adds to."""
        with self._lock:
            findings = self._findings.setdefault(key, Findings())
            self._findings.move_to_end(key)
            while len(self._findings) > MOST_FILMS:
                self._findings.popitem(last=False)
            return findings


KNOWN: Final = _Known()
