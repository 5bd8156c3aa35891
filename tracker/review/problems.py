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


def problem_of(known: JudgedSegments, track: SegmentResult) -> Problem | None:
    """What is to be said of a segment: the first problem that nobody has answered, else one
    that the picture was unclear; None where nothing is wrong.
    """
    found = problems_of(known, track)
    waiting = (one for one in found if one.answer is None)
    return next(waiting, None) or next((one for one in found if one.answer == "unclear"), None)


def problems_of(known: JudgedSegments, track: SegmentResult) -> tuple[Problem, ...]:
    """All of a segment: first what is wrong with it as a whole, then what is in doubt."""
    listed = _PROBLEMS.setdefault(known, {})
    if track.span not in listed:
        listed[track.span] = tuple(_answered(known, one) for one in _found(known, track))
    return listed[track.span]


_PROBLEMS: WeakKeyDictionary[JudgedSegments, dict[Span, tuple[Problem, ...]]] = WeakKeyDictionary()
"""Found once, and asked for by everything that speaks of a segment."""


def is_worth_a_keyframe(known: JudgedSegments, track: SegmentResult) -> bool:
    """Whether one is expected to mend something; asked only where that is known."""
    return track.kind == "lost" or gain(track) > known.keyed_px + WORTH_PX


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


def _found(known: JudgedSegments, track: SegmentResult) -> Iterator[Problem]:
    first, verdict = _first(known, track), track.verdict
    listed = [] if first is None else [first]
    if first is not None and verdict is not None and not _agrees(first, verdict):
        remedy = _remedy(known, track, verdict.cause)
        said = _by_verdict(known, track, verdict, _go(known, track, verdict), remedy)
        listed += [] if _is_settled(said.frame, listed) else [said]
    for doubt in doubts(track, known.height_px(track)):
        if not _is_settled(track.first + doubt.row, listed):
            listed.append(_of_part(known, track, doubt))
    yield from listed
    yield from _guessed(known, track, listed)


def _guessed(
    known: JudgedSegments, track: SegmentResult, listed: Sequence[Problem]
) -> Iterator[Problem]:
    """Find where parts are guesses in depth: what a look at the picture does not settle."""
    errors = known.direction_errors(track)
    for doubt in [] if errors is None else depth_doubts(errors):
        frame = track.first + doubt.row
        frames = track.first + doubt.first, track.first + doubt.last
        if any(_says_of(known, one, doubt.part, frame) for one in listed):
            continue
        part, remedy = known.name(doubt.part), _remedy(known, track, "depth")
        found = Problem(track.span, track.kind or "good", "depth", frame, frames, part, remedy)
        yield _sized(known, track, found)


def _says_of(known: JudgedSegments, one: Problem, part: int, frame: int) -> bool:
    """Whether a problem tells of a limb at a frame, or that it is a guess in depth."""
    if one.cause == "depth":
        return abs(frame - one.frame) <= REACH
    return part in known.limb_of(one.part) and one.frames[0] <= frame <= one.frames[1]


def _is_settled(frame: int, listed: Sequence[Problem]) -> bool:
    """Whether a look at one of these places settles a frame as well."""
    return any(abs(frame - other.frame) <= REACH for other in listed)


def _agrees(found: Problem, verdict: Verdict) -> bool:
    """Whether a problem says what the verdict says."""
    return verdict.kind == "good" or (
        found.cause not in BY_MOTION and verdict.part in (None, found.part)
    )


def _first(known: JudgedSegments, track: SegmentResult) -> Problem | None:
    """What is wrong with a segment as a whole."""
    verdict, is_good = track.verdict, track.kind == "good"
    assert verdict is not None
    if not is_good and blames_keys(track):
        frame = track.first if verdict.go is None else verdict.go
        return _by_verdict(known, track, verdict, frame, "keyframe")
    has_gain = track.diagnostics.expected_gain is not None
    if known.halves and not is_past_mending(track):
        if has_gain and is_worth_a_keyframe(known, track):
            return _where_it_gains(known, track, verdict)
        if not has_gain and not is_good:
            return _by_verdict(known, track, verdict, _go(known, track, verdict), "key")
    if is_good:
        return None
    remedy = _remedy(known, track, verdict.cause)
    return _by_verdict(known, track, verdict, _go(known, track, verdict), remedy)


def _remedy(known: JudgedSegments, track: SegmentResult, cause: Cause) -> Remedy:
    """What no look at the picture settles, a pose does."""
    is_posed = cause == "depth" and known.halves and not is_past_mending(track)
    return "key" if is_posed else "look"


def _go(known: JudgedSegments, track: SegmentResult, verdict: Verdict) -> int:
    """The frame that a verdict names, of a film between its keyframes."""
    frame = (track.first + track.last) // 2 if verdict.go is None else verdict.go
    return _inside(track, frame) if known.halves else frame


