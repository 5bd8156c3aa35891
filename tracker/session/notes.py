"""Notes at frames: what a person wants to remember of a moment. Tracking never reads them."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated

from pydantic import Field

from keypose.tracker.session.settings import FrameIndex, Plain

LONGEST = 500
"""Characters of a note."""


class Note(Plain):
    """A note at one frame; without words a flag."""

    frame: FrameIndex
    text: Annotated[str, Field(max_length=LONGEST)] = Field(
        default="", description="What is to be remembered; empty for a mere flag."
    )


NoteList = Annotated[
    tuple[Note, ...],
    Field(
        default=(),
        exclude_if=operator.not_,
        description="Notes at frames, by frame, one a frame; left out where there are none.",
    ),
]


def require_notes(notes: Sequence[Note], frame_count: int) -> None:
    """ValueError in one sentence unless notes are sorted, one a frame, within the video."""
    for one, other in pairwise(notes):
        if one.frame == other.frame:
            raise ValueError(f"notes: frame {one.frame} has two notes; one is allowed")
        if one.frame > other.frame:
            raise ValueError(
                f"notes: frame {other.frame} stands after {one.frame}; sort them by frame"
            )
    if notes and notes[-1].frame >= frame_count:
        raise ValueError(
            f"notes: frame {notes[-1].frame} is beyond the video, whose frames are 0 to "
            f"{frame_count - 1}"
        )
