"""Annotate frames: what drafts found, what a person said of places, and keypoints set right."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Final, Literal, Self, TypeAlias

from pydantic import Field, FiniteFloat, model_validator

from keypose.tracker.body.body import Name
from keypose.tracker.session.settings import FrameIndex, Pixel, Plain

Reason: TypeAlias = Literal["start", "end", "residual", "hidden", "flip", "person"]
"""Why a draft should be confirmed: the first or the last one of a stretch; joints lie far from
their keypoints; joints are hidden; a limb may point toward the camera or away from it; the person
may be another one from here on."""


LEARN_FRAMES: Final = 60
"""Before and after a keyframe, in which drafts learn from it: of frames farther away it says
little."""


class FrameRun(Plain):
    """Frames one after the other."""

    first_frame: FrameIndex
    last_frame: FrameIndex

    @model_validator(mode="after")
    def _runs_forward(self) -> Self:
        if self.last_frame < self.first_frame:
            raise ValueError("last_frame must not be before first_frame")
        return self


class DraftPlace(Plain):
    """A draft to confirm as a keyframe."""

    frame: FrameIndex
    reason: Reason
    parts: tuple[Name, ...] = Field(
        default=(), description="Those it is about; none where it is all."
    )


class Drafted(Plain):
    """Of the frames that were drafted: those without a draft, and the drafts to confirm."""

    first_frame: FrameIndex
    last_frame: FrameIndex
    missing: tuple[FrameRun, ...] = Field(default=(), description="Frames where nobody was found.")
    places: tuple[DraftPlace, ...] = ()


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


class KeypointCorrection(Plain):
    """Where one joint is seen in one frame, as a person says, whatever a detector found there."""

    frame: FrameIndex
    joint: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,59}$")] = Field(
        description="Name of the keypoint, such as left_wrist."
    )
    uv: Pixel | None = Field(
        default=None,
        description="Where it is, in pixels of the video as it was filmed; null: not seen, what "
        "was found there does not count.",
    )


def require_corrections(
    given: Sequence[KeypointCorrection], frame_count: int, width: int, height: int
) -> None:
    """ValueError in one sentence where corrections are not of this video, or two of one joint."""
    for one, other in pairwise(given):
        if (one.frame, one.joint) >= (other.frame, other.joint):
            raise ValueError(
                f"keypoint_corrections: {other.joint} at frame {other.frame} stands after "
                f"{one.joint} at frame {one.frame}; sort them by frame and joint, each once"
            )
    for each in given:
        if each.frame >= frame_count:
            raise ValueError(
                f"keypoint_corrections: frame {each.frame} is beyond the video, whose frames are "
                f"0 to {frame_count - 1}"
            )
        if each.uv is not None and not _is_near(each.uv, width, height):
            u, v = each.uv
            raise ValueError(
                f"keypoint_corrections: {each.joint} at frame {each.frame} is at ({u:g}, {v:g}), "
                f"far outside the picture of {width}×{height}"
            )


def _is_near(uv: Pixel, width: int, height: int) -> bool:
    """In the picture, or beside it by less than its size: a limb may reach out of it."""
    return all(-size < at < 2 * size for at, size in zip(uv, (width, height), strict=True))
