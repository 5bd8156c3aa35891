"""Stand the tracked motion on its floor."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol, Self

from keypose.app.editor.documents import softened
from keypose.app.jobs.find_up import SeenLines, seen_lines
from keypose.app.jobs.fit import Fit, sent
from keypose.app.jobs.job import Context
from keypose.app.state.outcomes import FoundUp
from keypose.app.words.bodies import after_id, body_names
from keypose.app.words.standing import bodies_stand_words
from keypose.tracker.errors import KeyposeError, SessionError
from keypose.tracker.session import Session
from keypose.tracker.session.schema import World
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.tracking.result import SegmentResult

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import Stand
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState
    from keypose.tracker.geometry.up import UpEvidence
    from keypose.tracker.operations.stand import Standing
    from keypose.tracker.space.soles import Soles
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


def _standing(
    session: Session,
    path: Path,
    results: Results,
    cancelled: Callable[[], bool] | None = None,
    *,
    tilts: bool,
) -> Standing:
    """A saved session on its floor, of which no file is written. SessionError where nobody stands.

    path: of its file.  results: what was tracked.  tilts: as of `stand`.
    """
    from keypose.tracker.operations.stand import stand  # loads what only this needs
    from keypose.tracker.storage.tracks import load_tracks

    up_evidence = _seen(session, path)
    motion = None if session.subject.results is None else load_tracks(session, path)
    fitting = results.fitting(session)
    return stand(session, fitting, up_evidence, cancelled, motion=motion, tilts=tilts)


@dataclass(frozen=True, eq=False)
class BodyStood:
    """What became of one body: how it stands, and its results with the motion solved for there.

    beside: whether it stands on the floor of another one.
    """

    done: Standing
    results: Results
    beside: bool = False

    @property
    def soles(self) -> Soles | None:
        """How its soles lie on the floor."""
        from keypose.tracker.space.soles import soles_of  # loads what only this needs

        return soles_of(self.done.session, self.results.space(self.done.session))


def stood_together(
    session: Session,
    path: Path,
    body_ids: Sequence[str],
    cancelled: Callable[[], bool] | None = None,
) -> tuple[Session, dict[str, BodyStood], dict[str, str]]:
    """A saved session whose bodies stand one after the other on one floor, that which the first to
    stand finds; what became of each, and why others do not stand, by their ids. SessionError where
    nobody does; no file is written.
    """
    from keypose.tracker.operations.stand import with_things_along  # loads what only this needs

    abouts = [session.about(body_id) for body_id in body_ids]
    results = {about.subject.id: _loaded(about, path) for about in abouts}

    def stand_there(about: Session, *, tilts: bool) -> Standing:
        return _standing(about, path, results[about.subject.id], cancelled, tilts=tilts)

    fittings = {about.subject.id: results[about.subject.id].fitting(about) for about in abouts}
    standing, refused = one_after_another(session, fittings, stand_there)
    if not standing:
        words = (after_id(words, body_id, session) for body_id, words in refused.items())
        raise SessionError(" ".join(words))
    last = list(standing.values())[-1].session
    whole, _ = with_things_along(last.about(session.subject.id), standing)
    bodies_stood = {}
    for place, (body_id, done) in enumerate(standing.items()):
        about = whole.about(body_id)
        in_space = resolved(about, results[body_id], cancelled)
        bodies_stood[body_id] = BodyStood(replace(done, session=about), in_space, place > 0)
    return whole, bodies_stood, refused


class _StandThere(Protocol):
    """Stands a body, in a session about it; SessionError where it cannot stand."""

    def __call__(self, about: Session, *, tilts: bool) -> Standing: ...


def one_after_another(
    session: Session, fittings: Mapping[str, Mapping[Span, SegmentResult]], stand_there: _StandThere
) -> tuple[dict[str, Standing], dict[str, str]]:
    """Bodies on one floor, that of the first to stand: each as it stands in a session in which
    those before it do; and why others do not, by their ids.

    fittings: what was tracked, by segment, by the body's id.
    """
    from keypose.tracker.operations.stand import in_standing_order  # loads what only this needs

    standing: dict[str, Standing] = {}
    refused: dict[str, str] = {}
    whole = session
    for body_id in in_standing_order(session, fittings):
        about = whole.about(body_id)
        try:
            if standing:
                done = stood_beside(about, whole.world, partial(stand_there, tilts=False))
            else:
                done = stand_there(about, tilts=True)
        except SessionError as error:
            refused[body_id] = str(error)
            continue
        standing[body_id], whole = done, done.session
    return standing, refused


def _loaded(session: Session, path: Path) -> Results:
    from keypose.tracker.storage.results import load_results  # loads what only this needs

    return load_results(session, path)


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


def stood_beside(
    session: Session, world: World, stand_there: Callable[[Session], Standing]
) -> Standing:
    """A body in the world where another one stands already, whose floor and up stay."""
    as_set = world.model_copy(update={"up_from": (*world.up_from, "set")})
    done = stand_there(session.model_copy(update={"world": as_set}))
    return replace(done, session=done.session.model_copy(update={"world": world}))


class EachStood(NamedTuple):
    """How every body stands, by id, the one whose floor it is first; why some do not; and what was
    seen of up."""

    standing: dict[str, Standing]
    refused: dict[str, str]
    lines: SeenLines


@dataclass(frozen=True)
class StandOnFloor(Fit):
    """fittings: what was tracked of each body, by segment, by the body's id.  frame: the present
    one, whose lines are shown of a camera that moves."""

    fittings: Mapping[str, Mapping[Span, SegmentResult]] = field(
        default_factory=dict, compare=False
    )
    frame: int = field(default=0, compare=False)

    asked = ("stand",)
    title = "Standing on the floor"
    why_cancelled = "Cancelled because keyframes, pins or the camera changed."
    fault = "Standing failed with an internal error ({}). Nothing was changed."
    not_of_surfaces = "A body fitted to surfaces stands where they do."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, _: Stand) -> Self:
        posed = edit.doc.subject.id
        fittings = {posed: edit.finished}
        for body in edit.doc.bodies:
            if body.id != posed and (fitting := edit.about(body.id).finished):
                fittings[body.id] = fitting
        return cls(*sent(opened, edit.doc), fittings, edit.frame)

    def work(self, session: Session, context: Context) -> EachStood:
        from keypose.tracker.operations.stand import stand  # loads what only this needs

        video = context.cache.video(session, self.video_path)
        seen_upright = seen_lines(session, video, self.frame)

        def stand_there(about: Session, *, tilts: bool) -> Standing:
            fitting, evidence = self.fittings[about.subject.id], seen_upright.evidence
            return stand(about, fitting, evidence, context.cancelled, tilts=tilts)

        standing, refused = one_after_another(session, self.fittings, stand_there)
        if not standing:
            raise SessionError(next(iter(refused.values())))
        return EachStood(standing, refused, seen_upright)

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        return (
            doc.subject.body,
            doc.view.camera,
            doc.subject.part_keyframes,
            *(doc.value(name) for name in CHANGED),
            *(body for body in doc.bodies if body is not doc.subject),
        )

    def apply(self, result: EachStood, state: AppState) -> tuple[AppState, str]:
        from keypose.tracker.operations.stand import with_things_along  # loads what only this needs

        standing, refused, seen_upright = result
        edit = state.editing
        doc, posed = edit.doc, edit.doc.subject.id
        for body_id, done in standing.items():
            doc = _as_stood(doc.about(body_id), done)
        doc, along = with_things_along(doc.about(posed), standing)
        refused = {name: why for name, why in refused.items() if name not in along}
        after = edit.with_step(doc, LABEL)
        # Sources that disagree are shown on a card, where a person chooses one.
        up = next(iter(standing.values())).up
        found_up = (
            FoundUp(up, seen_upright.lines, seen_upright.frame, after.doc) if up.apart else None
        )
        words = bodies_stand_words(standing, refused, body_names(edit.doc), along)
        return replace(state, edit=after, up=found_up), words


def _as_stood(doc: Session, done: Standing) -> Session:
    """The session with what standing changes of the body that is posed, and of the world."""
    fields = {name: done.session.value(name) for name in CHANGED if name != "keyframes"}
    # Unchanged keyframes stay the same objects, by which others see that nothing changed.
    fields["keyframes"] = tuple(
        softened(keyframe, "depth" if keyframe.frame in done.softened else keyframe.soft)
        for keyframe in doc.subject.keyframes
    )
    return doc.changed(fields)
