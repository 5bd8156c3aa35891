"""Keyframes that a motion is reduced to, shown until they are applied or discarded."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

from keypose.app.editor import actions as do
from keypose.app.editor.reduced import Reducible, reducible, with_reduction
from keypose.app.editor.refusal import Refused
from keypose.app.editor.state import EditorState
from keypose.tracker.errors import SessionError
from keypose.tracker.reduction.result import Every, Goal, Reduction, Tolerance
from keypose.tracker.storage.atomic import make_folder
from keypose.tracker.storage.sidecars import kept_beside, save_own_motion

WAITING = "Apply or discard the keyframes of the reduction first."


@dataclass(frozen=True, eq=False)
class ReductionPreview:
    """A reduction that waits to be applied or discarded.

    asked: what was asked for last.  found: the motion, as it is to be reduced.
    reduction: its keyframes; of what was asked before while `busy`, None at first.
    """

    asked: do.Reduce
    found: Reducible
    reduction: Reduction | None = None
    busy: bool = True

    def asking(self, asked: do.Reduce, found: Reducible) -> ReductionPreview:
        """With something else asked for; what was found stays until that is known."""
        return replace(self, asked=asked, found=found, busy=True)

    def done(self, reduction: Reduction) -> ReductionPreview:
        """With what was asked for last."""
        return replace(self, reduction=reduction, busy=False)

    def applied_to(self, edit: EditorState, session_path: Path) -> EditorState:
        """The keyframes, as one step that can be undone; the motion is written beside the session.
        Refused while they are not known."""
        if self.reduction is None or self.busy:
            raise Refused("The keyframes are not known yet. Wait a moment.")
        own = None
        if self.found.parts is None:
            make_folder(session_path.parent, error=SessionError)
            own = save_own_motion(edit.doc, session_path, self.found.motion)
        frames, replacing = self.reduction.frames, self.asked.replacing
        return with_reduction(edit, self.found, frames, own, replacing=replacing)


def goal_of(asked: do.Reduce) -> Goal:
    """So many frames, or metres and pixels."""
    if asked.every is not None:
        return Every(asked.every)
    metres = math.inf if asked.cm is None else asked.cm / 100
    return Tolerance(metres, math.inf if asked.px is None else asked.px)


def reducible_as_asked(edit: EditorState, asked: do.Reduce, folder: Path) -> Reducible:
    """The motion to reduce; KeyposeError in one sentence where there is none."""
    last = edit.frame_count - 1
    frames = (asked.first or 0, last if asked.last is None else asked.last)
    return reducible(
        edit.doc,
        edit.fitting,
        kept_beside(edit.doc, folder),
        frames=frames,
        limbs=asked.limbs,
        replacing=asked.replacing,
    )
