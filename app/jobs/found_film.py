"""Another film of a session's motion, as it was found: plain and light, for it is sent."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from keypose.app.editor.drafted import KEYPOINT_SOURCE
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.session import Session
from keypose.tracker.storage.sidecars import save_keypoints


class FoundFilm(NamedTuple):
    """A film that shows the motion of a session.

    session: with the film as its last view, which has no keypoints yet.  keypoints, network, seed:
    what was seen of the person in it, by which network, and the frame looked at first.  words: what
    was found, in sentences.
    """

    session: Session
    keypoints: Keypoints
    network: str
    seed: int
    words: str

    def saved(self, session_path: Path) -> Session:
        """The session, not yet saved, with the film's keypoints, which are written beside its
        file."""
        view = self.session.views[-1]
        alone = save_keypoints(
            self.session.alone(view.id),
            session_path,
            self.keypoints,
            KEYPOINT_SOURCE,
            network=self.network,
            seeds=(self.seed,),
        )
        view = view.model_copy(update={"keypoints": alone.view.keypoints})
        return self.session.model_copy(update={"views": (*self.session.views[:-1], view)})
