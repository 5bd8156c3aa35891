"""What helps most where there are observed surfaces: one keyframe is enough to follow them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from keypose.app.editor.judged import Judged
from keypose.app.editor.problem_words import detail_of
from keypose.app.editor.problems import ProblemCause, problem_of
from keypose.app.editor.suggest import ALL_GOOD, Fitting, Suggestion, segments_need
from keypose.app.editor.verdict_text import add_keyframe, named_frames, reason
from keypose.tracker.storage.results import Span
from keypose.tracker.tracking.result import SegmentResult


def surface_suggestion(
    keys: Sequence[int], spans: Sequence[Span], fitting: Fitting, known: Judged | None = None
) -> Suggestion:
    """The one thing that helps most. keys: frames of the keyframes, ascending.

    spans: the segments.  fitting: their results; unfinished ones count as none.
    known: the same with all that shows what is wrong with them.
    """
    if not keys:
        title = "Pose the body in this surface, then press K"
        return Suggestion(None, title, "One keyframe is enough to begin", "pose")
    if not spans:
        return Suggestion(None, "Nothing to fit", "There is only one surface", "pose")
    done = [fitting[span] for span in spans if span in fitting and fitting[span].finished]
    known = known or Judged({track.span: track for track in done}, halves=False)
    waiting = [track for track in done if _is_open(known, track)]
    off = [track for track in waiting if _is_off(track)]
    lost = [track for track in waiting if track.kind == "lost"]
    if off or lost:
        return _about(known, off[0] if off else max(lost, key=_doubtful), keys)
    stopped = [track for track in done if track.missing]
    if stopped:
        return _to_go_on(stopped[0])
    if len(done) < len(spans):  # first everything is fitted, then it is made better
        fitted = {track.span for track in done}
        return segments_need([span for span in spans if span not in fitted], "fitting")
    doubtful = [track for track in waiting if track.kind == "check"]
    return _about(known, max(doubtful, key=_doubtful), keys) if doubtful else ALL_GOOD


def _to_go_on(stopped: SegmentResult) -> Suggestion:
    verdict = stopped.verdict
    assert verdict is not None
    where = named_frames(*(verdict.frames or stopped.span))
    detail = f"{where[0].upper()}{where[1:]} {reason(verdict)}"
    return Suggestion(None, "Continue fitting", detail, "track")


def _is_off(track: SegmentResult) -> bool:
    return track.verdict is not None and track.verdict.cause == "body_off_surface"


def _is_open(known: Judged, track: SegmentResult) -> bool:
    """Whether something is wrong with a segment to which nobody has said anything yet."""
    found = problem_of(known, track)
    return found is not None and found.answer is None


def _about(known: Judged, track: SegmentResult, keys: Sequence[int]) -> Suggestion:
    """A keyframe where it was lost or is in doubt; where one stands already, a look at it."""
    found = problem_of(known, track)
    assert found is not None
    frame, why = found.frame, _THERE.get(found.cause, detail_of(found))
    if frame in keys:
        return Suggestion(frame, f"Check keyframe {frame}", why, "look", found)
    if found.kind == "lost":
        return Suggestion(frame, add_keyframe(frame), why, "key", found)
    return Suggestion(frame, f"Check frame {frame}", why, "look", found)


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
