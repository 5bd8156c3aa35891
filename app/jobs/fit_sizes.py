"""Fit the body's sizes to its keyframes in all films; shown until they are applied or discarded."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from keypose.app.editor.body import require_sizes_to_fit
from keypose.app.jobs.fit import Fit, filmed_by, sent
from keypose.app.jobs.job import Context
from keypose.app.state.previews import SizesPreview
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session import Session
from keypose.tracker.session.between_views import measured_share

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor import actions
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState
    from keypose.tracker.fitting.sizes import SizesFitted


@dataclass(frozen=True)
class FitSizes(Fit):
    """focal: fit the camera's focal length too."""

    session: bytes = field(compare=False)
    focal: bool = False

    asked = ("fit_sizes",)
    why_cancelled = "Fit cancelled because the sizes changed."
    title = "Fitting the sizes"
    not_of_surfaces = (
        "Sizes are fitted to pictures, not to surfaces: set them in Body, by what you see."
    )

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, action: actions.FitSizes) -> Self:
        require_sizes_to_fit(edit)
        return cls(*sent(opened, edit.doc), action.focal)

    def work(self, session: Session, context: Context) -> SizesFitted:
        # loads what only this needs
        from keypose.tracker.fitting.sizes import fit_sizes
        from keypose.tracker.operations.films import seen_beside

        video = context.cache.video(session, self.video_path)
        skeleton = Skeleton.of(session.subject.body)
        keyposes = {k.frame: k.pose(skeleton) for k in session.subject.keyframes}
        return fit_sizes(
            video,
            session.view.camera,
            session.subject.body,
            keyposes,
            focal=self.focal,
            masks=session.view.ignore_masks,
            cancelled=context.cancelled,
            up=session.world.up_world,
            path=session.camera_path,
            films=seen_beside(session, Path(self.folder)),
            measured=measured_share(session),
        )

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        return (
            doc.subject.body,
            *filmed_by(doc),
            doc.view.ignore_masks,
            doc.view.surface,
            doc.subject.keyframes,
            doc.subject.drafts,
            *doc.views[1:],
        )

    def apply(self, sizes_fitted: SizesFitted, state: AppState) -> tuple[AppState, str]:
        preview = SizesPreview.of(sizes_fitted, state.editing)
        if preview is None:
            return state, sizes_fitted.message
        return replace(state, preview=preview, fit=None), ""
