"""Follow one point from one keyframe, and combine its courses from both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.sigmas import ALONE_PX, MOST_SLIP_PX, RENEWED_PX, SLIP_PX, TRACK_PX
from keypose.tracker.tracking.initial.templates.patch import Patch, PatchMatch, Place
from keypose.tracker.tracking.initial.templates.search import GreyPicture, Match, find_match
from keypose.tracker.video.pyramid import FloatPicture

SPREAD_RAD = np.radians(9.0)
ALIKE = 0.45
CORRELATED = 0.5
"""Least similarity and correlation of a patch that counts as found."""
KNOWN_ALIKE = 0.5
KNOWN_CORRELATED = 0.85
"""The same of the keyframe's own patch, which then removes the drift."""
MOST_SCALED = 0.4
"""Log scale beyond which a patch fits anything."""
KEY_STRAY = 2.5
"""Pixels by which the keyframe's patch may move a place: further off it has slipped."""
MOST_POOR = 8
"""Frames on end through which a point that is not recognised is expected to move on."""
SLOWING = 0.7
UNLIKE_PX = 2.5
TURNED_PX = 2.0
SCALED_PX = 6.0
MOST_TURNED = 0.75
"""How far a place may be wrong whose patch is unlike, turned (up to so many radians) and scaled:
each shows that the part has turned out of the picture's plane. Measured on rendered motions."""


@dataclass(frozen=True, eq=False)
class BaseCourse:
    """One point of a base trajectory, in the order in which it is followed.

    uv: (N, 2) where it is seen. hidden: (N,) turned away or behind another part. trusted: (N,)
    whether its path is reliable there.
    """

    uv: Array
    hidden: NDArray[np.bool_]
    trusted: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Course:
    """Where a point was seen: uv (N, 2), NaN where it was not; sigma_px (N,).

    known: (N,) recognised by the keyframe's own patch, not only by the renewed one.
    """

    uv: Array
    sigma_px: Array
    known: NDArray[np.bool_]

    @classmethod
    def at_its_start(cls, uv: Array, count: int) -> Course:
        """A course of `count` frames, known at its first place only."""
        places, sigmas = np.full((count, 2), np.nan), np.full(count, np.inf)
        places[0], sigmas[0] = uv, 0.0
        return cls(places, sigmas, np.arange(count) == 0)

    def reversed(self) -> Course:
        """The same from its end to its start."""
        return Course(self.uv[::-1], self.sigma_px[::-1], self.known[::-1])


@dataclass(eq=False)
class _Runner:
    """The state on the way."""

    place: Place
    step: Array
    turning: float
    drift: float
    poor: int = 0

    def expected(self) -> Place:
        u, v, turn, scale = self.place
        return u + float(self.step[0]), v + float(self.step[1]), turn + self.turning, scale

    def move_to(self, to: PatchMatch) -> None:
        self.step = to.uv - self.place[:2]
        self.turning = to.turn - self.place[2]
        self.place, self.poor = to.place, 0

    def pass_unseen(self, by: Array) -> None:
        u, v, turn, scale = self.place
        self.place = (u + float(by[0]), v + float(by[1]), turn, scale)
        self.step, self.turning, self.poor = SLOWING * self.step, 0.0, self.poor + 1


def follow_point(
    key: Patch,
    uv: Array,
    pictures: Sequence[FloatPicture],
    shown: Sequence[GreyPicture],
    base: BaseCourse,
    reach: int,
) -> Course:
    """Follow the middle of a patch from the first of these pictures on.

    It is expected to move on as it last did, or while it is hidden as the base does. After too long
    without being recognised it is given up.
    """
    run = _Runner((float(uv[0]), float(uv[1]), 0.0, 0.0), np.zeros(2), 0.0, 0.0)
    course = Course.at_its_start(uv, len(shown))
    recent = key
    for n in range(1, len(shown)):
        match = None
        if not base.hidden[n]:
            match = _locate(
                key, recent, pictures[n], shown[n], run.expected(), reach + 2 * run.poor
            )
        if match is None:
            by_base = base.trusted[n] and base.trusted[n - 1]
            run.pass_unseen(base.uv[n] - base.uv[n - 1] if by_base else run.step)
            if run.poor > MOST_POOR and not by_base:
                break
            continue
        at, by_key = match
        run.move_to(at)
        run.drift = 0.0 if by_key else float(np.hypot(run.drift, RENEWED_PX))
        course.uv[n], course.known[n] = at.uv, by_key
        course.sigma_px[n] = _sigma(at, run.drift)
        recent = recent.renew(pictures[n], at.place) or recent
    return course


