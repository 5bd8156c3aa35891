"""A fit that is asked for: its order for the worker, and whether what it began from has changed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from keypose.app.document.open import OpenSession
from keypose.app.editor import actions as do
from keypose.app.editor.ahead import start_frame
from keypose.app.editor.drafted import keeps_proportions, require_draftable
from keypose.app.editor.fitted import pose_to_fit, require_sizes_to_fit
from keypose.app.editor.shown import find, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.jobs import AheadOrder, DraftOrder, FitOrder, PoseOrder, ReduceOrder, SizesOrder
from keypose.app.store.identity import unchanged
from keypose.app.store.reduction import goal_of, reducible_as_asked
from keypose.tracker.body.pose import Pose
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.results import pose_at

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
        """What is asked for; Refused with the reason where it cannot be had."""
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
        """What is said when it began from something that has changed."""
        if isinstance(self.order, DraftOrder):
            return "Draft cancelled because the body, the camera or a keyframe changed."
        if isinstance(self.order, AheadOrder):
            return "Tracking ahead cancelled because the body, the camera or a keyframe changed."
        if isinstance(self.order, ReduceOrder):
            return "Reduction cancelled because the motion changed."
        what = "sizes" if self.frame is None else "pose"
        return f"Fit cancelled because the {what} changed."

    def is_current(self, edit: EditorState) -> bool:
        """Whether what it began from still stands. A pose that is kept as a keyframe meanwhile is
        the same pose."""
        return unchanged(self._inputs(edit.doc), self._inputs(self.began.doc)) and (
            not isinstance(self.order, PoseOrder) or self._is_posed(edit, self.order)
        )

    def _is_posed(self, edit: EditorState, order: PoseOrder) -> bool:
        """Whether the frame still has the pose that is fitted."""
        known = _pose_at(edit.doc, order.frame), _pose_at(self.began.doc, order.frame)
        if known[0] is known[1]:
            return True
        pose = shown_pose(replace(edit, frame=order.frame)).pose
        return bool(
            np.allclose(pose.Rs_parent_part, order.pose.Rs_parent_part, atol=SAME)
            and np.allclose(pose.p_camera_root, order.pose.p_camera_root, atol=SAME)
        )

    def is_like(self, other: FitRequest) -> bool:
        """Whether the other asks for the same of what still stands."""
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
