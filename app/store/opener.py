"""Opening and closing sessions: one at a time, each on the disk as a whole before the next."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from pathlib import Path

from keypose.app.document.library import Library, id_of
from keypose.app.document.open import OpenSession, edit_state, open_for_editing
from keypose.app.editor import actions
from keypose.app.editor.documents import ActionRefused
from keypose.app.render.video_frames import Frames
from keypose.app.state.app_state import OpenedFile
from keypose.app.store.other_films import OtherFilms
from keypose.app.store.saving import SessionWriter
from keypose.app.working.examining import Examiner
from keypose.app.working.owner import StateOwner
from keypose.app.working.queue import WorkQueue
from keypose.app.working.segments import SegmentTracker
from keypose.tracker.errors import KeyposeError, SessionError, SurfaceError, VideoError

SECONDS_BETWEEN_LOOKS = 3.0
"""At a session that another Keypose has, which may have ended."""


class Opener:
    """What is open, for the host. All on the loop; files are read and closed in threads."""

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        host: StateOwner,
        library: Library,
        writer: SessionWriter,
        queue: WorkQueue,
        segments: SegmentTracker,
    ) -> None:
        self._loop = loop
        self._host = host
        self._library = library
        self._writer = writer
        self._queue, self._segments = queue, segments
        self._one_at_a_time = asyncio.Lock()
        self._warned: str | None = None
        self._looking: asyncio.Task[None] | None = None
        self._examiner: Examiner | None = None
        self.opened: OpenSession | None = None
        self.frames: Frames | None = None
        self.films: OtherFilms | None = None

    async def open_named(self, action: actions.Open) -> None:
        """Open what the library knows by a name; an upload that is no video is discarded."""

        def find() -> Path:
            return self._library.find(action.kind, action.id, action.video)

        try:
            await self.open(await asyncio.to_thread(find))
        except (VideoError, SurfaceError):
            if action.kind == "upload":  # what is no video need not stay
                await asyncio.to_thread(self._library.discard, action.id)
            raise

    async def open(self, path: Path) -> None:
        """Open a session or a video; KeyposeError when it cannot be, and all stays as it was.

        What is open already stays open as it is: the file may lag behind.
        """
        async with self._one_at_a_time:
            await self._host.read_poses()
            opened = await asyncio.to_thread(open_for_editing, path, self._library.session_for)
            try:
                if self.opened is not None and self.opened.is_same(opened):
                    await asyncio.to_thread(opened.video.close)
                    return
                edit, problem = await asyncio.to_thread(edit_state, opened)
                film = await asyncio.to_thread(opened.film)
                await self._close_open()
                self._writer.lock.take(opened)
                if opened.is_stale():  # another Keypose wrote on until it let go of the lock
                    opened.video.close()
                    opened = await asyncio.to_thread(
                        open_for_editing, opened.session_path, self._library.session_for
                    )
                    edit, problem = await asyncio.to_thread(edit_state, opened)
            except BaseException:
                opened.video.close()
                self._writer.lock.release()
                raise
            self._writer.begin(opened, edit)
            self.opened, self.frames = opened, Frames(opened.video)
            self.films = OtherFilms(opened.session_path)
            self._host.session_opened(opened, _opened_file(opened, film), edit)
            if self._writer.lock.is_elsewhere:
                self._looking = self._loop.create_task(self._look_until_free(opened))
            if edit.doc.evidence.can_be_damaged:
                self._examiner = Examiner(
                    self._loop, opened.video, self._host.show_damage, self._host.show_repeats
                )
            for words in filter(None, (*opened.news, opened.video.info.numbering, problem)):
                self._host.note("check", words)
            await self._visit(opened)

    async def _look_until_free(self, opened: OpenSession) -> None:
        while self.opened is opened and self._writer.lock.is_elsewhere:
            await asyncio.sleep(SECONDS_BETWEEN_LOOKS)
            try:
                await self.look_again()
            except KeyposeError as error:
                self._host.note("check", str(error))
                return

    async def look_again(self) -> None:
        """Write from now on what another Keypose had, where that has ended; what it wrote since it
        was opened here is read first."""
        async with self._one_at_a_time:
            opened, lock = self.opened, self._writer.lock
            if opened is None or not lock.is_elsewhere:
                return
            lock.take(opened)
            is_stale = not lock.read_only and opened.is_stale()
            if is_stale:
                await self._close_open()
            elif not lock.is_elsewhere:
                if not lock.read_only:
                    self._writer.begin(opened, self._host.app_state.editing)
                self._host.lock_changed()
        if is_stale:
            await self.open(opened.session_path)
        if self.opened is not None and not lock.read_only:
            self._host.note("good", "The other Keypose has ended: edit here.")

    async def _visit(self, opened: OpenSession) -> None:
        """The page's address leads to it from now on."""
        source = opened.video.info.path if opened.fresh else opened.session_path
        with suppress(KeyposeError):  # then it is found until the program ends
            await asyncio.to_thread(
                self._library.visit, opened.session_path, source, opened.session
            )

    def saved(self) -> None:
        """All is on the disk: what was said of a problem counts no longer."""
        self._warned = None

    async def close(self) -> None:
        """Save, and close what is open."""
        async with self._one_at_a_time:
            await self._close_open()

    async def _close_open(self) -> None:
        """Close what is open; SessionError, and it stays open, when it cannot be saved.

        A person who asks for it once more gives up what is not saved.
        """
        await self._settle()
        problem = self._writer.saver.problem
        if problem is not None and problem != self._warned:
            self._warned = problem
            raise SessionError(f"{problem} Repeat to continue without saving.")
        self._writer.give_up()
        await self._release()

    async def _settle(self) -> None:
        """Have everything written, as far as the disk takes it, with what is tracked until now."""
        await self._segments.leave()
        self._writer.saver.retry()
        while True:
            self._host.end_gesture()
            self._writer.save_waiting()
            if self._writer.saver.is_idle:
                return
            await self._writer.saver.wait()

    async def _release(self) -> None:
        """Nothing is open from here on, at once; what is slow to close is closed after that."""
        if self._looking is not None and self._looking is not asyncio.current_task():
            self._looking.cancel()
        self._looking = None
        opened, frames, examiner = self.opened, self.frames, self._examiner
        films = self.films
        self.opened = self.frames = self.films = self._warned = self._examiner = None
        self._host.session_closed()
        if examiner is not None:
            await asyncio.to_thread(examiner.close)
        if frames is not None:
            frames.close()
        if films is not None:
            await films.close()
        if opened is not None:
            await asyncio.to_thread(opened.video.close)

    async def stop(self) -> None:
        """Save what is unsaved and end the worker; SessionError when something is lost."""
        try:
            async with self._one_at_a_time:
                await self._settle()
                problem = self._writer.saver.problem
                kept = self._writer.is_logged
                await self._release()
        finally:
            await asyncio.to_thread(self._queue.stop)
        if problem is not None:
            rest = "The last changes are in its journal." if kept else "The last changes are lost."
            raise SessionError(f"{problem} {rest}")

    async def saved_path(self) -> Path:
        """The session's file once it holds everything; SessionError when it cannot be written."""
        opened = self.opened
        if opened is None:
            raise ActionRefused("Open a video first.")
        self._writer.saver.retry()
        self._writer.save_waiting()
        await self._writer.saver.wait()
        if self._writer.saver.problem is not None:
            raise SessionError(self._writer.saver.problem)
        return opened.session_path


def _opened_file(opened: OpenSession, film: str) -> OpenedFile:
    path = opened.session_path
    return OpenedFile(opened.name, str(path), id_of(str(path.absolute())), opened.video.info, film)
