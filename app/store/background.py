"""Work behind all else: look for damaged frames and people, find keypoints, learn from poses."""

from __future__ import annotations

import asyncio
import os
import sys
import threading
import traceback
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from keypose.app.document.open import OpenSession
from keypose.app.editor.documents import unchanged
from keypose.app.editor.drafted import newly_posed
from keypose.app.editor.state import EditorState
from keypose.app.jobs.find_people import FindPeople
from keypose.app.jobs.job import Ended, Failed, Finished
from keypose.app.jobs.learn import LearnDrafts, Learned
from keypose.app.state.app_state import KnownKeypoints
from keypose.app.state.outcomes import Boxes
from keypose.app.store.owner import StateOwner
from keypose.app.store.runner import Runner
from keypose.tracker.errors import KeyposeError, VideoError
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session.references import Repeats
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.cache import found_before
from keypose.tracker.storage.fingerprints import Span, has_drafted_keypoints
from keypose.tracker.storage.sidecars import keypoints_of_session
from keypose.tracker.video import Video, VideoInfo

T = TypeVar("T")

_NICENESS = 10
_PAUSE_S = 2.0
"""Before it begins: the page that a person waits for comes first, and a low priority does not free
the interpreter. And before it looks again: reading may show that frames are numbered otherwise."""
_SECONDS_TO_END = 5.0
"""Until what was cancelled is left to itself."""


