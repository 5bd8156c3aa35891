"""Drafts of a session's film: the bundled network at work on it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.keypoints.region import Box
from keypose.tracker.session import Session
from keypose.tracker.video import Video
from keypose.tracker.video.info import MissingFrame

if TYPE_CHECKING:
    from keypose.tracker.fitting.draft import ClipDraft, DraftProgress


class DraftLeft(Exception):
    """Raised within a draft that somebody cancelled."""


@dataclass
class DraftReporter:
    """Passes progress on, once for every whole number of per cent, and leaves when cancelled."""

    report: Callable[[DraftProgress], None]
    cancelled: Callable[[], bool]
    reported: tuple[str, int] = ("", -1)

    def __call__(self, progress: DraftProgress) -> None:
        if self.cancelled():
            raise DraftLeft
        now = (progress.stage, 100 * progress.done // max(progress.expected, 1))
        if now != self.reported:
            self.reported = now
            self.report(progress)


def drafted(
    session: Session,
    video: Video,
    at: int,
    box: Box,
    frames: tuple[int, int],
    *,
    proportions: bool,
    report: Callable[[DraftProgress], None],
) -> tuple[ClipDraft, str]:
    """Drafts of these frames, first and last, and the network's fingerprint; see `draft_clip`."""
    from keypose.tracker.fitting.draft import draft_clip  # loads what only this needs
    from keypose.tracker.keypoints.augmented import AugmentedNetwork
    from keypose.tracker.keypoints.model_files import FULL, find_model
    from keypose.tracker.storage.cache import Detections

    def picture(number: int) -> NDArray[np.uint8] | None:
        try:
            return video.frame(number)
        except MissingFrame:
            return None

    network = AugmentedNetwork.open(find_model(session.settings.network or FULL.name))
    found = draft_clip(
        picture, frames, at, box, session.camera, session.body, network,
        again=network.plain, proportions=proportions, report=report,
        film=session.video.pictures, kept=Detections(),
    )  # fmt: skip
    return found, network.fingerprint


def learned(session: Session, folder: Path, around: Collection[int]) -> Mapping[int, Pose]:
    """The drafts near some keyframes with what all keyframes there give of the keypoints; none
    where the keypoints are not beside the session any more. folder: of the session's file."""
    from keypose.tracker.fitting.draft import refit_drafts  # loads what only this needs
    from keypose.tracker.storage.sidecars import keypoints_of_session

    skeleton, keypoints = Skeleton.of(session.body), keypoints_of_session(session, folder)
    if keypoints is None:
        return {}
    keypoints = keypoints.corrected(session.keypoint_corrections)
    drafts = {d.frame: d.pose(skeleton) for d in session.drafts if d.drafted}
    posed = {k.frame: k.pose(skeleton) for k in session.keyframes}
    places = session.drafted.places if session.drafted else ()
    changes = [place.frame for place in places if place.reason == "person"]
    return refit_drafts(keypoints, session.camera, session.body, drafts, posed, around, changes)
