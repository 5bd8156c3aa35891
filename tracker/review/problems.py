"""Find what is wrong with a tracked segment, and where: the one source of what is said of it.

The head of the picture, the bar over the timeline, the card of the segment and the review name the
same frame, part and reason because all of them take a `Problem` from here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias
from weakref import WeakKeyDictionary

from keypose.tracker.review.segment_errors import (
    REACH,
    Doubt,
    body_error_px,
    depth_doubts,
    doubts,
    fast_about,
    gain,
    longest_occlusion,
    part_errors_px,
    possible_drift_px,
    unseen_share,
)
from keypose.tracker.review.segments import JudgedSegments
from keypose.tracker.session.annotations import Answer
from keypose.tracker.session.verdict import Cause, Kind, Verdict
from keypose.tracker.storage.results import Span
from keypose.tracker.tracking.result import SegmentResult

WORTH_PX: Final = 0.6
"""What a keyframe must be expected to mend, in the mean over a segment."""
SHORT_FRAMES = 4
SHORT_OCCLUSION_FRAMES = 6
"""Intervals up to these lengths gain nothing from one keyframe more. What is hidden, whoever sets
the keyframe does not see either."""
BY_MOTION: Final = ("fast_motion", "longest_interval", "drift")
WRONG_KEYS: Final = ("contradiction", "nothing_seen", "keyframe_off_keypoints")

ProblemCause: TypeAlias = Cause | Literal["fast_motion", "longest_interval", "drift"]
"""Beside the causes of verdicts: a part moves fast there; no interval is longer; nothing but that
most drift had to be corrected there."""
Remedy: TypeAlias = Literal["key", "keyframe", "look"]
"""A keyframe there; the keyframe that is there is wrong itself; nothing but to look."""


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong, or may be, with a segment.

    kind: of the segment's verdict.  frame: where to look, and to add a keyframe.
    frames: first and last frame it is about.  part: None where it is about all.
    px, cm: by which the part, or the body in the mean, is expected to be off at the frame; pixels
        of the video, of what is guessed in depth as large as it is from the side; None where nobody
        knows.
    behind: the part that hides it.  partly: whether it is seen in most of the frames.
    answer: what a person said of it.
    """

    span: Span
    kind: Kind
    cause: ProblemCause
    frame: int
    frames: Span
    part: str | None
    remedy: Remedy
    px: float | None = None
    cm: float | None = None
    behind: str | None = None
    partly: bool = False
    text: str = ""
    answer: Answer | None = None


def problem_of(judged_segments: JudgedSegments, track: SegmentResult) -> Problem | None:
    """What is to be said of a segment: the first problem that nobody has answered, else one
    that the picture was unclear; None where nothing is wrong.
    """
    problems = problems_of(judged_segments, track)
    waiting = (problem for problem in problems if problem.answer is None)
    return next(waiting, None) or next((one for one in problems if one.answer == "unclear"), None)


def problems_of(judged_segments: JudgedSegments, track: SegmentResult) -> tuple[Problem, ...]:
    """All of a segment: first what is wrong with it as a whole, then what is in doubt."""
    listed = _PROBLEMS.setdefault(judged_segments, {})
    if track.span not in listed:
        listed[track.span] = tuple(
            _answered(judged_segments, problem) for problem in _found(judged_segments, track)
        )
    return listed[track.span]


_PROBLEMS: WeakKeyDictionary[JudgedSegments, dict[Span, tuple[Problem, ...]]] = WeakKeyDictionary()
"""Found once, and asked for by everything that speaks of a segment."""


def is_worth_a_keyframe(judged_segments: JudgedSegments, track: SegmentResult) -> bool:
    """Whether one is expected to mend something; asked only where that is known."""
    return track.kind == "lost" or gain(track) > judged_segments.keyed_px + WORTH_PX


def blames_keys(track: SegmentResult) -> bool:
    """Whether keyframes themselves are wrong, not what lies between them."""
    verdict = track.verdict
    wrong = verdict is not None and verdict.cause in WRONG_KEYS
    return wrong or (track.kind == "lost" and track.last - track.first < 2)


def is_past_mending(track: SegmentResult) -> bool:
    """Whether the interval is too short for a keyframe to help."""
    hidden = track.verdict is not None and track.verdict.cause == "not_seen"
    short = SHORT_OCCLUSION_FRAMES if hidden else SHORT_FRAMES
    return not blames_keys(track) and track.last - track.first <= short


