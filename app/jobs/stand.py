"""Stand the tracked motion on its floor."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

from keypose.app.editor.documents import softened
from keypose.app.jobs.find_up import SeenLines, seen_lines
from keypose.app.jobs.fit import Fit, sent
from keypose.app.jobs.job import Context
from keypose.app.state.outcomes import FoundUp
from keypose.app.words.standing import standing_words
from keypose.tracker.errors import KeyposeError
from keypose.tracker.session import Session
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.tracking.result import SegmentResult

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import Stand
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState
    from keypose.tracker.geometry.up import UpEvidence
    from keypose.tracker.operations.stand import Standing
    from keypose.tracker.storage.results import Results

LABEL: Final = "stand on the floor"
"""What undo calls it."""
CHANGED: Final = (
    "keyframes",
    "pins",
    "settings",
    "up_world",
    "up_from",
    "up_sigma_rad",
    "floor_m",
    "camera_motion",
    "camera_keyframes",
)
"""The session's fields that standing sets."""


def stood(
    session: Session,
    path: Path,
    results: Results,
    cancelled: Callable[[], bool] | None = None,
) -> tuple[Standing, Results]:
    """A saved session on its floor, and its results with the motion solved for there; no file is
    written. SessionError where nobody stands.

    path: of its file.  results: what was tracked.
    """
    from keypose.tracker.operations.stand import stand  # loads what only this needs
    from keypose.tracker.storage.tracks import load_tracks

    up_evidence = _seen(session, path)
    motion = None if session.subject.results is None else load_tracks(session, path)
    done = stand(session, results.fitting(session), up_evidence, cancelled, motion=motion)
    return done, resolved(done.session, results, cancelled)


def resolved(
    session: Session, results: Results, cancelled: Callable[[], bool] | None = None
) -> Results:
    """The results with the motion solved for in space wherever that is not known."""
    from keypose.tracker.operations.solve_space import solved  # loads what only this needs

    for stretch in results.unsolved(session):
        results = results.with_space(solved(session, stretch, cancelled))
    return results


def _seen(session: Session, path: Path) -> UpEvidence | None:
    """What lines of a saved session's film show of up. Where a person has set up, they only check
    it, and a film that is gone is no error."""
    from keypose.tracker.storage.files import open_video_of  # loads what only this needs

    if not session.has_static_camera and session.camera_path is None:
        return None
    try:
        video = open_video_of(session, path)
    except KeyposeError:
        if session.has_up_of_hand:
            return None
        raise
    with video:
        return seen_lines(session, video).evidence


@dataclass(frozen=True)
class StandOnFloor(Fit):
    """fitting: what was tracked, by segment.  frame: the present one, whose lines are shown of a
    camera that moves."""

    fitting: Mapping[Span, SegmentResult] = field(default_factory=dict, compare=False)
    frame: int = field(default=0, compare=False)

    asked = ("stand",)
    title = "Standing on the floor"
    why_cancelled = "Cancelled because keyframes, pins or the camera changed."
    fault = "Standing failed with an internal error ({}). Nothing was changed."
    not_of_surfaces = "A body fitted to surfaces stands where they do."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, _: Stand) -> Self:
        return cls(*sent(opened, edit.doc), edit.finished, edit.frame)

    def work(self, session: Session, context: Context) -> tuple[Standing, SeenLines]:
        from keypose.tracker.operations.stand import stand  # loads what only this needs

        seen_upright = seen_lines(
            session, context.cache.video(session, self.video_path), self.frame
        )
        return stand(session, self.fitting, seen_upright.evidence, context.cancelled), seen_upright

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        return (
            doc.subject.body,
            doc.view.camera,
            doc.subject.part_keyframes,
            *(doc.value(name) for name in CHANGED),
        )

    def apply(self, result: tuple[Standing, SeenLines], state: AppState) -> tuple[AppState, str]:
        done, seen_upright = result
        edit = state.editing
        fields = {name: done.session.value(name) for name in CHANGED if name != "keyframes"}
        keyframes = (
            softened(keyframe, "depth" if keyframe.frame in done.softened else keyframe.soft)
            for keyframe in edit.doc.subject.keyframes
        )
        # Unchanged keyframes stay the same objects, by which others see that nothing changed.
        fields["keyframes"] = tuple(keyframes)
        after = edit.with_step(edit.doc.changed(fields), LABEL)
        # Sources that disagree are shown on a card, where a person chooses one.
        up = (
            FoundUp(done.up, seen_upright.lines, seen_upright.frame, after.doc)
            if done.up.apart
            else None
        )
        return replace(state, edit=after, up=up), standing_words(done)
