"""When a second film was taken, and where its camera stands: as the body says, or a calibration."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from keypose.app.jobs.film_camera import of_view_alone
from keypose.app.words.films import same_view_words
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SessionError
from keypose.tracker.films.cameras import joints_of_pose, lengths_of
from keypose.tracker.films.likeness import FEWEST_FRAMES, correlations
from keypose.tracker.films.offset import CLOSE, MOST_COST, FoundOffset, OffsetSearch, find_offsets
from keypose.tracker.films.parts import part_in_common, part_that_fits
from keypose.tracker.films.same_view import is_same_view
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.formats.cameras.calibrated_pair import CalibratedPair
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.between_views import T_world_camera
from keypose.tracker.session.views import View
from keypose.tracker.video import Video

LEAST_RATE = 0.01
"""Frames of one film per frame of another, at least, as clocks have them."""
SLOWED = (2.0, 4.0, 8.0, 0.5, 0.25, 0.125)
"""By how many times phones play slow motion slower, of the second film and of the first."""
LEAST_ALIKE = 0.5
"""From which on slow motion is looked at closer: real films of one motion 0.6 and more."""
MOST_SCANNED = 1_000_000
"""Frames of one film times those of the other: longer ones are no slow motion, and take minutes."""
MOST_MOVED_DEG = 15.0
"""A calibration that is off by more is of another setup; the published one of four cameras that
misses its own films is off by 2°."""


@dataclass(frozen=True, eq=False)
class Synchronised:
    """The offsets of two films, were these their cameras in a calibration; None without one.

    rate: frames of the second film per frame of the first, as their files say.
    """

    pair: CalibratedPair | None
    search: OffsetSearch
    rate: float
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

    @property
    def part(self) -> range | None:
        """The frames of the film that alone show what the first does, where others do not."""
        if self.offsets:
            return part_that_fits(self.search, self.offsets[0])
        return part_in_common(self.search, self.rate)

    @property
    def slowed(self) -> float | None:
        """How many times slower the second film shows the motion than the files say, below 1 where
        the first one does; None where neither does."""
        first, film = self.search.first, self.search.film
        if len(first) * len(film) > MOST_SCANNED:
            return None
        likeness = {
            factor: _most_alike(first, film, self.rate * factor) for factor in (1.0, *SLOWED)
        }
        factor = max(likeness, key=lambda each: likeness[each])
        if factor == 1.0 or likeness[factor] < LEAST_ALIKE:
            return None
        return factor if find_offsets(self.search, self.rate * factor) else None


def _most_alike(first: Sightings, film: Sightings, rate: float) -> float:
    """How alike the motions are at the best offset, 0 where nothing says so."""
    _, scores = correlations(first, film, rate)
    return float(np.nan_to_num(scores).max(initial=0.0))


def frame_rates(session: Session, view: View, first: Video, video: Video) -> tuple[float, float]:
    """Frames a second of both films as they were recorded; SessionError where no clock has both."""
    rates = (
        session.view.video.recorded_fps or first.info.fps,
        view.video.recorded_fps or video.info.fps,
    )
    if not LEAST_RATE <= rates[1] / rates[0] <= 1 / LEAST_RATE:
        raise SessionError(
            f"One film has {rates[0]:g} frames a second and the other {rates[1]:g}: they are too "
            "different to be synchronised."
        )
    return rates


def synchronised(
    session: Session,
    view: View,
    keypoints: tuple[Keypoints, Keypoints],
    rates: tuple[float, float],
    begins: float | None,
    pair: CalibratedPair | None,
    cancelled: Callable[[], bool],
    heard: float | None = None,
) -> Synchronised:
    """When the film was taken, the likeliest first.

    pair: the cameras of both in a calibration.  heard: the frame of the first at which it begins,
    as their sound says; None where it says nothing.
    """
    search, rate = _search(session, view, keypoints, rates[0], pair, heard), rates[1] / rates[0]
    if begins is None:
        return Synchronised(pair, search, rate, find_offsets(search, rate, cancelled))
    clock = FilmClock(begins, rate)
    camera = search.camera_at(clock)
    is_found = camera is not None and camera.cost <= MOST_COST
    offsets = (FoundOffset(clock, 0.0, camera),) if camera is not None and is_found else ()
    return Synchronised(pair, search, rate, offsets)


def _search(
    session: Session,
    view: View,
    keypoints: tuple[Keypoints, Keypoints],
    fps: float,
    pair: CalibratedPair | None,
    heard: float | None,
) -> OffsetSearch:
    cameras = session.view.camera, view.camera
    # the cameras of other films are placed with the first lens as it is
    is_free = session.view.lens_is_guess and len(session.views) == 1
    guesses, start = (is_free, view.lens_is_guess), None
    if pair is not None:
        first_lens = pair.first if len(session.views) == 1 else session.view.camera
        cameras, guesses, start = (first_lens, pair.film), (False, False), pair.T_film_first
    first = sightings_of(session, session.view, keypoints[0], cameras[0])
    film = sightings_of(session, view, keypoints[1], cameras[1])
    keyed = joints_at(session, (each for each in session.subject.keyframes if not each.drafted))
    lengths_m = lengths_of(session.subject.body)
    return OffsetSearch(first, film, fps, lengths_m, guesses, keyed, start, heard)


def sightings_of(session: Session, view: View, keypoints: Keypoints, camera: Camera) -> Sightings:
    """What a film shows of the person at each of its frames.  camera: with its distortion."""
    alone = session if view is session.view else of_view_alone(session, view)
    motion, path, unit_shift = alone.view.camera_motion, alone.camera_path, None
    if path is not None and motion is not None and motion.unscaled and view is not session.view:
        unit_shift = motion.in_its_units.Ts_camera_world[:, :3, 3]
    return Sightings.of(keypoints, camera, view.video.frame_count, path, unit_shift)


def best_of(tried: Sequence[Synchronised]) -> Synchronised:
    """Of the cameras that a calibration may mean those that were moved least: from wherever one
    begins, the body leads to the same place. SessionError where none is where the file has it."""
    least = min(each.cost for each in tried)
    best = min(
        (each for each in tried if each.cost <= CLOSE * least),
        key=lambda each: each.moved_deg,
    )
    if best.pair is not None and best.moved_deg > MOST_MOVED_DEG:
        raise SessionError(
            f"{best.pair.file} does not fit these films: the body shows their cameras turned by "
            f"{best.moved_deg:.0f}° from where it has them. Leave it out, and they are found from "
            "the body alone."
        )
    return best


def require_common_motion(
    session: Session,
    view: View,
    keypoints: tuple[Keypoints, Keypoints],
    best: Synchronised,
    begins: float | None,
    calibration: Path | None,
) -> None:
    """SessionError, in a sentence, where two films could not be synchronised, or only a part."""
    name, first = (Path(each.video.path).name for each in (view, session.view))
    for sightings, film in ((best.search.film, name), (best.search.first, first)):
        if sightings.seen.sum() < FEWEST_FRAMES:
            raise SessionError(
                f"The person is seen well in {sightings.seen.sum()} frames of {film}, and in "
                f"{FEWEST_FRAMES} at least both films have to show the motion."
            )
    if (part := best.part) is not None:
        raise SessionError(
            f"Only frames {part.start} to {part.stop - 1} of {name} show what {first} shows: it "
            "may be cut there, or another person is taken for the one who is meant. Cut the film "
            "there, and add the part that fits."
        )
    if best.offsets:
        return
    if calibration is not None:
        raise SessionError(
            f"{calibration.name} does not fit these films, or they show no motion in common: leave "
            "it out, and the cameras are found from the body alone."
        )
    if begins is not None:
        raise SessionError(
            f"{name} and {first} show no motion in common where it begins at {begins:g}: "
            "give another frame, or leave that to be found."
        )
    if any(each.p_hips is None for each in keypoints):
        raise SessionError(
            f"The keypoints of {first} have no depth, so nothing tells when {name} was "
            "taken: give the frame at which it begins."
        )
    if is_same_view(best.search, best.rate):
        raise SessionError(same_view_words(name))
    if (slowed := best.slowed) is not None:
        slow, quick = (name, first) if slowed > 1 else (first, name)
        raise SessionError(
            f"{slow} shows the motion {max(slowed, 1 / slowed):g} times slower than {quick}: say "
            "at which rate it was recorded (--recorded-fps), as slow motion is played at another."
        )
    raise SessionError(
        f"{name} and {first} show no motion in common, so nothing tells when it was taken: "
        "give the frame at which it begins."
    )


def joints_at(session: Session, keyframes: Iterable[Keyframe]) -> dict[int, Array]:
    """Joints (J, 3) in the world, by frame."""
    skeleton, joints = Skeleton.of(session.subject.body), {}
    for each in keyframes:
        T = T_world_camera(session, np.array([float(each.frame)]))
        joints[each.frame] = apply_transform(T, joints_of_pose(skeleton, each.pose(skeleton)))
    return joints
