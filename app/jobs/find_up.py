"""Find what is up by all that shows it, and take over what was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np

from keypose.app.jobs.fit import Fit, filmed_by, sent
from keypose.app.jobs.job import Context
from keypose.app.state.outcomes import FoundUp
from keypose.app.words.up import nothing_words, unsure_words, up_words
from keypose.tracker.session import Session
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video
from keypose.tracker.video.info import MissingFrame

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import FindUp as Asked
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState
    from keypose.tracker.geometry.up import UpEvidence
    from keypose.tracker.video.upright_lines import UprightLines

LABEL: Final = "find the up direction"
PICTURES: Final = 3
"""Pictures in which upright lines are looked for."""


@dataclass(frozen=True, eq=False)
class SeenLines:
    """What upright lines show of up, in the world, and those that are shown; None where few
    agree. frame: as of `FoundUp`."""

    evidence: UpEvidence | None
    lines: UprightLines | None
    frame: int | None = None


def upright_lines(session: Session, video: Video, frame: int | None = None) -> UprightLines | None:
    """Find upright lines in one frame, or in some of the whole film; None where few agree."""
    from keypose.tracker.operations.find_up import lens_spread  # loads what only this needs
    from keypose.tracker.video.upright_lines import up_from_lines

    pictures = []
    for number in _spread(session) if frame is None else [frame]:
        try:
            pictures.append(video.frame(number))
        except MissingFrame:
            continue
    camera = session.view.camera if frame is None else session.film_camera.at(frame)
    return up_from_lines(pictures, camera, lens_spread(session)) if pictures else None


def seen_lines(session: Session, video: Video, at: int | None = None) -> SeenLines:
    """Find upright lines in some frames of a film whose camera stands still, or moves as is known.

    at: the frame whose lines are shown, where a camera moves; the only one that is looked at as
    long as nobody knows how.
    """
    from keypose.tracker.operations.find_up import evidence_of_lines  # loads what only this needs

    if session.has_static_camera:
        lines = upright_lines(session, video)
        return SeenLines(None if lines is None else lines.evidence, lines)
    frames = [] if session.camera_path is None else _spread(session)
    frames += [] if at is None else [at]
    lines_of_frame = {
        frame: upright_lines(session, video, frame) for frame in dict.fromkeys(frames)
    }
    found_lines = {frame: lines for frame, lines in lines_of_frame.items() if lines is not None}
    return SeenLines(
        evidence_of_lines(session, found_lines), None if at is None else lines_of_frame[at], at
    )


def _spread(session: Session) -> list[int]:
    """Frames all over a film."""
    ends = np.linspace(0, session.view.video.frame_count - 1, PICTURES)
    return [int(frame) for frame in ends]


def with_up_unseen(session: Session, video: Video) -> tuple[Session, str]:
    """A session that nobody looks at, with up by the lines of its film where these are good enough,
    and what is said of that; itself where somebody set it, or the camera does not stand still."""
    if session.has_up_of_hand or not session.has_static_camera:
        return session, ""
    from keypose.tracker.operations.find_up import estimated_up  # loads what only this needs

    lines = upright_lines(session, video)
    up_estimate = None if lines is None else estimated_up(session, {}, lines.evidence)
    if lines is None:
        return session, nothing_words()
    if up_estimate is None or not lines.is_sure:
        return session, unsure_words(lines.evidence)
    return session.with_up_found(up_estimate), up_words(up_estimate)


@dataclass(frozen=True)
class FindUp(Fit):
    """frame: the present one, whose lines are shown of a camera that moves.  fitting: what was
    tracked, by segment."""

    frame: int = 0
    fitting: Mapping[Span, SegmentResult] = field(default_factory=dict, compare=False)

    asked = ("find_up",)
    title = "Looking for what is up"
    needs_loops = False
    why_cancelled = "Cancelled because the camera, the body, keyframes or pins changed."
    not_of_surfaces = "A film is needed to find the up direction."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, _: Asked) -> Self:
        return cls(*sent(opened, edit.doc), edit.frame, edit.finished)

    def work(self, session: Session, context: Context) -> FoundUp:
        from keypose.tracker.operations.find_up import (
            estimated_up,
            motions_of,
        )  # loads what only this needs

        seen_upright = seen_lines(
            session, context.cache.video(session, self.video_path), self.frame
        )
        free = session.with_up(None)  # asked for anew, whatever was set
        motions = motions_of(free, self.fitting)
        estimate = estimated_up(free, motions, seen_upright.evidence)
        return FoundUp(estimate, seen_upright.lines, seen_upright.frame, seen=seen_upright.evidence)

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        subject = doc.subject
        of_motion = subject.body, subject.keyframes, subject.part_keyframes, subject.pins
        up = doc.world.up_world, doc.world.up_from
        return *filmed_by(doc), *of_motion, subject.drafted, doc.settings, *up

    def apply(self, found_up: FoundUp, state: AppState) -> tuple[AppState, str]:
        edit, estimate = state.editing, found_up.estimate
        if estimate is None:
            return state, nothing_words() if found_up.seen is None else unsure_words(found_up.seen)
        after = edit.with_step(edit.doc.with_up_found(estimate), LABEL)
        return replace(
            state, edit=after, up=replace(found_up, after=after.doc)
        ), ""  # it has a card
