"""Follow the body from a keyframe as far as the evidence carries."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from keypose.app.editor.ahead import found_sentence, start_frame, with_followed
from keypose.app.editor.documents import ActionRefused
from keypose.app.jobs.fit import Fit, filmed_by, sent
from keypose.app.jobs.job import Context
from keypose.app.state.outcomes import Following
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import Direction

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import TrackAhead
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState
    from keypose.tracker.tracking.ahead.follow import FoundAhead


@dataclass(frozen=True)
class FollowAhead(Fit):
    """frame: of the keyframe."""

    frame: int
    direction: Direction

    asked = ("track_ahead",)
    kind = "ahead"
    why_cancelled = "Tracking ahead cancelled because the body, the camera or a keyframe changed."
    not_of_surfaces = "Surfaces are fitted from one keyframe on: press Fit."
    keeps_found = True

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, action: TrackAhead) -> Self:
        frame = start_frame(edit.doc, action.direction)
        return cls(*sent(opened, edit.doc), frame, action.direction)

    @property
    def title(self) -> str:
        return f"Tracking {'ahead' if self.direction == 'forward' else 'back'} from {self.frame}"

    def work(self, session: Session, context: Context) -> FoundAhead:
        from keypose.tracker.tracking.ahead.follow import LONGEST, follow_ahead  # only here

        def emit(motion: Trajectory) -> None:
            context.leave_when_cancelled()
            steps = len(motion) - 1
            words = f"{steps} frames so far" if steps else "Looking for the person"
            context.report(steps / LONGEST, words, Following(self.frame, motion))

        tracker = context.cache.follower(session, self.video_path, Path(self.folder))
        return follow_ahead(tracker, self.frame, self.direction, session.settings, emit)

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        cues = doc.settings, doc.view.keypoint_corrections
        return (
            doc.subject.body,
            *filmed_by(doc),
            doc.view.ignore_masks,
            doc.subject.keyframes,
            *cues,
        )

    def apply(self, found_ahead: FoundAhead, state: AppState) -> tuple[AppState, str]:
        """What led nowhere changes nothing."""
        if found_ahead.to_frame == found_ahead.frame:
            raise ActionRefused(found_sentence(found_ahead))
        return replace(state, edit=with_followed(state.editing, found_ahead)), ""
