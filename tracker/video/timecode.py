"""Timecode: the clock of a shoot, by which editing programs find a frame.  SMPTE ST 12-1

A frame is written as HH:MM:SS:FF. Where the rate is 30/1.001 or 60/1.001 frames a second, a
semicolon before FF says that numbers are dropped: 2 or 4 of them at every minute but each tenth, so
that the timecode keeps to the clock.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

_TIMECODE = re.compile(r"([01]\d|2[0-3]):([0-5]\d):([0-5]\d)([:;.,])(\d{2,3})", re.ASCII)
_TAG = "timecode"
_MINUTES = 24 * 60


@dataclass(frozen=True)
class Timecode:
    """A film's timecode.

    rate: numbers of frames in a second, the film's rate rounded.
    number: of the film's first frame, since midnight.
    mark: what stands before the frame; anything but a colon says that numbers are dropped.
    of_files: the film is image files, and `number` is that in the name of the first.
    """

    rate: int
    number: int
    mark: str = ":"
    of_files: bool = False

    @classmethod
    def read(cls, text: str, fps: float) -> Self | None:
        """The timecode of a first frame; None where the text is none of this rate."""
        found, rate = _TIMECODE.fullmatch(text.strip()), round(fps)
        if found is None or int(found[5]) >= rate:
            return None
        hours, minutes, seconds, frame = (int(found[k]) for k in (1, 2, 3, 5))
        minutes += 60 * hours
        number = (60 * minutes + seconds) * rate + frame
        dropped = _dropped(rate, found[4])
        return cls(rate, number - dropped * (minutes - minutes // 10), found[4])

    @classmethod
    def of_numbers(cls, numbers: Sequence[int | None], fps: float) -> Self | None:
        """The timecode of image files by the numbers in their names, frame 0 of which is midnight;
        None unless these are consecutive and within a day."""
        first, rate = numbers[0], round(fps)
        if first is None or len(numbers) < 2 or first + len(numbers) > 60 * _MINUTES * rate:
            return None
        if any(number != first + n for n, number in enumerate(numbers)):
            return None
        return cls(rate, first, of_files=True)

    def at(self, frame: int) -> str:
        """Of a frame of the film; a day has 24 hours."""
        dropped = _dropped(self.rate, self.mark)
        minute, tens = 60 * self.rate - dropped, 600 * self.rate - 9 * dropped
        number = (self.number + frame) % (_MINUTES // 10 * tens)
        whole, rest = divmod(number, tens)
        number += dropped * (9 * whole + max(0, (rest - dropped) // minute))
        seconds, shown = divmod(number, self.rate)
        clock = f"{seconds // 3600:02}:{seconds // 60 % 60:02}:{seconds % 60:02}"
        return f"{clock}{self.mark}{shown:02}"

    def __str__(self) -> str:
        return self.at(0)


def timecode_in(tags: Iterable[Mapping[str, str]], fps: float) -> Timecode | None:
    """The timecode that tags of a file give for its first frame; None where none do."""
    texts = (value for some in tags for key, value in some.items() if key.casefold() == _TAG)
    return next((code for text in texts if (code := Timecode.read(text, fps)) is not None), None)


def _dropped(rate: int, mark: str) -> int:
    """How many numbers a minute drops, but for every tenth."""
    return 0 if mark == ":" else 2 * round(rate / 30)
