"""Find the keypoints of the present segment and of the session's file, to be shown."""

from __future__ import annotations

import asyncio
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from keypose.app.document.open import OpenSession
from keypose.app.editor.documents import unchanged
from keypose.app.editor.state import EditorState
from keypose.app.state.app_state import KnownKeypoints
from keypose.tracker.errors import KeyposeError
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.cache import found_before
from keypose.tracker.storage.fingerprints import Span, has_drafted_keypoints
from keypose.tracker.storage.sidecars import keypoints_of_session

MOST_REMEMBERED = 16
"""Answers that are kept."""

_Read: TypeAlias = Callable[[], Keypoints | None]


@dataclass(frozen=True, eq=False)
class _Question:
    """Which keypoints are asked for.

    made_of: all that decides the answer: while it is unchanged, the question is the same one.
    read: finds the answer.
    """

    made_of: tuple[Any, ...]
    read: _Read


class KeypointFinder:
    """Reads in a thread, one after the other; `show` is called on the loop with all that is known
    about the newest state."""

    def __init__(
        self, loop: asyncio.AbstractEventLoop, show: Callable[[KnownKeypoints], None]
    ) -> None:
        self._loop, self._show = loop, show
        self._answers: list[tuple[_Question, Keypoints | None]] = []
        self._wanted: tuple[_Question, ...] = ()
        self._shown: tuple[_Question, ...] = ()
        self._reading: asyncio.Task[None] | None = None
        self._films: tuple[str, ...] = ()

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
        self._films = tuple(view.id for view in doc.views[1:])
        of_films = (_of_file(doc.alone(view), folder) for view in self._films)
        of_segment = _of_segment(doc, span, partial(self._read_before, of_file))
        self._wanted = (of_file, of_segment, *of_films)
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
        of_file, of_segment, *others = (each for answer in answers for each in answer or ())
        of_films = zip(self._films, others, strict=True)
        there = {view: each for view, each in of_films if each is not None}
        self._show(KnownKeypoints(of_segment, of_file, there))

    def _answer(self, question: _Question) -> tuple[Keypoints | None] | None:
        """The answer to a question as a tuple of one, since it may be None; None where it was not
        asked yet."""
        return next(
            ((keypoints,) for asked, keypoints in self._answers if _is_same(asked, question)), None
        )

    def _read_before(self, question: _Question) -> Keypoints | None:
        """The answer to a question that was read; None where there is none."""
        return next(iter(self._answer(question) or ()), None)

    async def _read(self, question: _Question) -> None:
        keypoints = await asyncio.to_thread(_or_none, question.read)
        self._answers = [*self._answers, (question, keypoints)][-MOST_REMEMBERED:]
        self._reading = None
        self._go_on()


def _is_same(before: _Question, question: _Question) -> bool:
    return unchanged(before.made_of, question.made_of)


def _or_none(read: _Read) -> Keypoints | None:
    """What is read; None where that fails: tracking says what is wrong with a file."""
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
