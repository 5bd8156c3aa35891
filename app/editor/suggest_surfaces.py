"""What helps most where there are observed surfaces: one keyframe is enough to follow them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from app.editor.suggest import Fitting, Suggestion
from app.editor.verdict_words import add_keyframe, frame_range, reason, reason_with_frames
from tracker.session.verdict import Cause
from tracker.storage.results import SegmentTrack, Span

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
    off = [track for track in done if _is_off(track)]
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
    named = " and ".join(frame_range(*span) for span in spans[:2])
    more = f" and {len(spans) - 2} more" if len(spans) > 2 else ""
    return Suggestion(None, "Fit next.", f"{named}{more} not fitted as posed now", "track")


def _to_go_on(stopped: SegmentTrack) -> Suggestion:
    verdict = stopped.verdict
    assert verdict is not None
    where = frame_range(*(verdict.frames or stopped.span))
    return Suggestion(None, "Fit next.", f"{where} {reason(verdict)}", "track")


def _is_off(track: SegmentTrack) -> bool:
    return track.verdict is not None and track.verdict.cause == "body_off_surface"


def _about(track: SegmentTrack, keys: Sequence[int]) -> Suggestion:
    """A keyframe where it was lost or is in doubt; where one stands already, a look at it."""
    verdict, middle = track.verdict, (track.first + track.last) // 2
    assert verdict is not None
    frame = middle if verdict.go is None else verdict.go
    why = _THERE.get(verdict.cause, reason_with_frames(verdict, capital=True))
    if frame in keys:
        return Suggestion(frame, f"Look at key {frame} again.", why, "look", track.span)
    if verdict.kind == "lost":
        return Suggestion(frame, f"{add_keyframe(frame)}.", why, "key", track.span)
    return Suggestion(frame, f"Look at frame {frame}.", why, "look", track.span)


_THERE: Mapping[Cause, str] = {
    "not_followed": "The fit is lost there",
    "body_off_surface": "The body lies off its surface there",
}
"""Reasons beside a frame that is named already."""


def _doubtful(track: SegmentTrack) -> int:
    """How many frames are in doubt."""
    frames = None if track.verdict is None else track.verdict.frames
    first, last = frames or track.span
    return last - first
