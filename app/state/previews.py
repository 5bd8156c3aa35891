"""What jobs propose: shown until it is applied or discarded."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from keypose.app.editor.body import with_sizes_fitted
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.reduced import Reducible, with_reduction
from keypose.app.editor.state import EditorState
from keypose.tracker.errors import KeyposeError, SessionError
from keypose.tracker.reduction.result import Reduction
from keypose.tracker.session import Session
from keypose.tracker.storage.atomic import make_folder
from keypose.tracker.storage.sidecars import save_own_motion

if TYPE_CHECKING:
    from keypose.app.editor import actions
    from keypose.tracker.fitting.sizes import Proposal, SizesFitted


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
    def of(cls, sizes_fitted: SizesFitted, edit: EditorState) -> SizesPreview | None:
        """Sizes alone to begin with; None where nothing fits better."""
        alone, with_poses = (
            _proposed(edit, proposal) for proposal in (sizes_fitted.alone, sizes_fitted.with_poses)
        )
        if alone is None and with_poses is None:
            return None
        return cls(sizes_fitted, edit.doc, alone, with_poses, poses=alone is None)

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
        return _with(edit, self.proposal)


@dataclass(frozen=True, eq=False)
class ReductionPreview:
    """A reduction that waits to be applied or discarded.

    asked: what was asked for last.  found: the motion, as it is to be reduced.
    reduction: its keyframes; of what was asked before while `busy`, None at first.
    """

    asked: actions.Reduce
    found: Reducible
    reduction: Reduction | None = None
    busy: bool = True

    def applied_to(self, edit: EditorState, session_path: Path) -> EditorState:
        """The keyframes, as one step that can be undone; the motion is written beside the session.
        Refused while they are not known."""
        if self.reduction is None or self.busy:
            raise ActionRefused("The keyframes are not known yet. Wait a moment.")
        own = None
        if self.found.parts is None:
            make_folder(session_path.parent, error=SessionError)
            own = save_own_motion(edit.doc, session_path, self.found.motion)
        frames, replacing = self.reduction.frames, self.asked.replacing
        return with_reduction(edit, self.found, frames, own, replacing=replacing)


def _proposed(edit: EditorState, proposal: Proposal | None) -> Session | None:
    if proposal is None:
        return None
    try:
        return _with(edit, proposal).doc
    except KeyposeError:  # such as a draft that would come to lie behind the camera
        return None


def _with(edit: EditorState, proposal: Proposal) -> EditorState:
    return with_sizes_fitted(
        edit,
        proposal.body,
        proposal.camera,
        proposal.keyposes,
        proposal.larger,
        proposal.apart,
    )
