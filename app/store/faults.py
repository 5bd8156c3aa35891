"""Say which part of the page is not up to date, and log why: once for each cause."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from typing import TypeAlias

from keypose.app.jobs.wire import failure_message

Fault: TypeAlias = tuple[str, Exception]
"""The part of the page that is not up to date, "the timeline", and why."""
Cause: TypeAlias = tuple[str, str, int]
"""The kind of an error, and the file and line that raised it."""


class Faults:
    """Faults in what follows from an edit, which is made and logged before any of it.

    note: sends every tab a sentence of a kind.
    """

    def __init__(self, note: Callable[[str, str], None]) -> None:
        self._note = note
        self._logged: set[Cause] = set()
        self._places: set[str] = set()
        """What was not up to date the last time."""

    def report(self, faults: Sequence[Fault], saves: bool) -> None:
        """Log the causes that are new, and say where they show, when that is more than before.

        saves: whether edits reach the disk.
        """
        for _, error in faults:
            if (cause := _cause_of(error)) not in self._logged:
                self._logged.add(cause)
                failure_message(error)
        places = {place for place, _ in faults}
        if not places <= self._places:
            self._note("lost", _sentence(sorted(places), saves))
        self._places = places


def _cause_of(error: Exception) -> Cause:
    frames = traceback.extract_tb(error.__traceback__)
    where = (frames[-1].filename, frames[-1].lineno or 0) if frames else ("", 0)
    return type(error).__name__, *where


def _sentence(places: list[str], saves: bool) -> str:
    """ "The timeline and the views are not up to date because of an internal error. …" """
    *others, last = places
    joined = f"{', '.join(others)} and {last}" if others else last
    verb = "are" if others or last.endswith("s") else "is"
    kept = "Your edits are saved: undo" if saves else "Undo"
    return (
        f"{joined[:1].upper()}{joined[1:]} {verb} not up to date because of an internal error. "
        f"{kept} the last one, or reload the page."
    )
