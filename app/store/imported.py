"""What was imported from a file, taken over as one step that can be undone."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from keypose.app.editor.documents import ActionRefused, unchanged
from keypose.app.editor.state import EditorState
from keypose.app.export.import_camera import with_camera_file
from keypose.app.export.importing import DraftImport, Import, MotionImport
from keypose.app.orders.imports import LEAST_TRACKED
from keypose.app.words.camera import imported_words
from keypose.app.words.imports import note_words
from keypose.tracker.errors import SessionError, listed
from keypose.tracker.session import Session
from keypose.tracker.storage.atomic import make_folder
from keypose.tracker.storage.sidecars import save_first_motion
from keypose.tracker.video import VideoInfo

LABEL = "import"
"""What undo calls it."""
CHANGED = "The body, the camera or a keyframe was changed meanwhile: import again."
SHOWN = 8
"""Frames in a sentence."""


@dataclass(frozen=True, eq=False)
class ImportTarget:
    """What a file is imported into: the session as it is now, and what is known of its video."""

    doc: Session
    session_path: Path
    video: VideoInfo

    @property
    def content(self) -> bytes:
        """The session as JSON."""
        return self.doc.model_dump_json().encode()


@dataclass(frozen=True)
class ImportOutcome:
    """What to report of an import: a sentence, what else is worth knowing, and whether that is a
    doubt, to be read."""

    words: str
    detail: str = ""
    doubtful: bool = False


def with_import(
    began: Session, edit: EditorState, imported: Import, file: str, session_path: Path
) -> tuple[EditorState, ImportOutcome]:
    """The state with what was imported; KeyposeError where that is not possible any more.

    began: what it was fitted to.  A motion is written beside the session.
    """
    if not unchanged(_inputs(began), _inputs(edit.doc)):
        raise ActionRefused(CHANGED)
    if isinstance(imported, MotionImport):
        make_folder(session_path.parent, error=SessionError)
        motion = imported.found.fit.trajectory
        doc = save_first_motion(edit.doc, session_path, motion, file, imported.matched)
        outcome = _of_motion(imported, file, edit.doc)
    elif isinstance(imported, DraftImport):
        if not imported.drafts:
            raise ActionRefused(_no_draft(imported, edit.doc))
        doc, outcome = imported.added_to(edit.doc), _of_drafts(imported, file)
    else:
        doc = with_camera_file(edit.doc, imported, file)
        focal, floor = (
            doc.view.camera.focal_mm,
            " and the floor" if imported.floor_m is not None else "",
        )
        words = f"Camera of {file} imported: {focal:.1f} mm, what is up{floor}."
        words_of_camera = (
            imported_words(doc, imported.background_px) if imported.way is not None else []
        )
        detail = " ".join([*note_words(imported.notes), *words_of_camera])
        outcome = ImportOutcome(words, detail, bool(imported.notes))
    return edit.with_step(doc, LABEL), outcome


def _inputs(doc: Session) -> tuple[object, ...]:
    return (
        doc.subject.body,
        doc.view.camera,
        doc.world.up_world,
        doc.subject.keyframes,
        doc.subject.drafts,
    )


def _of_motion(made: MotionImport, file: str, doc: Session) -> ImportOutcome:
    imported_motion, motion = made.found, made.found.fit.trajectory
    rms_cm = 100 * float(np.sqrt(np.nanmean(imported_motion.fit.rms_m**2)))
    words = f"{file} imported, frames {motion.first_frame}–{motion.last_frame}."
    sentences = [*note_words(imported_motion.notes), f"Joint error {rms_cm:.1f} cm (rms)."]
    if imported_motion.aligned:
        sentences.append(f"Aligned with {_frames('keyframe', imported_motion.aligned)}.")
    if imported_motion.scale != 1.0:
        sentences.append(f"Scaled to the body: × {imported_motion.scale:.3g}.")
    if len(doc.subject.keyframes) < LEAST_TRACKED:
        sentences.append("Reduce it to keyframes to see it, to edit it and to track from it.")
    else:
        sentences.append(
            "Tracking starts from it where it fits the video better than its own guess."
        )
    return ImportOutcome(words, " ".join(sentences), bool(imported_motion.notes))


def _of_drafts(draft_import: DraftImport, file: str) -> ImportOutcome:
    drafted = [draft.keyframe.frame for draft in draft_import.drafts]
    doubtful = [d.keyframe.frame for d in draft_import.drafts if d.doubtful or not d.converged]
    count = "1 draft" if len(drafted) == 1 else f"{len(drafted)} drafts"
    words = f"{count} made from {file}: {_frames('frame', drafted)}."
    closely = [f"Look closely at {_frames('frame', doubtful)}."] if doubtful else []
    return ImportOutcome(
        words, " ".join([*note_words(draft_import.notes), *closely]), bool(draft_import.notes)
    )


def _no_draft(draft_import: DraftImport, doc: Session) -> str:
    posed = {k.frame for k in (*doc.subject.keyframes, *doc.subject.drafts)}
    if draft_import.frames and posed.issuperset(draft_import.frames):
        return "All of these frames are posed already: choose others."
    return "No draft could be made: too few keypoints are seen at these frames."


def _frames(noun: str, frames: tuple[int, ...] | list[int]) -> str:
    shown = [str(frame) for frame in frames[:SHOWN]]
    if len(frames) > SHOWN:
        shown.append(f"{len(frames) - SHOWN} more")
    return f"{noun}{'' if len(frames) == 1 else 's'} {listed(shown)}"
