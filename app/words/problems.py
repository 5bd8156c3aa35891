"""Word the problems of a motion: verdicts, reasons with sizes, implausible space."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from keypose.app.posing.labels import part_label
from keypose.tracker.errors import readable
from keypose.tracker.formats.cause_words import CAUSE_WORDS, FOOT, PASSES
from keypose.tracker.review.problems import Problem
from keypose.tracker.session.results import PinResult, SpaceFinding
from keypose.tracker.session.verdict import Verdict

_WITH_THEIR_FRAMES: Final = ("damaged", "body_off_surface", "keyframe_off_keypoints")
"""Causes to check whose reason says already which frames they are about."""


def sentence(verdict: Verdict, first: int, last: int) -> str:
    """Word the verdict on the segment first … last: "Check: right hand hidden, frames 31–36"."""
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
    named = {
        "part": readable(verdict.part or "body"),
        "first": first,
        "last": last,
        "frames": frames,
    }
    is_other = verdict.cause == "other"
    words = verdict.text if is_other else CAUSE_WORDS[verdict.cause].shown.format(**named)
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


def repeats_words(count: int, frame_count: int) -> str:
    """Say how many frames of a film are copies."""
    return (
        f"{count} of {frame_count} frames repeat the one before. They do not count as standing "
        "still."
    )


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


def reason_of(problem: Problem) -> str:
    """Beside its part: "hidden behind the head, 83–92"."""
    words = CAUSE_WORDS[problem.cause].row if problem.cause != "other" else ""
    return _worded(words, problem) if words else reason_with_frames(_verdict(problem))


def sentence_of(problem: Problem) -> str:
    """Word a problem by itself: "Left hand hidden behind the head, frames 83–92". The frames are
    left out where they are all of its segment.
    """
    words = _alone(problem)
    if not words:
        return short_sentence(_verdict(problem), *problem.span)
    return _worded(
        words, problem, "" if _is_all(problem.frames, *problem.span) else _within(problem)
    )


def detail_of(problem: Problem) -> str:
    """The same beside what to do, always with the frames it is about."""
    words = _alone(problem)
    if not words:
        return reason_with_frames(_verdict(problem), capital=True)
    return _worded(words, problem, _within(problem))


def todo_of(problem: Problem) -> str:
    """What to do at its frame."""
    return add_keyframe(problem.frame) if problem.remedy == "key" else f"Go to {problem.frame}"


def size_of(px: float | None, cm: float | None) -> str:
    """ "≈ 6.8 px · 3.2 cm", "≈ 14 px", "under 0.5 px"; empty where nobody knows."""
    if px is None:
        return ""
    if px < LEAST_PX:
        return f"under {LEAST_PX} px"
    lengths = [f"{_short(px)} px", *([] if cm is None else [f"{_short(cm)} cm"])]
    return f"≈ {' · '.join(lengths)}"


def off_words(cm: float | None, px: float | None) -> str:
    """ "262 cm and 3.4 px"; without what nobody knows."""
    lengths = {"cm": cm, "px": px}
    return " and ".join(
        f"{_short(value)} {unit}" for unit, value in lengths.items() if value is not None
    )


LEAST_PX: Final = 0.5


def _short(value: float) -> str:
    return f"{value:.1f}" if value < 9.95 else f"{value:.0f}"


def _alone(problem: Problem) -> str:
    return "" if problem.cause == "other" else CAUSE_WORDS[problem.cause].alone


def _worded(words: str, problem: Problem, within: str = "") -> str:
    return words.format(
        Part=part_label(problem.part or "body"),
        hidden=_hidden(problem),
        differs=_differs(problem),
        range=frame_range(*problem.frames),
        span=frame_range(*problem.span),
        length=problem.span[1] - problem.span[0],
        within=within,
    )


def _hidden(problem: Problem) -> str:
    if problem.behind is not None:
        return f"hidden behind the {readable(problem.behind)}"
    return "partly hidden" if problem.partly else "hidden"


def _differs(problem: Problem) -> str:
    """From what a part in doubt differs: feet follow shins, and nothing is tracked of them."""
    return FOOT if (problem.part or "").endswith("_foot") else PASSES


def _within(problem: Problem) -> str:
    return f", {named_frames(*problem.frames)}"


def _verdict(problem: Problem) -> Verdict:
    """What verdicts have words for."""
    return Verdict.model_construct(
        kind=problem.kind,
        cause=problem.cause,
        part=problem.part,
        frames=problem.frames,
        go=problem.frame,
        text=problem.text,
    )


_SPACE_SENTENCES: Final[Mapping[str, str]] = {
    "slides": "{part} slides {cm} cm, {frames}",
    "off_floor": "{part} leaves the floor by {cm} cm, {frames}",
    "below_floor": "{part} goes {cm} cm into the floor, {frames}",
    "keyframe_depth": "At keyframe {go} {part} stands {cm} cm {way} than nearby",
    "mirrored": "At keyframe {go} {part} may point the wrong way in depth",
    "twisted": "At keyframe {go} {part} is turned {deg}° too far about its length",
    "leans": "The body leans {deg}° out of balance, {frames}",
    "shakes": "{part} shakes with {acceleration} m/s², {frames}",
    "pulled": "The pin of {the_part} moves it by {px} px in the picture, {frames}",
    "bent": "The pin of {the_part} bends the knee by {deg}°, which was not seen, {frames}",
    "jumps": "{part} jumps at {go}, where its pin begins or ends",
}


def space_sentence(space_finding: SpaceFinding) -> str:
    """Such as "Left foot slides 9 cm, 40–55"."""
    part = part_label(space_finding.part)
    the_part = f"the {part[:1].lower()}{part[1:]}"
    if space_finding.kind in ("keyframe_depth", "mirrored", "twisted"):
        part = the_part
    return _SPACE_SENTENCES[space_finding.kind].format(
        part=part,
        the_part=the_part,
        px=f"{space_finding.amount:.0f}",
        cm=_centimetres(space_finding.amount),
        frames=f"{space_finding.first_frame}–{space_finding.last_frame}",
        go=space_finding.go,
        way="nearer" if space_finding.amount < 0 else "farther away",
        deg=round(abs(math.degrees(space_finding.amount))),
        acceleration=f"{space_finding.amount:.0f}",
    )


def pin_sentence(pin: PinResult) -> str:
    """Such as "Keyframe 50 is 3 cm off the pin of the left foot"."""
    part = part_label(pin.part)
    return (
        f"Keyframe {pin.keyframe} is {_centimetres(pin.off_m)} cm off the pin of the "
        f"{part[:1].lower()}{part[1:]}"
    )


def _centimetres(metres: float) -> str:
    return f"{100 * abs(metres):.0f}"