def _inside(track: SegmentResult, frame: int) -> int:
    return min(max(frame, track.first + 1), max(track.last - 1, track.first))


def _where_it_gains(known: JudgedSegments, track: SegmentResult, verdict: Verdict) -> Problem:
    """Where the part that is most in doubt is farthest off; without one at the frame where a
    keyframe would mend most, by the verdict where that is about it, else by how the body moves."""
    doubtful = next(iter(doubts(track, known.height_px(track))), None)
    row = int(possible_drift_px(track).argmax()) if doubtful is None else doubtful.row
    frame = _inside(track, track.first + row)
    if verdict.kind != "good" and _is_about(verdict, frame):
        limb = known.limb_of(verdict.part)
        if verdict.part is None or doubtful is None or doubtful.part in limb:
            return _by_verdict(known, track, verdict, frame, "key")
    if doubtful is not None:
        return replace(_of_part(known, track, doubtful), remedy="key")
    cause, frames = _how_it_moves(known, track, frame)
    found = Problem(track.span, verdict.kind, cause, frame, frames, None, "key")
    return _sized(known, track, found)


def _is_about(verdict: Verdict, frame: int) -> bool:
    """Whether a verdict says why a frame needs a keyframe; one on a part speaks of its
    frames.
    """
    if verdict.part is None or verdict.frames is None:
        return True
    return verdict.frames[0] <= frame <= verdict.frames[1]


def _how_it_moves(
    known: JudgedSegments, track: SegmentResult, frame: int
) -> tuple[ProblemCause, Span]:
    """What is seen of the motion that makes a keyframe needed at a frame."""
    fast = fast_about(known.in_world(track), frame)
    if fast is not None:
        return "fast_motion", fast
    is_longest = min(known.lengths) < track.last - track.first == max(known.lengths)
    return ("longest_interval" if is_longest else "drift"), track.span


def _by_verdict(
    known: JudgedSegments, track: SegmentResult, verdict: Verdict, frame: int, remedy: Remedy
) -> Problem:
    """Add the verdict's reason; where tracking was lost, what made it so."""
    frames = verdict.frames or track.span
    cause, part = verdict.cause, verdict.part
    if cause == "not_followed":
        frames, hidden = track.span, longest_occlusion(track)
        name = None if hidden is None else known.name(hidden[0])
        if hidden is not None and name is not None:
            cause, part, frames = "not_seen", name, hidden[1]
    found = Problem(track.span, verdict.kind, cause, frame, frames, part, remedy, text=verdict.text)
    if remedy == "keyframe":
        return found
    return _sized(known, track, _occlusion(known, track, found) if cause == "not_seen" else found)


def _of_part(known: JudgedSegments, track: SegmentResult, doubt: Doubt) -> Problem:
    """A part in doubt, with what makes it so."""
    start = track.first
    frame, frames = start + doubt.row, (start + doubt.first, start + doubt.last)
    part = known.name(doubt.part)
    found = Problem(track.span, track.kind or "good", "uncertain", frame, frames, part, "look")
    found = _sized(known, track, found)
    hidden = _occlusion(known, track, found)
    if hidden.behind is not None or unseen_share(track, doubt.part, frames) > 0:
        return replace(hidden, cause="not_seen")
    return (
        replace(found, cause="fast_motion") if fast_about(known.in_world(track), frame) else found
    )


def _occlusion(known: JudgedSegments, track: SegmentResult, found: Problem) -> Problem:
    """Add what occludes the part."""
    if found.part is None:
        return found
    behind = known.occluder(track, found.frame, found.part)
    share = unseen_share(track, known.index(found.part), found.frames)
    return replace(found, behind=behind, partly=behind is None and 0 < share < 0.5)


def _sized(known: JudgedSegments, track: SegmentResult, found: Problem) -> Problem:
    """Add how far off it is expected to be: the part where joints are observed, else the body in
    the mean. Where no part is named, it is the worst one.
    """
    row = found.frame - track.first
    errors = part_errors_px(track)
    if errors is not None and 0 < row < len(errors) - 1:
        index = int(errors[row].argmax()) if found.part is None else known.index(found.part)
        if errors[row, index] > 0:
            found = replace(found, part=known.name(index), px=float(errors[row, index]))
    elif track.diagnostics.expected_gain is not None and found.part is None:
        found = replace(found, px=float(body_error_px(track)[row]))
    if found.px is None:
        return found
    cm = known.error_cm(track, found.frame, found.part, found.px)
    if found.cause != "depth":
        return replace(found, cm=cm)
    scale = known.px_per_m(track, found.frame, found.part) or 0.0
    along_px = scale * known.depth_error_m(track, found.frame, found.part)
    return replace(found, cm=cm, px=math.hypot(found.px, along_px))


def _answered(known: JudgedSegments, found: Problem) -> Problem:
    said = known.answer(found.part, found.frame, found.span)
    return found if said is None else replace(found, answer=said.answer)
