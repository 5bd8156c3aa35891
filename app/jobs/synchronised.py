"""When a second film was taken, and where its camera stands: as the body says, or a calibration."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SessionError
from keypose.tracker.films.cameras import joints_of_pose, lengths_of
from keypose.tracker.films.offset import CLOSE, MOST_COST, FoundOffset, OffsetSearch, find_offsets
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.formats.cameras.calibrated_pair import CalibratedPair
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.views import View
from keypose.tracker.video import Video

LEAST_RATE = 0.01
"""Frames of one film per frame of another, at least, as clocks have them."""
MOST_MOVED_DEG = 15.0
"""A calibration that is off by more is of another setup; the published one of four cameras that
misses its own films is off by 2°."""


@dataclass(frozen=True, eq=False)
class Synchronised:
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


def offsets_of(
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
    keyed = joints_at(session, (each for each in session.subject.keyframes if not each.drafted))
    lengths_m, rate = lengths_of(session.subject.body), rates[1] / rates[0]
    search = OffsetSearch(first, film, rates[0], lengths_m, guesses, keyed, start)
    if begins is None:
        return find_offsets(search, rate, cancelled)
    clock = FilmClock(begins, rate)
    camera = search.camera_at(clock)
    if camera is None or camera.cost > MOST_COST:
        return ()
    return (FoundOffset(clock, 0.0, camera),)


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


def why_not_synchronised(
    session: Session,
    view: View,
    keypoints: tuple[Keypoints, Keypoints],
    begins: float | None,
    calibration: Path | None,
) -> str:
    """Why two films could not be synchronised, a sentence."""
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


def joints_at(session: Session, keyframes: Iterable[Keyframe]) -> dict[int, Array]:
    """Joints (J, 3) in the first camera's frame, by frame."""
    skeleton = Skeleton.of(session.subject.body)
    return {each.frame: joints_of_pose(skeleton, each.pose(skeleton)) for each in keyframes}
