"""Run one fit at a time, from when it is asked for until what it found is in the state."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from keypose.app.document.open import OpenSession
from keypose.app.editor import actions as do
from keypose.app.editor.ahead import found_sentence, start_frame, with_followed
from keypose.app.editor.body import require_sizes_to_fit
from keypose.app.editor.drafted import (
    KEYPOINT_SOURCE,
    keeps_proportions,
    require_draftable,
    with_clip_drafted,
)
from keypose.app.editor.posing import pose_to_fit, with_pose_fitted
from keypose.app.editor.shown import find, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.jobs import (
    AheadOrder,
    Drafted,
    DraftOrder,
    FitOrder,
    Fitted,
    FollowedAhead,
    JobFailed,
    JobFinished,
    PoseFitted,
    PoseOrder,
    Reduced,
    ReduceOrder,
    SizesFitted,
    SizesOrder,
)
from keypose.app.store.previews import SizesPreview, goal_of, reducible_as_asked
from keypose.app.store.runner import Runner
from keypose.app.store.sections.json_value import unchanged
from keypose.app.store.state import FitOutcome, StateOwner
from keypose.tracker.body.pose import Pose
from keypose.tracker.errors import KeypointError, KeyposeError
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.atomic import make_folder
from keypose.tracker.storage.results import pose_at
from keypose.tracker.storage.sidecars import keypoints_of_session, save_keypoints

if TYPE_CHECKING:
    from keypose.tracker.tracking.ahead.follow import FoundAhead


SAME = 1e-9
"""Poses that differ by less are the same."""
NEAR_FRAMES = 8
"""So many frames to both sides the tracked poses are handed over."""

Asking: TypeAlias = do.FitHere | do.FitSizes | do.Draft | do.TrackAhead | do.Reduce
"""What a person asks to be fitted."""


@dataclass(frozen=True, eq=False)
class FitRequest:
    """A fit, or a draft of the clip, that is under way.

    frame: whose pose is fitted; None for the sizes and for a draft.
    began: the state when it was asked for.
    """

    order: FitOrder
    frame: int | None
    began: EditorState

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, action: Asking) -> FitRequest:
        """Return what is asked for; Refused with the reason where it cannot be had."""
        path = str(opened.video.info.path)
        if isinstance(action, do.Draft):
            return cls(_draft_order(path, edit, action), None, edit)
        if isinstance(action, do.TrackAhead):
            return cls(_ahead_order(path, opened, edit, action), None, edit)
        if isinstance(action, do.Reduce):
            return cls(_reduce_order(path, opened, edit, action), None, edit)
        if isinstance(action, do.FitSizes):
            require_sizes_to_fit(edit)
            return cls(SizesOrder(_content(edit.doc), path, action.focal), None, edit)
        pose, frame = pose_to_fit(edit), edit.frame
        near, folder = _near(edit), str(opened.session_path.absolute().parent)
        return cls(PoseOrder(_content(edit.doc), path, frame, pose, near, folder), frame, edit)

    @property
    def title(self) -> str:
        if isinstance(self.order, DraftOrder):
            return "Drafting poses"
        if isinstance(self.order, AheadOrder):
            way = "ahead" if self.order.direction == "forward" else "back"
            return f"Tracking {way} from {self.order.frame}"
        if isinstance(self.order, ReduceOrder):
            return "Reducing to keyframes"
        return "Fitting the sizes" if self.frame is None else f"Fitting frame {self.frame}"

    @property
    def why_cancelled(self) -> str:
        """Return what is said when it began from something that has changed."""
        if isinstance(self.order, DraftOrder):
            return "Draft cancelled because the body, the camera or a keyframe changed."
        if isinstance(self.order, AheadOrder):
            return "Tracking ahead cancelled because the body, the camera or a keyframe changed."
        if isinstance(self.order, ReduceOrder):
            return "Reduction cancelled because the motion changed."
        what = "sizes" if self.frame is None else "pose"
        return f"Fit cancelled because the {what} changed."

    def is_current(self, edit: EditorState) -> bool:
        """Return whether what it began from still stands. A pose that is kept as a keyframe
        meanwhile is the same pose.
        """
        return unchanged(self._inputs(edit.doc), self._inputs(self.began.doc)) and (
            not isinstance(self.order, PoseOrder) or self._is_posed(edit, self.order)
        )

    def _is_posed(self, edit: EditorState, order: PoseOrder) -> bool:
        """Return whether the frame still has the pose that is fitted."""
        known = _pose_at(edit.doc, order.frame), _pose_at(self.began.doc, order.frame)
        if known[0] is known[1]:
            return True
        pose = shown_pose(replace(edit, frame=order.frame)).pose
        return bool(
            np.allclose(pose.Rs_parent_part, order.pose.Rs_parent_part, atol=SAME)
            and np.allclose(pose.p_camera_root, order.pose.p_camera_root, atol=SAME)
        )

    def is_like(self, other: FitRequest) -> bool:
        """Return whether the other asks for the same of what still stands."""
        whole = DraftOrder | AheadOrder | ReduceOrder
        if isinstance(self.order, whole) or isinstance(other.order, whole):
            return self.order == other.order
        focal = (getattr(request.order, "focal", None) for request in (self, other))
        return (
            self.frame == other.frame
            and next(focal) == next(focal)
            and self.is_current(other.began)
        )

    def _inputs(self, doc: Session) -> tuple[Any, ...]:
        if isinstance(self.order, DraftOrder):
            return doc.body, doc.camera, doc.surface, doc.keyframes
        if isinstance(self.order, AheadOrder):
            cues = doc.settings, doc.keypoint_corrections
            return doc.body, doc.camera, doc.ignore_masks, doc.keyframes, *cues
        if isinstance(self.order, ReduceOrder):
            return doc.body, doc.keyframes, doc.part_keyframes, doc.drafts, doc.first_motion
        what = (doc.body, doc.camera, doc.ignore_masks, doc.surface)
        if self.frame is None:
            return *what, doc.keyframes, doc.drafts
        return what


def _pose_at(doc: Session, frame: int) -> Keyframe | None:
    return find(doc.keyframes, frame) or find(doc.drafts, frame)


def _draft_order(path: str, edit: EditorState, action: do.Draft) -> DraftOrder:
    doc, last = edit.doc, edit.frame_count - 1
    frames = (action.first or 0, last if action.last is None else action.last)
    require_draftable(doc, action.frame, action.box, frames)
    bare = doc.model_copy(update={"keyframes": ()})
    proportions = not keeps_proportions(doc)
    return DraftOrder(_content(bare), path, action.frame, action.box, frames, proportions)


def _ahead_order(
    path: str, opened: OpenSession, edit: EditorState, action: do.TrackAhead
) -> AheadOrder:
    frame = start_frame(edit.doc, action.direction)
    folder = str(opened.session_path.absolute().parent)
    return AheadOrder(_content(edit.doc), path, frame, action.direction, folder)


def _reduce_order(
    path: str, opened: OpenSession, edit: EditorState, action: do.Reduce
) -> ReduceOrder:
    found = reducible_as_asked(edit, action, opened.session_path.absolute().parent)
    bare = edit.doc.model_copy(update={"keyframes": (), "part_keyframes": ()})
    return ReduceOrder(_content(bare), path, found, goal_of(action))


def _content(doc: Session) -> bytes:
    """The session without what no fit needs: it is read anew for every order."""
    return doc.model_copy(update={"drafts": (), "results": None}).model_dump_json().encode()


def _near(edit: EditorState) -> dict[int, Pose]:
    """The tracked poses of frames near, this one too: it shows whether they were led through the
    pose to be fitted, and so hold its error. What tracking is on its way to does not count."""
    finished = {span: track for span, track in edit.fitting.items() if track.finished}
    around = range(edit.frame - NEAR_FRAMES, edit.frame + NEAR_FRAMES + 1)
    found = {frame: pose_at(finished, frame) for frame in around}
    return {frame: pose for frame, pose in found.items() if pose is not None}


class Fitter:
    """One fit at a time. What it finds is taken over once, and only where it began from still
    stands; while a hand drags something else, it waits until that is let go."""

    def __init__(self, runner: Runner, host: StateOwner) -> None:
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
        self._close_reduction()
        self._resume_tracking()

    def _close_reduction(self) -> None:
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
            self._close_reduction()
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
        """Take over what was found. What led nowhere changes nothing; what led on is shown where
        the next keyframe is.
        """
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
    """Return what the same network found for an earlier draft, perhaps of other frames."""
    if doc.keypoints is None or doc.keypoints.network != network:
        return None
    with suppress(KeypointError):  # they are found again when needed
        return keypoints_of_session(doc, path.parent)
    return None
