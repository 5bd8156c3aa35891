"""Solve anew for drafts near keyframes that are new, with what these give."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Self, TypeAlias

from keypose.app.editor.drafted import near_frames, with_learned
from keypose.app.jobs.fit import Fit, sent
from keypose.app.jobs.job import Context
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.lifted_depth import DepthLifter
from keypose.tracker.operations.lifting import lifter_for_drafts
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import LEARN_FRAMES
from keypose.tracker.storage.sidecars import at_one_focal, keypoints_of_session

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState

Learned: TypeAlias = Mapping[int, Pose]
"""Drafts with what keyframes give, by frame."""


def learned(
    session: Session, folder: Path, around: Collection[int], lifter: DepthLifter | None = None
) -> Learned:
    """The drafts near some keyframes with what all keyframes there give of the keypoints; none
    where the keypoints are not beside the session any more.

    folder: of the session's file.  lifter: what gives keypoints their depth; None where they keep
    their own.
    """
    from keypose.tracker.fitting.draft import refit_drafts  # loads what only this needs

    skeleton, keypoints = Skeleton.of(session.subject.body), keypoints_of_session(session, folder)
    if keypoints is None:
        return {}
    keypoints = keypoints.corrected(session.view.keypoint_corrections)
    drafts = {d.frame: d.pose(skeleton) for d in session.subject.drafts if d.drafted}
    posed = {k.frame: k.pose(skeleton) for k in session.subject.keyframes}
    places = session.subject.drafted.places if session.subject.drafted else ()
    changes = [place.frame for place in places if place.reason == "person"]
    if lifter is not None:
        keypoints = keypoints.over(*_looked_at(lifter, keypoints, around))
        keypoints = lifter.of(keypoints, session.subject.body)
    filmed, camera = at_one_focal(session, keypoints), session.view.camera
    return refit_drafts(filmed, camera, session.subject.body, drafts, posed, around, changes)


def _looked_at(
    lifter: DepthLifter, keypoints: Keypoints, around: Collection[int]
) -> tuple[int, int]:
    """First and last of the frames that drafts near some frames are lifted from."""
    first = max(min(around) - LEARN_FRAMES, keypoints.first_frame)
    last = min(max(around) + LEARN_FRAMES, keypoints.last_frame)
    low, high = lifter.looked_at(first, last)
    return max(low, keypoints.first_frame), min(high, keypoints.last_frame)


@dataclass(frozen=True)
class LearnDrafts(Fit):
    """around: frames of the new keyframes."""

    around: tuple[int, ...]

    kind = "drafts"
    title = "Drafts learn from keyframes"
    not_of_surfaces = "Drafts are made from a video, not from surfaces."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, around: Collection[int]) -> Self:
        near = near_frames(edit.doc, around)
        return cls(*sent(opened, near, drafts=near.subject.drafts), tuple(sorted(around)))

    def work(self, session: Session, context: Context) -> Learned:
        lifter = lifter_for_drafts(
            session, lambda: context.cache.video(session, self.video_path).info.times_s
        )
        return learned(session, Path(self.folder), self.around, lifter)

    def taken(self, poses: Learned, began: EditorState, state: AppState) -> tuple[AppState, str]:
        """The state with what drafts learned from keyframes as they were when it began."""
        after = with_learned(state.editing, began.doc, poses)
        if after.doc.subject.drafts == state.editing.doc.subject.drafts:
            return state, ""
        words = f"{len(poses)} drafts learned from your keyframe and were moved."
        return replace(state, edit=after), words
