"""The tracker's verdict in the page's words: sentence case, bare frames, no range said twice."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal, TypeAlias

from tracker.tracking.diagnostics.verdict import DAMAGED

Kind: TypeAlias = Literal["good", "check", "lost"]
What: TypeAlias = Literal[
    "good",
    "hidden",
    "uncertain",
    "diverged",
    "off",
    "near",
    "nowhere",
    "contradiction",
    "damaged",
    "other",
]

_CHECK = re.compile(r"check frames? (\d+)(?:–(\d+))?: (.+)")
_NEAR = re.compile(r"lost: add a keyframe near (\d+)")
_CONTRADICTION = re.compile(r"lost: the keyframes at (\d+) and (\d+) contradict each other")
_NOWHERE = "lost: nothing of the body is seen"
_OFF = "the body lies off the surface that moves with it"
_REASONS: dict[str, What] = {"not seen": "hidden", "uncertain": "uncertain"}


@dataclass(frozen=True)
class Finding:
    """What a verdict says. frames: first and last frame to look at, where it names any."""

    kind: Kind
    what: What
    part: str = ""
    frames: tuple[int, int] | None = None
    told: str = ""

    @classmethod
    def of(cls, kind: Kind, told: str) -> Finding:
        """Read the tracker's words (see `verdict`), which are also those in a session's file."""
        if kind == "good":
            return cls("good", "good", told=told)
        if match := _CHECK.fullmatch(told):
            first, last = int(match[1]), int(match[2] or match[1])
            what, part = _reason(match[3])
            return cls(kind, what, part, (first, last), told)
        if match := _NEAR.fullmatch(told):
            return cls(kind, "near", "", (int(match[1]), int(match[1])), told)
        if match := _CONTRADICTION.fullmatch(told):
            return cls(kind, "contradiction", "", (int(match[1]), int(match[2])), told)
        return cls(kind, "nowhere" if told.startswith(_NOWHERE) else "other", told=told)

    @property
    def reason(self) -> str:
        """Why, without frames: "right hand hidden"."""
        if self.what in ("hidden", "uncertain"):
            return f"{self.part} {self.what}"
        if self.what == "diverged":
            return "a pass diverged"
        return self.told.partition(": ")[2] or self.told

    def sentence(self, first: int, last: int) -> str:
        """For the segment first … last: "Check: right hand hidden 31–36"."""
        if self.what == "good":
            return "Good"
        if self.what == "near" and self.frames is not None:
            return f"Lost. Key frame {self.frames[0]}"
        if self.what == "contradiction":
            return f"Lost. Keys {first} and {last} contradict each other"
        if self.what == "nowhere":
            return "Lost. Nothing of the body is seen: check keys, camera and masks"
        if self.what == "off" and self.frames is not None:
            return f"Check: at key {self.frames[0]} the body lies off its surface"
        if self.what == "damaged" and self.frames is not None:
            return f"Check: {damaged_in_words(*self.frames)}"
        sentence = f"{self.kind.capitalize()}: {self.reason}"
        if self.frames is None or _is_all(self.frames, first, last):
            return sentence
        return f"{sentence} {frames_in_words(*self.frames)}"

    @property
    def go(self) -> int | None:
        """The frame to go to and look."""
        if self.frames is None:
            return None
        if self.what == "contradiction":
            return self.frames[0]
        return (self.frames[0] + self.frames[1] + 1) // 2


def frames_in_words(first: int, last: int) -> str:
    """ "31–36", or "46" where it is one frame."""
    return str(first) if first >= last else f"{first}–{last}"


def damaged_in_words(first: int, last: int) -> str:
    """ "frames 31–60 are damaged in the video"."""
    if first >= last:
        return f"frame {first} is {DAMAGED}"
    return f"frames {first}–{last} are {DAMAGED}"


def _reason(text: str) -> tuple[What, str]:
    for ending, what in _REASONS.items():
        if text.endswith(f" {ending}"):
            return what, text.removesuffix(f" {ending}")
    named: dict[str, What] = {"a pass diverged": "diverged", _OFF: "off", DAMAGED: "damaged"}
    return named.get(text, "other"), ""


def _is_all(frames: tuple[int, int], first: int, last: int) -> bool:
    """Whether frames are all that lie between the keyframes."""
    return frames[0] <= first + 1 and frames[1] >= last - 1
