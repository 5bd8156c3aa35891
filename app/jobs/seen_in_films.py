"""What is seen of the person in the films of a session, and in one that is added."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from keypose.app.jobs.film_session import people_seen
from keypose.app.orders.film import BesideOrder
from keypose.app.words.people import NOBODY, several_words
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError, SessionError
from keypose.tracker.keypoints.detect import Seed, detect
from keypose.tracker.keypoints.detectors import open_detector
from keypose.tracker.keypoints.find_people import PeopleInFilm, spread_frames
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.keypoints.region import Box
from keypose.tracker.session import Session
from keypose.tracker.session.views import View
from keypose.tracker.storage.cache import Detections
from keypose.tracker.storage.sidecars import keypoints_of_session
from keypose.tracker.tracking.pool import Cancelled
from keypose.tracker.video import Video

MOST_PEOPLE = 4
"""In a film, of whom the one is taken who moves as in the first film."""


class WhoIsMeant(KeypointError):
    """Whom to look at in a film is not known: nobody was found, or several.

    people: None where nobody was.
    """

    def __init__(self, people: PeopleInFilm | None) -> None:
        super().__init__(NOBODY if people is None else several_words(people))
        self.people = people


def keypoints_of_first(
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


def keypoints_of_others(session: Session, folder: Path) -> dict[str, Keypoints]:
    """The keypoints of all films but the first that have any, by the view's id."""
    return {
        view.id: keypoints
        for view in session.views[1:]
        if (keypoints := keypoints_of_session(session.alone(view.id), folder)) is not None
    }


@dataclass(frozen=True, eq=False)
class SeenPerson:
    """Somebody in a film.  keypoints: found by a network of this fingerprint, from a frame on."""

    keypoints: Keypoints
    network: str
    frame: int


def seen_people(
    session: Session,
    view: View,
    video: Video,
    order: BesideOrder,
    report: Callable[[float], None],
    cancelled: Callable[[], bool],
) -> tuple[list[SeenPerson], PeopleInFilm | None]:
    """What is seen of the person who is meant, or of everybody who may be; and who they are, where
    nobody said who is meant.  report: receives the share that is done."""
    if order.box is not None:
        whole = [(order.box, order.frame or 0)]
        people = None
    else:
        people = people_seen(video, spread_frames(0, video.info.frame_count - 1))
        if people is None or len(people.people) > MOST_PEOPLE:
            raise WhoIsMeant(people)
        whole = [(person.box, people.frame) for person in people.people]
    persons = []
    for number, (box, frame) in enumerate(whole):
        done, share = number / len(whole), 1 / len(whole)

        def of_this(part: float, done: float = done, share: float = share) -> None:
            report(done + share * part)

        persons.append(_detected(session, view, video, box, frame, of_this, cancelled))
    return persons, people


def _detected(
    session: Session,
    view: View,
    video: Video,
    box: Box,
    at: int,
    report: Callable[[float], None],
    cancelled: Callable[[], bool],
) -> SeenPerson:
    model, count = find_model(session.settings.network_used), video.info.frame_count
    network, pictures = open_detector(model), _leaving(video, cancelled)
    looks = 0

    def picture(number: int) -> NDArray[np.uint8]:
        nonlocal looks
        looks += 1
        report(min(looks / count, 1.0))
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
    return SeenPerson(keypoints, network.fingerprint, at)


def _leaving(video: Video, cancelled: Callable[[], bool]) -> Callable[[int], NDArray[np.uint8]]:
    """The pictures of a video, until it is cancelled."""

    def picture(number: int) -> NDArray[np.uint8]:
        if cancelled():
            raise Cancelled
        return video.frame(number)

    return picture
