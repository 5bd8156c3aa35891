"""What helps most where there are observed surfaces: one keyframe is enough to follow them."""

from __future__ import annotations

from collections.abc import Sequence

from app.editor.suggest import Fitting, Suggestion
from tracker.storage.results import SegmentTrack, Span, frames_in_words

_ALL_GOOD = Suggestion(None, "All Good. Add a key only where you disagree.", "", "good")


def surface_suggestion(keys: Sequence[int], spans: Sequence[Span], fitting: Fitting) -> Suggestion:
    """The one thing that helps most. keys: frames of the keyframes, ascending.

    spans: the segments.  fitting: their results; unfinished ones count as none.
    """
    if not keys:
        words = "Pose the body in this surface, then press K. One keyframe is enough to begin."
        return Suggestion(None, words, "", "pose")
    if not spans:
        return Suggestion(None, "One surface is all there is: nothing to fit.", "", "pose")
    done = [fitting[span] for span in spans if span in fitting and fitting[span].finished]
    off = [track for track in done if track.finding is not None and track.finding.what == "off"]
    lost = [track for track in done if track.kind == "lost"]
    if off or lost:
        return _about(off[0] if off else max(lost, key=_doubtful), keys)
    stopped = [track for track in done if track.missing]
    if stopped:
        return _to_go_on(stopped[0])
    if len(done) < len(spans):  # first everything is fitted, then it is made better
        return _to_fit([span for span in spans if span not in {track.span for track in done}])
    doubtful = [track for track in done if track.kind == "check"]
    return _about(max(doubtful, key=_doubtful), keys) if doubtful else _ALL_GOOD


def _to_fit(spans: Sequence[Span]) -> Suggestion:
    named = " and ".join(frames_in_words(*span) for span in spans[:2])
    more = f" and {len(spans) - 2} more" if len(spans) > 2 else ""
    return Suggestion(None, "Fit next.", f"{named}{more} not fitted as posed now", "track")


def _to_go_on(stopped: SegmentTrack) -> Suggestion:
    finding = stopped.finding
    assert finding is not None
    where = frames_in_words(*(finding.frames or stopped.span))
    return Suggestion(None, "Fit next.", f"{where} {finding.reason}", "track")


def _about(track: SegmentTrack, keys: Sequence[int]) -> Suggestion:
    """A keyframe where it was lost or is in doubt; where one stands already, a look at it."""
    finding, middle = track.finding, (track.first + track.last) // 2
    assert finding is not None
    frame = middle if finding.go is None else finding.go
    where = "" if finding.frames is None else f" {frames_in_words(*finding.frames)}"
    told = {"near": "The fit is lost there", "off": "The body lies off its surface there"}
    reason = told.get(finding.what, f"{finding.reason}{where}")
    reason = reason[:1].upper() + reason[1:]
    if frame in keys:
        return Suggestion(frame, f"Look at key {frame} again.", reason, "look")
    words = f"Key frame {frame} next." if track.kind == "lost" else f"Look at frame {frame}."
    return Suggestion(frame, words, reason, "key" if track.kind == "lost" else "look")


def _doubtful(track: SegmentTrack) -> int:
    """How many frames are in doubt."""
    first, last = track.frames if track.frames is not None else track.span
    return last - first
