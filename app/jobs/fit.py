"""What is asked of the worker besides tracking, of one session and its video."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

from keypose.app.editor.documents import unchanged
from keypose.app.jobs.job import Context, Job
from keypose.app.state.job_state import Kind
from keypose.tracker.errors import SurfaceError
from keypose.tracker.session import Session
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState


def filmed_by(doc: Session) -> tuple[Any, ...]:
    """All that says how the camera films: its lens, and its motion as corrected."""
    return doc.view.camera, doc.view.camera_motion, doc.view.camera_keyframes


@dataclass(frozen=True)
class Fit(Job):
    """What a person waits for. It is taken over only where what it began from still stands.

    session: as JSON, without what it does not need.  folder: of the session's file.
    asked: the names of the page's messages that ask for it; none where it follows by itself.
    not_of_surfaces: why there is none of surfaces.  keeps_found: whether what was found until it
    was cancelled is of use.  tracks_after: whether segments that it made outdated are tracked.
    """

    session: bytes
    video_path: str
    folder: str

    asked: ClassVar[tuple[str, ...]] = ()
    kind: ClassVar[Kind] = "fit"
    fault: ClassVar[str] = "Fitting failed with an internal error ({}). Nothing was changed."
    died: ClassVar[str] = "Fitting stopped unexpectedly; everything is as it was, fit again."
    why_cancelled: ClassVar[str] = ""
    not_of_surfaces: ClassVar[str] = ""
    keeps_found: ClassVar[bool] = False
    tracks_after: ClassVar[bool] = False

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, action: Any) -> Self:
        """What an action asks for of the state; refused with the reason where it cannot be had."""
        raise NotImplementedError

    def run(self, context: Context) -> Any:
        session = Session.model_validate_json(self.session)
        if self.not_of_surfaces and _ARE_SURFACES.of(session):
            raise SurfaceError(self.not_of_surfaces)
        result = self.work(session, context)
        if not self.keeps_found:
            context.leave_when_cancelled()
        return result

    def work(self, session: Session, context: Context) -> Any:
        """Do it for the session; Cancelled or KeyposeError as in `run`."""
        raise NotImplementedError

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        """What it stands or falls with."""
        raise NotImplementedError

    def stands(self, began: EditorState, edit: EditorState) -> bool:
        """Whether what it began from still stands."""
        return unchanged(self.inputs(edit.doc), self.inputs(began.doc))

    def apply(self, result: Any, state: AppState) -> tuple[AppState, str]:
        """The state with what was found, and what else is to be said; KeyposeError where that is
        not possible."""
        raise NotImplementedError

    def left(self, state: AppState) -> AppState:
        """The state once it was cancelled or failed."""
        return state


_ARE_SURFACES = ByEvidence({FilmEvidence: False, SurfaceEvidence: True})


def sent(opened: OpenSession, doc: Session, **without: Any) -> tuple[bytes, str, str]:
    """What every job of a session is sent: the session without what no fit needs, for it is read
    anew for every job, the video's path and the folder of the session's file."""
    content = doc.changed({"drafts": (), "results": None, **without}).model_dump_json()
    folder = str(opened.session_path.absolute().parent)
    return content.encode(), str(opened.video.info.path), folder