class Examiner:
    """Decodes the whole video once, in a thread of its own, and again where reading numbers its
    frames anew; `found` receives what is damaged, `repeats` which frames are repeated."""

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        video: Video,
        found: Callable[[VideoInfo], None],
        repeats: Callable[[Repeats], None],
    ) -> None:
        """Both are called on the loop: `found` as often as more is known to be damaged or missing,
        `repeats` when every frame has been decoded, where there are any."""
        self._loop, self._video, self._found, self._repeats = loop, video, found, repeats
        self._known = Repeats()
        self._ended, self._reported = threading.Event(), video.info
        self._thread = threading.Thread(target=self._run, name="examining", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End it, soon; nothing is reported any more."""
        self._ended.set()
        self._thread.join(_SECONDS_TO_END)

    def _run(self) -> None:
        _lower_priority()
        while not self._ended.wait(_PAUSE_S):
            try:
                self._examine()
            except VideoError:
                return  # closed or gone meanwhile: whoever reads frames gets the error

    def _examine(self) -> None:
        """Examine what is not examined yet: at first everything, then nothing or what has become of
        it.

        Until all of that is, what was found before still counts.
        """
        for _ in self._video.examine(0, self._video.info.frame_count - 1):
            if self._ended.is_set():
                return
            if _unusable(self._video.info) > _unusable(self._reported):
                self._pass_on(self._video.info)
        if _unusable(self._video.info) != _unusable(self._reported):
            self._pass_on(self._video.info)
        if (repeats := self._video.repeats()) != self._known:
            self._known = repeats
            self._loop.call_soon_threadsafe(self._report, self._repeats, repeats)

    def _pass_on(self, info: VideoInfo) -> None:
        self._reported = info
        self._loop.call_soon_threadsafe(self._report, self._found, info)

    def _report(self, found: Callable[[T], None], what: T) -> None:
        if not self._ended.is_set():
            found(what)


def _unusable(info: VideoInfo) -> frozenset[int]:
    return frozenset((*info.damaged, *info.missing))


def _lower_priority() -> None:
    """Let others go first, where threads have a priority of their own."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICENESS)


MOST_REMEMBERED = 8
"""Answers that are kept."""

_Read: TypeAlias = Callable[[], Keypoints | None]


@dataclass(frozen=True, eq=False)
class _Question:
    """Which keypoints; the same where all that decides it is unchanged."""

    made_of: tuple[Any, ...]
    read: _Read


class KeypointFinder:
    """Reads in a thread, one after the other; `found` is called on the loop with all that is known
    about the newest state."""

    def __init__(
        self, loop: asyncio.AbstractEventLoop, found: Callable[[KnownKeypoints], None]
    ) -> None:
        self._loop, self._found = loop, found
        self._answers: list[tuple[_Question, Keypoints | None]] = []
        self._wanted: tuple[_Question, ...] = ()
        self._shown: tuple[_Question, ...] = ()
        self._reading: asyncio.Task[None] | None = None

    def closed(self) -> None:
        """No session is open any more."""
        self._answers, self._wanted, self._shown = [], (), ()

    def tracked(self) -> None:
        """More was found: what was not there may be now."""
        self._answers = [each for each in self._answers if each[1] is not None]
        self._shown = ()

    def look(self, opened: OpenSession, edit: EditorState) -> None:
        """The state is another one, perhaps at another frame."""
        doc, folder = edit.settled, opened.session_path.parent
        of_file, span = _of_file(doc, folder), _span_at(doc, edit.frame)
        self._wanted = (of_file, _of_segment(doc, span, partial(self._read_before, of_file)))
        if self._reading is None:
            self._go_on()

    def _go_on(self) -> None:
        """Show what is wanted, once all of it has been read."""
        if len(self._shown) == len(self._wanted) and all(map(_is_same, self._shown, self._wanted)):
            return
        answers = [self._answer(question) for question in self._wanted]
        for question, answer in zip(self._wanted, answers, strict=True):
            if answer is None:
                self._reading = self._loop.create_task(self._read(question))
                return
        self._shown = self._wanted
        of_file, of_segment = (keypoints for answer in answers for keypoints in answer or ())
        self._found(KnownKeypoints(of_segment, of_file))

    def _answer(self, question: _Question) -> tuple[Keypoints | None] | None:
        """None where it was not asked yet."""
        return next(
            ((keypoints,) for known, keypoints in self._answers if _is_same(known, question)), None
        )

    def _read_before(self, question: _Question) -> Keypoints | None:
        return next(iter(self._answer(question) or ()), None)

    async def _read(self, question: _Question) -> None:
        keypoints = await asyncio.to_thread(_or_none, question.read)
        self._answers = [*self._answers, (question, keypoints)][-MOST_REMEMBERED:]
        self._reading = None
        self._go_on()


def _is_same(question: _Question, other: _Question) -> bool:
    return unchanged(question.made_of, other.made_of)


def _or_none(read: _Read) -> Keypoints | None:
    """Tracking says what is wrong with a file; here nothing of it is shown."""
    try:
        return read()
    except KeyposeError:
        return None
    except Exception:  # noqa: BLE001 — a fault of ours, or no other frame's would be looked for
        traceback.print_exc()
        return None


def _of_file(doc: Session, folder: Path) -> _Question:
    name = "" if doc.view.keypoints is None else str(folder / doc.view.keypoints.file)
    return _Question(("file", name), partial(keypoints_of_session, doc, folder))


def _of_segment(doc: Session, span: Span | None, drafted: _Read) -> _Question:
    """What decides where a network looked in a segment."""
    if span is None:
        return _Question(("segment",), lambda: None)
    ends = [keyframe for keyframe in doc.subject.keyframes if keyframe.frame in span]
    camera = doc.view.camera, doc.view.camera_motion, doc.view.camera_keyframes
    network = doc.settings.network, doc.view.keypoints, has_drafted_keypoints(doc)
    made_of = ("segment", *span, *ends, doc.subject.body, *camera, *network)
    return _Question(made_of, lambda: found_before(doc, span, drafted()))


def _span_at(doc: Session, frame: int) -> Span | None:
    """The segment around a frame whose keypoints a network finds; None where none does."""
    wanted = "keypoints" in doc.settings.cues_used and doc.view.given_keypoints is None
    if doc.view.surface is not None or not wanted or not is_persons(doc.subject.body):
        return None
    return next((span for span in doc.spans if span[0] <= frame <= span[1]), None)


class DraftLearner:
    """Waits while something else is at work or dragged. What a person posed is never changed, and
    what they undo is not learned from."""

    def __init__(self, runner: Runner, host: StateOwner) -> None:
        self._runner = runner
        self._host = host
        self._waiting: frozenset[int] = frozenset()
        self._found: tuple[LearnDrafts, EditorState, Learned] | None = None
        self._announced = False

    def closed(self) -> None:
        """No session is open any more."""
        self._waiting, self._found, self._announced = frozenset(), None, False

    def edited(self, before: EditorState, after: EditorState) -> None:
        """An edit is done; keyframes may be new."""
        self._waiting |= newly_posed(before, after)

    def go_on(self) -> None:
        """Take over what was found, or begin, unless somebody drags."""
        opened, edit = self._host.opened, self._host.app_state.edit
        if opened is None or edit is None or edit.stroke is not None:
            return
        around = self._waiting.intersection(edit.keys)
        if self._found is not None:
            self._take(*self._found)
        elif around:
            job = LearnDrafts.of(opened, edit, around)
            self._runner.follow(job, lambda end: self._on_end(job, edit, end))

    def _on_end(self, job: LearnDrafts, began: EditorState, end: Ended) -> None:
        self._waiting -= {*job.around}
        if isinstance(end, Finished) and not end.cancelled:
            self._found = job, began, end.result
        self.go_on()

    def _take(self, job: LearnDrafts, began: EditorState, poses: Learned) -> None:
        self._found = None
        with suppress(KeyposeError):  # drafts that cannot be stay as they are
            after, words = job.taken(poses, began, self._host.app_state)
            self._host.take(after)
            if words and not self._announced:
                self._announced = True
                self._host.note("info", words)


class PeopleLooker:
    """Looks for people in a picture on which a box is about to be drawn, once a picture; `found`
    receives the boxes by frame, None of a picture that could not be looked at to the end."""

    def __init__(
        self,
        runner: Runner,
        host: StateOwner,
        found: Callable[[Mapping[int, Boxes | None]], None],
    ) -> None:
        self._runner, self._host, self._found = runner, host, found

    def look(self, frame: int) -> None:
        """Begin, unless it is known, or something else is at work: then it may be asked again."""
        opened, edit = self._host.opened, self._host.app_state.edit
        if opened is None or edit is None or not 0 <= frame < edit.frame_count:
            return
        if frame not in self._host.app_state.people:
            job = FindPeople.of(opened, edit, frame)
            self._runner.look(job, partial(self._on_end, frame, opened))

    def _on_end(self, frame: int, opened: OpenSession, end: Ended) -> None:
        if self._host.opened is not opened:
            return
        boxes = end.result if isinstance(end, Finished) and not end.cancelled else None
        self._found({**self._host.app_state.people, frame: boxes})
        if isinstance(end, Failed):
            self._host.note("check", end.words)
