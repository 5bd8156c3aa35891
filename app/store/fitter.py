"""Run one fit at a time, from when it is asked for until what it found is in the state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

from keypose.app.document.open import OpenSession
from keypose.app.editor import actions as do
from keypose.app.editor.state import EditorState
from keypose.app.jobs.ahead import FollowAhead
from keypose.app.jobs.draft import DraftClip
from keypose.app.jobs.find_camera import FindCamera
from keypose.app.jobs.find_up import FindUp
from keypose.app.jobs.fit import Fit
from keypose.app.jobs.fit_pose import FitPose
from keypose.app.jobs.fit_sizes import FitSizes
from keypose.app.jobs.job import Ended, Failed
from keypose.app.jobs.lift import LiftDrafts
from keypose.app.jobs.reduce import ReduceMotion
from keypose.app.jobs.stand import StandOnFloor
from keypose.app.store.owner import StateOwner
from keypose.app.store.runner import Runner
from keypose.tracker.errors import KeyposeError
from keypose.tracker.storage.fingerprints import Span

Asking: TypeAlias = (
    do.FitHere
    | do.FitSizes
    | do.Draft
    | do.DraftRest
    | do.Lift
    | do.FindUp
    | do.FindCamera
    | do.Stand
    | do.TrackAhead
    | do.Reduce
)
"""What a person asks to be fitted."""

JOBS: Mapping[type[Asking], Any] = {
    do.FitHere: FitPose,
    do.FitSizes: FitSizes,
    do.Draft: DraftClip,
    do.DraftRest: DraftClip,
    do.TrackAhead: FollowAhead,
    do.Reduce: ReduceMotion,
    do.Stand: StandOnFloor,
    do.Lift: LiftDrafts,
    do.FindUp: FindUp,
    do.FindCamera: FindCamera,
}


class Fitter:
    """One fit at a time. What it finds is taken over once, and only where it began from still
    stands; while a hand drags something else, it waits until that is let go."""

    def __init__(self, runner: Runner, host: StateOwner) -> None:
        self._runner = runner
        self._host = host
        self._request: tuple[Fit, EditorState] | None = None
        """The fit under way, and the state when it was asked for."""
        self._found: tuple[Any] | None = None

    def ask(self, action: Asking) -> Fit:
        """Begin; a fit that is asked for twice is done once. Refused with the reason where it
        cannot be had."""
        opened, edit = self._current()
        job: Fit = JOBS[type(action)].of(opened, edit, action)
        if self._request is None or self._request[0] != job:
            self._request, self._found = (job, edit), None
            self._runner.fit(job, self._on_end)
        return job

    def changed(self) -> None:
        """The state is another one."""
        if self._request is None:
            return
        (job, began), (_, edit) = self._request, self._current()
        if not job.stands(began, edit):
            self._host.note("info", job.why_cancelled)
            self._drop(job)
        elif self._found is not None and edit.stroke is None:
            self._apply(job, *self._found)

    def cancel(self) -> bool:
        """Leave the fit that is under way; whether there was one."""
        if self._request is None:
            return False
        if self._request[0].keeps_found:
            self._runner.cancel()
        else:
            self._drop(self._request[0])
        return True

    def closed(self) -> None:
        """No session is open any more."""
        self._request = self._found = None

    def _drop(self, job: Fit) -> None:
        self._runner.drop_fit()
        self._leave(job)

    def _leave(self, job: Fit) -> None:
        self._host.take(job.left(self._host.app_state))
        self._resume_tracking()

    def _on_end(self, end: Ended) -> None:
        if self._request is None:
            return
        if isinstance(end, Failed):
            self._host.note("lost", end.words)
        if isinstance(end, Failed) or end.cancelled:
            self._leave(self._request[0])
        else:
            self._found = (end.result,)
            self.changed()

    def _apply(self, job: Fit, found: Any) -> None:
        self._request = self._found = None
        tracked = self._tracked()
        try:
            after, words = job.apply(found, self._host.app_state)
            if words:
                self._host.note("info", words)
            self._host.take(after)
        except KeyposeError as error:
            self._host.note("check", str(error))
        finally:
            self._resume_tracking()
        if job.tracks_after and not tracked <= self._tracked():
            self._runner.track(*self._current(), "changed")

    def _tracked(self) -> set[Span]:
        """The segments whose motion is as the session asks for it."""
        _, edit = self._current()
        return {span for span, segment_result in edit.fitting.items() if segment_result.finished}

    def _resume_tracking(self) -> None:
        self._request = self._found = None
        self._runner.resume(*self._current())

    def _current(self) -> tuple[OpenSession, EditorState]:
        opened, edit = self._host.opened, self._host.app_state.edit
        assert opened is not None
        assert edit is not None
        return opened, edit
