"""Drafts learn from every keyframe, in the background and by themselves."""

from __future__ import annotations

from typing import Protocol

from keypose.app.document.open import OpenSession
from keypose.app.editor.drafted import near_frames, newly_posed, with_learned
from keypose.app.editor.state import EditorState
from keypose.app.jobs import Learned, LearnOrder
from keypose.app.store.runner import Runner
from keypose.app.store.state import AppState
from keypose.tracker.errors import KeyposeError
from keypose.tracker.session.schema import Session


class Host(Protocol):
    """Who owns the state."""

    @property
    def app_state(self) -> AppState: ...

    @property
    def opened(self) -> OpenSession | None: ...

    def show_learned(self, edit: EditorState) -> None: ...

    def note(self, kind: str, words: str) -> None: ...


class DraftLearner:
    """Waits while something else is at work or dragged. What a person posed is never changed, and
    what they undo is not learned from."""

    def __init__(self, runner: Runner, host: Host) -> None:
        self._runner = runner
        self._host = host
        self._waiting: frozenset[int] = frozenset()
        self._found: tuple[Session, Learned] | None = None
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
        if self._found is not None:
            self._take(edit)
            return
        around = self._waiting.intersection(edit.keys)
        if not around:
            return
        doc, folder = edit.doc, str(opened.session_path.absolute().parent)
        content = near_frames(doc, around).model_dump_json().encode()
        order = LearnOrder(content, str(opened.video.info.path), tuple(sorted(around)), folder)
        self._runner.learn(order, lambda found: self._on_end(doc, around, found))

    def _on_end(self, doc: Session, around: frozenset[int], found: Learned | None) -> None:
        self._waiting -= around
        if found is not None:
            self._found = doc, found
        self.go_on()

    def _take(self, edit: EditorState) -> None:
        assert self._found is not None
        (used, found), self._found = self._found, None
        try:
            after = with_learned(edit, used, found.poses)
        except KeyposeError:
            return  # drafts that cannot be stay as they are
        if after is edit or after.doc.drafts == edit.doc.drafts:
            return
        self._host.show_learned(after)
        if not self._announced:
            self._announced = True
            words = f"{len(found.poses)} drafts learned from your keyframe and were moved."
            self._host.note("info", words)
