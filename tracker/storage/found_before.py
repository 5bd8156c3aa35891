"""The keypoints that were found when a session was tracked, as this user's cache keeps them."""

from __future__ import annotations

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.model_files import FULL, find_model
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.detections import Detections
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.tracking.cues import sources


def found_before(session: Session, span: Span) -> Keypoints | None:
    """Those that a network found in one segment, without a look at the film; None where there are
    none."""
    skeleton = Skeleton.of(session.body)
    posed = {k.frame: k.pose(skeleton) for k in session.keyframes if k.frame in span}
    model = find_model(session.settings.network or FULL.name)
    film = session.video.pictures
    return sources.found_before(posed, skeleton, session.camera, film, Detections(), model)
