"""Every edit on the disk before it is acknowledged: journal and session file of an open session.

Edits are noted on the loop's thread and written on another; what is acknowledged meanwhile waits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock

from keypose.app.editor.state import EditorState
from keypose.tracker.files import read_regular
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.edit_history import (
    Moment,
    Received,
    edit_record,
    mark_of,
    saved_record,
    single_steps,
    whole_record,
)
from keypose.tracker.storage.files import (
    LARGEST_SESSION_BYTES,
    journal_path,
    save_session,
    session_json,
    set_aside,
)
from keypose.tracker.storage.journal import Journal

MOST_BYTES = 4 * 2**20
"""A longer journal, and twice as long as it began, is begun anew with what can still be undone."""


@dataclass(frozen=True)
class Beginning:
    """Where a session's files stand when it is opened.

    size: bytes of the journal that are whole, of `length` in all.  follows: it can be gone on with;
    otherwise the next edit begins it anew.  content: of the session file.  received: whose edits
    are in it.
    """

    size: int = 0
    follows: bool = False
    content: bytes = b""
    length: int = 0
    received: Received = field(default_factory=Received)


class EditLog:
    """The journal of the session that is open, and its file."""

    def __init__(self, session_path: Path, edit: EditorState, beginning: Beginning) -> None:
        size = beginning.size if beginning.follows else 0
        self._journal = Journal(journal_path(session_path), size)
        self._follows = beginning.follows
        self._ours: tuple[bytes, ...] = (beginning.content,)
        self._began_with = size
        self._last = _moment(edit, beginning.received)
        self._lock = Lock()
        self._pending: list[tuple[Moment, Moment]] = []
        self._marked = ""
        self._noted = self._written = 0
        self._waiting: list[tuple[int, Callable[[], None]]] = []

    # --- on the loop's thread

    def note(self, edit: EditorState, received: Received | None = None) -> bool:
        """Whether something was decided, which has to be written. received: whose edits are
        in what is settled of it, where that has changed.
        """
        if edit.settled is self._last.doc and edit.history is self._last.history:
            return False
        moment = _moment(edit, received or self._last.received)
        with self._lock:
            self._pending.extend(single_steps(self._last, moment))
            self._noted += 1
        self._last = moment
        return True

    def when_written(self, call: Callable[[], None]) -> None:
        """Call once all that was noted until now is on the disk, however long that takes."""
        if self._noted <= self._written:
            call()
        else:
            self._waiting.append((self._noted, call))

    def call_written(self) -> None:
        """Call those whose wait is over."""
        self._call(self._written)

    def give_up(self) -> None:
        """Call all, for a person has given up what is not on the disk."""
        self._call(self._noted)

    def _call(self, upto: int) -> None:
        ready = [call for number, call in self._waiting if number <= upto]
        self._waiting = [waits for waits in self._waiting if waits[0] > upto]
        for call in ready:
            call()

    # --- on the thread that writes

    def write(self) -> None:
        """Bring everything noted to the disk; SessionError when it refuses, and nothing is lost."""
        with self._lock:
            pending = list(self._pending)
        if not pending:
            return
        if not self._follows or self._is_long() or not self._journal.is_there():
            self._begin_anew(pending[-1][1])
        else:
            self._journal.append(edit_record(before, after) for before, after in pending)
        with self._lock:
            del self._pending[: len(pending)]
            self._written += len(pending)

    def _is_long(self) -> bool:
        return self._journal.size > max(MOST_BYTES, 2 * self._began_with)

    def _begin_anew(self, moment: Moment) -> None:
        self._journal.begin_anew(whole_record(moment), keep_previous=not self._follows)
        self._follows, self._marked = True, ""
        self._began_with = self._journal.size

    def as_written(self, doc: Session) -> Session:
        """The document as far as the journal has it; `doc` where it has everything."""
        with self._lock:
            return self._pending[0][0].doc if self._pending else doc

    def is_written(self) -> bool:
        """Whether the journal has everything."""
        return self._noted == self._written

    def is_own(self, path: Path) -> bool:
        """Whether a session file is as this program read it or left it."""
        try:
            return read_regular(path, LARGEST_SESSION_BYTES) in self._ours
        except OSError:
            return False

    def save(self, session: Session, path: Path) -> Path | None:
        """Save the session file. Returns where the version of another program that wrote it
        meanwhile is kept, None where none did; SessionError when the disk refuses."""
        theirs = set_aside(path, self._ours)
        content = session_json(session)
        self._ours = (*self._there(path), content)  # either may be there if this fails
        save_session(session, path)
        self._ours = (content,)
        self._mark(mark_of(session))
        return theirs

    def _there(self, path: Path) -> tuple[bytes, ...]:
        """What lies there now, ours or set aside; all that may, where it cannot be read."""
        try:
            return (read_regular(path, LARGEST_SESSION_BYTES),)
        except OSError:
            return self._ours

    def _mark(self, mark: str) -> None:
        """Only now is the session file known to follow the journal."""
        if self._follows and mark != self._marked and self._journal.is_there():
            self._journal.append([saved_record(mark)], durable=False)
            self._marked = mark

    def close(self) -> None:
        """Close the file."""
        self._journal.close()


def _moment(edit: EditorState, received: Received) -> Moment:
    return Moment(edit.settled, edit.history, edit.frame, received)
