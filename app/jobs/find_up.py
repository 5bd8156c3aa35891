"""Find what is up by upright lines in the pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np

from keypose.app.editor.frames import to_world
from keypose.app.jobs.fit import Fit, filmed_by, sent
from keypose.app.jobs.job import Context
from keypose.app.words.standing import lines_words
from keypose.tracker.session import Session
from keypose.tracker.video import Video
from keypose.tracker.video.info import MissingFrame

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import FindUp as Asked
    from keypose.app.editor.state import EditorState
    from keypose.app.store.state import AppState
    from keypose.tracker.video.upright_lines import UprightLines

LABEL: Final = "find the up direction"
PICTURES: Final = 3
"""Pictures in which upright lines are looked for."""


def upright_lines(session: Session, video: Video, frame: int | None = None) -> UprightLines | None:
    """Find upright lines in one frame, or in some of the whole film; None where few agree."""
    from keypose.tracker.video.upright_lines import up_from_lines  # loads what only this needs

    spread = np.linspace(0, session.view.video.frame_count - 1, PICTURES).astype(int).tolist()
    pictures = []
    for number in spread if frame is None else [frame]:
        try:
            pictures.append(video.frame(number))
        except MissingFrame:
            continue
    camera = session.view.camera if frame is None else session.camera_at(frame)
    if not pictures:
        return None
    most = session.view.depth_share or 0.0  # two standard deviations of usual lenses
    return up_from_lines(pictures, camera, most / 2)


def sure_lines(session: Session, video: Video) -> UprightLines | None:
    """Those of the whole film where they are good enough to be taken unseen."""
    lines = upright_lines(session, video)
    return lines if lines is not None and lines.is_sure else None


@dataclass(frozen=True)
class FindUp(Fit):
    """frame: the present one, the only one that is looked at before a camera that moves."""

    frame: int = 0

    title = "Looking for upright lines"
    needs_loops = False
    why_cancelled = "Cancelled because the camera changed."
    not_of_surfaces = "A film is needed to find upright lines in it."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, _: Asked) -> Self:
        return cls(*sent(opened, edit.doc, keyframes=()), edit.frame)

    def work(self, session: Session, context: Context) -> UprightLines | None:
        video = context.cache.video(session, self.video_path)
        return upright_lines(session, video, None if session.has_static_camera else self.frame)

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        return *filmed_by(doc), doc.world.up_world

    def apply(self, found: UprightLines | None, state: AppState) -> tuple[AppState, str]:
        if found is None:
            return state, "Too few upright lines agree. Draw the horizon, or two verticals."
        edit = state.editing
        up_world = to_world(edit.doc, self.frame, found.up_camera)
        after = edit.with_step(edit.doc.with_up(up_world), LABEL)
        return replace(state, edit=after), lines_words(found)