def _locate(
    key: Patch,
    recent: Patch,
    picture: FloatPicture,
    shown: GreyPicture,
    expected: Place,
    reach: int,
) -> tuple[PatchMatch, bool] | None:
    """The place, and whether the keyframe's patch decided it; None where it is not seen."""
    coarse = _search(recent, shown, expected, reach)
    if coarse is None:
        return None
    at = recent.refine(picture, coarse)
    checked = key.refine(picture, at.place)
    slipped = float(np.hypot(*(checked.uv - at.uv)))
    if slipped <= KEY_STRAY and _is_like(checked, KNOWN_ALIKE, KNOWN_CORRELATED):
        return checked, True
    return (at, False) if _is_like(at, ALIKE, CORRELATED) else None


def _sigma(at: PatchMatch, drift: float) -> float:
    """Pixels by which a place may be wrong, one standard deviation."""
    turned = TURNED_PX * min(abs(at.turn), MOST_TURNED)
    terms = (at.sigma, drift, UNLIKE_PX * (1 - at.alike), turned, SCALED_PX * at.place[3])
    return float(np.linalg.norm(terms))


def _is_like(at: PatchMatch, alike: float, correlation: float) -> bool:
    fits = at.alike >= alike and at.correlation >= correlation
    return fits and abs(at.place[3]) <= MOST_SCALED


def _search(patch: Patch, shown: GreyPicture, expected: Place, reach: int) -> Place | None:
    """The best whole-pixel place of a few turns."""
    uv = np.array(expected[:2])
    height, width = shown.grey.shape
    if not ((uv > -reach).all() and uv[0] < width + reach and uv[1] < height + reach):
        return None
    matches: list[tuple[Match, float]] = []
    for turn in (expected[2], expected[2] - SPREAD_RAD, expected[2] + SPREAD_RAD):
        template = patch.turned.at(turn)
        if template is not None:
            matches.append((find_match(template, shown, uv, reach), turn))
    if not matches:
        return None
    best, turn = min(matches, key=lambda m: m[0].miss)
    return best.uv[0], best.uv[1], turn, expected[3]


AGREED_PX = 6.0
"""How near two courses must come to confirm each other: each slips a little on its way."""
APART_PX = 12.0
"""Where both are confirmed and yet lie further apart than this, neither is used."""
ALONE_FRAMES = 3
"""How many frames an unconfirmed course is used."""
DISAGREED = 0.35
"""Share of two courses' distance in their sigma."""


def combine_courses(forward: Course, backward: Course, offset: Array) -> tuple[Array, Array]:
    """Both courses (2, N, 2), NaN where lost, and (2, N) their sigmas; all in frame order.

    offset: (N, 2) where the second course's point is seen beside the first one's.

    A course is confirmed where its keyframe's own patch recognises the point, or where the other
    course agrees; each begins at its own keyframe, and so ends where the other begins. What lies
    before a confirmed frame was most likely right too.
    """
    gap = np.nan_to_num(backward.uv - forward.uv - offset, nan=np.inf)  # also where one is missing
    apart = np.hypot(gap[:, 0], gap[:, 1])
    agreed = apart <= AGREED_PX
    sigma = np.stack([_sigmas(forward, agreed), _sigmas(backward.reversed(), agreed[::-1])[::-1]])
    two = np.isfinite(sigma).all(axis=0)
    sigma = np.hypot(sigma, np.where(two, DISAGREED * np.where(two, apart, 0.0), 0.0))
    sigma[:, two & (apart > APART_PX)] = np.inf
    uv = np.where(np.isfinite(sigma)[..., None], np.stack([forward.uv, backward.uv]), np.nan)
    return uv, sigma


def _sigmas(course: Course, agreed: NDArray[np.bool_]) -> Array:
    """(N,) how far a course, from its own keyframe on, may be wrong; inf where not used."""
    frames = np.arange(len(agreed))
    confirmed = np.flatnonzero((agreed | course.known) & np.isfinite(course.uv[:, 0]))
    if not len(confirmed):
        return np.full(len(frames), np.inf)
    alone = np.maximum(frames - confirmed[-1], 0)
    slip = np.minimum(SLIP_PX * frames, MOST_SLIP_PX)
    sigma = np.hypot(np.hypot(course.sigma_px, TRACK_PX), slip + ALONE_PX * alone)
    trusted = np.isfinite(course.uv[:, 0]) & (alone <= ALONE_FRAMES)
    return np.where(trusted, sigma, np.inf)
