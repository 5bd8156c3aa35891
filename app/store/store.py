"""The one owner of the state. Everything happens on one loop, in the order it arrived.

An action changes the state at once; what follows from it (the scene redrawn, the tabs told, the
session saved, segments tracked anew) is done once per turn of the loop, for the newest state only.
"""

from __future__ import annotations

import asyncio
import re
import secrets
import traceback
from collections.abc import Callable, Coroutine
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from app.document.edit_log import Journaling
from app.document.library import Library, id_of
from app.document.open import OpenSession, edit_state, open_for_editing
from app.document.write_lock import WriteLock
from app.editor import actions
from app.editor.refusal import Refused
from app.editor.state import EditorState
from app.editor.update import end_stroke, update
from app.render.video_frames import Frames
from app.store.autosave import Saver
from app.store.clients import Clients
from app.store.examiner import Examiner
from app.store.fitter import Fitter
from app.store.guide import guide_after
from app.store.runner import Runner
from app.store.sections import Sections
from app.store.state import AppState, FitTold, Guide, Job, Opened, Saved, SurfaceSeen
from app.store.tabs import Tab, Tabs
from tracker.errors import KeyposeError, SessionError, SurfaceError, VideoError, one_sentence
from tracker.storage.chronicle import mark_of
from tracker.storage.results import save_results, tidy_tracks
from tracker.surface.picture import SurfaceVideo
from tracker.video import VideoInfo

CLIENT = re.compile(r"[0-9A-Za-z_-]{8,64}")
"""What a tab may call itself."""

SECONDS_BETWEEN_SAVES = 3.0
"""Of tracked segments, while more of them are to come; edits are saved at once."""

SECONDS_BETWEEN_NEWS = 0.2
SECONDS_IN_A_GESTURE = 0.6
"""Of passes, which may come faster than any page can draw them; a hand that drags goes first."""


