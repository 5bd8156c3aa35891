"""Kinds of values a person can ask for; each is read from its text in one way at every door."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, ClassVar

from keypose.tracker.errors import FormatError

SMALLEST_SIDE = 16
LARGEST_SIDE = 8192
MOST_PIXELS = 20_000_000
"""Of a picture or film, pixels."""
_NUMBER = re.compile(r"[+-]?\d{1,7}(\.\d{0,20})?")
_LONGEST = 40
"""Letters of a wrong value that a sentence repeats."""


class Misread(FormatError):
    """A text that is no such value; its words are a clause without a full stop."""


@dataclass(frozen=True, eq=False, repr=False)
class Value:
    """A kind of value. metavar: its sign in the help of the command line; form: in the page."""

    metavar: str | None = None
    form: ClassVar[str] = "text"

    def read(self, text: str) -> Any:
        """The value; Misread where the text is none."""
        raise NotImplementedError

    def shape(self) -> dict[str, Any]:
        """What a form of the page has to know of it."""
        return {}


@dataclass(frozen=True, eq=False, repr=False)
class Number(Value):
    """A number from `least` to `most`. noun: what it is called where it is wrong; unit: may follow
    it."""

    least: float = -math.inf
    most: float = math.inf
    noun: str = ""
    unit: str = ""
    form: ClassVar[str] = "number"

    def read(self, text: str) -> float:
        number = text.strip().lower().removesuffix(self.unit.lower()).rstrip()
        value = float(number) if _NUMBER.fullmatch(number) else None
        if value is None or not self.least <= value <= self.most:
            noun = self.noun or f"a number from {self.least:g} to {self.most:g}"
            raise Misread(f"{text[:_LONGEST]!r} is not {noun}")
        return value

    def shape(self) -> dict[str, Any]:
        return {"least": self.least, "most": self.most, "unit": self.unit}


@dataclass(frozen=True, eq=False, repr=False)
class Whole(Value):
    """A whole number from `least` on, up to `most` where there is one."""

    least: int = 0
    most: int | None = None
    form: ClassVar[str] = "whole"

    def read(self, text: str) -> int:
        value = int(text) if re.fullmatch(r"\s*[+-]?\d{1,15}\s*", text) else self.least - 1
        if value < self.least or (self.most is not None and value > self.most):
            allowed = f"from {self.least} on" if self.most is None else None
            allowed = allowed or f"from {self.least} to {self.most}"
            raise Misread(f"{text[:_LONGEST]!r} is not a whole number {allowed}")
        return value

    def shape(self) -> dict[str, Any]:
        return {"least": self.least, "most": self.most}


@dataclass(frozen=True, eq=False, repr=False)
class Percent(Value):
    """A share in whole percent, as a number from 0 to 1."""

    metavar: str | None = "PERCENT"

    def read(self, text: str) -> float:
        return Whole(least=0, most=100).read(text) / 100


@dataclass(frozen=True, eq=False, repr=False)
class Rate(Value):
    """Frames a second, such as 25, 29.97 or 30000/1001."""

    metavar: str | None = "N"
    least: Fraction = Fraction(1, 10)
    most: int = 1000
    form: ClassVar[str] = "number"

    def read(self, text: str) -> Fraction:
        try:
            value = Fraction(text) if len(text) <= 16 and "e" not in text.lower() else Fraction(0)
        except (ValueError, ZeroDivisionError):
            value = Fraction(0)
        if not self.least <= value <= self.most:
            allowed = f"from {float(self.least):g} to {self.most} frames a second"
            raise Misread(f"{text[:_LONGEST]!r} is not a rate {allowed}")
        return value.limit_denominator(100_000)

    def shape(self) -> dict[str, Any]:
        return {"least": float(self.least), "most": self.most, "unit": "frames/s"}


@dataclass(frozen=True, eq=False, repr=False)
class Choice(Value):
    """One of some names. labels: what the page calls each; notes: what stands beside it there."""

    names: tuple[str, ...] = ()
    labels: Mapping[str, str] = field(default_factory=dict)
    notes: Mapping[str, str] = field(default_factory=dict)
    form: ClassVar[str] = "choice"

    def read(self, text: str) -> str:
        if text not in self.names:
            raise Misread(
                f"invalid choice: {text[:_LONGEST]!r} (choose from {', '.join(self.names)})"
            )
        return text

    def shape(self) -> dict[str, Any]:
        options = []
        for name in self.names:
            note = {"note": self.notes[name]} if name in self.notes else {}
            options.append({"id": name, "label": self.labels.get(name, name), **note})
        return {"options": options}


@dataclass(frozen=True, eq=False, repr=False)
class Switch(Value):
    """Off unless it is asked for. labels: what the page calls off and on."""

    labels: tuple[str, str] = ("Off", "On")
    form: ClassVar[str] = "switch"

    def read(self, text: str) -> bool:
        if text not in ("true", "false"):
            raise Misread(f"{text[:_LONGEST]!r} is neither true nor false")
        return text == "true"

    def shape(self) -> dict[str, Any]:
        return {"labels": list(self.labels)}


@dataclass(frozen=True, eq=False, repr=False)
class Name(Value):
    """A name of at most `most` letters."""

    most: int = 200

    def read(self, text: str) -> str:
        if not 0 < len(text) <= self.most:
            raise Misread(f"a name has 1 to {self.most} letters")
        return text


@dataclass(frozen=True, eq=False, repr=False)
class FrameRange(Value):
    """First and last frame, such as 10-60."""

    metavar: str | None = "A-B"
    form: ClassVar[str] = "range"

    def read(self, text: str) -> tuple[int, int]:
        found = re.fullmatch(r"(\d{1,9})[-–](\d{1,9})", text)
        if not found or int(found[1]) > int(found[2]):
            raise Misread(f"{text[:_LONGEST]!r} are no frames such as 10-60")
        return int(found[1]), int(found[2])


@dataclass(frozen=True, eq=False, repr=False)
class Frames(Value):
    """Frames with commas between, ascending, such as 0,24,48."""

    metavar: str | None = "N,N,…"
    most: int = 2000
    form: ClassVar[str] = "frames"

    def read(self, text: str) -> tuple[int, ...]:
        words = text.split(",")
        if len(words) > self.most or not all(re.fullmatch(r"\s*\d{1,9}\s*", w) for w in words):
            raise Misread(f"{text[:_LONGEST]!r} are no frames such as 0,24,48")
        return tuple(sorted({int(word) for word in words}))


@dataclass(frozen=True, eq=False, repr=False)
class Pixels(Value):
    """Width and height in pixels, such as 1920x1080."""

    metavar: str | None = "WxH"
    form: ClassVar[str] = "size"

    def read(self, text: str) -> tuple[int, int]:
        found = re.fullmatch(r"(\d{1,5})[x×X](\d{1,5})", text)
        sides = (int(found[1]), int(found[2])) if found else (0, 0)
        if not found or not SMALLEST_SIDE <= min(sides) <= max(sides) <= LARGEST_SIDE:
            raise Misread(
                f"{text[:_LONGEST]!r} is not a size such as 1920x1080, sides from {SMALLEST_SIDE} "
                f"to {LARGEST_SIDE} pixels"
            )
        if sides[0] * sides[1] > MOST_PIXELS:
            raise Misread(f"{text!r} has more than {MOST_PIXELS // 10**6} million pixels")
        return sides
