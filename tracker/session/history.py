"""Undo and redo: whole documents, which share everything unchanged."""

from __future__ import annotations

from dataclasses import dataclass

from tracker.session.schema import Session

MOST_STEPS = 1000


@dataclass(frozen=True, eq=False)
class Step:
    """One edit: the document on its other side, its label, and the current frame."""

    doc: Session
    label: str
    frame: int


@dataclass(frozen=True, eq=False)
class History:
    """The steps that can be undone, oldest first, and those that can be redone, next one last."""

    past: tuple[Step, ...] = ()
    future: tuple[Step, ...] = ()

    def after(self, before: Session, label: str, frame: int) -> History:
        """The history after one more edit, which was made to `before`."""
        return History((*self.past, Step(before, label, frame))[-MOST_STEPS:])

    def undo(self, present: Session) -> tuple[Step, History] | None:
        """The step to go back to, and the history then; None at the beginning."""
        if not self.past:
            return None
        step = self.past[-1]
        again = Step(present, step.label, step.frame)
        return step, History(self.past[:-1], (*self.future, again))

    def redo(self, present: Session) -> tuple[Step, History] | None:
        """The step to go forward to, and the history then; None at the end."""
        if not self.future:
            return None
        step = self.future[-1]
        back = Step(present, step.label, step.frame)
        return step, History((*self.past, back), self.future[:-1])
