"""The one owner of the state. Everything happens on one loop, in the order it arrived.

An action changes the state at once; what follows from it (the scene redrawn, the tabs updated, the
session saved, segments tracked anew) is done once per turn of the loop, for the newest state only.
"""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from keypose.app.document.library import Library
from keypose.app.document.library.names import clean_name
from keypose.app.document.open import OpenSession, with_own_motion
from keypose.app.editor import actions
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.known import KnownMotion
from keypose.app.editor.live import moved_spans
from keypose.app.editor.message import Look
from keypose.app.editor.state import EditorState
from keypose.app.editor.update import end_stroke, update
from keypose.app.export.importing import Import
from keypose.app.jobs.wire import failure_message
from keypose.app.render.video_frames import Frames
from keypose.app.state.app_state import (
    AppState,
    Guide,
    KnownKeypoints,
    OpenedFile,
    Saved,
    SurfaceSeen,
)
from keypose.app.state.job_state import JobState
from keypose.app.store.faults import Fault, Faults
from keypose.app.store.guide import guide_after
from keypose.app.store.imported import ImportOutcome, ImportTarget, with_import
from keypose.app.store.opener import Opener
from keypose.app.store.other_films import OtherFilms
from keypose.app.store.proposals import Proposals
from keypose.app.store.saving import SessionWriter
from keypose.app.store.sections import PLACES, Sections
from keypose.app.store.session_manager import PoseLibrary, Shelf
from keypose.app.store.tabs import Clients, Tab, Tabs, split_envelope
from keypose.app.words.problems import repeats_words
from keypose.app.working.fitting import Fitter
from keypose.app.working.keypoints import KeypointFinder
from keypose.app.working.learning import DraftLearner
from keypose.app.working.people import PeopleLooker
from keypose.app.working.previews import HandPreviews
from keypose.app.working.queue import WorkQueue
from keypose.app.working.segments import SegmentTracker
from keypose.app.working.space import SpaceSolving
from keypose.tracker.errors import one_sentence
from keypose.tracker.session.references import Repeats
from keypose.tracker.storage.edit_history import mark_of
from keypose.tracker.storage.results import Results
from keypose.tracker.video import VideoInfo

SECONDS_BETWEEN_PROGRESS = 0.2
SECONDS_IN_A_GESTURE = 0.6
"""Of passes, which may come faster than any page can draw them; a hand that drags goes first."""


