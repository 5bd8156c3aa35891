"""Draft a pose of every frame of a clip from a box around the person on one of them."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.app.editor.drafted import (
    KEYPOINT_SOURCE,
    keeps_proportions,
    require_draftable,
    with_clip_drafted,
)
from keypose.app.jobs.fit import Fit, sent
from keypose.app.jobs.job import Context
from keypose.app.jobs.progress import seconds_left
from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.region import Box
from keypose.tracker.session import Session
from keypose.tracker.session.settings import Position
from keypose.tracker.storage.atomic import make_folder
from keypose.tracker.storage.sidecars import keypoints_of_session, save_keypoints
from keypose.tracker.tracking.pool import Cancelled
from keypose.tracker.video import Video
from keypose.tracker.video.info import MissingFrame

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import Draft
    from keypose.app.editor.state import EditorState
    from keypose.app.store.state import AppState
    from keypose.tracker.fitting.draft import ClipDraft, DraftProgress

NETWORK_SHARE = 0.9
"""Of the time that a draft takes."""

Drafted: TypeAlias = "tuple[ClipDraft, str]"
"""The drafts, and the fingerprint of the network."""


@dataclass
class DraftReporter:
    """Passes progress on, once for every further per cent of a stage, and leaves when cancelled.

    A stage may find out that there is more to do: meanwhile nothing is reported.
    """

    report: Callable[[DraftProgress], None]
    cancelled: Callable[[], bool]
    reported: tuple[str, int] = ("", -1)

    def __call__(self, progress: DraftProgress) -> None:
        if self.cancelled():
            raise Cancelled
        stage, per_cent = self.reported
        now = 100 * progress.done // max(progress.expected, 1)
        if progress.stage != stage or now > per_cent:
            self.reported = progress.stage, now
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
) -> Drafted:
    """Drafts of these frames, first and last; see `draft_clip`."""
    from keypose.tracker.fitting.draft import draft_clip  # loads what only this needs
    from keypose.tracker.keypoints.detectors import open_detector
    from keypose.tracker.keypoints.model_files import find_model
    from keypose.tracker.storage.cache import Detections

    def picture(number: int) -> NDArray[np.uint8] | None:
        try:
            return video.frame(number)
        except MissingFrame:
            return None

    network = open_detector(find_model(session.settings.network_used))
    found = draft_clip(
        picture, frames, at, box, session.camera, session.body, network,
        again=network.plain, proportions=proportions, up_camera=session.up_camera, report=report,
        film=session.video.pictures, kept=Detections(),
    )  # fmt: skip
    return found, network.fingerprint


@dataclass(frozen=True)
class DraftClip(Fit):
    """frame, box: the frame of the box, and left, top, right, bottom in pixels.

    frames: first and last to draft.
    proportions: whether the body's limbs may be scaled to the person's.
    up_camera: what is known to be up; drafts stay where that changes meanwhile.
    """

    frame: int
    box: Box
    frames: tuple[int, int]
    proportions: bool
    up_camera: Position | None = None

    kind = "draft"
    title = "Drafting poses"
    why_cancelled = "Draft cancelled because the body, the camera or a keyframe changed."
    not_of_surfaces = "Drafts are made from a video, not from surfaces."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, action: Draft) -> Self:
        doc, last = edit.doc, edit.frame_count - 1
        frames = (action.first or 0, last if action.last is None else action.last)
        require_draftable(doc, action.frame, action.box, frames)
        given = sent(opened, doc, keyframes=())
        box, proportions = action.box, not keeps_proportions(doc)
        return cls(*given, action.frame, box, frames, proportions, doc.up_camera)

    def work(self, session: Session, context: Context) -> Drafted:
        began = time.monotonic()

        def report(progress: DraftProgress) -> None:
            share, words = progress_of(progress)
            left = seconds_left(time.monotonic() - began, share)
            context.report(share, words, seconds_left=left)

        return drafted(
            session, context.cache.video(session, self.video_path), self.frame, self.box,
            self.frames, proportions=self.proportions,
            report=DraftReporter(report, context.cancelled),
        )  # fmt: skip

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        return doc.body, doc.camera, doc.surface, doc.keyframes

    def apply(self, found: Drafted, state: AppState) -> tuple[AppState, str]:
        assert state.opened is not None
        after = self.taken(found, state.editing, Path(state.opened.session_path))
        return replace(state, edit=after, draft=after.doc), ""

    def taken(self, found: Drafted, edit: EditorState, path: Path) -> EditorState:
        """The state with the drafts, their keypoints written beside the session; KeyposeError where
        that is not possible. path: of the session's file."""
        draft, network = found
        make_folder(path.parent, error=KeypointError)  # a new film's is there from its first edit
        seeds, keypoints = {self.frame}, draft.keypoints
        before = _keypoints_before(edit.doc, path, network)
        if before is not None and edit.doc.keypoints is not None:
            seeds |= set(edit.doc.keypoints.seeds)
            keypoints = before.overlaid(keypoints)
        referring = save_keypoints(
            edit.doc, path, keypoints, KEYPOINT_SOURCE, network=network, seeds=tuple(seeds)
        )
        given = (draft.body, draft.poses, referring.keypoints, draft.proposals)
        return with_clip_drafted(edit, self.frames, *given, self.up_camera)


def progress_of(progress: DraftProgress) -> tuple[float, str]:
    """Return the share and words. The network takes most of the time."""
    share = progress.done / max(progress.expected, 1)
    if progress.stage == "keypoints":  # at frames from before and from after them, some twice
        return NETWORK_SHARE * share, f"Looking for the person: {100 * share:.0f} %"
    words = f"Posing: {progress.done} of {progress.expected} frames"
    return NETWORK_SHARE + (1 - NETWORK_SHARE) * share, words


def _keypoints_before(doc: Session, path: Path, network: str) -> Keypoints | None:
    """Return what the same network found for an earlier draft, perhaps of other frames."""
    if doc.keypoints is None or doc.keypoints.network != network:
        return None
    with suppress(KeypointError):  # they are found again when needed
        return keypoints_of_session(doc, path.parent)
    return None
