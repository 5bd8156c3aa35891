"""Add a film of the same motion to a session: when it was taken, and where its camera stands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from keypose.app.document.new import new_session
from keypose.app.editor.camera import as_taken
from keypose.app.editor.documents import film_of
from keypose.app.editor.films import choices_beside, require_overlap
from keypose.app.jobs.film_camera import with_camera_motion
from keypose.app.jobs.seen_in_films import (
    WhoIsMeant,
    keypoints_of_first,
    keypoints_of_others,
    seen_people,
)
from keypose.app.jobs.synchronised import (
    Synchronised,
    best_of,
    frame_rates,
    require_common_motion,
    synchronised,
)
from keypose.app.jobs.with_film import AddedFilm, with_film
from keypose.app.orders.film import BesideOrder
from keypose.app.orders.tracking import FilmTaken, said
from keypose.app.words.films import aside_deg, same_view_words
from keypose.tracker.errors import SessionError
from keypose.tracker.films.offset import CLOSE
from keypose.tracker.films.sound import heard_s
from keypose.tracker.formats.cameras.calibrated_pair import calibrated_pairs
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.keypoints.find_people import PeopleInFilm
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session import Session
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.session.views import View
from keypose.tracker.storage.files import open_video_of, video_path
from keypose.tracker.storage.sidecars import keypoints_of_session
from keypose.tracker.tracking.pool import Cancelled, never
from keypose.tracker.video import Video
from keypose.tracker.video.sound import loudness_of

AS_IN_ITS_FILE = FilmTaken()
SEEN_FIRST = 0.2
SEEN = 0.7
FOLLOWED = 0.9
"""Shares of the work that are done once the first film was looked at, the other one, and how its
camera moves."""
MOST_FILMS = 8
"""Of one motion."""
LEAST_ASIDE_DEG = 8.0
"""Between the directions from which two films see the person; nearer ones say nothing of depth."""


def found_film(
    session: Session,
    session_path: Path,
    path: Path,
    order: BesideOrder,
    report: Callable[[float], None] = lambda share: None,
    cancelled: Callable[[], bool] = never,
    calibration: Path | None = None,
    taken: FilmTaken = AS_IN_ITS_FILE,
) -> AddedFilm:
    """A film that shows the motion of a session; no file is written.

    path: of the film.  calibration: a file of several cameras, both films' among them.  taken: how
        it was taken, where its file does not say so.
    report: receives the share that is done.  Cancelled, or KeyposeError in one sentence where it
    cannot be read, shows nobody, or nothing that the first shows.
    """
    _require_room(session)
    deinterlace = said(taken).get("deinterlace", True)
    with (
        open_video_of(session, session_path) as first,
        Video.open(path, deinterlace=deinterlace) as video,
    ):
        view = _begun_view(session, session_path, video, taken)
        rates = frame_rates(session, view, first, video)
        if order.begins is not None:
            require_overlap(session, view, FilmClock(order.begins, rates[1] / rates[0]))
        pairs = [None] if calibration is None else calibrated_pairs(calibration, session.view, view)
        first_keypoints = keypoints_of_first(session, session_path, first, cancelled)
        report(SEEN_FIRST)

        def looked(share: float) -> None:
            report(SEEN_FIRST + (SEEN - SEEN_FIRST) * share)

        def followed(share: float) -> None:
            if cancelled():
                raise Cancelled
            report(SEEN + (FOLLOWED - SEEN) * share)

        candidates, people = seen_people(session, view, video, order, looked, cancelled)
        view = with_camera_motion(
            session, view, video, [each.keypoints for each in candidates], followed
        )
    heard = _heard(session, session_path, path, rates)
    tried = []
    for person in candidates:
        both = first_keypoints, person.keypoints
        of_pairs = [
            synchronised(session, view, both, rates, order.begins, pair, cancelled, heard)
            for pair in pairs
        ]
        if cancelled():
            raise Cancelled
        tried.append(best_of(of_pairs))
    number = _who_is_meant(tried, people)
    person, best = candidates[number], tried[number]
    keypoints = first_keypoints, person.keypoints
    require_common_motion(session, view, keypoints, best, order.begins, calibration)
    others = keypoints_of_others(session, session_path.parent)
    added = with_film(session, view, keypoints, best, person.network, person.frame, others=others)
    added = replace(added, people=len(candidates))
    if aside_deg(added.session, added.view) < LEAST_ASIDE_DEG:
        raise SessionError(same_view_words(path.name))
    return added


def _who_is_meant(tried: Sequence[Synchronised], people: PeopleInFilm | None) -> int:
    """The number of the person who moves as in the first film; WhoIsMeant where two do so nearly
    as well, or none of several does."""
    order = sorted(range(len(tried)), key=lambda number: tried[number].cost)
    if len(order) == 1:
        return 0
    best, second = tried[order[0]], tried[order[1]]
    if not best.offsets or second.cost <= CLOSE * best.cost:
        raise WhoIsMeant(people)
    return order[0]


def _heard(
    session: Session, session_path: Path, path: Path, rates: tuple[float, float]
) -> float | None:
    """The frame of the first film at which another begins, as their sound says; None where it says
    nothing, or a film plays slower than it was recorded, with its sound as it is."""
    if session.view.video.recorded_fps is not None:
        return None
    seconds = heard_s(loudness_of(video_path(session, session_path)), loudness_of(path))
    return None if seconds is None else seconds * rates[0]


def placed_again(
    session: Session,
    session_path: Path,
    view_id: str,
    begins: float,
    report: Callable[[float], None] = lambda share: None,
    cancelled: Callable[[], bool] = never,
) -> AddedFilm:
    """A film of a session with its camera found anew, from what was seen in it, for a frame of the
    first at which it begins; as of `found_film`."""
    alone, view = session.alone(view_id), film_of(session, view_id)
    name = Path(view.video.path).name
    film_keypoints = keypoints_of_session(alone, session_path.parent)
    if film_keypoints is None or view.keypoints is None:
        raise SessionError(
            f"Nothing is known of the person in {name}: remove the film and add it again."
        )
    with open_video_of(session, session_path) as first, open_video_of(alone, session_path) as video:
        first_keypoints = keypoints_of_first(session, session_path, first, cancelled)
        rates = frame_rates(session, view, first, video)
    report(0.5)
    rest = tuple(each for each in session.views if each is not view)
    without = session.model_copy(update={"views": rest})
    keypoints = first_keypoints, film_keypoints
    best = synchronised(without, view, keypoints, rates, begins, None, cancelled)
    require_common_motion(without, view, keypoints, best, begins, None)
    seeds = view.keypoints.seeds
    network, at = view.keypoints.network, seeds[0] if seeds else 0
    also = choices_beside(view, begins)
    others = keypoints_of_others(without, session_path.parent)
    return with_film(without, view, keypoints, best, network, at, also, others=others)


_TAKES_NONE = ByEvidence(
    {FilmEvidence: "", SurfaceEvidence: "A session about surfaces takes no film beside them."}
)


def _require_room(session: Session) -> None:
    if why := _TAKES_NONE.of(session):
        raise SessionError(why)
    if not is_persons(session.subject.body):
        raise SessionError(
            "Where another film's camera stands is found from a person: this body is none."
        )
    if session.has_unknown_motion:
        raise SessionError(
            "The first film's camera moves, and nobody knows how: find that first, or say that it "
            "stands still (in the Camera tab, or by keypose camera)."
        )
    if session.view.camera_motion is not None and session.view.camera_motion.unscaled:
        raise SessionError(
            "How far the first film's camera went is not known: say that first (in the Camera tab, "
            "or by keypose camera --went)."
        )
    if len(session.views) >= MOST_FILMS:
        raise SessionError(f"The session has {MOST_FILMS} films already, which are the most.")


def _begun_view(session: Session, session_path: Path, video: Video, taken: FilmTaken) -> View:
    """The view of a film, before anything is known of where it stands."""
    view = as_taken(new_session(video, session_path), said(taken)).view
    fingerprints = [each.video.fingerprint for each in session.views]
    if view.video.fingerprint and view.video.fingerprint in fingerprints:
        raise SessionError("This film is in the session already.")
    ids = {each.id for each in session.views}
    number = next(n for n in range(2, MOST_FILMS + 2) if f"film-{n}" not in ids)
    return view.model_copy(update={"id": f"film-{number}"})
