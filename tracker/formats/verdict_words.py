"""Verdicts in words, as files and the command line have them."""

from __future__ import annotations

from keypose.tracker.errors import readable
from keypose.tracker.formats.cause_words import CAUSE_WORDS
from keypose.tracker.session.verdict import Verdict


def verdict_words(verdict: Verdict) -> str:
    """ "good", "check frames 31–36: right hand not seen", "lost: add a keyframe near 37"."""
    if verdict.cause == "other":
        return verdict.text
    if verdict.cause == "good":
        return "good"
    first, last = verdict.frames or (None, None)
    named = {"part": readable(verdict.part or "body"), "first": first, "last": last}
    reason = CAUSE_WORDS[verdict.cause].file.format(**named)
    return f"{verdict.kind}{_at(verdict)}: {reason}"


def _at(verdict: Verdict) -> str:
    """ " frames 31–36" of what is to be checked."""
    if verdict.kind != "check" or verdict.frames is None:
        return ""
    first, last = verdict.frames
    return f" frame {first}" if first == last else f" frames {first}–{last}"
