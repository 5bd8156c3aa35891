"""Where the next keyframe helps most, and why, in the page's words."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from app.editor.verdict_text import add_keyframe, frame_range, reason, reason_with_frames
from tracker.geometry.rotations import Array, log_rotation, transpose
from tracker.session.ahead import Direction
from tracker.session.verdict import Verdict
from tracker.storage.results import Span
from tracker.tracking.diagnostics.expected_gain import MENDED
from tracker.tracking.result import SegmentResult

NEXT_FRAMES = 24
"""A good first distance of keyframes: about a second."""
LONG_FRAMES = 32
"""Past this length, fast motion is lost in half of all segments."""
SHORT_FRAMES, SHORT_HIDDEN_FRAMES = 4, 6
"""Intervals up to these lengths gain nothing from one keyframe more. What is hidden, whoever sets
the keyframe does not see either."""
HIDDEN, HIDDEN_FRAMES = 0.15, 3
"""As in the verdict: a part below this observability, for so many frames, is not seen."""

WORTH_PX = 0.6
"""What a keyframe must be expected to mend, in the mean over a segment that is good."""
KEYED_FRAMES = 8
"""What is expected to be mended in intervals up to this length is mostly the keyframes' own error,
which no keyframe more takes away."""
OWN_PX = 0.2
"""How much a motion can be expected to stray with every frame from the nearer keyframe. What seems
to be more is a keyframe's own error, and one more beside it would not mend it."""
FAST, FAST_DEG, FAST_SHARE = 1.5, 2.0, 0.6
"""Motion is fast where a part turns more than so many times the segment's mean, and more than so
many degrees a frame; and worth a word where that is less than this share of the segment."""
ROOT_LEVER_M = 0.3
"""The lever at which a turn of the root moves the body as far as a shift does."""

Fitting = Mapping[Span, SegmentResult]


@dataclass(frozen=True)
class Suggestion:
    """What to do next. title: what; detail: why, may be empty. Neither has a full stop at its end.

    kind: "pose" a frame and press K; "key" set the keyframe `frame`; "track" what is not tracked as
    it is posed now; "look" at `frame`, where keyframes themselves are wrong or no keyframe more
    would help; "good" nothing.
    ahead: tracking that way from the keyframes leads on.
    """

    frame: int | None
    title: str
    detail: str
    kind: Literal["pose", "key", "track", "look", "good"]
    ahead: Direction | None = None


def suggestion(
    keys: Sequence[int], frame_count: int, fitting: Fitting, parts: Sequence[str] = ()
) -> Suggestion:
    """The one thing that helps most. keys: frames of the keyframes, ascending.

    fitting: the results of the present segments (Results.fitting); unfinished ones count as none.
    parts: names of the body's parts, so that what is hidden where tracking was lost can be named.
    """
    if len(keys) < 2:
        return _first_poses(keys, frame_count)
    spans = list(pairwise(keys))
    done = {span: fitting[span] for span in spans if span in fitting and fitting[span].finished}
    if len(done) == len(spans) and all(
        track.diagnostics.expected_gain is not None for track in done.values()
    ):
        return _by_gain(list(done.values()), parts) or _all_good(keys, frame_count)
    bad = [track for track in done.values() if track.kind != "good"]
    to_mend = [track for track in bad if not _is_past_mending(track)]
    for kind in ("lost", "check"):
        found = [track for track in to_mend if track.kind == kind]
        if kind == "check" and len(done) < len(spans):
            break  # first everything is tracked, then it is made better
        if found:
            return _about(max(found, key=_need), parts)
    if len(done) < len(spans):
        return _to_track([span for span in spans if span not in done])
    divided = _longest(spans)
    if divided is None and bad:
        return _look(max(bad, key=lambda track: (track.kind == "lost", _need(track))), parts)
    return divided or _all_good(keys, frame_count)


