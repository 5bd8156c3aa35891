"""The person cut out of the film, as pictures or as a film with alpha: of command line and page."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from keypose.app.export.film import clock_of
from keypose.app.export.picture_names import picture_names
from keypose.app.orders.drawing import MatteOrder
from keypose.app.render.studio import png
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SessionError, listed
from keypose.tracker.keypoints.detect import Progress
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.keypoints.person_mask import PersonMask
from keypose.tracker.operations.track import detected_keypoints
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.atomic import make_folder, write_file
from keypose.tracker.video import Video
from keypose.tracker.video.encode import MOV, WEBM, FilmWriter, film_file

FILMS = {"webm": WEBM, "mov": MOV}


@dataclass(frozen=True, eq=False)
class Matte:
    """Where the person is in the frames of a film, first to last.

    own: first and last of the frames that show the person who was posed; in those before and after
    it may be another one.
    progress: is told how many of how many steps are done, a look or a picture each.
    """

    session: Session
    video: Video
    order: MatteOrder
    first: int
    last: int
    seen: Keypoints
    own: tuple[int, int]
    progress: Callable[[int, int], None]
    looks: int

    def __len__(self) -> int:
        return self.last - self.first + 1

    @property
    def words(self) -> str:
        """What should be known of it, sentences or nothing."""
        words, (first, last) = [], self.own
        if self.empty:
            share = f"{len(self.empty)} of the {len(self)} frames"
            words.append(f"No person was found in {share}: their alpha is empty.")
        if self.first < first:
            words.append(
                f"Before frame {first} it may be another person: set a keyframe at {first - 1}."
            )
        if self.last > last:
            words.append(
                f"From frame {last + 1} on it may be another person: set a keyframe there."
            )
        return " ".join(words)

    @property
    def empty(self) -> tuple[int, ...]:
        """Frames in which no person was found."""
        return tuple(n for n in range(self.first, self.last + 1) if self.seen.mask(n) is None)

    @property
    def maybe_another(self) -> tuple[int, ...]:
        """Frames in which it may be another person."""
        first, last = self.own
        return tuple(n for n in range(self.first, self.last + 1) if not first <= n <= last)

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """RGBA (H, W, 4), alpha straight, or the alpha alone (H, W, 3), of every frame in turn."""
        frames = self.video.frames(self.first, self.last + 1)
        for done, (number, picture) in enumerate(frames, start=1):
            alpha = _alpha(self.seen.mask(number), self.video)
            shown = np.zeros((*alpha.shape, 3), np.uint8) if picture is None else picture
            yield np.dstack([alpha] * 3 if self.order.alpha_only else [shown, alpha])
            self.progress(self.looks + done, self.looks + len(self))


def frames_of(session: Session, order: MatteOrder) -> tuple[int, int]:
    """First and last frame that are ordered."""
    return order.frames or (0, session.view.video.frame_count - 1)


def matte_of(
    session: Session,
    name: str,
    video: Video,
    order: MatteOrder,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> Matte:
    """Look for the person in the frames that are ordered; what `progress` raises ends that.

    name: of the session's file.  SessionError where there is nothing to start from, or nobody.
    """
    first, last = frames_of(session, order)
    seeds = _seeds(session, session.subject_in(name), first, last)
    count, looks = last - first + 1, 0

    def looked(now: Progress) -> None:
        nonlocal looks
        looks = now.expected
        progress(now.done, now.expected + count)

    skeleton = Skeleton.of(session.subject.body)
    people = [(skeleton, seeds), *_others(session, first, last)]
    posed = [frame for _, own_seeds in people for frame in own_seeds]
    reached = min(first, *posed), max(last, *posed)
    detected = detected_keypoints(session, video)
    followed = detected.follow_people(reached, people, looked) if len(people) > 1 else None
    if followed is None:
        alone = detected.follow(reached, skeleton, seeds, looked)
        followed = [] if alone is None else [alone]
    if not followed or all(followed[0].mask(n) is None for n in range(first, last + 1)):
        raise SessionError(
            f"No person was found in frames {first} to {last}, starting from the poses at "
            f"{listed([str(n) for n in seeds])}: pose the body over a person who is seen well."
        )
    keypoints = followed[0]

    def looked_again(done: int, expected: int) -> None:
        progress(looks + done, looks + expected + count)

    changes = _drafted_changes(session, reached)
    if changes is None:
        changes = detected.changes(followed, posed, looked_again)[0]
    own = _own(changes, list(seeds), reached)
    return Matte(session, video, order, first, last, keypoints, own, progress, looks)


def _others(session: Session, first: int, last: int) -> list[tuple[Skeleton, dict[int, Pose]]]:
    """The other people of a session, as they are posed: nobody is taken for one of them."""
    people = []
    for body in session.bodies:
        if body.id == session.subject.id or not is_persons(body.body):
            continue
        if posed := _posed(session.about(body.id), first, last):
            people.append((Skeleton.of(body.body), posed))
    return people


def _drafted_changes(session: Session, frames: tuple[int, int]) -> tuple[int, ...] | None:
    """The frames from which on it may be another person, as the draft says; None where these
    frames were not drafted."""
    drafted = session.subject.drafted
    if drafted is None or not drafted.first_frame <= frames[0] <= frames[1] <= drafted.last_frame:
        return None
    return tuple(place.frame for place in drafted.places if place.reason == "person")


def _own(changes: Sequence[int], seeds: Sequence[int], frames: tuple[int, int]) -> tuple[int, int]:
    """First and last of the frames that no change separates from the nearest seed. Between two
    seeds the body comes out at both."""
    first = max((change for change in changes if change <= min(seeds)), default=frames[0])
    after = min((change for change in changes if change > max(seeds)), default=frames[1] + 1)
    return max(first, frames[0]), after - 1


def shown_mask(
    session: Session, video: Video, frame: int, pose: Pose, keypoints: Keypoints | None
) -> NDArray[np.uint8]:
    """The alpha (H, W) of one frame through an ideal lens, looked for around a pose where it
    is not known; SessionError where there is nobody."""
    _require_person(session, session.title)
    mask = None if keypoints is None else keypoints.mask(frame)
    if mask is None:
        detections = detected_keypoints(session, video).at(
            frame, Skeleton.of(session.subject.body), pose
        )
        mask = None if detections is None else detections.mask(frame)
    if mask is None:
        raise SessionError(f"No person was found at frame {frame}.")
    return session.view.camera.rectify(_alpha(mask, video))


def _alpha(mask: PersonMask | None, video: Video) -> NDArray[np.uint8]:
    size = video.info.width, video.info.height
    share = np.zeros(size[::-1]) if mask is None else mask.in_picture(*size)
    return np.round(255 * share).astype(np.uint8)


def _require_person(session: Session, name: str) -> None:
    if session.evidence.has_surface or not is_persons(session.subject.body):
        about = "surfaces, not a film" if session.evidence.has_surface else "no person"
        raise SessionError(f"{name} is about {about}: only a person in a film is cut out.")


def _seeds(session: Session, name: str, first: int, last: int) -> dict[int, Pose]:
    """The poses from which the person is looked for, by frame."""
    _require_person(session, name)
    posed = _posed(session, first, last)
    if not posed:
        raise SessionError(
            f"{name} does not say where the person is: set a keyframe, or draft the poses from a "
            "box around the person."
        )
    return posed


def _posed(session: Session, first: int, last: int) -> dict[int, Pose]:
    """The poses that say where the person is: those within the frames and the nearest on either
    side."""
    said = () if session.view.keypoints is None else session.view.keypoints.seeds
    drafts = [draft for draft in session.subject.drafts if draft.frame in said]
    posed = list(session.subject.keyframes) or drafts or list(session.subject.drafts[:1])
    before = [k for k in posed if k.frame <= first][-1:]
    after = [k for k in posed if k.frame >= last][:1]
    within = [k for k in posed if first < k.frame < last]
    skeleton = Skeleton.of(session.subject.body)
    return {k.frame: k.pose(skeleton) for k in (*before, *within, *after)}


def write_pictures_into(folder: Path, matte: Matte, *, overwrite: bool) -> None:
    """Write a PNG file a frame; each is whole or not there."""
    make_folder(folder)
    for name, picture in _named(matte):
        write_file(folder / name, picture, overwrite=overwrite)


def write_zip(out: Path, matte: Matte) -> None:
    """Write the same files into one zip."""
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:  # PNG is packed already
        for name, picture in _named(matte):
            archive.writestr(zipfile.ZipInfo(name), picture)


def _named(matte: Matte) -> Iterator[tuple[str, bytes]]:
    names = picture_names(matte.video.info, range(matte.first, matte.last + 1))
    for name, picture in zip(names, matte.pictures(), strict=True):
        yield name, png(picture[..., 0] if matte.order.alpha_only else picture)


def write_film_with_alpha(out: Path, matte: Matte, *, overwrite: bool = False) -> None:
    """Write a film; VideoError, and no file, when it cannot be made."""
    info = matte.video.info
    clock = clock_of(matte.session, matte.video, matte.first, matte.last)
    kind, alpha = FILMS[matte.order.kind], not matte.order.alpha_only
    with (
        film_file(out, overwrite=overwrite) as place,
        FilmWriter(
            place,
            (info.width, info.height),
            clock.time_base,
            clock.rate,
            info.pixel_aspect,
            kind,
            alpha=alpha,
        ) as film,
    ):
        for pts, picture in zip(clock.pts, matte.pictures(), strict=True):
            film.add(picture, pts)
