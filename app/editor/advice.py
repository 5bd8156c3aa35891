"""Advise what to do next: where a keyframe helps most and why; or why nothing can be done."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

from keypose.app.editor.ahead import tracked_to, why_stopped
from keypose.app.editor.outdated import still_leads_on
from keypose.app.words.problems import add_keyframe, detail_of, frame_range, named_frames, reason
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.review.problems import (
    SHORT_FRAMES,
    Problem,
    ProblemCause,
    blames_keys,
    is_past_mending,
    is_worth_a_keyframe,
    problem_of,
)
from keypose.tracker.review.segment_errors import gain, part_errors_px, possible_drift_px
from keypose.tracker.review.segments import JudgedSegments
from keypose.tracker.session.annotations import Ahead, Direction
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.session.schema import Session
from keypose.tracker.session.verdict import WORST_FIRST
from keypose.tracker.storage.results import Span
from keypose.tracker.tracking.result import SegmentResult

NEXT_FRAMES = 24
"""A good first distance of keyframes: about a second."""
LONG_FRAMES = 32
"""Past this length, fast motion is lost in half of all segments."""

Fitting = Mapping[Span, SegmentResult]


@dataclass(frozen=True)
class Suggestion:
    """What to do next. title: what; detail: why, may be empty. Neither has a full stop at its end.

    kind: "pose" a frame and press K; "key" set the keyframe `frame`; "track" what is not tracked as
    it is posed now; "look" at `frame`, where keyframes themselves are wrong or no keyframe more
    would help; "good" nothing.
    problem: the one that is spoken of.
    ahead: the direction in which tracking ahead is offered, also beside advice about a frame.
    """

    frame: int | None
    title: str
    detail: str
    kind: Literal["pose", "key", "track", "look", "good"]
    problem: Problem | None = None
    ahead: Direction | None = None


def suggestion(
    keys: Sequence[int],
    frame_count: int,
    fitting: Fitting,
    parts: Sequence[str] = (),
    judged_segments: JudgedSegments | None = None,
) -> Suggestion:
    """The one thing that helps most. keys: frames of the keyframes, ascending.

    fitting: the results of the present segments (Results.fitting); unfinished ones count as none.
    parts: names of the body's parts, so that what is hidden where tracking was lost can be named.
    judged_segments: the same with all that shows what is wrong with them.
    """
    if len(keys) < 2:
        return _first_poses(keys, frame_count)
    spans = list(pairwise(keys))
    done = {span: fitting[span] for span in spans if span in fitting and fitting[span].finished}
    judged_segments = judged_segments or JudgedSegments(done, parts)
    if len(done) == len(spans) and all(
        track.diagnostics.expected_gain is not None for track in done.values()
    ):
        return _by_gain(judged_segments, list(done.values())) or ALL_GOOD
    bad = [
        track
        for track in done.values()
        if track.kind != "good" and _is_open(judged_segments, track)
    ]
    to_mend = [track for track in bad if not is_past_mending(track)]
    for kind in ("lost", "check"):
        segment_results = [track for track in to_mend if track.kind == kind]
        if kind == "check" and len(done) < len(spans):
            break  # first everything is tracked, then it is made better
        if segment_results:
            return _about(judged_segments, max(segment_results, key=_need))
    if len(done) < len(spans):
        return segments_need([span for span in spans if span not in done], "tracking")
    divided = _longest(spans)
    if divided is None and bad:
        return _about(
            judged_segments, max(bad, key=lambda track: (track.kind == "lost", _need(track)))
        )
    return divided or ALL_GOOD


def _by_gain(judged_segments: JudgedSegments, tracks: Sequence[SegmentResult]) -> Suggestion | None:
    """The keyframe that is expected to mend most, of all segments; None where all is good.

    Where tracking was lost comes before what is to be checked: nobody knows how far off it is.
    What short intervals still show is the keyframes' own error: that much is not to be gained.
    """
    waiting = [track for track in tracks if _is_open(judged_segments, track)]
    bad = [track for track in waiting if track.kind != "good"]
    for kinds in (("lost",), WORST_FIRST):
        wrong = [track for track in bad if track.kind in kinds and blames_keys(track)]
        if wrong:
            return _about(judged_segments, max(wrong, key=_need))
        open_ones = [t for t in waiting if t.kind in kinds and not is_past_mending(t)]
        worth = [track for track in open_ones if is_worth_a_keyframe(judged_segments, track)]
        if worth:
            return _about(
                judged_segments, max(worth, key=lambda track: _gains_by(judged_segments, track))
            )
    if bad:
        return _about(
            judged_segments, max(bad, key=lambda track: (track.kind == "lost", _need(track)))
        )
    return None


def _gains_by(judged_segments: JudgedSegments, track: SegmentResult) -> tuple[float, float, float]:
    """How much a keyframe would mend: by the joint that is farthest off where joints are
    observed, else by what may have drifted.
    """
    problem = problem_of(judged_segments, track)
    has_parts = part_errors_px(track) is not None
    px = problem.px if has_parts and problem is not None and problem.px is not None else 0.0
    return px, float(possible_drift_px(track).sum()), gain(track)


def _is_open(judged_segments: JudgedSegments, track: SegmentResult) -> bool:
    """Whether something is wrong with a segment to which nobody has said anything yet."""
    problem = problem_of(judged_segments, track)
    return problem is not None and problem.answer is None


def _about(judged_segments: JudgedSegments, track: SegmentResult) -> Suggestion:
    """What a segment needs."""
    problem = problem_of(judged_segments, track)
    assert problem is not None
    frame, why = problem.frame, detail_of(problem)
    if problem.remedy == "keyframe":
        return Suggestion(frame, f"Check keyframe {frame}", why, "look", problem)
    if problem.remedy == "key":
        return Suggestion(frame, add_keyframe(frame), why, "key", problem)
    return Suggestion(frame, f"Check frame {frame} and move on", why, "look", problem)


def _need(track: SegmentResult) -> int:
    """How many frames a keyframe there would mend: those in doubt, or all that are lost."""
    verdict = track.verdict
    if verdict is not None and verdict.kind == "check" and verdict.frames is not None:
        return verdict.frames[1] - verdict.frames[0]
    return track.last - track.first


def _longest(spans: list[Span]) -> Suggestion | None:
    first, last = max(spans, key=lambda span: span[1] - span[0])
    if last - first <= LONG_FRAMES:
        return None
    frame, why = (first + last) // 2, f"Longest interval, {last - first} frames"
    return Suggestion(frame, add_keyframe(frame), why, "key")


def middle(keys: Sequence[int], frame: int) -> int | None:
    """The middle of the interval between keyframes that a frame lies in; on a keyframe, of the next
    one. None outside of all intervals and where the interval has no inside."""
    after = bisect_right(keys, frame)
    if after == len(keys) and keys and keys[-1] == frame:
        after -= 1
    if not 0 < after < len(keys):
        return None
    first, last = keys[after - 1], keys[after]
    return (first + last) // 2 if last - first > 1 else None


def _first_poses(keys: Sequence[int], frame_count: int) -> Suggestion:
    if not keys:
        return Suggestion(None, "Pose this frame, then press K", _TWO_KEYFRAMES, "pose")
    key, last = keys[0], frame_count - 1
    frame = min(key + NEXT_FRAMES, last)
    if frame - key < NEXT_FRAMES // 2 and key > last - key:
        frame = max(key - NEXT_FRAMES, 0)
    if frame == key:
        return Suggestion(None, "Nothing to track", "The video has only one frame", "pose")
    return Suggestion(frame, f"Pose frame {frame}, then press K", _TWO_KEYFRAMES, "pose")


_TWO_KEYFRAMES = "Two keyframes make the first segment"


def segments_need(spans: Sequence[Span], action: str) -> Suggestion:
    """ "4 segments need tracking", and the first of them."""
    count = len(spans)
    title = f"1 segment needs {action}" if count == 1 else f"{count} segments need {action}"
    named = [frame_range(*span) for span in spans[:2]]
    more = f"{', '.join(named)} and {count - 2} more" if count > 2 else " and ".join(named)
    return Suggestion(None, title, f"Frames {more}", "track")


ALL_GOOD = Suggestion(None, "All good", "Add a keyframe only where the motion looks wrong", "good")


def followed_suggestion(session: Session) -> Suggestion | None:
    """The last frame that can be trusted of what was tracked ahead: its pose is all but a keyframe.
    None where nothing was, or so little that a keyframe there is no gain."""
    followed = [
        record_ahead
        for record_ahead in session.subject.ahead
        if _is_worth_keying(session, record_ahead)
    ]
    if not followed:
        return None
    record = max(followed, key=lambda ahead: ahead.is_forward)
    title = f"Check frame {record.to_frame}, then press K"
    why = f"{tracked_to(record)}. {why_stopped(record)}"
    return Suggestion(record.to_frame, title, why, "key")


def _is_worth_keying(session: Session, record: Ahead) -> bool:
    first, last = record.span
    return last - first >= SHORT_FRAMES and still_leads_on(session, record)


def with_way_ahead(advised: Suggestion, keys: Sequence[int], session: Session) -> Suggestion:
    """Add the way in which tracking ahead leads on, unless something is to be tracked first.

    Where a keyframe is asked for and the film was drafted, what lies beyond has poses already.
    """
    about_a_frame = advised.kind in ("key", "look")
    if (
        not keys
        or advised.kind == "track"
        or (about_a_frame and session.subject.drafted is not None)
    ):
        return advised
    way_ahead = _way(keys, session)
    return advised if way_ahead is None else replace(advised, ahead=way_ahead)


def _way(keys: Sequence[int], session: Session) -> Direction | None:
    """Forward before backward; not again where it led to next to nothing."""
    tried = {ahead.is_forward for ahead in session.subject.ahead if still_leads_on(session, ahead)}
    after, before = session.view.video.frame_count - 1 - keys[-1], keys[0]
    if after >= SHORT_FRAMES and True not in tried:
        return "forward"
    if before >= SHORT_FRAMES and False not in tried:
        return "backward"
    return None


def surface_suggestion(
    keys: Sequence[int],
    spans: Sequence[Span],
    fitting: Fitting,
    judged_segments: JudgedSegments | None = None,
) -> Suggestion:
    """The one thing that helps most. keys: frames of the keyframes, ascending.

    spans: the segments.  fitting: their results; unfinished ones count as none.
    judged_segments: the same with all that shows what is wrong with them.
    """
    if not keys:
        title = "Pose the body in this surface, then press K"
        return Suggestion(None, title, "One keyframe is enough to begin", "pose")
    if not spans:
        return Suggestion(None, "Nothing to fit", "There is only one surface", "pose")
    done = [fitting[span] for span in spans if span in fitting and fitting[span].finished]
    judged_segments = judged_segments or JudgedSegments(
        {track.span: track for track in done}, halves=False
    )
    waiting = [track for track in done if _is_open(judged_segments, track)]
    off = [track for track in waiting if _is_off(track)]
    lost = [track for track in waiting if track.kind == "lost"]
    if off or lost:
        return _about_surfaces(judged_segments, off[0] if off else max(lost, key=_doubtful), keys)
    stopped = [track for track in done if track.missing]
    if stopped:
        return _to_go_on(stopped[0])
    if len(done) < len(spans):  # first everything is fitted, then it is made better
        fitted = {track.span for track in done}
        return segments_need([span for span in spans if span not in fitted], "fitting")
    doubtful = [track for track in waiting if track.kind == "check"]
    return (
        _about_surfaces(judged_segments, max(doubtful, key=_doubtful), keys)
        if doubtful
        else ALL_GOOD
    )


def _to_go_on(stopped: SegmentResult) -> Suggestion:
    verdict = stopped.verdict
    assert verdict is not None
    where = named_frames(*(verdict.frames or stopped.span))
    detail = f"{where[0].upper()}{where[1:]} {reason(verdict)}"
    return Suggestion(None, "Continue fitting", detail, "track")


def _is_off(track: SegmentResult) -> bool:
    return track.verdict is not None and track.verdict.cause == "body_off_surface"


def _about_surfaces(
    judged_segments: JudgedSegments, track: SegmentResult, keys: Sequence[int]
) -> Suggestion:
    """A keyframe where it was lost or is in doubt; where one stands already, a look at it."""
    problem = problem_of(judged_segments, track)
    assert problem is not None
    frame, why = problem.frame, _THERE.get(problem.cause, detail_of(problem))
    if frame in keys:
        return Suggestion(frame, f"Check keyframe {frame}", why, "look", problem)
    if problem.kind == "lost":
        return Suggestion(frame, add_keyframe(frame), why, "key", problem)
    return Suggestion(frame, f"Check frame {frame}", why, "look", problem)


_THERE: Mapping[ProblemCause, str] = {
    "not_followed": "The fit is lost there",
    "body_off_surface": "The body is off its surface there",
}
"""Reasons beside a frame that is named already."""


def _doubtful(track: SegmentResult) -> int:
    """How many frames are in doubt."""
    frames = None if track.verdict is None else track.verdict.frames
    first, last = frames or track.span
    return last - first


_BOX_OR_POSE = ("Press B and draw a box around the person", "Or pose this frame and press K")


@dataclass(frozen=True)
class _Advice:
    """next: of the keyframes' frames, the session and its results.  missing: of a session without
    a segment, what it lacks."""

    next: Callable[[Sequence[int], Session, JudgedSegments], Suggestion]
    missing: Callable[[Session], str]


def next_step(
    keys: Sequence[int],
    session: Session,
    fitting: Fitting,
    judged_segments: JudgedSegments | None = None,
) -> Suggestion:
    """The one thing that helps most. keys: frames of the keyframes, ascending.

    fitting: the results of the present segments; unfinished ones count as none.
    judged_segments: the same, where what is wrong with them was asked for already.
    """
    return _ADVICE.of(session).next(
        keys, session, judged_segments or JudgedSegments.over(session, fitting)
    )


def why_nothing_to_do(session: Session) -> str:
    """Why there is no segment whose motion could be found."""
    return _ADVICE.of(session).missing(session)


def _next_of_film(
    keys: Sequence[int], session: Session, judged_segments: JudgedSegments
) -> Suggestion:
    followed = followed_suggestion(session)
    if followed is not None:
        return followed
    if not keys and not session.subject.drafts and is_persons(session.subject.body):
        return Suggestion(None, *_BOX_OR_POSE, "pose")
    of_film = suggestion(
        keys,
        session.view.video.frame_count,
        judged_segments.tracks,
        judged_segments.parts,
        judged_segments,
    )
    return with_way_ahead(of_film, keys, session)


def _missing_of_film(session: Session) -> str:
    few = bool(session.subject.keyframes)
    return "Add a second keyframe first." if few else "Add two keyframes first."


def _next_of_surfaces(
    keys: Sequence[int], session: Session, judged_segments: JudgedSegments
) -> Suggestion:
    return surface_suggestion(keys, session.spans, judged_segments.tracks, judged_segments)


def _missing_of_surfaces(session: Session) -> str:
    if session.view.video.frame_count < 2:
        return "Nothing to fit: there is only one mesh."
    return "Add a keyframe first: pose the body in one of the meshes."


_ADVICE = ByEvidence(
    {
        FilmEvidence: _Advice(_next_of_film, _missing_of_film),
        SurfaceEvidence: _Advice(_next_of_surfaces, _missing_of_surfaces),
    }
)