class Store:
    """State, tabs, files and jobs of one server.

    `show` draws the state and its trail in the views; `library` knows what can be opened and where
    a video's session lives. All methods are for the loop's thread.
    """

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        show: Callable[[EditorState, Any], None],
        library: Library,
    ) -> None:
        self._loop = loop
        self._show = show
        self._library = library
        self._app_state = AppState(server=secrets.token_hex(8))
        self._sections = Sections()
        self._tabs = Tabs()
        self._opened: OpenSession | None = None
        self._saver = Saver(self._on_saved)
        self._runner = Runner(loop, self._on_running)
        self._fitter = Fitter(self._runner, self)
        self._turn_asked = False
        self._dragging: Tab | None = None
        self._saving_later: asyncio.TimerHandle | None = None
        self._news_later: asyncio.TimerHandle | None = None
        self._next_news = 0.0
        self._opening = asyncio.Lock()
        self._tasks: set[asyncio.Task[None]] = set()
        self._warned: str | None = None
        self._holding = WriteLock()
        self._journaling: Journaling | None = None
        self._examiner: Examiner | None = None
        self._clients = Clients()
        self.frames: Frames | None = None

    @property
    def app_state(self) -> AppState:
        return self._app_state

    @property
    def opened(self) -> OpenSession | None:
        return self._opened

    # --- tabs

    def join(self) -> Tab:
        """One more tab, told everything."""
        tab = self._tabs.join()
        self._look(tabs=len(self._tabs))
        self._tell()
        self._tabs.greet(tab, self._sections.all)
        return tab

    def leave(self, tab: Tab) -> None:
        """One tab fewer; the gesture it may have been in the middle of ends as it is."""
        self._tabs.leave(tab)
        if self._app_state.edit is not None and self._dragging is tab:
            self._clients.resume_gesture()
            self._edit_to(end_stroke(self._app_state.edit))
            self._clients.end()
        self._look(tabs=len(self._tabs))
        self._look_back(False)

    def receive(self, tab: Tab, message: Any) -> None:
        """An action from a tab: validated, done once, acknowledged."""
        client, number, message = _split_envelope(message)
        try:
            if not self._clients.begin(client, number):
                return
            action = actions.ACTIONS.validate_python(message)
            self.do(action)
            under_way = self._app_state.edit.stroke if self._app_state.edit else None
            if under_way is not None and under_way.name == getattr(action, "stroke", None):
                self._dragging = tab
        except ValidationError as error:
            tab.say({"t": "refused", "n": number, "words": one_sentence(error)})
        except KeyposeError as error:
            tab.say({"t": "refused", "n": number, "words": str(error)})
        except Exception as error:  # noqa: BLE001 — the state is as it was, the line stays
            traceback.print_exception(error)
            words = f"This met a fault of Keypose itself ({type(error).__name__})."
            tab.say({"t": "refused", "n": number, "words": words})
        finally:
            self._clients.end()
            # After the turn that tells it.
            self._loop.call_soon(self._acknowledge, tab, number, client)

    def _acknowledge(self, tab: Tab, number: int, client: str) -> None:
        """As kept only once what was decided is on the disk."""
        tab.settle(number, client)
        if self._journaling is None:
            tab.acknowledge(number, client)
        else:
            self._journaling.when_written(lambda: tab.acknowledge(number, client))

    def do(self, action: actions.Action) -> None:
        """Do it; KeyposeError, in one sentence, when it cannot be done."""
        if isinstance(action, actions.Running):
            self._run(action)
            return
        if self._app_state.edit is None:
            raise Refused("Open a video first.")
        if not isinstance(action, actions.Looking):
            self._holding.require_writable()
        self._edit_to(update(self._app_state.edit, action))
        guide = guide_after(self._app_state.guide, action, self._app_state.edit.doc.body)
        if guide is not self._app_state.guide:
            self._look(guide=guide)

    # --- what follows from a change

    def _edit_to(self, edit: EditorState) -> None:
        before = self._app_state.edit
        if edit is before:
            return
        fit = self._app_state.fit
        self._look(edit=edit, fit=fit if fit is not None and edit.doc is fit.after else None)
        if (before is not None and before.stroke is not None) != (edit.stroke is not None):
            self._runner.hold(edit.stroke is not None)
        received = self._clients.received(edit.stroke.name if edit.stroke else None)
        if self._journaling is not None and self._journaling.note(edit, received):
            self._look(revision=received.revision)
            self._save()
        if before is None:
            return
        if edit.stroke is None and edit.doc is not before.settled:
            self._runner.changed(self._opened, edit)
        self._fitter.changed()

    def _look(self, **changes: Any) -> None:
        self._app_state = replace(self._app_state, **changes)
        if not self._turn_asked:
            self._turn_asked = True
            self._loop.call_soon(self._publish)

    def _publish(self) -> None:
        self._turn_asked = False
        self._tell()
        edit = self._app_state.as_looked_at.edit
        if edit is not None:
            self._show(edit, self._sections.all["trail"])

    def _tell(self) -> None:
        """Tell every tab what has changed since they were told last."""
        self._tabs.tell(self._sections.changed(self._app_state.as_looked_at))

    def surface_seen(self, seen: SurfaceSeen) -> None:
        """The views have looked at an observed surface; what they saw of it."""
        if seen != self._app_state.surface:
            self._look(surface=seen)

    def surfaces_unusable(self, words: str) -> None:
        """Which of the observed surfaces cannot be used: a sentence."""
        self._look(unusable=words)

    # --- saving

    def _save(self) -> None:
        """Save the document as it stands, without a gesture that may yet be taken back."""
        if self._saving_later is not None:
            self._saving_later.cancel()
            self._saving_later = None
        edit, opened, journaling = self._app_state.edit, self._opened, self._journaling
        if edit is None or opened is None or journaling is None:
            return
        path, doc = opened.session_path, edit.settled

        def write() -> None:
            self._holding.require_folder(path.parent, partial(journaling.is_own, path))
            if not path.exists():  # a journal alone would not be found
                journaling.save(journaling.as_written(doc), path)
            journaling.write()
            self._loop.call_soon_threadsafe(journaling.call_written)
            session = save_results(doc, path, edit.results)
            theirs = journaling.save(session, path)
            if theirs is not None:
                self._loop.call_soon_threadsafe(self.note, "check", _set_aside_words(path, theirs))
            with suppress(OSError):  # what is left over does no harm
                tidy_tracks(path.parent)
            with suppress(KeyposeError):  # only the list of recent sessions would lack it
                self._library.remember(path, session)

        self._saver.save(write)

    def _save_soon(self, at_once: bool) -> None:
        """While segments come in one by one, the motion is not written with each of them."""
        if at_once:
            self._save()
        elif self._saving_later is None:
            self._saving_later = self._loop.call_later(SECONDS_BETWEEN_SAVES, self._save)

    def _on_saved(self, saved: Saved) -> None:
        if saved.state == "saved":
            self._warned = None
        self._look(saved=saved)

    # --- tracking

    def _on_running(self, runner: Runner, finished: bool) -> None:
        """The tracker has told something: its results, its progress."""
        was, job = self._app_state.job, runner.job
        is_another = (job.state, job.title) != (was.state, was.title)
        if finished or is_another or self._loop.time() >= self._next_news:
            self._take_news()
        elif self._news_later is None:
            self._news_later = self._loop.call_at(self._next_news, self._take_news)
        if finished or job.state != was.state:
            self._save_soon(at_once=job.state != "running")

    def _take_news(self) -> None:
        """Take over what the tracker has told until now."""
        if self._news_later is not None:
            self._news_later.cancel()
            self._news_later = None
        edit, runner = self._app_state.edit, self._runner
        is_dragged = edit is not None and edit.stroke is not None
        rest = SECONDS_IN_A_GESTURE if is_dragged else SECONDS_BETWEEN_NEWS
        self._next_news = self._loop.time() + rest
        if edit is not None and runner.results is not None:
            edit = replace(edit, results=runner.results)
        self._look(edit=edit, job=runner.job, running=dict(runner.running))

    def _run(self, action: actions.Running) -> None:
        if isinstance(action, actions.Open):
            self._in_background(self._open_named(action))
        elif isinstance(action, actions.Close):
            self._in_background(self.close_session())
        elif isinstance(action, actions.SaveAgain):
            self._saver.again()
        elif isinstance(action, actions.Cancel):
            if not self._fitter.cancel():
                self._runner.cancel()
        elif isinstance(action, actions.LookBefore):
            self._look_back(action.on)
        elif isinstance(action, actions.CloseFit):
            self._look(fit=None)
        elif self._app_state.edit is None or self._opened is None:
            raise Refused("Open a video first.")
        else:
            self._holding.require_writable()
            self._edit_to(end_stroke(self._app_state.edit))
            if isinstance(action, actions.Track):
                self._runner.track(self._opened, self._app_state.edit, action.what)
            else:
                self._fitter.ask(action)

    # --- fitting

    def take_fit(self, edit: EditorState, told: FitTold) -> None:
        """Go on from what was fitted, and tell what it did."""
        self._edit_to(edit)
        self._look(fit=told)

    def _look_back(self, on: bool) -> None:
        fit = self._app_state.fit
        if fit is not None and fit.looking_back != on:
            self._look(fit=replace(fit, looking_back=on))

    # --- opening and closing

    def _in_background(self, work: Coroutine[Any, Any, None]) -> None:
        """Do it while the loop goes on; what goes wrong is told to the tabs."""

        async def told() -> None:
            try:
                await work
            except KeyposeError as error:
                self.note("lost", str(error))
            except Exception as error:  # noqa: BLE001 — or the page would wait for ever
                traceback.print_exception(error)
                self.note("lost", f"This met a fault of Keypose itself ({type(error).__name__}).")

        task = self._loop.create_task(told())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _open_named(self, action: actions.Open) -> None:
        def find() -> Path:
            return self._library.find(action.kind, action.id, action.video)

        try:
            await self.open(await asyncio.to_thread(find))
        except (VideoError, SurfaceError):
            if action.kind == "upload":  # what is no video need not be kept
                await asyncio.to_thread(self._library.discard, action.id)
            raise

    async def open(self, path: Path) -> None:
        """Open a session or a video; KeyposeError when it cannot be, and all stays as it was.

        What is open already stays open as it is: the file may lag behind.
        """
        async with self._opening:
            opened = await asyncio.to_thread(open_for_editing, path, self._library.session_for)
            try:
                if self._opened is not None and self._opened.is_same(opened):
                    await asyncio.to_thread(opened.video.close)
                    return
                edit, problem = await asyncio.to_thread(edit_state, opened)
                film = await asyncio.to_thread(opened.film)
                await self._put_away()
                self._holding.take(opened)
                if opened.is_stale():  # another Keypose wrote on until it let go of the lock
                    opened.video.close()
                    opened = await asyncio.to_thread(
                        open_for_editing, opened.session_path, self._library.session_for
                    )
                    edit, problem = await asyncio.to_thread(edit_state, opened)
            except BaseException:
                opened.video.close()
                self._holding.release()
                raise
            read_only = self._holding.read_only
            if not read_only:
                self._journaling = Journaling(opened.session_path, edit, opened.journal)
            received = opened.journal.received
            self._clients = Clients(received.clients)
            self._opened, self.frames = opened, Frames(opened.video)
            self._look(
                opened=_opened_facts(opened, film),
                revision=received.revision or mark_of(edit.doc),
                edit=edit,
                guide=Guide(first=not edit.doc.keyframes),
                saved=Saved("readonly" if read_only else "saved", 0.0, read_only),
            )
            self._runner.opened(edit)
            if not isinstance(opened.video, SurfaceVideo):
                self._examiner = Examiner(self._loop, opened.video, self._on_damage)
            for words in (*opened.news, *([problem] if problem else [])):
                self.note("check", words)

    def _on_damage(self, info: VideoInfo) -> None:
        """More frames of the open video are known to be missing or damaged."""
        if self._app_state.opened is not None:
            self._look(opened=replace(self._app_state.opened, info=info))

    async def close_session(self) -> None:
        """Save, and go back to the start screen."""
        async with self._opening:
            await self._put_away()

    async def _put_away(self) -> None:
        """Close what is open; SessionError, and it stays open, when it cannot be saved.

        A person who asks for it once more gives up what is not saved.
        """
        await self._settle()
        problem = self._saver.problem
        if problem is not None and problem != self._warned:
            self._warned = problem
            raise SessionError(f"{problem} Ask once more to go on without saving.")
        if self._journaling is not None:
            self._journaling.give_up()
        await self._let_go()

    async def _settle(self) -> None:
        """Have everything written, as far as the disk takes it, with what is tracked until now."""
        await self._runner.leave()
        self._saver.again()
        while True:
            if self._app_state.edit is not None:
                self._edit_to(end_stroke(self._app_state.edit))
            if self._saving_later is not None:
                self._save()
            if self._saver.is_settled:
                return
            await self._saver.settled()

    async def _let_go(self) -> None:
        """Nothing is open from here on, at once; what is slow to close is closed after that."""
        opened, frames, examiner = self._opened, self.frames, self._examiner
        self._opened = self.frames = self._warned = self._examiner = None
        self._saver.give_up()
        self._fitter.closed()
        self._runner.closed()
        if self._journaling is not None:
            self._journaling.close()
            self._journaling = None
        self._holding.release()
        self._clients = Clients()
        self._look(opened=None, edit=None, running={}, job=Job(), saved=Saved(), fit=None)
        self._look(surface=SurfaceSeen(), unusable="", revision="")
        if examiner is not None:
            await asyncio.to_thread(examiner.close)
        if frames is not None:
            frames.close()
        if opened is not None:
            await asyncio.to_thread(opened.video.close)

    async def stop(self) -> None:
        """Save what is unsaved and end the worker; SessionError when something is lost."""
        try:
            async with self._opening:
                await self._settle()
                problem = self._saver.problem
                kept = self._journaling is not None and self._journaling.is_written()
                await self._let_go()
        finally:
            await asyncio.to_thread(self._runner.stop)
        if problem is not None:
            rest = "The last changes are in its journal." if kept else "The last changes are lost."
            raise SessionError(f"{problem} {rest}")

    async def saved_path(self) -> Path:
        """The session's file once it holds everything; SessionError when it cannot be written."""
        opened = self._opened
        if opened is None:
            raise Refused("Open a video first.")
        self._saver.again()
        if self._saving_later is not None:
            self._save()
        await self._saver.settled()
        if self._saver.problem is not None:
            raise SessionError(self._saver.problem)
        return opened.session_path

    def note(self, kind: str, words: str, button: dict[str, Any] | None = None) -> None:
        """Tell every tab something worth a sentence; when there is none, the first that comes."""
        self._tabs.say({"t": "note", "kind": kind, "words": words, "button": button})


def _set_aside_words(path: Path, theirs: Path) -> str:
    return (
        f"Another program changed {path.name} meanwhile: its version is kept as {theirs.name}, "
        "yours goes on."
    )


def _opened_facts(opened: OpenSession, film: str) -> Opened:
    path = opened.session_path
    return Opened(opened.name, str(path), id_of(str(path.absolute())), opened.video.info, film)


def _split_envelope(message: Any) -> tuple[str, int, Any]:
    """Who sends a message, its number, and what is left of it. Without a number nothing is told of
    it, and without a client it is not remembered."""
    if not isinstance(message, dict):
        return "", 0, message
    number, client = message.get("n", 0), message.get("client", "")
    is_number = type(number) is int and 0 <= number < 2**53
    is_client = isinstance(client, str) and CLIENT.fullmatch(client)
    rest = {key: value for key, value in message.items() if key not in ("n", "client")}
    return client if is_client and is_number and number else "", number if is_number else 0, rest
