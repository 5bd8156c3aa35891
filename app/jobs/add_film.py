"""Add a film of the same motion to a session: when it was taken, and where its camera stands."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from keypose.app.document.new import new_session
from keypose.app.editor.camera import as_taken
from keypose.app.editor.documents import film_of, seen_as_before
from keypose.app.editor.films import choices_beside
from keypose.app.jobs.film_session import people_seen
from keypose.app.jobs.found_film import FoundFilm
from keypose.app.orders.film import BesideOrder
from keypose.app.orders.tracking import FilmTaken, said
from keypose.app.words.films import aside_deg
from keypose.app.words.people import NOBODY, several_words
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError, SessionError
from keypose.tracker.films.cameras import at_scale_of, joints_of_pose, lengths_of
from keypose.tracker.films.offset import CLOSE, MOST_COST, FoundOffset, OffsetSearch, find_offsets
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.formats.cameras.calibrated_pair import CalibratedPair, calibrated_pairs
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import Array, quaternion_wxyz
from keypose.tracker.keypoints.detect import Seed, detect
from keypose.tracker.keypoints.detectors import open_detector
from keypose.tracker.keypoints.find_people import PeopleInFilm, spread_frames
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.keypoints.region import Box
from keypose.tracker.operations.mend_keyframes import MendedKeyframes, mend_keyframes
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.session.views import Clock, Placed, View
from keypose.tracker.storage.cache import Detections
from keypose.tracker.storage.files import open_video_of
from keypose.tracker.storage.sidecars import keypoints_of_session
from keypose.tracker.tracking.pool import Cancelled, never
from keypose.tracker.video import Video

AS_IN_ITS_FILE = FilmTaken()
LEAST_RATE = 0.01
"""Frames of one film per frame of another, at least, as clocks have them."""
MOST_FILMS = 8
"""Of one motion."""
MOST_MOVED_DEG = 15.0
"""A calibration that is off by more is of another setup; the published one of four cameras that
misses its own films is off by 2°."""
LEAST_ASIDE_DEG = 8.0
"""Between the directions from which two films see the person; nearer ones say nothing of depth."""
MOST_DRAFTS = 30
"""That are asked how far away a camera is; neighbouring ones know the same."""


class WhoIsMeant(KeypointError):
    """Whom to look at in a film is not known: nobody was found, or several.

    people: None where nobody was.
    """

    def __init__(self, people: PeopleInFilm | None) -> None:
        super().__init__(NOBODY if people is None else several_words(people))
        self.people = people


@dataclass(frozen=True, eq=False)
class AddedFilm:
    """A film that was found to show the motion of a session.

    film: the session with the film, and with mended keyframes, and what was seen in the film.
    offset: when it was taken, and where its camera stands.  others: the other offsets that may be
        true.  mended: what became of the keyframes.  pair: of a calibration, where one was given.
    """

    film: FoundFilm
    offset: FoundOffset
    others: tuple[FoundOffset, ...]
    mended: MendedKeyframes
    pair: CalibratedPair | None = None

    @property
    def session(self) -> Session:
        """With the film as its last view, which has no keypoints yet."""
        return self.film.session

    @property
    def view(self) -> View:
        """Of the film."""
        return self.session.views[-1]

    def saved(self, session_path: Path) -> Session:
        """As of `FoundFilm`."""
        return self.film.saved(session_path)


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
        rates = _rates(session, view, first, video)
        first_keypoints = _keypoints_of_first(session, session_path, first, cancelled)
        report(0.2)
        box, at = _box(order, video)
        film_keypoints, network = _detected(session, view, video, box, at, report, cancelled)
    keypoints = first_keypoints, film_keypoints
    pairs = [None] if calibration is None else calibrated_pairs(calibration, session.view, view)
    tried = [
        Laid(pair, _offsets(session, view, keypoints, rates, order.begins, pair, cancelled))
        for pair in pairs
    ]
    if cancelled():
        raise Cancelled
    laid = _best(tried)
    if not laid.offsets:
        raise SessionError(_why_not_laid(session, view, keypoints, order.begins, calibration))
    others = _keypoints_of_others(session, session_path.parent)
    added = _added(session, view, keypoints, laid, network, at, others=others)
    if aside_deg(added.session, added.view) < LEAST_ASIDE_DEG:
        raise SessionError(
            f"{path.name} looks at the person as the first film does, so it says nothing of depth: "
            "add one that was taken from the side."
        )
    return added


def _rates(session: Session, view: View, first: Video, video: Video) -> tuple[float, float]:
    """Frames a second of both films as they were recorded; SessionError where no clock has both."""
    rates = (
        session.view.video.recorded_fps or first.info.fps,
        view.video.recorded_fps or video.info.fps,
    )
    if not LEAST_RATE <= rates[1] / rates[0] <= 1 / LEAST_RATE:
        raise SessionError(
            f"One film has {rates[0]:g} frames a second and the other {rates[1]:g}: they are too "
            "different to be laid beside each other."
        )
    return rates


def _why_not_laid(
    session: Session,
    view: View,
    keypoints: tuple[Keypoints, Keypoints],
    begins: float | None,
    calibration: Path | None,
) -> str:
    """Why two films could not be laid beside each other, a sentence."""
    names = [Path(each.video.path).name for each in (view, session.view)]
    if calibration is not None:
        return (
            f"{calibration.name} does not fit these films, or they show no motion in common: leave "
            "it out, and the cameras are found from the body alone."
        )
    if begins is not None:
        return (
            f"{names[0]} and {names[1]} show no motion in common where it begins at {begins:g}: "
            "give another frame, or leave that to be found."
        )
    if any(each.p_hips is None for each in keypoints):
        return (
            f"The keypoints of {names[1]} have no depth, so nothing tells when {names[0]} was "
            "taken: give the frame at which it begins."
        )
    return (
        f"{names[0]} and {names[1]} show no motion in common, so nothing tells when it was taken: "
        "give the frame at which it begins."
    )


def _keypoints_of_others(session: Session, folder: Path) -> dict[str, Keypoints]:
    """The keypoints of all films but the first that have any, by the view's id."""
    return {
        view.id: keypoints
        for view in session.views[1:]
        if (keypoints := keypoints_of_session(session.alone(view.id), folder)) is not None
    }


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
        first_keypoints = _keypoints_of_first(session, session_path, first, cancelled)
        rates = _rates(session, view, first, video)
    report(0.5)
    rest = tuple(each for each in session.views if each is not view)
    without = session.model_copy(update={"views": rest})
    keypoints = first_keypoints, film_keypoints
    offsets = _offsets(without, view, keypoints, rates, begins, None, cancelled)
    if not offsets:
        raise SessionError(_why_not_laid(without, view, keypoints, begins, None))
    seeds = view.keypoints.seeds
    network, at = view.keypoints.network, seeds[0] if seeds else 0
    also = choices_beside(view, begins)
    others = _keypoints_of_others(without, session_path.parent)
    return _added(without, view, keypoints, Laid(None, offsets), network, at, also, others=others)


