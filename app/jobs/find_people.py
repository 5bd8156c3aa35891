"""Look for the people in one picture, for a person who is about to draw a box around one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

from keypose.app.jobs.fit import Fit, sent
from keypose.app.jobs.job import Context
from keypose.app.state.outcomes import Boxes
from keypose.tracker.errors import KeypointError
from keypose.tracker.session import Session
from keypose.tracker.video.info import MissingFrame

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.state import EditorState


@dataclass(frozen=True)
class FindPeople(Fit):
    """frame: whose picture is looked at. It is no fit that a person waits for, and changes nothing:
    whatever else is asked for ends it."""

    frame: int = 0

    title = "Looking for people"
    needs_loops = False
    fault = "Looking for people failed with an internal error ({}). Draw the box by hand."
    died = "Looking for people stopped unexpectedly. Draw the box by hand."
    not_of_surfaces = "A film is needed to find people in it."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, frame: int) -> Self:
        return cls(*sent(opened, edit.doc, keyframes=()), frame)

    def work(self, session: Session, context: Context) -> Boxes:
        from keypose.tracker.keypoints.find_people import PeopleFinder  # loads what only this needs

        finder = PeopleFinder.open(context.leave_when_cancelled)
        try:
            picture = context.cache.video(session, self.video_path).frame(self.frame)
        except MissingFrame as error:
            raise KeypointError(
                f"Frame {self.frame} cannot be read, so nobody was looked for in it."
            ) from error
        people = sorted(finder.near_or_far(picture), key=lambda person: -person.height_px)
        return tuple(person.box for person in people)
