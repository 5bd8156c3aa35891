"""Reduce a motion to keyframes; shown until they are applied or discarded."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

from keypose.app.editor.reduced import Reducible, reducible
from keypose.app.jobs.fit import Fit, filmed_by, sent
from keypose.app.jobs.job import Context
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.reduction.result import Every, Goal, Reduction, Tolerance
from keypose.tracker.session import Session
from keypose.tracker.storage.sidecars import load_first_motion

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor import actions
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState


@dataclass(frozen=True)
class ReduceMotion(Fit):
    """found: the motion to reduce. No two ask for the same."""

    found: Reducible
    goal: Goal

    asked = ("reduce",)
    kind = "reduce"
    title = "Reducing to keyframes"
    why_cancelled = "Reduction cancelled because the motion changed."
    not_of_surfaces = "Only the motion of a video is reduced, not that of surfaces."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, action: actions.Reduce) -> Self:
        last = edit.frame_count - 1
        frames = (action.first or 0, last if action.last is None else action.last)
        imported = load_first_motion(edit.doc, opened.session_path.absolute().parent)
        reducible_motion = reducible(
            edit.doc,
            edit.fitting,
            imported,
            frames=frames,
            limbs=action.limbs,
            replacing=action.replacing,
        )
        work_inputs = sent(opened, edit.doc, keyframes=(), part_keyframes=())
        return cls(*work_inputs, reducible_motion, _goal_of(action))

    def work(self, session: Session, context: Context) -> Reduction:
        from keypose.tracker.reduction.reduce import reduce_motion  # loads what only this needs

        reported = -1

        def report(done: int, expected: int) -> None:
            nonlocal reported
            context.leave_when_cancelled()
            if 100 * done // expected != reported:
                reported = 100 * done // expected
                context.report(done / expected)

        reducible_motion, skeleton = self.found, Skeleton.of(session.subject.body)
        return reduce_motion(
            skeleton,
            session.view.camera,
            reducible_motion.motion,
            self.goal,
            reducible_motion.required,
            reducible_motion.parts,
            report,
            session.camera_path,
        )

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        return (
            doc.subject.body,
            *filmed_by(doc),
            doc.subject.keyframes,
            doc.subject.part_keyframes,
            doc.subject.drafts,
            doc.subject.first_motion,
        )

    def apply(self, reduction: Reduction, state: AppState) -> tuple[AppState, str]:
        reduction_preview = state.reduction
        done = (
            None
            if reduction_preview is None
            else replace(reduction_preview, reduction=reduction, busy=False)
        )
        return replace(state, reduction=done), ""

    def left(self, state: AppState) -> AppState:
        return replace(state, reduction=None)


def _goal_of(asked: actions.Reduce) -> Goal:
    """So many frames, or metres and pixels."""
    if asked.every is not None:
        return Every(asked.every)
    metres = math.inf if asked.cm is None else asked.cm / 100
    return Tolerance(metres, math.inf if asked.px is None else asked.px)
