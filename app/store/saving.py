"""Writing the open session: its journal, its file and its tracks, by one program at a time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Protocol

from keypose.app.document.edit_log import EditLog
from keypose.app.document.library import Library
from keypose.app.document.open import OpenSession
from keypose.app.document.write_lock import WriteLock
from keypose.app.editor.state import EditorState
from keypose.app.store.autosave import Saver
from keypose.app.store.state import AppState, Saved
from keypose.tracker.errors import KeyposeError
from keypose.tracker.storage.chronicle import Received
from keypose.tracker.storage.results import save_results, tidy_tracks

SECONDS_BETWEEN_SAVES = 3.0
"""Of tracked segments, while more of them are to come; edits are saved at once."""


class Host(Protocol):
    """Who owns the state."""

    @property
    def app_state(self) -> AppState: ...

    def note(self, kind: str, words: str) -> None: ...


class SessionWriter:
    """Writes what the host has open. `report` receives the state of saving. All on the loop."""

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        host: Host,
        library: Library,
        report: Callable[[Saved], None],
    ) -> None:
        self._loop = loop
        self._host = host
        self._library = library
        self.saver = Saver(report)
        self.lock = WriteLock()
        self._edit_log: EditLog | None = None
        self._path = Path()
        self._later: asyncio.TimerHandle | None = None

    def begin(self, opened: OpenSession, edit: EditorState) -> None:
        """Log the edits of a session that has just been opened, unless another program has it."""
        self._path = opened.session_path
        if not self.lock.read_only:
            self._edit_log = EditLog(self._path, edit, opened.journal)

    def log(self, edit: EditorState, received: Received) -> bool:
        """Whether there is an edit to write."""
        return self._edit_log is not None and self._edit_log.note(edit, received)

    def when_logged(self, call: Callable[[], None]) -> None:
        """Call once all edits until now are on the disk."""
        if self._edit_log is None:
            call()
        else:
            self._edit_log.when_written(call)

    @property
    def is_logged(self) -> bool:
        """Whether all edits are on the disk, if only in the journal."""
        return self._edit_log is not None and self._edit_log.is_written()

    def save(self) -> None:
        """Save the document as it stands, without a gesture that may yet be cancelled."""
        if self._later is not None:
            self._later.cancel()
            self._later = None
        edit, edit_log = self._host.app_state.edit, self._edit_log
        if edit is not None and edit_log is not None:
            self.saver.save(partial(self._write, self._path, edit, edit_log))

    def save_soon(self) -> None:
        """While segments come in one by one, the motion is not written with each of them."""
        if self._later is None:
            self._later = self._loop.call_later(SECONDS_BETWEEN_SAVES, self.save)

    def save_waiting(self) -> None:
        """Save now what `save_soon` put off."""
        if self._later is not None:
            self.save()

    def give_up(self) -> None:
        """What could not be written is acknowledged: a person has given it up."""
        if self._edit_log is not None:
            self._edit_log.give_up()

    def close(self) -> None:
        """Write no more."""
        self.saver.give_up()
        if self._edit_log is not None:
            self._edit_log.close()
            self._edit_log = None
        if self.lock.is_held:  # nobody else is about to name a young one
            tidy_tracks(self._path.parent, young_seconds=0.0)
        self.lock.release()

    def _write(self, path: Path, edit: EditorState, edit_log: EditLog) -> None:
        """In a thread of the saver."""
        doc = edit.settled
        self.lock.require_folder(path.parent, partial(edit_log.is_own, path))
        if not path.exists():  # a journal alone would not be found
            edit_log.save(edit_log.as_written(doc), path)
        edit_log.write()
        self._loop.call_soon_threadsafe(edit_log.call_written)
        session = save_results(doc, path, edit.results)
        theirs = edit_log.save(session, path)
        if theirs is not None:
            message = (
                f"Another program changed {path.name}. Its version is kept as {theirs.name}; "
                "you continue with yours."
            )
            self._loop.call_soon_threadsafe(self._host.note, "check", message)
        with suppress(OSError):  # what is left over does no harm
            tidy_tracks(path.parent)
        with suppress(KeyposeError):  # only the list of recent sessions would lack it
            self._library.remember(path, session)
