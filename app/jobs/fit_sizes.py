"""Fit the body's sizes to its keyframes' pictures; shown until they are applied or discarded."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Self

from keypose.app.editor.body import require_sizes_to_fit, with_sizes_fitted
from keypose.app.editor.documents import ActionRefused
from keypose.app.jobs.fit import Fit, filmed_by, sent
from keypose.app.jobs.job import Context
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeyposeError
from keypose.tracker.session import Session

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor import actions
    from keypose.app.editor.state import EditorState
    from keypose.app.store.state import AppState
    from keypose.tracker.fitting.sizes import Proposal, SizesFitted


@dataclass(frozen=True)
class FitSizes(Fit):
    """focal: fit the camera's focal length too."""

    session: bytes = field(compare=False)
    focal: bool = False

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
        from keypose.tracker.fitting.sizes import fit_sizes  # loads what only this needs

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
        )

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        return (
            doc.subject.body,
            *filmed_by(doc),
            doc.view.ignore_masks,
            doc.view.surface,
            doc.subject.keyframes,
            doc.subject.drafts,
        )

    def apply(self, found: SizesFitted, state: AppState) -> tuple[AppState, str]:
        preview = SizesPreview.of(found, state.editing)
        if preview is None:
            return state, found.message
        return replace(state, preview=preview, fit=None), ""


@dataclass(frozen=True, eq=False)
class SizesPreview:
    """New sizes that wait to be applied or discarded.

    before: the document they were found for.  alone, with_poses: the documents with them, poses as
    they are or posed anew; None where these fit no better or are not possible.
    poses: which of the two is shown.  looking_back: `before` is shown just now.
    """

    found: SizesFitted
    before: Session
    alone: Session | None
    with_poses: Session | None
    poses: bool
    looking_back: bool = False

    @classmethod
    def of(cls, found: SizesFitted, edit: EditorState) -> SizesPreview | None:
        """Sizes alone to begin with; None where nothing fits better."""
        alone, with_poses = (_proposed(edit, some) for some in (found.alone, found.with_poses))
        if alone is None and with_poses is None:
            return None
        return cls(found, edit.doc, alone, with_poses, poses=alone is None)

    @property
    def after(self) -> Session:
        """The document that is shown, and applied."""
        chosen = self.with_poses if self.poses else self.alone
        assert chosen is not None
        return chosen

    @property
    def proposal(self) -> Proposal:
        """What it was made from."""
        chosen = self.found.with_poses if self.poses else self.found.alone
        assert chosen is not None
        return chosen

    def choosing(self, poses: bool) -> SizesPreview:
        """Choose with or without other poses; Refused where that fits no better."""
        if (self.with_poses if poses else self.alone) is None:
            raise ActionRefused("That does not fit better.")
        return replace(self, poses=poses)

    def shown_in(self, edit: EditorState) -> EditorState:
        """The new sizes, with the body as it is as an outline."""
        return replace(edit.with_doc(self.after), compared=self.before)

    def applied_to(self, edit: EditorState) -> EditorState:
        """The new sizes, as one step that can be undone."""
        some = self.proposal
        return with_sizes_fitted(edit, some.body, some.camera, some.keyposes)


def _proposed(edit: EditorState, proposal: Proposal | None) -> Session | None:
    if proposal is None:
        return None
    try:
        return with_sizes_fitted(edit, proposal.body, proposal.camera, proposal.keyposes).doc
    except KeyposeError:  # such as a draft that would come to lie behind the camera
        return None
