"""Save the open session as the one who may write it: journal, file and tracks, soon after a change.

The session's folder is known by its device and number: one that was renamed, or is gone, is not
made anew, which would leave half a session there and the other half elsewhere.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TypeAlias

from keypose.app.document.edit_log import EditLog
from keypose.app.document.folder_lock import LockedElsewhere, NotALock, SessionLock
from keypose.app.document.library import Library
from keypose.app.document.open import OpenSession
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.state import EditorState
from keypose.app.jobs.wire import failure_message
from keypose.app.state.app_state import Saved
from keypose.app.working.owner import StateOwner
from keypose.tracker.errors import KeyposeError, SessionError
from keypose.tracker.storage.atomic import make_folder
from keypose.tracker.storage.edit_history import Received
from keypose.tracker.storage.results import save_all_results, tidy_tracks

Identity: TypeAlias = tuple[int, int]


class WriteLock:
    """The lock of the open session's folder. read_only: why it is not written, a sentence.
    is_elsewhere: another Keypose has it, which may end."""

    def __init__(self) -> None:
        self.read_only = ""
        self.is_elsewhere = False
        self._lock: SessionLock | None = None
        self._folder: Identity | None = None

    def take(self, opened: OpenSession) -> None:
        """Take the lock, where there is a folder; else, or where it cannot be had, say so."""
        self.read_only, self.is_elsewhere = "", False
        folder = opened.session_path.parent
        if opened.session.is_newer:
            self.read_only = f"Read only: a newer Keypose wrote {opened.session_path.name}."
        elif folder.is_dir():
            try:
                self._hold(folder)
            except LockedElsewhere as held:
                self.read_only = f"Read only: {held}. Close it there to edit it here."
                self.is_elsewhere = True
            except NotALock as error:
                self.read_only = f"Read only: {error}"

    def require_folder(self, folder: Path, is_ours: Callable[[], bool]) -> None:
        """SessionError unless the session can be written into its folder, which is made for a
        session that has none yet; LockedElsewhere where it is another's by now.

        is_ours: whether another folder in its place holds what this program wrote last: then the
        session was put back from a copy.
        """
        if self._folder is None:
            make_folder(folder, error=SessionError)
            self._hold(folder)
        elif _identity(folder) != self._folder:
            if not is_ours():
                raise SessionError(
                    f"The session's folder is gone or was renamed: put {str(folder)!r} back. "
                    "Your edits stay here and are written once it is back."
                )
            self._release()
            self._hold(folder)

    def release(self) -> None:
        """Let others write."""
        self.read_only, self.is_elsewhere = "", False
        self._release()

    def _hold(self, folder: Path) -> None:
        self._lock = SessionLock.take(folder)
        self._folder = _identity(folder)

    def _release(self) -> None:
        self._folder = None
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    @property
    def is_held(self) -> bool:
        """Whether this program alone writes there."""
        return self._lock is not None

    def require_writable(self) -> None:
        """Refused where it may only be looked at."""
        if self.read_only:
            raise ActionRefused(self.read_only)


def _identity(folder: Path) -> Identity | None:
    try:
        facts = folder.stat()
    except OSError:
        return None
    return facts.st_dev, facts.st_ino


SECONDS_BETWEEN_TRIES = 3.0
"""To write what could not be written: the disk may have room again, or the folder be back."""

Write = Callable[[], None]
"""Writes one state to disk; runs in a thread."""


class Saver:
    """Writes what it was given last. `report` receives the state of saving, on the loop.

    What could not be written is tried again every few seconds until it could.
    """

    def __init__(self, report: Callable[[Saved], None]) -> None:
        self._report = report
        self._next: Write | None = None
        self._failed: tuple[Write, str] | None = None
        self._task: asyncio.Task[None] | None = None
        self._later: asyncio.TimerHandle | None = None
        self._at_s = 0.0

    def save(self, write: Write) -> None:
        """Write this soon; what still waits to be written is replaced."""
        failing = self._failed is not None
        self._begin(write)
        if not failing:  # otherwise it stays reported as unsaved until it is written
            self._report(Saved("saving", self._at_s))

    def retry(self) -> None:
        """Try once more what could not be written."""
        if self._try_again():
            self._report(Saved("saving", self._at_s))

    def _try_again(self) -> bool:
        """Whether there was something to try, and nothing newer is being written."""
        if self._failed is None or self._next is not None or not self.is_idle:
            return False
        self._begin(self._failed[0])
        return True

    def _begin(self, write: Write) -> None:
        self._next = write
        self._stop_waiting()
        if self.is_idle:
            self._task = asyncio.ensure_future(self._work())

    def _stop_waiting(self) -> None:
        if self._later is not None:
            self._later.cancel()
            self._later = None

    @property
    def problem(self) -> str | None:
        """Why the newest state is not on disk, in one sentence; None unless writing it failed."""
        return None if self._failed is None else self._failed[1]

    def give_up(self) -> None:
        """Give up what could not be written: it is not tried again."""
        self._failed = None
        self._stop_waiting()

    @property
    def is_idle(self) -> bool:
        """Whether nothing is being written."""
        return self._task is None or self._task.done()

    async def wait(self) -> None:
        """Wait until nothing is left to write."""
        while self._task is not None and not self.is_idle:
            await asyncio.shield(self._task)

    async def _work(self) -> None:
        while self._next is not None:
            write, self._next = self._next, None
            try:
                await asyncio.to_thread(write)
            except Exception as error:  # noqa: BLE001 — whatever it is, a person must know
                if self._next is None:
                    self._fail(write, error)
                    return
            else:
                self._at_s, self._failed = time.time(), None
        self._report(Saved("saved", self._at_s))

    def _fail(self, write: Write, error: Exception) -> None:
        words = failure_message(error)
        self._failed = write, words
        self._later = asyncio.get_running_loop().call_later(SECONDS_BETWEEN_TRIES, self._try_again)
        self._report(Saved("failed", self._at_s, words))


SECONDS_BETWEEN_SAVES = 3.0
"""Of tracked segments, while more of them are to come; edits are saved at once."""


class SessionWriter:
    """Writes what the host has open. `report` receives the state of saving. All on the loop."""

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        host: StateOwner,
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
        """Acknowledge what could not be written: a person has given it up."""
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
        """Write in a thread of the saver."""
        doc = edit.settled
        self.lock.require_folder(path.parent, partial(edit_log.is_own, path))
        if not path.exists():  # a journal alone would not be found
            edit_log.save(edit_log.as_written(doc), path)
        edit_log.write()
        self._loop.call_soon_threadsafe(edit_log.call_written)
        session = save_all_results(doc, path, edit.results)
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
