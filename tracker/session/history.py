"""Undo and redo: whole documents, which share everything unchanged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from keypose.tracker.session.schema import Session

MOST_STEPS = 1000


@dataclass(frozen=True, eq=False)
class Step:
    """One edit: the document on its other side, its label, and the current frame.

    made_s: when it was made, seconds since 1970; None where that was not kept.
    """

    doc: Session
    label: str
    frame: int
    made_s: float | None = None

    def is_same(self, step: Step) -> bool:
        """Whether both are one edit, seen from the same side."""
        return self is step or (
            self.doc is step.doc
            and (self.label, self.frame, self.made_s) == (step.label, step.frame, step.made_s)
        )


@dataclass(frozen=True, eq=False)
class History:
    """The steps that can be undone, oldest first, and those that can be redone, next one last."""

    past: tuple[Step, ...] = ()
    future: tuple[Step, ...] = ()

    def after(self, before: Session, label: str, frame: int) -> History:
        """The history after one more edit, which was made to `before`."""
        return History((*self.past, Step(before, label, frame))[-MOST_STEPS:])

    @property
    def total(self) -> int:
        """All steps, done and undone."""
        return len(self.past) + len(self.future)

    def stamped(self, before: History, present: Session, now_s: float) -> History:
        """Stamp the newest step with the time where it was made since `before`; undone or redone
        ones keep theirs. present: the document now.
        """
        newest = self.past[-1] if self.past else None
        if newest is None or newest.made_s is not None or newest in before.past:
            return self
        if any(step.doc is present for step in before.future):
            return self
        return History((*self.past[:-1], replace(newest, made_s=now_s)), self.future)

    def undo(self, present: Session) -> tuple[Step, History] | None:
        """The step to go back to, and the history then; None at the beginning."""
        if not self.past:
            return None
        step = self.past[-1]
        again = replace(step, doc=present)
        return step, History(self.past[:-1], (*self.future, again))

    def redo(self, present: Session) -> tuple[Step, History] | None:
        """The step to go forward to, and the history then; None at the end."""
        if not self.future:
            return None
        step = self.future[-1]
        back = replace(step, doc=present)
        return step, History((*self.past, back), self.future[:-1])

    def way_to(self, present: Session, done: int) -> Iterator[tuple[Step, History]]:
        """The steps to undo or redo, one after the other, until so many are done: each the step to
        go to, and the history then."""
        history = self
        while len(history.past) != done:
            back = len(history.past) > done
            neighbour = history.undo(present) if back else history.redo(present)
            if neighbour is None:
                return
            step, history = neighbour
            present = step.doc
            yield step, history
