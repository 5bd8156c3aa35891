"""A problem in the page's words: as a sentence, as a reason beside its part, with its size."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from keypose.app.editor.problems import Problem, ProblemCause
from keypose.app.editor.verdict_text import (
    add_keyframe,
    frame_range,
    named_frames,
    reason_with_frames,
    short_sentence,
)
from keypose.app.posing import part_label
from keypose.tracker.errors import readable
from keypose.tracker.session.verdict import Verdict

PASSES: Final = "forward and backward passes differ"

_REASONS: Final[Mapping[ProblemCause, Callable[[Problem], str]]] = {
    "not_seen": lambda found: f"{_hidden(found)}, {frame_range(*found.frames)}",
    "uncertain": lambda _: PASSES,
    "not_followed": lambda _: PASSES,
    "diverged": lambda _: PASSES,
    "fast_motion": lambda _: "fast motion, blurred",
    "longest_interval": lambda found: f"longest interval, {_length(found)} frames",
    "drift": lambda found: f"most drift in {frame_range(*found.span)}",
}
_SENTENCES: Final[Mapping[ProblemCause, Callable[[Problem, str], str]]] = {
    "not_seen": lambda found, within: f"{_part(found)} {_hidden(found)}{within}",
    "uncertain": lambda found, within: f"{_part(found)} may be wrong{within}: {PASSES}",
    "not_followed": lambda found, _: f"Forward and backward differ in {frame_range(*found.span)}",
    "fast_motion": lambda found, _: f"Fast motion {frame_range(*found.frames)}",
    "longest_interval": lambda found, _: f"Longest interval, {_length(found)} frames",
    "drift": lambda found, _: f"Most drift in {frame_range(*found.span)}",
}


def reason_of(found: Problem) -> str:
    """Beside its part: "hidden behind the head, 83–92"."""
    reason = _REASONS.get(found.cause)
    return reason(found) if reason else reason_with_frames(_verdict(found))


def sentence_of(found: Problem) -> str:
    """By itself: "Left hand hidden behind the head, frames 83–92". The frames are left out where
    they are all of its segment."""
    sentence = _SENTENCES.get(found.cause)
    if sentence is None:
        return short_sentence(_verdict(found), *found.span)
    (first, last), (start, end) = found.frames, found.span
    return sentence(found, "" if first <= start + 1 and last >= end - 1 else _within(found))


def detail_of(found: Problem) -> str:
    """The same beside what to do, always with the frames it is about."""
    sentence = _SENTENCES.get(found.cause)
    if sentence is None:
        return reason_with_frames(_verdict(found), capital=True)
    return sentence(found, _within(found))


def todo_of(found: Problem) -> str:
    """What to do at its frame."""
    return add_keyframe(found.frame) if found.remedy == "key" else f"Go to {found.frame}"


def size_of(px: float | None, cm: float | None) -> str:
    """ "≈ 6.8 px · 3.2 cm", "≈ 14 px", "under 0.5 px"; empty where nobody knows."""
    if px is None:
        return ""
    if px < LEAST_PX:
        return f"under {LEAST_PX} px"
    lengths = [f"{_short(px)} px", *([] if cm is None else [f"{_short(cm)} cm"])]
    return f"≈ {' · '.join(lengths)}"


LEAST_PX: Final = 0.5


def _short(value: float) -> str:
    return f"{value:.1f}" if value < 9.95 else f"{value:.0f}"


def _hidden(found: Problem) -> str:
    if found.behind is not None:
        return f"hidden behind the {readable(found.behind)}"
    return "partly hidden" if found.partly else "hidden"


def _part(found: Problem) -> str:
    return part_label(found.part or "body")


def _within(found: Problem) -> str:
    return f", {named_frames(*found.frames)}"


def _length(found: Problem) -> int:
    return found.span[1] - found.span[0]


def _verdict(found: Problem) -> Verdict:
    """What verdicts have words for."""
    return Verdict.model_construct(
        kind=found.kind, cause=found.cause, part=found.part, frames=found.frames, go=found.frame,
        text=found.text,
    )  # fmt: skip
