"""One fit at a time, from when it is asked for until what it found is in the state."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from keypose.app.document.open import OpenSession
from keypose.app.editor.ahead import with_followed
from keypose.app.editor.ahead_text import found_sentence
from keypose.app.editor.drafted import KEYPOINT_SOURCE, with_clip_drafted
from keypose.app.editor.fitted import with_pose_fitted
from keypose.app.editor.state import EditorState
from keypose.app.jobs import (
    AheadOrder,
    Drafted,
    DraftOrder,
    Fitted,
    FollowedAhead,
    JobFailed,
    JobFinished,
    PoseFitted,
    Reduced,
    ReduceOrder,
    SizesFitted,
)
from keypose.app.store.fit_request import Asking, FitRequest
from keypose.app.store.preview import SizesPreview
from keypose.app.store.runner import Runner
from keypose.app.store.state import AppState, FitOutcome
from keypose.tracker.errors import KeypointError, KeyposeError
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.atomic import make_folder
from keypose.tracker.storage.sidecars import keypoints_of_session, save_keypoints

if TYPE_CHECKING:
    from keypose.tracker.reduction.result import Reduction
    from keypose.tracker.tracking.ahead.follow import FoundAhead


class Host(Protocol):
    """Who owns the state."""

    @property
    def app_state(self) -> AppState: ...

    @property
    def opened(self) -> OpenSession | None: ...

    def show_fit(self, edit: EditorState, outcome: FitOutcome) -> None: ...

    def show_draft(self, edit: EditorState) -> None: ...

    def show_ahead(self, edit: EditorState) -> None: ...

    def show_preview(self, preview: SizesPreview) -> None: ...

    def show_reduction(self, reduction: Reduction | None) -> None: ...

    def note(self, kind: str, words: str) -> None: ...


class Fitter:
    """One fit at a time. What it finds is taken over once, and only where it began from still
    stands; while a hand drags something else, it waits until that is let go."""

    def __init__(self, runner: Runner, host: Host) -> None:
        self._runner = runner
        self._host = host
        self._request: FitRequest | None = None
        self._found: Fitted | None = None

    def ask(self, action: Asking) -> FitRequest:
        """Begin; a fit that is asked for twice is done once."""
        opened, edit = self._current()
        request = FitRequest.of(opened, edit, action)
        if self._request is None or not self._request.is_like(request):
            self._request, self._found = request, None
            self._runner.fit(request.order, request.title, self._on_fit_end)
        return request

    def changed(self) -> None:
        """The state is another one."""
        if self._request is None:
            return
        _, edit = self._current()
        if not self._request.is_current(edit):
            self._host.note("info", self._request.why_cancelled)
            self._drop()
        elif self._found is not None and edit.stroke is None:
            self._apply(self._request, self._found)

    def cancel(self) -> bool:
        """Leave the fit that is under way; whether there was one. What was tracked ahead until then
        is reported, and kept."""
        if self._request is None:
            return False
        if isinstance(self._request.order, AheadOrder):
            self._runner.cancel()
        else:
            self._drop()
        return True

    def _drop(self) -> None:
        self._runner.drop_fit()
        self._leave_reduction()
        self._resume_tracking()

    def _leave_reduction(self) -> None:
        if self._request is not None and isinstance(self._request.order, ReduceOrder):
            self._host.show_reduction(None)

    def closed(self) -> None:
        """No session is open any more."""
        self._request = self._found = None

    def _on_fit_end(self, report: Fitted | JobFailed | JobFinished) -> None:
        if self._request is None:
            return
        if isinstance(report, JobFailed | JobFinished):
            if isinstance(report, JobFailed):
                self._host.note("lost", report.words)
            self._leave_reduction()
            self._resume_tracking()
            return
        self._found = report
        self.changed()

    def _apply(self, request: FitRequest, found: Fitted) -> None:
        opened, edit = self._current()
        self._request = self._found = None
        try:
            if isinstance(found, Drafted):
                self._host.show_draft(apply_draft(request, found, edit, opened))
                return
            if isinstance(found, SizesFitted):
                self._preview(found, edit)
                return
            if isinstance(found, Reduced):
                self._host.show_reduction(found.reduction)
                return
            if isinstance(found, FollowedAhead):
                self._take_ahead(found.found, edit)
                return
            after, outcome = apply_fit(request, found, edit)
            if after is edit:
                self._host.note("info", outcome.words)
            else:
                self._host.show_fit(after, outcome)
        except KeyposeError as error:
            self._host.note("check", str(error))
        finally:
            self._resume_tracking()

    def _take_ahead(self, found: FoundAhead, edit: EditorState) -> None:
        """What led nowhere changes nothing; what led on is shown where the next keyframe is."""
        if found.to_frame != found.frame:
            self._host.show_ahead(with_followed(edit, found))
        else:
            self._host.note("check", found_sentence(found))

    def _preview(self, found: SizesFitted, edit: EditorState) -> None:
        preview = SizesPreview.of(found, edit)
        if preview is None:
            self._host.note("info", found.words)
        else:
            self._host.show_preview(preview)

    def _resume_tracking(self) -> None:
        self._request = self._found = None
        self._runner.resume(*self._current())

    def _current(self) -> tuple[OpenSession, EditorState]:
        opened, edit = self._host.opened, self._host.app_state.edit
        assert opened is not None
        assert edit is not None
        return opened, edit


def apply_fit(
    request: FitRequest, fitted: PoseFitted, edit: EditorState
) -> tuple[EditorState, FitOutcome]:
    """The state with what was found, and a summary of it; KeyposeError where it is not valid."""
    assert request.frame is not None
    after = with_pose_fitted(edit, request.frame, fitted.pose) if fitted.found else edit
    return after, FitOutcome(request.frame, fitted.words, edit.doc, after.doc)


def apply_draft(
    request: FitRequest, drafted: Drafted, edit: EditorState, opened: OpenSession
) -> EditorState:
    """The state with the drafts, their keypoints written beside the session; KeyposeError where
    that is not possible."""
    order, path = request.order, opened.session_path
    assert isinstance(order, DraftOrder)
    make_folder(path.parent, error=KeypointError)  # a new film's is there from its first edit on
    seeds, found = {order.frame}, drafted.keypoints
    before = _keypoints_before(edit.doc, path, drafted.network)
    if before is not None and edit.doc.keypoints is not None:
        seeds |= set(edit.doc.keypoints.seeds)
        found = before.overlaid(found)
    referring = save_keypoints(
        edit.doc, path, found, KEYPOINT_SOURCE, network=drafted.network, seeds=tuple(seeds)
    )
    given = (drafted.body, drafted.poses, referring.keypoints, drafted.proposals)
    return with_clip_drafted(edit, order.frames, *given)


def _keypoints_before(doc: Session, path: Path, network: str) -> Keypoints | None:
    """What the same network found for an earlier draft, perhaps of other frames."""
    if doc.keypoints is None or doc.keypoints.network != network:
        return None
    with suppress(KeypointError):  # they are found again when needed
        return keypoints_of_session(doc, path.parent)
    return None