def _added(
    session: Session,
    view: View,
    keypoints: tuple[Keypoints, Keypoints],
    laid: Laid,
    network: str,
    at: int,
    also: tuple[float, ...] | None = None,
    *,
    others: Mapping[str, Keypoints],
) -> AddedFilm:
    """The session with a view, its clock and camera as found, and with mended keyframes.

    also: where it may begin besides; None: where the other offsets say.  others: keypoints of films
    that are there already, by the view's id.
    """
    if len(session.views) == 1:  # the cameras of other films are placed with the lens that it has
        session = _with_first_lens(session, laid)
    if laid.pair is not None:
        lens = {"camera": laid.pair.film, "lens_source": "calibration"}
        view = view.model_copy(update=lens)
    first_keypoints, film_keypoints = keypoints
    best, *further = (_at_scale(session, view, film_keypoints, offset) for offset in laid.offsets)
    source: Literal["body", "file"] = "body" if laid.pair is None else "file"
    placed = _placed(view, best, further, source)
    if also is not None and placed.clock is not None:
        placed = placed.model_copy(update={"clock": placed.clock.model_copy(update={"also": also})})
    after = _with_view(session, placed)
    of_films = {**others, session.view.id: first_keypoints, view.id: film_keypoints}
    mended = mend_keyframes(after, of_films)
    film = FoundFilm(mended.session, film_keypoints, network, at, "")
    return AddedFilm(film, best, tuple(further), mended, laid.pair)


