"""What a person said of a place of the tracked motion, kept so that nobody is asked again."""

from __future__ import annotations

import operator
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, FiniteFloat, model_validator

from keypose.tracker.body.body import Name
from keypose.tracker.session.settings import FrameIndex, Plain

Answer: TypeAlias = Literal["accepted", "unclear"]


class Reviewed(Plain):
    """An answer about a part in some frames of the motion, given where it was looked at: at
    `frame`. It counts as long as the part lies there as it was seen."""

    part: Name
    frame: FrameIndex
    first_frame: FrameIndex
    last_frame: FrameIndex
    answer: Answer = Field(description="accepted: it is right; unclear: the picture cannot tell.")
    seen_m: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = Field(
        description="Where the part's far end lay, camera frame, metres."
    )

    @model_validator(mode="after")
    def _runs_forward(self) -> Self:
        if not self.first_frame <= self.frame <= self.last_frame:
            raise ValueError("reviewed: frame must lie between first_frame and last_frame")
        return self


ReviewedList = Annotated[
    tuple[Reviewed, ...],
    Field(
        default=(),
        exclude_if=operator.not_,
        description="Places of the motion that a person has reviewed; left out where there are "
        "none.",
    ),
]
