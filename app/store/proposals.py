"""What was found and waits for a person's answer: new sizes, the keyframes of a reduction."""

from __future__ import annotations

from dataclasses import replace

from keypose.app.editor import actions
from keypose.app.editor.documents import ActionRefused
from keypose.app.jobs.reduce import ReduceMotion
from keypose.app.state.previews import ReductionPreview
from keypose.app.store.saving import WriteLock
from keypose.app.working.fitting import Fitter
from keypose.app.working.owner import StateOwner


class Proposals:
    """Answers to what is shown as a proposal; nothing is edited while one waits."""

    def __init__(self, host: StateOwner, fitter: Fitter, lock: WriteLock) -> None:
        self._host, self._fitter, self._lock = host, fitter, lock

    def require_none(self) -> None:
        """Refused while one waits."""
        if self._host.app_state.preview is not None:
            raise ActionRefused("Apply or discard the new sizes first.")
        if self._host.app_state.reduction is not None:
            raise ActionRefused("Apply or discard the keyframes of the reduction first.")

    def answer_sizes(self, action: actions.Previewing) -> None:
        """Apply or discard new sizes, or choose whether poses change with them."""
        state = self._host.app_state
        preview, edit = state.preview, state.edit
        if preview is None or edit is None:
            raise ActionRefused("There are no new sizes to answer.")
        if isinstance(action, actions.PreviewPoses):
            self._host.take(replace(state, preview=preview.choosing(action.on)))
            return
        if isinstance(action, actions.ApplySizes):
            self._lock.require_writable()
            edit = preview.applied_to(edit)
        self._host.take(replace(state, preview=None, edit=edit))

    def reduce(self, action: actions.Reduce) -> None:
        """Find the keyframes of a motion; asked again, with another tolerance, find those."""
        reduction_preview = self._host.app_state.reduction
        if reduction_preview is None:
            self.require_none()
        job = self._fitter.ask(action)
        assert isinstance(job, ReduceMotion)
        shown = (
            reduction_preview.reduction if reduction_preview else None
        )  # stays until the other is known
        preview = ReductionPreview(action, job.found, shown)
        self._host.take(replace(self._host.app_state, reduction=preview, fit=None))

    def answer_reduction(self, action: actions.ApplyReduction | actions.DiscardReduction) -> None:
        """Apply or discard the keyframes that were found."""
        reduction_preview, edit = self._host.app_state.reduction, self._host.app_state.edit
        opened = self._host.opened
        if reduction_preview is None or edit is None or opened is None:
            raise ActionRefused("There are no keyframes of a reduction to answer.")
        if isinstance(action, actions.ApplyReduction):
            self._lock.require_writable()
            edit = reduction_preview.applied_to(edit, opened.session_path)
        elif reduction_preview.busy:
            self._fitter.cancel()
        self._host.take(replace(self._host.app_state, reduction=None, edit=edit))