def _by_gain(tracks: Sequence[SegmentResult], parts: Sequence[str]) -> Suggestion | None:
    """The keyframe that is expected to mend most, of all segments; None where all is good.

    What short intervals still show is the keyframes' own error: that much is not to be gained.
    """
    wrong = [track for track in tracks if track.kind != "good" and _blames_keys(track)]
    if wrong:
        return _about(max(wrong, key=_need), parts)
    short = [_gain(track) for track in tracks if track.last - track.first <= KEYED_FRAMES]
    floor = float(np.median(short)) if short else 0.0
    open_ = [track for track in tracks if not _is_past_mending(track)]
    worth = [t for t in open_ if t.kind == "lost" or _gain(t) > floor + WORTH_PX]
    if worth:
        best = max(worth, key=lambda track: (float(_possible_drift_px(track).sum()), _gain(track)))
        return _key_where_it_gains(best, parts, tracks)
    bad = [track for track in tracks if track.kind != "good"]
    if bad:
        return _look(max(bad, key=lambda track: (track.kind == "lost", _need(track))), parts)
    return None


def _gain(track: SegmentResult) -> float:
    """Pixels that the best keyframe in a segment is expected to mend, in the mean over it."""
    return float(_expected_gain(track).max() / (track.last - track.first))


def _expected_gain(track: SegmentResult) -> Array:
    """(n + 1,) pixels that a keyframe at each frame would mend; asked only where it is known."""
    gain = track.diagnostics.expected_gain
    assert gain is not None
    return gain


def _possible_drift_px(track: SegmentResult) -> Array:
    """(n + 1,) pixels by which the motion may be off without the keyframes' own errors."""
    gain = _expected_gain(track)
    away = np.arange(len(gain))
    most = OWN_PX * np.minimum(away, away[::-1])
    whole = float(gain.sum())
    if whole <= 0:
        return most
    return np.minimum(gain * (float(gain.max()) / MENDED / whole), most)


def _key_where_it_gains(
    track: SegmentResult, parts: Sequence[str], tracks: Sequence[SegmentResult]
) -> Suggestion:
    frame = track.first + int(_possible_drift_px(track).argmax())
    frame = min(max(frame, track.first + 1), track.last - 1)
    verdict = track.verdict
    if verdict is not None and verdict.kind != "good" and _is_about(verdict, frame):
        return _by_verdict(frame, add_keyframe(frame), track, verdict, parts, "key")
    return _add_keyframe(frame, _why(track, frame, tracks))


def _add_keyframe(frame: int, why: str) -> Suggestion:
    return Suggestion(frame, add_keyframe(frame), why, "key")


def _is_about(verdict: Verdict, frame: int) -> bool:
    """Whether a verdict says why a frame needs a keyframe; one on a part speaks of its frames."""
    if verdict.part is None or verdict.frames is None:
        return True
    return verdict.frames[0] <= frame <= verdict.frames[1]


def _why(track: SegmentResult, frame: int, tracks: Sequence[SegmentResult]) -> str:
    """What is seen of the motion that makes a keyframe needed there."""
    length = track.last - track.first
    fast = _fast_about(track, frame)
    if fast is not None:
        return f"Fast motion {frame_range(*fast)}"
    lengths = [other.last - other.first for other in tracks]
    if min(lengths) < length == max(lengths):
        return f"Longest interval, {length} frames"
    return f"Most drift in {frame_range(track.first, track.last)}"


def _fast_about(track: SegmentResult, frame: int) -> Span | None:
    """The run of fast frames that a frame lies in, where it stands out of its segment."""
    path = track.trajectory
    Rs, ps = path.Rs_parent_part, path.ps_camera_root
    turned = np.linalg.norm(log_rotation(transpose(Rs[:-1]) @ Rs[1:]), axis=-1).max(axis=1)
    shifted = np.linalg.norm(np.diff(ps, axis=0), axis=1) / ROOT_LEVER_M
    speed = np.rad2deg(np.maximum(turned, shifted))
    fast = speed > max(FAST * speed.mean(), FAST_DEG)
    step = min(frame - track.first, len(speed) - 1)
    if not fast[step] or fast.mean() > FAST_SHARE:
        return None
    slow = np.flatnonzero(~fast)
    first = int(slow[slow < step].max(initial=-1)) + 1
    last = int(slow[slow > step].min(initial=len(speed)))
    return track.first + first, track.first + last


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


