"""Where the next keyframe helps most, and why, in the page's words."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

from keypose.app.editor.judged import Judged
from keypose.app.editor.problem_words import detail_of
from keypose.app.editor.problems import (
    Problem,
    blames_keys,
    is_past_mending,
    is_worth_a_keyframe,
    problem_of,
)
from keypose.app.editor.segment_evidence import gain, part_errors_px, possible_drift_px
from keypose.app.editor.verdict_text import add_keyframe, frame_range
from keypose.tracker.session.annotations import Direction
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
    ahead: tracking that way from the keyframes leads on; where this is about a frame, as well.
    """

    frame: int | None
    title: str
    detail: str
    kind: Literal["pose", "key", "track", "look", "good"]
    problem: Problem | None = None
    ahead: Direction | None = None


def suggestion(
    keys: Sequence[int], frame_count: int, fitting: Fitting, parts: Sequence[str] = (),
    known: Judged | None = None,
) -> Suggestion:  # fmt: skip
    """The one thing that helps most. keys: frames of the keyframes, ascending.

    fitting: the results of the present segments (Results.fitting); unfinished ones count as none.
    parts: names of the body's parts, so that what is hidden where tracking was lost can be named.
    known: the same with all that shows what is wrong with them.
    """
    if len(keys) < 2:
        return _first_poses(keys, frame_count)
    spans = list(pairwise(keys))
    done = {span: fitting[span] for span in spans if span in fitting and fitting[span].finished}
    known = known or Judged(done, parts)
    if len(done) == len(spans) and all(
        track.diagnostics.expected_gain is not None for track in done.values()
    ):
        return _by_gain(known, list(done.values())) or ALL_GOOD
    bad = [track for track in done.values() if track.kind != "good" and _is_open(known, track)]
    to_mend = [track for track in bad if not is_past_mending(track)]
    for kind in ("lost", "check"):
        found = [track for track in to_mend if track.kind == kind]
        if kind == "check" and len(done) < len(spans):
            break  # first everything is tracked, then it is made better
        if found:
            return _about(known, max(found, key=_need))
    if len(done) < len(spans):
        return _to_track([span for span in spans if span not in done])
    divided = _longest(spans)
    if divided is None and bad:
        return _about(known, max(bad, key=lambda track: (track.kind == "lost", _need(track))))
    return divided or ALL_GOOD


def _by_gain(known: Judged, tracks: Sequence[SegmentResult]) -> Suggestion | None:
    """The keyframe that is expected to mend most, of all segments; None where all is good.

    Where tracking was lost comes before what is to be checked: nobody knows how far off it is.
    What short intervals still show is the keyframes' own error: that much is not to be gained.
    """
    waiting = [track for track in tracks if _is_open(known, track)]
    bad = [track for track in waiting if track.kind != "good"]
    for kinds in (("lost",), WORST_FIRST):
        wrong = [track for track in bad if track.kind in kinds and blames_keys(track)]
        if wrong:
            return _about(known, max(wrong, key=_need))
        open_ones = [t for t in waiting if t.kind in kinds and not is_past_mending(t)]
        worth = [track for track in open_ones if is_worth_a_keyframe(known, track)]
        if worth:
            return _about(known, max(worth, key=lambda track: _gains_by(known, track)))
    if bad:
        return _about(known, max(bad, key=lambda track: (track.kind == "lost", _need(track))))
    return None


def _gains_by(known: Judged, track: SegmentResult) -> tuple[float, float, float]:
    """How much a keyframe would mend: by the joint that is farthest off where joints are observed,
    else by what may have drifted."""
    found = problem_of(known, track)
    has_parts = part_errors_px(track) is not None
    px = found.px if has_parts and found is not None and found.px is not None else 0.0
    return px, float(possible_drift_px(track).sum()), gain(track)


def _is_open(known: Judged, track: SegmentResult) -> bool:
    """Whether something is wrong with a segment to which nobody has said anything yet."""
    found = problem_of(known, track)
    return found is not None and found.answer is None


def _about(known: Judged, track: SegmentResult) -> Suggestion:
    """What a segment needs."""
    found = problem_of(known, track)
    assert found is not None
    frame, why = found.frame, detail_of(found)
    if found.remedy == "keyframe":
        return Suggestion(frame, f"Check keyframe {frame}", why, "look", found)
    if found.remedy == "key":
        return Suggestion(frame, add_keyframe(frame), why, "key", found)
    return Suggestion(frame, f"Check frame {frame} and move on", why, "look", found)


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


def _to_track(spans: Sequence[Span]) -> Suggestion:
    return segments_need(spans, "tracking")


def segments_need(spans: Sequence[Span], what: str) -> Suggestion:
    """ "4 segments need tracking", and the first of them."""
    count = len(spans)
    title = f"1 segment needs {what}" if count == 1 else f"{count} segments need {what}"
    named = [frame_range(*span) for span in spans[:2]]
    more = f"{', '.join(named)} and {count - 2} more" if count > 2 else " and ".join(named)
    return Suggestion(None, title, f"Frames {more}", "track")


ALL_GOOD = Suggestion(None, "All good", "Add a keyframe only where the motion looks wrong", "good")
