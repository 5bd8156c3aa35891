"""Rank the places of a motion to look at, the worst first."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final, TypeAlias

import numpy as np

from keypose.tracker.body.modify import height
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.review.problems import Problem, problems_of
from keypose.tracker.review.segment_errors import (
    IN_DOUBT,
    LEAST_PX,
    depth_errors_m,
    part_errors_px,
    right_error_px,
)
from keypose.tracker.review.segments import JudgedSegments, far_end
from keypose.tracker.session.annotations import DraftPlace, Reviewed
from keypose.tracker.session.results import SpaceFinding
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.by_id import ById
from keypose.tracker.storage.results import Results, Span
from keypose.tracker.tracking.result import SegmentResult

GOALS_PX: Final = (3, 5, 8, 12)
USUAL_GOAL_PX: Final = 5

ELSEWHERE: Final = 0.1
"""A share of the body's height: a draft that is this far from where it was is another one."""

Reason: TypeAlias = Problem | SpaceFinding | DraftPlace
"""Why a place should be looked at."""


@dataclass(frozen=True, eq=False)
class Place:
    """A place to look at.

    part: None where it is about the whole body.  frames: first and last frame it is about.
    px, cm: by which it is expected to be off: pixels of the video; None where nobody knows.
    end_m: (3,) where the part's far end lies, camera frame.  px_per_m: there.
    body_m: (K, 3) the joints and the ends of all parts.
    """

    why: Reason
    frame: int
    part: str | None
    frames: Span
    px: float | None
    cm: float | None
    end_m: Array
    px_per_m: float
    body_m: Array

    @property
    def cause(self) -> str:
        """The same as one word."""
        if isinstance(self.why, Problem):
            return self.why.cause
        return self.why.kind if isinstance(self.why, SpaceFinding) else self.why.reason

    @property
    def id(self) -> str:
        """Distinguishes it from the others."""
        return f"{self.frame}-{self.part or 'body'}"


@dataclass(frozen=True, eq=False)
class Review:
    """places: those without an answer, the worst first.  answered: the answers that count.

    goal_px: a goal that this film allows.  right_px: by which a joint may be off that is right.
    px, cm: by which all joints are expected to be off in the mean.  untracked: segments.
    body_m: the body's height.
    """

    places: tuple[Place, ...]
    answered: tuple[Reviewed, ...]
    goal_px: int
    right_px: float | None
    px: float | None
    cm: float | None
    untracked: tuple[Span, ...]
    body_m: float

    def between(self, first: int, last: int) -> Review:
        """The places, answers and untracked segments between two frames."""
        return replace(
            self,
            places=tuple(place for place in self.places if first <= place.frame <= last),
            answered=tuple(
                reviewed for reviewed in self.answered if first <= reviewed.frame <= last
            ),
            untracked=tuple((a, b) for a, b in self.untracked if a < last and b > first),
        )

    def above(self, goal_px: float) -> tuple[Place, ...]:
        """The places over a goal; those whose size nobody knows are."""
        return tuple(place for place in self.places if place.px is None or place.px > goal_px)


def review_of(doc: Session, results: Results) -> Review:
    """All that there is to review; found once for as long as nothing changes."""
    return _review(ById(doc), ById(results))


@lru_cache(maxsize=4)
def _review(doc: ById, results: ById) -> Review:
    session: Session = doc.it
    judged_segments = JudgedSegments.of(session, results.it)
    places = [
        *_drafts(judged_segments, session),
        *_worst_first(_tracked(judged_segments, session, results.it)),
    ]
    right = _right_px(judged_segments)
    px, cm = _mean(judged_segments)
    return Review(
        places=tuple(places),
        answered=tuple(
            answer_given
            for answer_given in session.subject.reviewed
            if judged_segments.counts(answer_given)
        ),
        goal_px=_goal(right),
        right_px=right,
        px=px,
        cm=cm,
        untracked=tuple(span for span in session.spans if span not in judged_segments.tracks),
        body_m=height(session.subject.body),
    )


def _goal(right_px: float | None) -> int:
    """The usual goal, or the least one that can be reached: a right joint is off by so much."""
    usual = [goal for goal in GOALS_PX if goal >= USUAL_GOAL_PX]
    return next((goal for goal in usual if right_px is None or goal > right_px), usual[-1])


