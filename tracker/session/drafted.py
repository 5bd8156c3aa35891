"""What the drafts of a film found besides poses: plain data, which stays until they are undone."""

from __future__ import annotations

from typing import Final, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from keypose.tracker.body.body import Name
from keypose.tracker.session.settings import FrameIndex, Plain

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
