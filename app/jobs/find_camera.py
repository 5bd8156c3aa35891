"""Find how the film's camera moves, from its background."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np

from keypose.app.editor.documents import seen_as_before
from keypose.app.jobs.fit import Fit, sent
from keypose.app.jobs.job import Context
from keypose.app.words.camera import (
    camera_sentence,
    finding_sentences,
    lens_sentence,
    way_sentences,
)
from keypose.tracker.session import Session
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.tracking.result import SegmentResult

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import FindCamera as Asked
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState
    from keypose.tracker.camera_motion import CameraKind
    from keypose.tracker.operations.find_camera import FoundCamera

LABEL: Final = "find the camera's motion"
REPORTS_S: Final = 0.2
"""Between reports of how far it is."""


def found_words(found_camera: FoundCamera) -> str:
    """Say what was found of the camera, the most important first."""
    motion, error = found_camera.motion, None
    if motion is not None and np.isfinite(motion.errors_px).any():
        error = float(np.nanmedian(motion.errors_px))
    zooms = motion is not None and motion.path.zooms
    unscaled = () if motion is None else motion.unscaled
    words = [camera_sentence(found_camera.kind, zooms, error)]
    if found_camera.lens is not None:
        words.append(lens_sentence(found_camera.lens.focal_mm))
    words += [] if motion is None else way_sentences(motion)
    return " ".join([*words, *finding_sentences((*found_camera.findings, *unscaled))])


def with_found(session: Session, found_camera: FoundCamera) -> Session:
    """The session with what was found of its camera. A zoom, and a lens that was a guess and turns
    out as another, move what is posed along the line of sight, so that it is seen as large as
    before."""
    after = found_camera.applied(session)
    if found_camera.lens is not None:
        after = after.changed({"camera": found_camera.lens, "lens_source": "turns"})
    return seen_as_before(session, after)


def is_camera_wanted(session: Session) -> bool:
    """Whether a session says that its camera's motion is found, and nobody has found it."""
    unknown = session.view.camera_motion is None and not session.has_static_camera
    return bool(session.settings.find_camera) and unknown and not session.evidence.has_surface


def find_saved(
    session: Session,
    path: Path,
    camera: CameraKind | None = None,
    report: Callable[[float], None] = lambda share: None,
) -> FoundCamera:
    """Find how the camera of a saved session's film moves.

    camera: how it moves, where that is known.  report: receives the share that is done.
    """
    from keypose.tracker.operations import (
        find_camera as camera_motion,  # loads what only this needs
    )
    from keypose.tracker.storage.files import open_video_of
    from keypose.tracker.storage.results import load_results

    fitting = load_results(session, path).fitting(session)
    poses = camera_motion.known_poses(session, fitting)
    with open_video_of(session, path) as video:
        found_camera = camera_motion.find_camera(session, video, poses, camera, report)
    camera_motion.keep_points(found_camera)
    return camera_motion.scaled(found_camera, session, fitting)


@dataclass(frozen=True)
class FindCamera(Fit):
    """camera: how it moves, where a person said; None: as it is found.  fitting: what was tracked,
    by segment: the body is no background."""

    camera: CameraKind | None = None
    fitting: Mapping[Span, SegmentResult] = field(default_factory=dict, compare=False)

    asked = ("find_camera",)
    kind = "camera"
    title = "Finding the camera's motion"
    fault = "Finding the camera failed with an internal error ({}). Nothing was changed."
    died = "Finding the camera stopped unexpectedly; everything is as it was, find it again."
    why_cancelled = "Cancelled because the lens or a mask changed."
    not_of_surfaces = "A film is needed to find its camera's motion."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, asked: Asked) -> Self:
        work_inputs = sent(opened, edit.doc, drafts=edit.doc.subject.drafts)
        return cls(*work_inputs, asked.camera, edit.finished)

    def work(self, session: Session, context: Context) -> FoundCamera:
        from keypose.tracker.operations import (
            find_camera as camera_motion,  # loads what only this needs
        )

        began, said = time.monotonic(), 0.0

        def report(share: float) -> None:
            nonlocal said
            context.leave_when_cancelled()
            now = time.monotonic() - began
            if now - said > REPORTS_S:
                said = now  # how many passes there will be nobody knows, nor when they are done
                context.report(share, "")

        video = context.cache.video(session, self.video_path)
        poses = camera_motion.known_poses(session, self.fitting)
        found_camera = camera_motion.find_camera(session, video, poses, self.camera, report)
        camera_motion.keep_points(found_camera)
        found_camera = camera_motion.scaled(found_camera, session, self.fitting)
        return replace(found_camera, points=None)  # which are many, and kept

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        return doc.view.camera, doc.view.ignore_masks

    def apply(self, found_camera: FoundCamera, state: AppState) -> tuple[AppState, str]:
        edit = state.editing
        after = edit.with_step(with_found(edit.doc, found_camera), LABEL)
        return replace(state, edit=after), found_words(found_camera)
