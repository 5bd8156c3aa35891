"""The one owner of the state. Everything happens on one loop, in the order it arrived.

An action changes the state at once; what follows from it (the scene redrawn, the tabs told, the
session saved, segments tracked anew) is done once per turn of the loop, for the newest state only.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from app.editor import actions
from app.editor.refusal import Refused
from app.editor.state import EditorState
from app.editor.update import ended, update
from app.frames import Frames
from app.guiding import guide_after
from app.library import Library
from app.opening import Workpiece, edit_state, open_workpiece
from app.outlook import Guide, Opened, Outlook, Saved
from app.results import save_results, tidy_tracks
from app.running import Runner
from app.saving import Saver
from app.sections import Sections
from app.tabs import Tab
from tracker.errors import KeyposeError
from tracker.session.files import save_session
from tracker.wording import one_sentence

SECONDS_BETWEEN_SAVES = 3.0
"""Of tracked segments, while more of them are to come; edits are saved at once."""


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
        self._outlook = Outlook()
        self._sections = Sections()
        self._tabs: set[Tab] = set()
        self._piece: Workpiece | None = None
        self._saver = Saver(self._on_saved)
        self._runner = Runner(loop, self._on_running)
        self._turn_asked = False
        self._dragging: Tab | None = None
        self._saving_later: asyncio.TimerHandle | None = None
        self._opening = asyncio.Lock()
        self.frames: Frames | None = None

    @property
    def outlook(self) -> Outlook:
        return self._outlook

    @property
    def piece(self) -> Workpiece | None:
        return self._piece

    # --- tabs

    def join(self) -> Tab:
        """One more tab, told everything."""
        tab = Tab()
        self._tabs.add(tab)
        self._look(tabs=len(self._tabs))
        tab.tell({**self._sections.all, **self._sections.changed(self._outlook)})
        return tab

    def leave(self, tab: Tab) -> None:
        """One tab fewer; the gesture it may have been in the middle of ends as it is."""
        self._tabs.discard(tab)
        if self._outlook.edit is not None and self._dragging is tab:
            self._edit_to(ended(self._outlook.edit))
        self._look(tabs=len(self._tabs))

    def receive(self, tab: Tab, message: Any) -> None:
        """An action from a tab: validated, done, acknowledged."""
        number = message.get("n", 0) if isinstance(message, dict) else 0
        number = number if isinstance(number, int) and 0 <= number < 2**53 else 0
        try:
            action = actions.ACTIONS.validate_python(_without_number(message))
            self.do(action)
            if getattr(action, "stroke", None) is not None:
                self._dragging = tab
        except ValidationError as error:
            tab.say({"t": "refused", "n": number, "words": one_sentence(error)})
        except KeyposeError as error:
            tab.say({"t": "refused", "n": number, "words": str(error)})
        self._loop.call_soon(tab.acknowledge, number)  # after the turn that tells what it did

    def do(self, action: actions.Action) -> None:
        """Do it; KeyposeError, in one sentence, when it cannot be done."""
        if isinstance(action, actions.Running):
            self._run(action)
            return
        if self._outlook.edit is None:
            raise Refused("Open a video first.")
        self._edit_to(update(self._outlook.edit, action))
        guide = guide_after(self._outlook.guide, action)
        if guide is not self._outlook.guide:
            self._look(guide=guide)

    # --- what follows from a change

    def _edit_to(self, edit: EditorState) -> None:
        before = self._outlook.edit
        if edit is before:
            return
        self._look(edit=edit)
        if before is None or edit.stroke is not None:
            return
        settled = before.stroke.before if before.stroke else before.doc
        if edit.doc is not settled:
            self._save()
            self._runner.changed(self._piece, edit)

    def _look(self, **changes: Any) -> None:
        self._outlook = replace(self._outlook, **changes)
        if not self._turn_asked:
            self._turn_asked = True
            self._loop.call_soon(self._turn)

    def _turn(self) -> None:
        self._turn_asked = False
        fresh = self._sections.changed(self._outlook)
        if fresh:
            for tab in self._tabs:
                tab.tell(fresh)
        if self._outlook.edit is not None:
            self._show(self._outlook.edit, self._sections.all["trail"])

    # --- saving

    def _save(self) -> None:
        edit, piece = self._outlook.edit, self._piece
        if edit is None or piece is None:
            return
        path = piece.session_path

        def write() -> None:
            path.parent.mkdir(parents=True, exist_ok=True)
            session = save_results(edit.doc, path, edit.results)
            save_session(session, path)
            tidy_tracks(path.parent)
            with suppress(KeyposeError):  # only the list of recent sessions would lack it
                self._library.remember(path, session)

        self._saver.save(write)

    def _save_soon(self, at_once: bool) -> None:
        """While segments come in one by one, the motion is not written with each of them."""
        if self._saving_later is not None:
            self._saving_later.cancel()
            self._saving_later = None
        if at_once:
            self._save()
        else:
            self._saving_later = self._loop.call_later(SECONDS_BETWEEN_SAVES, self._save)

    def _on_saved(self, saved: Saved) -> None:
        self._look(saved=saved)

    # --- tracking

    def _on_running(self, runner: Runner, finished: bool) -> None:
        """The tracker has told something: its results, its progress."""
        edit, was = self._outlook.edit, self._outlook.job.state
        if edit is not None and runner.results is not None:
            edit = replace(edit, results=runner.results)
        self._look(edit=edit, job=runner.job, running=dict(runner.running))
        if finished or runner.job.state != was:
            self._save_soon(at_once=runner.job.state != "running")

    def _run(self, action: actions.Running) -> None:
        if isinstance(action, actions.Open):
            self._loop.create_task(self._open_named(action))
        elif isinstance(action, actions.Close):
            self._loop.create_task(self.close_session())
        elif isinstance(action, actions.SaveAgain):
            self._saver.again()
        elif isinstance(action, actions.Cancel):
            self._runner.cancel()
        elif self._outlook.edit is None or self._piece is None:
            raise Refused("Open a video first.")
        else:
            self._edit_to(ended(self._outlook.edit))
            self._runner.track(self._piece, self._outlook.edit, action.what)

    # --- opening and closing

    async def _open_named(self, action: actions.Open) -> None:
        def find() -> Path:
            return self._library.find(action.kind, action.id, action.video)

        try:
            await self.open(await asyncio.to_thread(find))
        except KeyposeError as error:
            if action.kind == "upload":  # what cannot be opened need not be kept
                await asyncio.to_thread(self._library.discard, action.id)
            self.note("lost", str(error))

    async def open(self, path: Path) -> None:
        """Open a session or a video; KeyposeError when it cannot be, and all stays as it was."""
        async with self._opening:
            piece = await asyncio.to_thread(open_workpiece, path, self._library.session_for)
            edit = await asyncio.to_thread(edit_state, piece)
            await self._put_away()
            self._piece = piece
            self.frames = Frames(piece.video)
            self._look(
                opened=Opened(piece.name, str(piece.session_path), piece.video.info),
                edit=edit,
                guide=Guide(first=not edit.doc.keyframes),
                saved=Saved("saved", 0.0, "Nothing to save yet" if piece.fresh else ""),
            )
            self._runner.opened(edit)

    async def close_session(self) -> None:
        """Save, and go back to the start screen."""
        async with self._opening:
            await self._put_away()

    async def _put_away(self) -> None:
        edit = self._outlook.edit
        if edit is not None:
            self._edit_to(ended(edit))
        self._runner.closed()
        await self._saver.settled()
        if self.frames is not None:
            self.frames.close()
            self.frames = None
        if self._piece is not None:
            await asyncio.to_thread(self._piece.video.close)
            self._piece = None
        self._look(opened=None, edit=None, running={})

    async def stop(self) -> None:
        """Save what is unsaved and end the worker."""
        await self.close_session()
        await asyncio.to_thread(self._runner.stop)

    def note(self, kind: str, words: str, button: dict[str, Any] | None = None) -> None:
        """Tell every tab something worth a sentence."""
        for tab in self._tabs:
            tab.say({"t": "note", "kind": kind, "words": words, "button": button})


def _without_number(message: Any) -> Any:
    if not isinstance(message, dict):
        return message
    return {key: value for key, value in message.items() if key != "n"}
