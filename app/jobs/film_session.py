"""Begin the session of a film from its file and draft the person in it, without a page."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from keypose.app.document.new import new_session
from keypose.app.editor.camera import as_taken
from keypose.app.editor.drafted import drafted_session, keypoint_source, require_draftable
from keypose.app.jobs.draft import Drafted, taken_and_left
from keypose.app.jobs.rerun import with_settings
from keypose.app.orders.film import FilmOrder, FilmToDraft
from keypose.app.orders.tracking import said
from keypose.app.words.people import NOBODY, several_words
from keypose.tracker.body.body import preset
from keypose.tracker.body.modify import with_height
from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.keypoints.find_people import (
    FAR,
    WHOLE_AND_NEAR,
    FoundPerson,
    PeopleFinder,
    PeopleInFilm,
    people_in_film,
    spread_frames,
)
from keypose.tracker.keypoints.on_animal import is_animals
from keypose.tracker.keypoints.region import Box
from keypose.tracker.session import Session
from keypose.tracker.storage.sidecars import save_keypoints
from keypose.tracker.video import READ_AGAIN_BYTES, Video
from keypose.tracker.video.info import MissingFrame

Span: TypeAlias = tuple[int, int]
"""First and last frame."""


@dataclass(frozen=True)
class WhoIsDrafted:
    """The box of a person at a frame.

    found: whom it was chosen from; None where a person drew it.
    """

    frame: int
    box: Box
    found: PeopleInFilm | None = None


def opened_film(film: FilmToDraft) -> Video:
    """A film, to be closed; KeyposeError where it cannot be read."""
    return Video.open(
        film.path, READ_AGAIN_BYTES, deinterlace=said(film.taken).get("deinterlace", True)
    )


def begun_session(film: FilmToDraft, video: Video, place: Path) -> Session:
    """A session of a film with what is said of it; its file is not written."""
    session = as_taken(new_session(video, place), said(film.taken))
    session = with_settings(session, film.network)
    body = session.subject.body if film.order.body is None else preset(film.order.body)
    if film.order.height_cm is not None:
        body = with_height(body, film.order.height_cm / 100)
    session = session.changed({"body": body})
    camera = _camera_said(film.order, session)
    if camera is None:
        return session
    return session.changed({"camera": camera, "lens_source": "person"})


def _camera_said(order: FilmOrder, session: Session) -> Camera | None:
    width, height = session.view.video.width, session.view.video.height
    if order.lens_mm is not None:
        return Camera.from_focal_length(width, height, order.lens_mm)
    if order.field_of_view is not None:
        return Camera.from_field_of_view(width, height, math.radians(order.field_of_view))
    return None


def frames_to_draft(order: FilmOrder, session: Session) -> Span:
    """First and last frame to draft."""
    return order.frames or (0, session.view.video.frame_count - 1)


def who_are_drafted(
    order: FilmOrder,
    session: Session,
    video: Video,
    report: Callable[[float], None] = lambda share: None,
) -> list[WhoIsDrafted]:
    """The person whom an order names, the only one who is found, or everybody where that is asked
    for.

    report: receives the share that is done, and may raise Cancelled. KeypointError in one sentence
    where there is nobody, or more than one and that is not asked for.
    """
    frames = frames_to_draft(order, session)
    if order.box is not None:
        at = frames[0] if order.frame is None else order.frame
        require_draftable(session, at, order.box, frames)
        return [WhoIsDrafted(at, order.box)]
    if is_animals(session.subject.body):
        raise KeypointError(
            "An animal is drafted from a box around it, which is missing: give its left, top, "
            "right and bottom in pixels, as in --box 210,80,420,610."
        )
    whole = (0.0, 0.0, session.view.video.width - 1.0, session.view.video.height - 1.0)
    require_draftable(session, frames[0] if order.frame is None else order.frame, whole, frames)
    numbers = spread_frames(*frames) if order.frame is None else [order.frame]
    people = people_seen(video, numbers, report)
    if people is None:
        raise KeypointError(NOBODY)
    if len(people.people) > 1 and not order.everyone:
        raise KeypointError(several_words(people))
    return [WhoIsDrafted(people.frame, person.box, people) for person in people.people]


def people_seen(
    video: Video, numbers: list[int], report: Callable[[float], None] = lambda share: None
) -> PeopleInFilm | None:
    """Who is to be seen at some frames of a film; where nobody is near, who is far away at the
    first frame of every second that shows somebody."""
    finder, people_of_frame = PeopleFinder.open(), dict[int, tuple[FoundPerson, ...]]()
    searches = [(number, WHOLE_AND_NEAR) for number in numbers]
    searches += [(number, FAR) for number in numbers[::2]]
    for done, (number, shares) in enumerate(searches):
        if shares == FAR and any(people_of_frame.values()):
            break
        report(done / len(searches))
        try:
            people_of_frame[number] = finder(video.frame(number), shares)
        except MissingFrame:
            continue
    return people_in_film(people_of_frame)


def with_draft_kept(
    session: Session,
    video: Video,
    place: Path,
    who: WhoIsDrafted,
    frames: Span,
    drafts: Drafted,
    *,
    together: bool = False,
) -> Session:
    """The session with a draft of every frame, whose keypoints are written beside its file.

    place: of the session's file, which is not written; its folder is there.  together: whether the
    people around were followed as well.
    """
    draft, network, detected = drafts
    asked = range(frames[0], frames[1] + 1)
    only, rest = taken_and_left(asked, detected, who.frame, who.box)
    session = save_keypoints(
        session,
        place,
        draft.keypoints,
        keypoint_source(session),
        network=network,
        seeds=(who.frame,),
        together=together,
    )
    times_s = session.evidence.times_s(video.info.times_s)
    return drafted_session(
        session,
        frames,
        draft.body,
        draft.poses,
        session.view.keypoints,
        draft.proposals,
        times_s,
        session.world.up_world,
        only,
        rest,
        draft.flipped,
    )


def with_people_kept(
    session: Session,
    video: Video,
    place: Path,
    people: Sequence[WhoIsDrafted],
    frames: Span,
    drafts: Sequence[Drafted],
) -> Session:
    """The session with a body for each of several people, each as of `with_draft_kept`."""
    first = session.subject
    more = (
        first.model_copy(update={"id": f"{first.id}-{number}"})
        for number in range(2, len(people) + 1)
    )
    session = session.model_copy(update={"bodies": (first, *more)})
    together = len(people) > 1
    for body, who, own in zip(session.bodies, people, drafts, strict=True):
        about = session.about(body.id)
        session = with_draft_kept(about, video, place, who, frames, own, together=together)
    return session.about(first.id)