def _about(track: SegmentResult, parts: Sequence[str]) -> Suggestion:
    """What a segment that is lost, or to be checked, needs."""
    verdict, (first, last) = track.verdict, track.span
    assert verdict is not None
    if _blames_keys(track):
        frame = first if verdict.go is None else verdict.go
        why = reason(verdict, capital=True)
        return Suggestion(frame, f"Check keyframe {frame}", why, "look")
    frame = (first + last) // 2 if verdict.go is None else verdict.go
    frame = min(max(frame, first + 1), last - 1)
    return _by_verdict(frame, add_keyframe(frame), track, verdict, parts, "key")


def _blames_keys(track: SegmentResult) -> bool:
    """Whether keyframes themselves are wrong, not what lies between them."""
    verdict = track.verdict
    wrong = verdict is not None and verdict.cause in ("contradiction", "nothing_seen")
    return wrong or (track.kind == "lost" and track.last - track.first < 2)


def _is_past_mending(track: SegmentResult) -> bool:
    """Whether the interval is too short for a keyframe to help: it would be halved for ever."""
    hidden = track.verdict is not None and track.verdict.cause == "not_seen"
    short = SHORT_HIDDEN_FRAMES if hidden else SHORT_FRAMES
    return not _blames_keys(track) and track.last - track.first <= short


def _look(track: SegmentResult, parts: Sequence[str]) -> Suggestion:
    """Nothing but to look at a segment, and to be content where it is right."""
    verdict = track.verdict
    assert verdict is not None
    frame = (track.first + track.last) // 2 if verdict.go is None else verdict.go
    return _by_verdict(frame, f"Check frame {frame} and move on", track, verdict, parts, "look")


def _need(track: SegmentResult) -> int:
    """How many frames a keyframe there would mend: those in doubt, or all that are lost."""
    verdict = track.verdict
    if verdict is not None and verdict.kind == "check" and verdict.frames is not None:
        return verdict.frames[1] - verdict.frames[0]
    return track.last - track.first


def _by_verdict(
    frame: int, title: str, track: SegmentResult, verdict: Verdict, parts: Sequence[str],
    kind: Literal["key", "look"],
) -> Suggestion:  # fmt: skip
    """With the verdict's reason; where tracking was lost, with what made it so."""
    if verdict.cause == "not_followed":
        differ = f"Forward and backward differ in {frame_range(*track.span)}"
        why = _longest_hidden(track, parts) or differ
        return Suggestion(frame, title, why, kind)
    return Suggestion(frame, title, reason_with_frames(verdict, capital=True), kind)


def _longest_hidden(track: SegmentResult, parts: Sequence[str]) -> str | None:
    """The part that goes unseen for the longest run of frames, in words."""
    runs = []
    for name, column in zip(parts, track.diagnostics.observability.T, strict=False):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], column < HIDDEN, [0]])))
        runs += [(b - a, a, name) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    length, start, name = max(runs, default=(0, 0, ""))
    if length < HIDDEN_FRAMES:
        return None
    first = track.first + 1 + int(start)
    last = min(first + int(length) - 1, track.last - 1)
    return reason_with_frames(Verdict.check("not_seen", (first, last), name), capital=True)


def _longest(spans: list[Span]) -> Suggestion | None:
    first, last = max(spans, key=lambda span: span[1] - span[0])
    if last - first <= LONG_FRAMES:
        return None
    return _add_keyframe((first + last) // 2, f"Longest interval, {last - first} frames")


def _all_good(keys: Sequence[int], frame_count: int) -> Suggestion:
    outside = [(0, keys[0] - 1), (keys[-1] + 1, frame_count - 1)]
    left = [frame_range(*frames) for frames in outside if frames[1] >= frames[0]]
    more = f". Outside the keyframes: {' and '.join(left)}" if left else ""
    return Suggestion(None, ALL_GOOD, f"{WHERE_WRONG}{more}", "good")


ALL_GOOD = "All good"
WHERE_WRONG = "Add a keyframe only where the motion looks wrong"