def worst_of_all(places_by_body: Mapping[str, Sequence[Place]]) -> list[tuple[str, Place]]:
    """The places of several bodies with their bodies' ids: drafts by their frames, then the worst
    first."""
    both = [(body_id, place) for body_id, places in places_by_body.items() for place in places]

    def rank(body_and_place: tuple[str, Place]) -> tuple[bool, float, float, int]:
        place = body_and_place[1]
        if isinstance(place.why, DraftPlace):
            return False, 0.0, 0.0, place.frame
        return True, *_rank(place)

    return sorted(both, key=rank)


def _worst_first(places: Sequence[Place]) -> list[Place]:
    """Sort places: of those whose size nobody knows wrong keyframes and what is lost come first,
    others last.
    """
    return sorted(places, key=_rank)


def _rank(place: Place) -> tuple[float, float, int]:
    why = place.why
    is_lost = isinstance(why, Problem) and (why.remedy == "keyframe" or why.kind == "lost")
    px = place.px if place.px is not None else np.inf if is_lost else 0.0
    return -px, -(place.cm or 0.0), place.frame


def _tracked(judged_segments: JudgedSegments, doc: Session, results: Results) -> list[Place]:
    """List tracked places: of one limb at one time only the worst."""
    places = [*_in_segments(judged_segments), *_in_space(judged_segments, doc, results)]
    kept: list[Place] = []
    for place in _worst_first(places):
        if not any(_is_same(judged_segments, place, kept_place) for kept_place in kept):
            kept.append(place)
    return kept


def _is_same(judged_segments: JudgedSegments, place: Place, other: Place) -> bool:
    """Whether two of different kinds are about one limb at one time."""
    if type(place.why) is type(other.why) or judged_segments.limb_of(
        place.part
    ) != judged_segments.limb_of(other.part):
        return False
    return place.frames[0] <= other.frames[1] and other.frames[0] <= place.frames[1]


def _in_segments(judged_segments: JudgedSegments) -> Iterator[Place]:
    for track in judged_segments.tracks.values():
        for problem in problems_of(judged_segments, track):
            is_small = problem.px is not None and problem.px <= LEAST_PX
            if problem.answer is None and not is_small:
                place = _tracked_place(
                    judged_segments,
                    track,
                    problem,
                    problem.frame,
                    problem.part,
                    problem.frames,
                    problem.px,
                )
                yield from [place] if place else []


def _in_space(judged_segments: JudgedSegments, doc: Session, results: Results) -> Iterator[Place]:
    """Feet that leave the floor and what their pins do to legs: as large as it would be seen from
    the side."""
    findings = [finding for stretch in results.space(doc) for finding in stretch.findings]
    for space_finding in findings:
        as_px = _SIZES.get(space_finding.kind)
        if (
            as_px is None
            or judged_segments.answer(space_finding.part, space_finding.go) is not None
        ):
            continue
        track = next(
            (t for t in judged_segments.tracks.values() if t.first <= space_finding.go <= t.last),
            None,
        )
        scale = (
            None
            if track is None
            else judged_segments.px_per_m(track, space_finding.go, space_finding.part)
        )
        frames = (space_finding.first_frame, space_finding.last_frame)
        px = None if scale is None else as_px(abs(space_finding.amount), scale)
        if track is None or px is None or px <= LEAST_PX:
            continue
        place = _tracked_place(
            judged_segments, track, space_finding, space_finding.go, space_finding.part, frames, px
        )
        yield from [place] if place else []


KNEE_LEVER_M: Final = 0.2
"""By a radian that it is bent a knee is so far aside, hip and ankle where they are: half of what
thigh or shin are long."""
_SIZES: Final[Mapping[str, Callable[[float, float], float]]] = {
    "off_floor": lambda metres, px_per_m: metres * px_per_m,
    "pulled": lambda px, _: px,
    "bent": lambda radians, px_per_m: KNEE_LEVER_M * radians * px_per_m,
}
"""Pixels of a finding by its amount, and by those of a metre there."""
REVIEWED_IN_SPACE: Final = frozenset(_SIZES)
"""Kinds of findings in space that are places of the review."""


