"""What is said of a segment, good, check or lost, and how frames and parts are named in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

DAMAGED = "damaged in the video"
"""Why frames are to be checked that nothing could be seen of, for their pictures are not sound."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """kind and words for a person; frames: first and last frame to look at, where there are any."""

    kind: Literal["good", "check", "lost"]
    words: str
    frames: tuple[int, int] | None = None


def spoken(name: str) -> str:
    """A part's name in a sentence."""
    return name.replace("_", " ")


def frames_in_words(first: int, last: int) -> str:
    """ "frames 31–36"."""
    return f"frame {first}" if first >= last else f"frames {first}–{last}"


def runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
