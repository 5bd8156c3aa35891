"""Verdicts in words: the reason of each cause, once, for files, command line and page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from keypose.tracker.errors import readable
from keypose.tracker.session.verdict import Cause, Verdict

REASONS: Final[Mapping[Cause, str]] = {
    "uncertain": "{part} uncertain",
    "not_seen": "{part} not seen",
    "beyond_limits": "{part} beyond its joint limits",
    "diverged": "a pass diverged",
    "damaged": "damaged in the video",
    "no_surface": "no surface that can be used",
    "not_fitted": "not fitted yet",
    "one_keyframe": "fitted from one keyframe only so far",
    "keyframe_off_surface": "the keyframe lies off its surface",
    "body_off_surface": "the body lies off the surface that moves with it",
    "keyframe_off_keypoints": "the keyframe's {part} is not where it is seen",
    "moves_beside_body": "the body does not match the silhouette",
    "depth": "{part} a guess in depth",
    "not_followed": "add a keyframe near {first}",
    "nothing_seen": "nothing of the body is seen; check keyframes, camera and masks",
    "contradiction": "the keyframes at {first} and {last} contradict each other",
}


def verdict_words(verdict: Verdict) -> str:
    """ "good", "check frames 31–36: right hand not seen", "lost: add a keyframe near 37"."""
    if verdict.cause == "other":
        return verdict.text
    if verdict.cause == "good":
        return "good"
    first, last = verdict.frames or (None, None)
    named = {"part": readable(verdict.part or "body"), "first": first, "last": last}
    reason = REASONS[verdict.cause].format(**named)
    return f"{verdict.kind}{_at(verdict)}: {reason}"


def _at(verdict: Verdict) -> str:
    """ " frames 31–36" of what is to be checked."""
    if verdict.kind != "check" or verdict.frames is None:
        return ""
    first, last = verdict.frames
    return f" frame {first}" if first == last else f" frames {first}–{last}"