def _found(judged_segments: JudgedSegments, track: SegmentResult) -> Iterator[Problem]:
    first, verdict = _first(judged_segments, track), track.verdict
    listed = [] if first is None else [first]
    if first is not None and verdict is not None and not _agrees(first, verdict):
        remedy = _remedy(judged_segments, track, verdict.cause)
        said = _by_verdict(
            judged_segments, track, verdict, _go(judged_segments, track, verdict), remedy
        )
        listed += [] if _is_settled(said.frame, listed) else [said]
    for doubt in doubts(track, judged_segments.height_px(track)):
        if not _is_settled(track.first + doubt.row, listed):
            listed.append(_of_part(judged_segments, track, doubt))
    yield from listed
    yield from _guessed(judged_segments, track, listed)


def _guessed(
    judged_segments: JudgedSegments, track: SegmentResult, listed: Sequence[Problem]
) -> Iterator[Problem]:
    """Find where parts are guesses in depth: what a look at the picture does not settle."""
    errors = judged_segments.direction_errors(track)
    for doubt in [] if errors is None else depth_doubts(errors):
        frame = track.first + doubt.row
        frames = track.first + doubt.first, track.first + doubt.last
        if any(_says_of(judged_segments, one, doubt.part, frame) for one in listed):
            continue
        part, remedy = judged_segments.name(doubt.part), _remedy(judged_segments, track, "depth")
        problem = Problem(track.span, track.kind or "good", "depth", frame, frames, part, remedy)
        yield _sized(judged_segments, track, problem)


def _says_of(judged_segments: JudgedSegments, problem: Problem, part: int, frame: int) -> bool:
    """Whether a problem tells of a limb at a frame, or that it is a guess in depth."""
    if problem.cause == "depth":
        return abs(frame - problem.frame) <= REACH
    return (
        part in judged_segments.limb_of(problem.part)
        and problem.frames[0] <= frame <= problem.frames[1]
    )


def _is_settled(frame: int, listed: Sequence[Problem]) -> bool:
    """Whether a look at one of these places settles a frame as well."""
    return any(abs(frame - problem.frame) <= REACH for problem in listed)


def _agrees(problem: Problem, verdict: Verdict) -> bool:
    """Whether a problem says what the verdict says."""
    return verdict.kind == "good" or (
        problem.cause not in BY_MOTION and verdict.part in (None, problem.part)
    )


def _first(judged_segments: JudgedSegments, track: SegmentResult) -> Problem | None:
    """What is wrong with a segment as a whole."""
    verdict, is_good = track.verdict, track.kind == "good"
    assert verdict is not None
    if not is_good and blames_keys(track):
        frame = track.first if verdict.go is None else verdict.go
        return _by_verdict(judged_segments, track, verdict, frame, "keyframe")
    has_gain = track.diagnostics.expected_gain is not None
    if judged_segments.halves and not is_past_mending(track):
        if has_gain and is_worth_a_keyframe(judged_segments, track):
            return _where_it_gains(judged_segments, track, verdict)
        if not has_gain and not is_good:
            return _by_verdict(
                judged_segments, track, verdict, _go(judged_segments, track, verdict), "key"
            )
    if is_good:
        return None
    remedy = _remedy(judged_segments, track, verdict.cause)
    return _by_verdict(
        judged_segments, track, verdict, _go(judged_segments, track, verdict), remedy
    )


def _remedy(judged_segments: JudgedSegments, track: SegmentResult, cause: Cause) -> Remedy:
    """What no look at the picture settles, a pose does."""
    is_posed = cause == "depth" and judged_segments.halves and not is_past_mending(track)
    return "key" if is_posed else "look"


def _go(judged_segments: JudgedSegments, track: SegmentResult, verdict: Verdict) -> int:
    """The frame that a verdict names, of a film between its keyframes."""
    frame = (track.first + track.last) // 2 if verdict.go is None else verdict.go
    return _inside(track, frame) if judged_segments.halves else frame


def _inside(track: SegmentResult, frame: int) -> int:
    return min(max(frame, track.first + 1), max(track.last - 1, track.first))


def _where_it_gains(
    judged_segments: JudgedSegments, track: SegmentResult, verdict: Verdict
) -> Problem:
    """Where the part that is most in doubt is farthest off; without one at the frame where a
    keyframe would mend most, by the verdict where that is about it, else by how the body moves."""
    doubtful = next(iter(doubts(track, judged_segments.height_px(track))), None)
    row = int(possible_drift_px(track).argmax()) if doubtful is None else doubtful.row
    frame = _inside(track, track.first + row)
    if verdict.kind != "good" and _is_about(verdict, frame):
        limb = judged_segments.limb_of(verdict.part)
        if verdict.part is None or doubtful is None or doubtful.part in limb:
            return _by_verdict(judged_segments, track, verdict, frame, "key")
    if doubtful is not None:
        return replace(_of_part(judged_segments, track, doubtful), remedy="key")
    cause, frames = _how_it_moves(judged_segments, track, frame)
    problem = Problem(track.span, verdict.kind, cause, frame, frames, None, "key")
    return _sized(judged_segments, track, problem)


