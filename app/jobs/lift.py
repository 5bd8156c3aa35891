"""Find drafts anew from their keypoints, for what is up by now."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeAlias

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.drafted import has_drafts_for_other_up, to_lift, with_lifted
from keypose.app.jobs.draft import DraftReporter
from keypose.app.jobs.fit import Fit, filmed_by, sent
from keypose.app.jobs.job import Context
from keypose.app.words.standing import lifted_words
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError
from keypose.tracker.operations.lifting import lifter_for_drafts
from keypose.tracker.session import Session
from keypose.tracker.storage.sidecars import at_one_focal, keypoints_of_session

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import Lift
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState
    from keypose.tracker.fitting.draft import DraftProgress

Lifted: TypeAlias = Mapping[int, Pose]
"""Poses by frame."""


@dataclass(frozen=True)
class LiftDrafts(Fit):
    """frames: whose poses nobody has set."""

    frames: frozenset[int] = field(default=frozenset())

    asked = ("lift",)
    kind = "draft"
    title = "Drafting anew"
    tracks_after = True
    why_cancelled = "Cancelled because the body, the camera or a keyframe changed."
    not_of_surfaces = "Drafts are made from a video, not from surfaces."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, _: Lift) -> Self:
        if not has_drafts_for_other_up(edit.doc):
            raise ActionRefused("The drafts are as the up direction has them.")
        return cls(*sent(opened, edit.doc), to_lift(edit.doc))

    def work(self, session: Session, context: Context) -> Lifted:
        from keypose.tracker.fitting.draft import (  # loads what only this needs
            draft_from_keypoints,
            refit_drafts,
        )

        keypoints = keypoints_of_session(session, Path(self.folder))
        if keypoints is None:
            raise KeypointError("The keypoints of the drafts are gone: draft the film again.")
        keypoints = keypoints.corrected(session.view.keypoint_corrections)
        places = session.subject.drafted.places if session.subject.drafted else ()
        changes = [place.frame for place in places if place.reason == "person"]

        def report(progress: DraftProgress) -> None:
            share = progress.done / max(progress.expected, 1)
            context.report(share, f"Posing: {progress.done} of {progress.expected} frames")

        lifter = lifter_for_drafts(
            session, lambda: context.cache.video(session, self.video_path).info.times_s
        )
        clip_draft = draft_from_keypoints(
            keypoints,
            session.view.camera,
            session.subject.body,
            changes=changes,
            proportions=False,
            up_world=session.world.up_world,
            path=session.camera_path,
            lifter=lifter,
            report=DraftReporter(report, context.cancelled),
        )
        anew = {frame: pose for frame, pose in clip_draft.poses.items() if frame in self.frames}
        skeleton = Skeleton.of(session.subject.body)
        posed = {
            k.frame: k.pose(skeleton)
            for k in session.subject.keyframes
            if k.frame not in self.frames
        }
        if lifter is not None:
            keypoints = lifter.of(keypoints, session.subject.body)
        filmed = at_one_focal(session, keypoints)
        return {
            **anew,
            **refit_drafts(
                filmed, session.view.camera, session.subject.body, anew, posed, posed, changes
            ),
        }

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        return (
            doc.subject.body,
            *filmed_by(doc),
            doc.world.up_world,
            doc.settings.cues,
            doc.subject.keyframes,
            doc.subject.drafts,
        )

    def apply(self, poses: Lifted, state: AppState) -> tuple[AppState, str]:
        edit = state.editing
        after = with_lifted(edit, poses)
        keyed = sum(keyframe.frame in poses for keyframe in edit.doc.subject.keyframes)
        return replace(state, edit=after), lifted_words(len(poses) - keyed, keyed)
