"""Add a film of the same motion to a session: when it was taken, and where its camera stands."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from keypose.app.document.new import new_session
from keypose.app.editor.camera import as_taken
from keypose.app.editor.documents import film_of
from keypose.app.editor.films import choices_beside, require_overlap
from keypose.app.jobs.seen_in_films import (
    box_of,
    detected,
    keypoints_of_first,
    keypoints_of_others,
)
from keypose.app.jobs.synchronised import (
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
from keypose.tracker.formats.cameras.calibrated_pair import calibrated_pairs
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session import Session
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.session.views import View
from keypose.tracker.storage.files import open_video_of
from keypose.tracker.storage.sidecars import keypoints_of_session
from keypose.tracker.tracking.pool import Cancelled, never
from keypose.tracker.video import Video

AS_IN_ITS_FILE = FilmTaken()
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
        report(0.2)
        box, at = box_of(order, video)
        film_keypoints, network = detected(session, view, video, box, at, report, cancelled)
    keypoints = first_keypoints, film_keypoints
    tried = [
        synchronised(session, view, keypoints, rates, order.begins, pair, cancelled)
        for pair in pairs
    ]
    if cancelled():
        raise Cancelled
    best = best_of(tried)
    require_common_motion(session, view, keypoints, best, order.begins, calibration)
    others = keypoints_of_others(session, session_path.parent)
    added = with_film(session, view, keypoints, best, network, at, others=others)
    if aside_deg(added.session, added.view) < LEAST_ASIDE_DEG:
        raise SessionError(same_view_words(path.name))
    return added


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
    found = synchronised(without, view, keypoints, rates, begins, None, cancelled)
    require_common_motion(without, view, keypoints, found, begins, None)
    seeds = view.keypoints.seeds
    network, at = view.keypoints.network, seeds[0] if seeds else 0
    also = choices_beside(view, begins)
    others = keypoints_of_others(without, session_path.parent)
    return with_film(without, view, keypoints, found, network, at, also, others=others)


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
    if session.camera_path is not None or session.has_unknown_motion:
        raise SessionError(
            "The first film's camera moves: films are added to one whose camera stands still. "
            "If this one does, say so first (in the Camera tab, or keypose camera --kind static)."
        )
    if len(session.views) >= MOST_FILMS:
        raise SessionError(f"The session has {MOST_FILMS} films already, which are the most.")


def _begun_view(session: Session, session_path: Path, video: Video, taken: FilmTaken) -> View:
    """The view of a film, before anything is known of where it stands."""
    view = as_taken(new_session(video, session_path), said(taken)).view
    if view.video.stands_still is False:
        raise SessionError(
            f"The camera of {video.info.path.name} moves, or the film is cut: a second film needs "
            "one camera that stands still."
        )
    fingerprints = [each.video.fingerprint for each in session.views]
    if view.video.fingerprint and view.video.fingerprint in fingerprints:
        raise SessionError("This film is in the session already.")
    ids = {each.id for each in session.views}
    number = next(n for n in range(2, MOST_FILMS + 2) if f"film-{n}" not in ids)
    return view.model_copy(update={"id": f"film-{number}"})
