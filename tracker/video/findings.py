"""What was found in a film's frames by decoding them strictly.

It is kept while the process lives, so that the next one who opens the film need not do it again.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock
from typing import Final, TypeAlias

from keypose.tracker.video.damage import Examined

MOST_FILMS: Final = 8

FileKey: TypeAlias = tuple[str, int, int, int]
"""A file as it is now: its path, its place on the disk, its size and when it was written."""


@dataclass(frozen=True, eq=False)
class Findings:
    """The frames that were examined, those of them that are damaged, and grey levels by which
    frames differ from the one before."""

    examined: frozenset[int] = frozenset()
    damaged: frozenset[int] = frozenset()
    changes: Mapping[int, float] = field(default_factory=dict)

    def and_also(self, found: Examined) -> Findings:
        """With what is known now."""
        return Findings(
            self.examined | frozenset(range(found.first, found.last + 1)),
            self.damaged | found.damaged,
            {**self.changes, **found.changes},
        )


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
        with self._lock:
            return self._findings.get(key, Findings())

    def keep(self, key: FileKey, findings: Findings) -> None:
        with self._lock:
            self._findings[key] = findings
            self._findings.move_to_end(key)
            while len(self._findings) > MOST_FILMS:
                self._findings.popitem(last=False)


KNOWN: Final = _Known()