@dataclass(frozen=True, eq=False)
class Laid:
    """The offsets of two films, were these their cameras in a calibration; None without one."""

    pair: CalibratedPair | None
    offsets: tuple[FoundOffset, ...]

    @property
    def cost(self) -> float:
        """Of the likeliest offset."""
        return self.offsets[0].cost if self.offsets else np.inf

    @property
    def moved_deg(self) -> float:
        """By how much the body shows the film's camera turned from where the calibration has it."""
        if self.pair is None or not self.offsets:
            return 0.0
        return self.pair.turned_deg(self.offsets[0].camera.T_camera_first)


def _best(tried: Sequence[Laid]) -> Laid:
    """Of the cameras that a calibration may mean those that were moved least: from wherever one
    begins, the body leads to the same place. SessionError where none is where the file has it."""
    least = min(laid.cost for laid in tried)
    best = min((laid for laid in tried if laid.cost <= CLOSE * least), key=lambda it: it.moved_deg)
    if best.pair is not None and best.moved_deg > MOST_MOVED_DEG:
        raise SessionError(
            f"{best.pair.file} does not fit these films: the body shows their cameras turned by "
            f"{best.moved_deg:.0f}° from where it has them. Leave it out, and they are found from "
            "the body alone."
        )
    return best


def _with_first_lens(session: Session, laid: Laid) -> Session:
    """The session with the lens that its first turned out to have: what is posed is seen as large
    as before."""
    lens, source = session.view.camera.zoomed(laid.offsets[0].camera.first_focal), "fitted"
    if laid.pair is not None:
        lens, source = laid.pair.first, "calibration"
    if lens == session.view.camera:
        return session
    return seen_as_before(session, session.changed({"camera": lens, "lens_source": source}))


def _at_scale(
    session: Session, view: View, keypoints: Keypoints, offset: FoundOffset
) -> FoundOffset:
    """An offset with its camera as far away as all that is posed says."""
    count = session.view.video.frame_count
    film = Sightings.of(keypoints, view.camera, view.video.frame_count)
    film = film.at(offset.clock, np.arange(count))
    posed = (*session.subject.keyframes, *session.subject.drafts[:: _every(session)])
    return replace(offset, camera=at_scale_of(offset.camera, film, _joints_at(session, posed)))


def _every(session: Session) -> int:
    """One in how many drafts is asked."""
    return max(1, len(session.subject.drafts) // MOST_DRAFTS)


def _joints_at(session: Session, keyframes: Iterable[Keyframe]) -> dict[int, Array]:
    """Joints (J, 3) in the first camera's frame, by frame."""
    skeleton = Skeleton.of(session.subject.body)
    return {each.frame: joints_of_pose(skeleton, each.pose(skeleton)) for each in keyframes}


def _with_view(session: Session, view: View) -> Session:
    """The session with a further view."""
    return Session.model_validate(
        session.model_copy(update={"views": (*session.views, view)}).model_dump()
    )


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
            f"The camera of {video.info.path.name} moves: a film beside another needs one that "
            "stands still."
        )
    fingerprints = [each.video.fingerprint for each in session.views]
    if view.video.fingerprint and view.video.fingerprint in fingerprints:
        raise SessionError("This film is in the session already.")
    ids = {each.id for each in session.views}
    number = next(n for n in range(2, MOST_FILMS + 2) if f"film-{n}" not in ids)
    return view.model_copy(update={"id": f"film-{number}"})


def _keypoints_of_first(
    session: Session, session_path: Path, video: Video, cancelled: Callable[[], bool]
) -> Keypoints:
    """What is seen of the person in the first film: a draft's keypoints, or looked for from the
    keyframes on."""
    drafted = keypoints_of_session(session, session_path.parent)
    if drafted is not None:
        return drafted.corrected(session.view.keypoint_corrections)
    camera, keyframes = session.view.camera, session.subject.keyframes
    if not keyframes:
        raise SessionError(
            "Draft the first film or pose a keyframe first: nothing says where the person is in it."
        )
    skeleton = Skeleton.of(session.subject.body)
    seeds = [Seed.of_pose(k.frame, skeleton, k.pose(skeleton), camera) for k in keyframes]
    last = session.view.video.frame_count - 1
    model = find_model(session.settings.network_used)
    return detect(
        _leaving(video, cancelled),
        (0, last),
        seeds,
        open_detector(model),
        film=session.view.video.pictures,
        kept=Detections(),
    )