def _is_about(verdict: Verdict, frame: int) -> bool:
    """Whether a verdict says why a frame needs a keyframe; one on a part speaks of its
    frames.
    """
    if verdict.part is None or verdict.frames is None:
        return True
    return verdict.frames[0] <= frame <= verdict.frames[1]


def _how_it_moves(
    judged_segments: JudgedSegments, track: SegmentResult, frame: int
) -> tuple[ProblemCause, Span]:
    """What is seen of the motion that makes a keyframe needed at a frame."""
    fast = fast_about(judged_segments.in_world(track), frame)
    if fast is not None:
        return "fast_motion", fast
    is_longest = (
        min(judged_segments.lengths) < track.last - track.first == max(judged_segments.lengths)
    )
    return ("longest_interval" if is_longest else "drift"), track.span


def _by_verdict(
    judged_segments: JudgedSegments,
    track: SegmentResult,
    verdict: Verdict,
    frame: int,
    remedy: Remedy,
) -> Problem:
    """Add the verdict's reason; where tracking was lost, what made it so."""
    frames = verdict.frames or track.span
    cause, part = verdict.cause, verdict.part
    if cause == "not_followed":
        frames, hidden = track.span, longest_occlusion(track)
        name = None if hidden is None else judged_segments.name(hidden[0])
        if hidden is not None and name is not None:
            cause, part, frames = "not_seen", name, hidden[1]
    problem = Problem(
        track.span, verdict.kind, cause, frame, frames, part, remedy, text=verdict.text
    )
    if remedy == "keyframe":
        return problem
    return _sized(
        judged_segments,
        track,
        _occlusion(judged_segments, track, problem) if cause == "not_seen" else problem,
    )


def _of_part(judged_segments: JudgedSegments, track: SegmentResult, doubt: Doubt) -> Problem:
    """A part in doubt, with what makes it so."""
    start = track.first
    frame, frames = start + doubt.row, (start + doubt.first, start + doubt.last)
    part = judged_segments.name(doubt.part)
    problem = Problem(track.span, track.kind or "good", "uncertain", frame, frames, part, "look")
    problem = _sized(judged_segments, track, problem)
    hidden = _occlusion(judged_segments, track, problem)
    if hidden.behind is not None or unseen_share(track, doubt.part, frames) > 0:
        return replace(hidden, cause="not_seen")
    return (
        replace(problem, cause="fast_motion")
        if fast_about(judged_segments.in_world(track), frame)
        else problem
    )


def _occlusion(judged_segments: JudgedSegments, track: SegmentResult, problem: Problem) -> Problem:
    """Add what occludes the part."""
    if problem.part is None:
        return problem
    behind = judged_segments.occluder(track, problem.frame, problem.part)
    share = unseen_share(track, judged_segments.index(problem.part), problem.frames)
    return replace(problem, behind=behind, partly=behind is None and 0 < share < 0.5)


def _sized(judged_segments: JudgedSegments, track: SegmentResult, problem: Problem) -> Problem:
    """Add how far off it is expected to be: the part where joints are observed, else the body in
    the mean. Where no part is named, it is the worst one.
    """
    row = problem.frame - track.first
    errors = part_errors_px(track)
    if errors is not None and 0 < row < len(errors) - 1:
        index = (
            int(errors[row].argmax())
            if problem.part is None
            else judged_segments.index(problem.part)
        )
        if errors[row, index] > 0:
            problem = replace(
                problem, part=judged_segments.name(index), px=float(errors[row, index])
            )
    elif track.diagnostics.expected_gain is not None and problem.part is None:
        problem = replace(problem, px=float(body_error_px(track)[row]))
    if problem.px is None:
        return problem
    cm = judged_segments.error_cm(track, problem.frame, problem.part, problem.px)
    if problem.cause != "depth":
        return replace(problem, cm=cm)
    scale = judged_segments.px_per_m(track, problem.frame, problem.part) or 0.0
    along_px = scale * judged_segments.depth_error_m(track, problem.frame, problem.part)
    return replace(problem, cm=cm, px=math.hypot(problem.px, along_px))


def _answered(judged_segments: JudgedSegments, problem: Problem) -> Problem:
    said = judged_segments.answer(problem.part, problem.frame, problem.span)
    return problem if said is None else replace(problem, answer=said.answer)