@contextmanager
def _collected(errors: list[Fault], place: str) -> Iterator[None]:
    """An error in what follows from an edit is collected under the part of the page it shows in."""
    try:
        yield
    except Exception as error:  # noqa: BLE001 — all else that follows goes on; it is said
        errors.append((place, error))


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
        self._faults = Faults(self.note)
        self._queue = WorkQueue(loop, self._on_progress)
        self._space = SpaceSolving(self._queue, self)
        self._segments = SegmentTracker(self._queue, self, self._space.anew)
        self._previews = HandPreviews(self._queue, self)
        self._fitter = Fitter(self._queue, self, self._segments)
        self._learner = DraftLearner(self._queue, self)
        waiting = (self._segments, self._previews, self._learner, self._space)
        self._queue.serve(*(client.go_on for client in waiting))
        self._people = PeopleLooker(self._queue, self, lambda people: self._set(people=people))
        self._keypoints = KeypointFinder(
            loop, lambda known_keypoints: self._set(keypoints=known_keypoints)
        )
        self._turn_asked = False
        self._dragging: Tab | None = None
        self._progress_later: asyncio.TimerHandle | None = None
        self._next_progress = 0.0
        self._tasks: set[asyncio.Task[None]] = set()
        self._writer = SessionWriter(loop, self, library, self._on_saved)
        self._opener = Opener(loop, self, library, self._writer, self._queue, self._segments)
        self._shelf = Shelf(self, library)
        self._proposals = Proposals(self, self._fitter, self._writer.lock)
        self._clients = Clients()
        self._poses = PoseLibrary(library.workspace, lambda poses: self._set(poses=poses))

    @property
    def app_state(self) -> AppState:
        return self._app_state

    @property
    def name(self) -> str:
        """What its files are called, without what no file can be called."""
        if self.opened is None or self._app_state.edit is None:
            return "keypose"
        title = self._app_state.edit.doc.title
        return clean_name(title) if title else self.opened.name

    @property
    def opened(self) -> OpenSession | None:
        return self._opener.opened

    @property
    def frames(self) -> Frames | None:
        """The pictures of what is open."""
        return self._opener.frames

    @property
    def films(self) -> OtherFilms | None:
        """The pictures of the other films of what is open."""
        return self._opener.films

    # --- tabs

    def join(self) -> Tab:
        """One more tab, sent everything."""
        tab = self._tabs.join()
        self._set(tabs=len(self._tabs))
        self._send_sections()  # what fails is said when the turn is published
        self._tabs.send_all(tab, self._sections.all)
        return tab

    def leave(self, tab: Tab) -> None:
        """One tab fewer; the gesture it may have been in the middle of ends as it is."""
        self._tabs.leave(tab)
        if self._app_state.edit is not None and self._dragging is tab:
            self._clients.resume_gesture()
            self._edit_to(end_stroke(self._app_state.edit))
            self._clients.end()
        self._set(tabs=len(self._tabs))
        self._show_before(False)

    def receive(self, tab: Tab, message: Any) -> None:
        """An action from a tab: validated, done once, acknowledged."""
        client, number, message = split_envelope(message)
        try:
            if not self._clients.begin(client, number):
                return
            action = actions.ACTIONS.validate_python(message)
            self.do(action)
            under_way = self._app_state.edit.stroke if self._app_state.edit else None
            if under_way is not None and under_way.name == getattr(action, "stroke", None):
                self._dragging = tab
        except ValidationError as error:
            tab.send({"t": "refused", "n": number, "words": one_sentence(error)})
        except Exception as error:  # noqa: BLE001 — the state is as it was, the line stays
            tab.send({"t": "refused", "n": number, "words": failure_message(error)})
        finally:
            self._clients.end()
            # After the turn that sends it.
            self._loop.call_soon(self._acknowledge, tab, number, client)

    def _acknowledge(self, tab: Tab, number: int, client: str) -> None:
        """Acknowledge edits as saved only once they are on the disk."""
        tab.mark_done(number, client)
        self._writer.when_logged(lambda: tab.acknowledge(number, client))

    def do(self, action: actions.Action) -> None:
        """Do it; KeyposeError, in one sentence, when it cannot be done."""
        if isinstance(action, actions.Running):
            self._run_action(action)
            return
        if isinstance(action, actions.PoseKeeping):
            self._in_background(self._poses.change(action, self._app_state.edit))
            return
        if self._app_state.edit is None:
            raise ActionRefused("Open a video first.")
        if isinstance(action, actions.InsertPose):
            action = self._poses.inserting(action)
        if not isinstance(action, Look):
            self._writer.lock.require_writable()
            self._proposals.require_none()
        self._edit_to(update(self._app_state.edit, action))
        guide = guide_after(self._app_state.guide, action, self._app_state.edit.doc.subject.body)
        if guide is not self._app_state.guide:
            self._set(guide=guide)

    # --- what follows from a change

    def _edit_to(self, edit: EditorState) -> None:
        before = self._app_state.edit
        if edit is before:
            return
        if before is not None:
            if self.opened and edit.doc.subject.first_motion != before.doc.subject.first_motion:
                edit = with_own_motion(edit, self.opened.session_path)
            edit = edit.stamped(before, time.time())
            if self._app_state.opened is not None:  # an undone step may not know them
                edit = edit.with_repeats(self._app_state.opened.repeats)
            video = edit.doc.view.video
            if self.opened and video.deinterlace != before.doc.view.video.deinterlace:
                self.opened.video.deinterlace(video.deinterlace)
        fit = self._app_state.fit
        up = self._app_state.up
        self._set(
            edit=edit,
            fit=fit if fit is not None and edit.doc is fit.after else None,
            up=up if up is not None and edit.doc is up.after else None,
        )
        if (before is not None and before.stroke is not None) != (edit.stroke is not None):
            self._queue.pause(edit.stroke is not None)
        received = self._clients.received(edit.stroke.name if edit.stroke else None)
        if self._writer.log(edit, received):
            self._set(revision=received.revision)
            self._writer.save()
        if before is None:
            return
        is_done = edit.stroke is None and edit.doc is not before.settled
        is_over = before.stroke is not None and edit.stroke is None
        if is_done:
            self._segments.changed(before)
            self._previews.let_go()
            self._learner.edited(before, edit)
        elif moved_spans(edit) and edit.doc is not before.doc:
            self._segments.dragged()
            self._previews.dragged()
        elif is_over:
            self._previews.let_go()
        self._fitter.changed()
        self._learner.go_on()
        if is_done or is_over:
            self._queue.go_on()

    def _set(self, **changes: Any) -> None:
        self._app_state = replace(self._app_state, **changes)
        if not self._turn_asked:
            self._turn_asked = True
            self._loop.call_soon(self._publish)

    def _publish(self) -> None:
        self._turn_asked = False
        shown, errors = self._send_sections()
        if self._app_state.edit is not None and self.opened is not None:
            opened, edit = self.opened, self._app_state.edit
            with _collected(errors, "the keypoints"):
                self._keypoints.look(opened, edit)
        if shown.edit is not None and "trail" in self._sections.all:
            with _collected(errors, "the views"):
                self._show(shown.edit, self._sections.all["trail"])
        self._faults.report(errors, self._app_state.saved.state in ("saved", "saving"))

    def _send_sections(self) -> tuple[AppState, list[Fault]]:
        """Send every tab what has changed since the last time. What is displayed, and why some
        part of the page is not up to date."""
        shown, errors = self._app_state, list[Fault]()
        with _collected(errors, "the preview"):
            shown = shown.displayed
        self._tabs.update(self._sections.changed(shown))
        errors += [(PLACES[name], error) for name, error in self._sections.failed.items()]
        return shown, errors

    def surface_seen(self, view: SurfaceSeen) -> None:
        """The views have looked at an observed surface; what they saw of it."""
        if view != self._app_state.surface:
            self._set(surface=view)

    def surfaces_unusable(self, words: str) -> None:
        """Set which of the observed surfaces cannot be used: a sentence."""
        self._set(unusable=words)

    def _on_saved(self, saved: Saved) -> None:
        if saved.state == "saved":
            self._opener.saved()
        self._set(saved=saved)

    # --- tracking

    def know(self, results: Results) -> None:
        """More is known of the motion. It is shown with the next progress, for passes come faster
        than any page can draw them."""
        self._app_state = replace(
            self._app_state, edit=self._app_state.editing.with_results(results)
        )

    def show_motion(self, motion: KnownMotion) -> None:
        """Another motion is known, or shown, while a hand moves a keyframe: at once."""
        if motion is not self._app_state.editing.motion:
            self._set(edit=replace(self._app_state.editing, motion=motion))

    def _on_progress(self, finished: bool) -> None:
        """The worker has reported something, or does something else."""
        was, job = self._app_state.job, self._queue.state
        is_another = (job.state, job.title) != (was.state, was.title)
        if finished or is_another or self._loop.time() >= self._next_progress:
            self._take_progress()
        elif self._progress_later is None:
            self._progress_later = self._loop.call_at(self._next_progress, self._take_progress)
        if finished or job.state != was.state:
            self._keypoints.tracked()
            if job.state == "running":
                self._writer.save_soon()
            else:
                self._writer.save()

    def _take_progress(self) -> None:
        """Take over what the worker has reported until now."""
        if self._progress_later is not None:
            self._progress_later.cancel()
            self._progress_later = None
        edit = self._app_state.edit
        is_dragged = edit is not None and edit.stroke is not None
        rest = SECONDS_IN_A_GESTURE if is_dragged else SECONDS_BETWEEN_PROGRESS
        self._next_progress = self._loop.time() + rest
        self._set(
            job=self._queue.state,
            running=dict(self._segments.running),
            following=self._fitter.following,
        )

    def _run_action(self, action: actions.Running) -> None:
        if isinstance(action, actions.Open):
            self._in_background(self._opener.open_named(action))
        elif isinstance(action, actions.Close):
            self._in_background(self.close_session())
        elif isinstance(action, actions.Shelving):
            self._in_background(self._shelf.do(action))
        elif isinstance(action, actions.SaveAgain):
            self._writer.saver.retry()
        elif isinstance(action, actions.Cancel):
            if not self._fitter.cancel():
                self._queue.cancel()
        elif isinstance(action, actions.FindPeople):
            self._people.look(action.frame)
        elif isinstance(action, actions.LookBefore):
            self._show_before(action.on)
        elif isinstance(action, actions.CloseFit):
            self._set(fit=None)
        elif isinstance(action, actions.CloseUp):
            self._set(up=None)
        elif isinstance(action, actions.Previewing):
            self._proposals.answer_sizes(action)
        elif isinstance(action, actions.ApplyReduction | actions.DiscardReduction):
            self._proposals.answer_reduction(action)
        elif self._app_state.edit is None or self.opened is None:
            raise ActionRefused("Open a video first.")
        else:
            self._writer.lock.require_writable()
            if isinstance(action, actions.Reduce):
                self._proposals.reduce(action)
                return
            self._proposals.require_none()
            self._edit_to(end_stroke(self._app_state.edit))
            if isinstance(action, actions.AddFilm):
                self._in_background(self._add_film(action, self.opened))
            elif isinstance(action, actions.Track):
                self._set(edit=self._app_state.edit.with_proposals_anew())
                self._segments.track(action.what, action.frames)
            else:
                self._fitter.ask(action)

    async def _add_film(self, action: actions.AddFilm, opened: OpenSession) -> None:
        path = await asyncio.to_thread(self._library.find, action.kind, action.id)
        if self.opened is opened:
            self._fitter.ask(actions.FilmToAdd(path))

    def take(self, after: AppState) -> None:
        """Go on from what a job, or the answer to it, made of the state."""
        self._set(
            fit=after.fit,
            up=after.up,
            draft=after.draft,
            preview=after.preview,
            reduction=after.reduction,
        )
        self._edit_to(after.editing)

    # --- files from elsewhere

    def import_target(self) -> ImportTarget:
        """What a file would be imported into now; Refused where nothing can be."""
        edit, opened = self._app_state.edit, self.opened
        if edit is None or opened is None:
            raise ActionRefused("Open a video first.")
        self._writer.lock.require_writable()
        self._proposals.require_none()
        return ImportTarget(edit.settled, opened.session_path, opened.video.info)

    def take_import(self, target: ImportTarget, imported: Import, file: str) -> ImportOutcome:
        """Go on with what was imported; KeyposeError where the session is another one by now."""
        now = self.import_target()
        edit = self._app_state.edit
        if edit is None or now.session_path != target.session_path:
            raise ActionRefused("Another session was opened meanwhile: import again.")
        after, outcome = with_import(
            target.doc, end_stroke(edit), imported, file, target.session_path
        )
        self._edit_to(after)
        return outcome

    def _show_before(self, on: bool) -> None:
        fit, preview = self._app_state.fit, self._app_state.preview
        if preview is not None and preview.looking_back != on:
            self._set(preview=replace(preview, looking_back=on))
        if fit is not None and fit.looking_back != on:
            self._set(fit=replace(fit, looking_back=on))

    # --- opening and closing

    def _in_background(self, work: Coroutine[Any, Any, None]) -> None:
        """Do it while the loop goes on; what goes wrong is sent to the tabs."""

        async def outcome() -> None:
            try:
                await work
            except Exception as error:  # noqa: BLE001 — or the page would wait for ever
                self.note("lost", failure_message(error))

        task = self._loop.create_task(outcome())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def open(self, path: Path) -> None:
        """Open a session or a video; KeyposeError when it cannot be, and all stays as it was."""
        await self._opener.open(path)

    async def close_session(self) -> None:
        """Save, and go back to the start screen."""
        await self._opener.close()

    async def stop(self) -> None:
        """Save what is unsaved and end the worker; SessionError when something is lost."""
        await self._opener.stop()

    async def saved_path(self) -> Path:
        """The session's file once it holds everything; SessionError when it cannot be written."""
        return await self._opener.saved_path()

    async def read_poses(self) -> None:
        """The kept poses may have changed since another session was opened."""
        await self._poses.read()

    def session_opened(self, opened: OpenSession, file: OpenedFile, edit: EditorState) -> None:
        """Another session is open."""
        received = opened.journal.received
        self._clients = Clients(received.clients)
        self._set(
            opened=file,
            revision=received.revision or mark_of(edit.doc),
            edit=edit,
            guide=Guide(first=not edit.doc.subject.keyframes),
        )
        self._space.anew()
        self.lock_changed()

    def lock_changed(self) -> None:
        """Who may write the open session is known, or another one by now."""
        read_only = self._writer.lock.read_only
        self._set(saved=Saved("readonly" if read_only else "saved", 0.0, read_only))
        self._queue.go_on()

    def session_closed(self) -> None:
        """Nothing is open any more."""
        self._fitter.closed()
        self._learner.closed()
        self._keypoints.closed()
        self._segments.closed()
        self._queue.closed()
        self._writer.close()
        self._clients = Clients()
        self._set(
            opened=None, edit=None, running={}, job=JobState(), saved=Saved(), fit=None, up=None
        )
        self._set(
            draft=None,
            preview=None,
            reduction=None,
            following=None,
            people={},
            keypoints=KnownKeypoints(),
        )
        self._set(surface=SurfaceSeen(), unusable="", revision="")

    def end_gesture(self) -> None:
        """The gesture under way, if there is one, ends as it is."""
        if self._app_state.edit is not None:
            self._edit_to(end_stroke(self._app_state.edit))

    def show_damage(self, info: VideoInfo) -> None:
        """More frames of the open video are known to be missing or damaged."""
        if self._app_state.opened is not None:
            self._set(opened=replace(self._app_state.opened, info=info))

    def show_repeats(self, repeats: Repeats) -> None:
        """Repeated frames were found in the open video: its session knows them from now on."""
        opened, edit = self._app_state.opened, self._app_state.edit
        if opened is None or edit is None:
            return
        is_news = edit.doc.view.video.repeats is None
        self._set(opened=replace(opened, repeats=repeats), edit=edit.with_repeats(repeats))
        if is_news:
            self.note("info", repeats_words(len(repeats.frames), edit.frame_count))

    def broadcast(self, message: dict[str, Any]) -> None:
        """Send every tab that is there a message that needs no words."""
        if len(self._tabs):
            self._tabs.send(message)

    def note(self, kind: str, words: str, button: dict[str, Any] | None = None) -> None:
        """Send every tab a sentence; when there is none, the first that comes."""
        self._tabs.send({"t": "note", "kind": kind, "words": words, "button": button})