def _leaving(video: Video, cancelled: Callable[[], bool]) -> Callable[[int], NDArray[np.uint8]]:
    """The pictures of a video, until it is cancelled."""

    def picture(number: int) -> NDArray[np.uint8]:
        if cancelled():
            raise Cancelled
        return video.frame(number)

    return picture


def _box(order: BesideOrder, video: Video) -> tuple[Box, int]:
    """Around whom to look, and at which frame."""
    if order.box is not None:
        return order.box, order.frame or 0
    people = people_seen(video, spread_frames(0, video.info.frame_count - 1))
    if people is None or len(people.people) > 1:
        raise WhoIsMeant(people)
    return people.people[0].box, people.frame


def _detected(
    session: Session,
    view: View,
    video: Video,
    box: Box,
    at: int,
    report: Callable[[float], None],
    cancelled: Callable[[], bool],
) -> tuple[Keypoints, str]:
    """What is seen of the person in the film, and by which network."""
    model, count = find_model(session.settings.network_used), video.info.frame_count
    network, pictures = open_detector(model), _leaving(video, cancelled)
    looks = 0

    def picture(number: int) -> NDArray[np.uint8]:
        nonlocal looks
        looks += 1
        report(0.2 + 0.7 * min(looks / count, 1.0))
        return pictures(number)

    keypoints = detect(
        picture,
        (0, count - 1),
        [Seed.of_box(at, box, view.camera.width, view.camera.height)],
        network,
        film=view.video.pictures,
        kept=Detections(),
        every_second=model.skips_frames_at(video.info.fps),
    )
    return keypoints, network.fingerprint


def _offsets(
    session: Session,
    view: View,
    keypoints: tuple[Keypoints, Keypoints],
    rates: tuple[float, float],
    begins: float | None,
    pair: CalibratedPair | None,
    cancelled: Callable[[], bool],
) -> tuple[FoundOffset, ...]:
    """When the film was taken, the likeliest first.  pair: the cameras of both in a calibration."""
    cameras = session.view.camera, view.camera
    # the cameras of other films are placed with the first lens as it is
    is_free = session.view.lens_is_guess and len(session.views) == 1
    guesses, start = (is_free, view.lens_is_guess), None
    if pair is not None:
        first_lens = pair.first if len(session.views) == 1 else session.view.camera
        cameras, guesses, start = (first_lens, pair.film), (False, False), pair.T_film_first
    first = Sightings.of(keypoints[0], cameras[0], session.view.video.frame_count)
    film = Sightings.of(keypoints[1], cameras[1], view.video.frame_count)
    keyed = _joints_at(session, (each for each in session.subject.keyframes if not each.drafted))
    lengths_m, rate = lengths_of(session.subject.body), rates[1] / rates[0]
    search = OffsetSearch(first, film, rates[0], lengths_m, guesses, keyed, start)
    if begins is None:
        return find_offsets(search, rate, cancelled)
    clock = FilmClock(begins, rate)
    camera = search.camera_at(clock)
    if camera is None or camera.cost > MOST_COST:
        return ()
    return (FoundOffset(clock, 0.0, camera),)


def _placed(
    view: View, best: FoundOffset, others: list[FoundOffset], source: Literal["body", "file"]
) -> View:
    """The view with its clock and its camera as found."""
    clock, placed = best.clock, best.camera
    T = placed.T_camera_first
    update = {
        "clock": Clock(
            begins=round(clock.begins, 4),
            rate=round(clock.rate, 8),
            sigma=round(best.sigma, 4) if 0 < best.sigma < np.inf else None,
            also=tuple(round(each.clock.begins, 4) for each in others),
        ),
        "placed": Placed(
            source=source,
            turn_sigma_rad=round(placed.sigma_rad, 6),
            place_sigma_m=round(placed.sigma_m, 4),
        ),
        "R_camera_world_wxyz": tuple(float(q) for q in quaternion_wxyz(T[:3, :3])),
        "p_camera_world": tuple(round(float(p), 6) for p in T[:3, 3]),
        "camera": view.camera.zoomed(placed.focal),
    }
    if placed.focal != 1.0:
        update["lens_source"] = "fitted"
    return view.model_copy(update=update)