def _tracked_place(
    judged_segments: JudgedSegments,
    track: SegmentResult,
    why: Reason,
    frame: int,
    part: str | None,
    frames: Span,
    px: float | None,
) -> Place | None:
    """A place of the tracked motion; None where the body is behind the camera. What is off in space
    has as many pixels as it has from the side."""
    in_picture = isinstance(why, Problem) and why.cause != "depth"
    along_m = judged_segments.depth_error_m(track, frame, part) if in_picture else 0.0
    return _place(
        judged_segments, track.trajectory.pose(frame), why, frame, part, frames, px, along_m
    )


def _place(
    judged_segments: JudgedSegments,
    pose: Pose,
    why: Reason,
    frame: int,
    part: str | None,
    frames: Span,
    px: float | None,
    along_m: float = 0.0,
) -> Place | None:
    """along_m: by which it is expected to be off along the view."""
    assert judged_segments.skeleton is not None
    assert judged_segments.camera is not None
    body, index = judged_segments.skeleton.body, judged_segments.index(part)
    Ts = pose_transforms(judged_segments.skeleton, pose)
    ends = [T[:3, :3] @ far_end(body, k) + T[:3, 3] for k, T in enumerate(Ts)]
    end = ends[index]
    depth = float(judged_segments.camera.depth(end))
    if depth <= 0:
        return None
    scale = judged_segments.px_per_m_at(depth, frame)
    cm = None if px is None or judged_segments.guessed else 100 * math.hypot(px / scale, along_m)
    joints = np.concatenate([Ts[:, :3, 3], ends])
    return Place(why, frame, part, frames, px, cm, end, scale, joints)


def _drafts(judged_segments: JudgedSegments, doc: Session) -> Iterator[Place]:
    """Drafts that a person should confirm, in the order of their frames; none where what is tracked
    is shown instead."""
    tracks = judged_segments.tracks.values()
    drafts = {
        draft.frame: draft
        for draft in doc.subject.drafts
        if not (draft.is_found and any(t.first < draft.frame < t.last for t in tracks))
    }
    for why in doc.subject.drafted.places if doc.subject.drafted else ():
        draft, part = drafts.get(why.frame), why.parts[0] if why.parts else None
        if draft is None or judged_segments.skeleton is None:
            continue
        pose, frames = draft.pose(judged_segments.skeleton), (why.frame, why.frame)
        place = _place(judged_segments, pose, why, why.frame, part, frames, None)
        if place is not None and not _is_unclear(doc, place):
            yield place


def drafts_to_confirm(doc: Session) -> tuple[int, ...]:
    """Their frames, without those of which a person could not tell whether they are right."""
    return tuple(place.frame for place in _drafts(JudgedSegments.over(doc, {}), doc))


def _is_unclear(doc: Session, place: Place) -> bool:
    """Whether a person marked this draft as unclear. It may have learned from keyframes
    since, but a draft that is elsewhere is another one.
    """
    elsewhere_m = ELSEWHERE * height(doc.subject.body)
    return any(
        answer_given.frame == place.frame
        and float(np.linalg.norm(answer_given.seen_m - place.end_m)) < elsewhere_m
        for answer_given in doc.subject.reviewed
    )


def _right_px(judged_segments: JudgedSegments) -> float | None:
    """Pixels by which a right joint may be off: as is told of such, or as is no doubt yet."""
    right_errors = [
        max(px, IN_DOUBT * (judged_segments.height_px(track) or 0.0))
        for track in judged_segments.tracks.values()
        if (px := right_error_px(track)) is not None
    ]
    return float(np.median(right_errors)) if right_errors else None


def _mean(judged_segments: JudgedSegments) -> tuple[float | None, float | None]:
    """Pixels and centimetres by which joints are expected to be off between keyframes."""
    px, cm = [], []
    for track in judged_segments.tracks.values():
        errors = part_errors_px(track)
        if errors is None or len(errors) < 3:
            continue
        inside, depths = errors[1:-1], depth_errors_m(track)
        px.append(inside[inside > 0])
        scale = judged_segments.px_per_m(track, (track.first + track.last) // 2, None)
        if scale is not None:
            along_m = 0.0 if depths is None else depths[1:-1][inside > 0]
            cm.append(100 * np.hypot(px[-1] / scale, along_m))
    if not px:
        return None, None
    mean_cm = float(np.concatenate(cm).mean()) if cm and not judged_segments.guessed else None
    return float(np.concatenate(px).mean()), mean_cm
