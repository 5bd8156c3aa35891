"""What was found and waits for a person's answer: new sizes, the keyframes of a reduction."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypedDict, Unpack

from keypose.app.editor import actions
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.state import EditorState
from keypose.app.jobs.fit_pose import FitOutcome
from keypose.app.jobs.fit_sizes import SizesPreview
from keypose.app.jobs.reduce import ReduceMotion, ReductionPreview
from keypose.app.store.fitter import Fitter
from keypose.app.store.saving import WriteLock
from keypose.app.store.state import StateOwner


class Shown(TypedDict, total=False):
    """The fields of the state that a proposal sets."""

    preview: SizesPreview | None
    reduction: ReductionPreview | None
    fit: FitOutcome | None


class Change(Protocol):
    """Sets fields of the host's state; the others stay."""

    def __call__(self, **fields: Unpack[Shown]) -> None: ...


class Proposals:
    """Answers to what is shown as a proposal; nothing is edited while one waits.

    `edit_to` goes on from an edited document.
    """

    def __init__(
        self,
        host: StateOwner,
        fitter: Fitter,
        lock: WriteLock,
        change: Change,
        edit_to: Callable[[EditorState], None],
    ) -> None:
        self._host, self._fitter, self._lock = host, fitter, lock
        self._change, self._edit_to = change, edit_to

    def require_none(self) -> None:
        """Refused while one waits."""
        if self._host.app_state.preview is not None:
            raise ActionRefused("Apply or discard the new sizes first.")
        if self._host.app_state.reduction is not None:
            raise ActionRefused("Apply or discard the keyframes of the reduction first.")

    def answer_sizes(self, action: actions.Previewing) -> None:
        """Apply or discard new sizes, or choose whether poses change with them."""
        preview, edit = self._host.app_state.preview, self._host.app_state.edit
        if preview is None or edit is None:
            raise ActionRefused("There are no new sizes to answer.")
        if isinstance(action, actions.PreviewPoses):
            self._change(preview=preview.choosing(action.on))
            return
        if isinstance(action, actions.ApplySizes):
            self._lock.require_writable()
            edit = preview.applied_to(edit)
        self._change(preview=None)
        self._edit_to(edit)

    def reduce(self, action: actions.Reduce) -> None:
        """Find the keyframes of a motion; asked again, with another tolerance, find those."""
        known = self._host.app_state.reduction
        if known is None:
            self.require_none()
        job = self._fitter.ask(action)
        assert isinstance(job, ReduceMotion)
        shown = known.reduction if known else None  # stays until the other is known
        self._change(reduction=ReductionPreview(action, job.found, shown), fit=None)

    def answer_reduction(self, action: actions.ApplyReduction | actions.DiscardReduction) -> None:
        """Apply or discard the keyframes that were found."""
        known, edit = self._host.app_state.reduction, self._host.app_state.edit
        opened = self._host.opened
        if known is None or edit is None or opened is None:
            raise ActionRefused("There are no keyframes of a reduction to answer.")
        if isinstance(action, actions.ApplyReduction):
            self._lock.require_writable()
            edit = known.applied_to(edit, opened.session_path)
        elif known.busy:
            self._fitter.cancel()
        self._change(reduction=None)
        self._edit_to(edit)
