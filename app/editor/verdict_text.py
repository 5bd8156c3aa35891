"""A verdict in the page's words: what is wrong, at which frames, and what to do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from keypose.tracker.errors import readable
from keypose.tracker.session.verdict import Cause, Verdict

_REASONS: Final[Mapping[Cause, str]] = {
    "good": "good",
    "uncertain": "{part} may be wrong",
    "not_seen": "{part} hidden",
    "beyond_limits": "{part} beyond its joint limits",
    "diverged": "a pass diverged",
    "damaged": "{frames} damaged in the video",
    "no_surface": "no surface that can be used",
    "not_fitted": "not fitted yet",
    "one_keyframe": "fitted from one keyframe only so far",
    "keyframe_off_surface": "the keyframe is off its surface",
    "body_off_surface": "at key {first} the body is off its surface",
    "keyframe_off_keypoints": "at key {first} the {part} is not where it is seen",
    "moves_beside_body": "the body does not cover what moves",
    "not_followed": "lost near {first}",
    "nothing_seen": "the body is not visible: check keyframes, camera and masks",
    "contradiction": "keys {first} and {last} contradict each other",
}
_WITH_THEIR_FRAMES: Final = ("damaged", "body_off_surface", "keyframe_off_keypoints")
"""Causes to check whose reason says already which frames they are about."""


def sentence(verdict: Verdict, first: int, last: int) -> str:
    """Of the segment first … last: "Check: right hand hidden, frames 31–36"."""
    words = short_sentence(verdict, first, last)
    if verdict.cause == "not_followed" and verdict.go is not None:
        return f"{words}. {add_keyframe(verdict.go)}"
    if verdict.kind == "check" and verdict.cause != "other":
        return f"Check: {_checked(verdict, first, last)}"
    return words


def short_sentence(verdict: Verdict, first: int, last: int) -> str:
    """The same for places whose sign says "check", and whose button the keyframe to add: "Right
    hand hidden, frames 31–36", "Lost"."""
    if verdict.cause == "good":
        return "Good"
    if verdict.cause == "other":
        return reason(verdict, capital=True)
    if verdict.cause == "not_followed":
        return "Lost"
    if verdict.kind == "lost":
        return f"Lost. {reason(verdict, capital=True)}"
    return _checked(verdict, first, last, capital=True)


def _checked(verdict: Verdict, first: int, last: int, capital: bool = False) -> str:
    """Why, with the frames unless they are all."""
    is_all = verdict.frames is None or _is_all(verdict.frames, first, last)
    return reason(verdict, capital) if is_all else reason_with_frames(verdict, capital)


def reason(verdict: Verdict, capital: bool = False) -> str:
    """Why: "right hand hidden". capital: as the beginning of a sentence."""
    first, last = verdict.frames or (None, None)
    frames = _are(*verdict.frames) if verdict.frames else ""
    named = {"part": readable(verdict.part or ""), "first": first, "last": last, "frames": frames}
    is_other = verdict.cause == "other"
    words = verdict.text if is_other else _REASONS[verdict.cause].format(**named)
    return words[:1].upper() + words[1:] if capital else words


def reason_with_frames(verdict: Verdict, capital: bool = False) -> str:
    """ "right hand hidden, frames 31–36"."""
    words = reason(verdict, capital)
    if verdict.kind != "check" or verdict.frames is None:
        return words
    if verdict.cause == "other" or verdict.cause in _WITH_THEIR_FRAMES:
        return words
    return f"{words}, {named_frames(*verdict.frames)}"


def add_keyframe(frame: int) -> str:
    """What helps at a frame."""
    return f"Add a keyframe at {frame}"


def frame_range(first: int, last: int) -> str:
    """ "31–36", or "46" where it is one frame."""
    return str(first) if first >= last else f"{first}–{last}"


def named_frames(first: int, last: int) -> str:
    """ "frames 31–36", or "frame 46"."""
    return f"frame{'s' if first < last else ''} {frame_range(first, last)}"


def _are(first: int, last: int) -> str:
    return f"{named_frames(first, last)} {'are' if first < last else 'is'}"


def _is_all(frames: tuple[int, int], first: int, last: int) -> bool:
    """Whether frames are all that lie between the keyframes."""
    return frames[0] <= first + 1 and frames[1] >= last - 1
