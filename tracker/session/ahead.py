"""How far the body was followed from one keyframe, and why no farther: plain data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Self, TypeAlias

from pydantic import Field, model_validator

from keypose.tracker.body.body import Body, Name
from keypose.tracker.session.settings import FrameIndex, Plain

Direction: TypeAlias = Literal["forward", "backward"]
StopCause: TypeAlias = Literal[
    "uncertain",
    "not_seen",
    "left_picture",
    "damaged",
    "cut",
    "keyframe",
    "clip_end",
    "limit",
    "cancelled",
]
"""Why following ended: the evidence about the part disagrees; the part is not seen; it leaves the
picture, or the body does; the next frames are damaged; another scene begins; the next keyframe, or
the video's end; so many frames are enough; somebody stopped it."""


class Stop(Plain):
    """Why a body was followed no farther."""

    cause: StopCause
    part: Name | None = Field(default=None, description="The part it is about, if it is about one.")
    behind: Name | None = Field(default=None, description="The part that hides it, if one does.")


class Ahead(Plain):
    """Frames over which the body was followed from a keyframe; their poses are drafts.

    `to_frame` lies before `from_frame` where it was followed backward.
    """

    from_frame: FrameIndex = Field(description="The keyframe.")
    to_frame: FrameIndex = Field(description="The last frame that can be trusted.")
    stop: Stop
    key: str = Field(
        default="",
        description="Digest of the keyframe's pose, the body and the camera it was followed with.",
    )

    @model_validator(mode="after")
    def _leads_somewhere(self) -> Self:
        if self.from_frame == self.to_frame:
            raise ValueError("to_frame must differ from from_frame")
        return self

    @property
    def span(self) -> tuple[int, int]:
        """First and last frame, the keyframe's included."""
        ends = self.from_frame, self.to_frame
        return min(ends), max(ends)

    @property
    def is_forward(self) -> bool:
        return self.to_frame > self.from_frame


def require_ahead(records: Sequence[Ahead], body: Body, frame_count: int) -> None:
    """ValueError in one sentence unless each lies in the video and names parts of the body."""
    for record in records:
        if record.span[1] >= frame_count:
            raise ValueError(
                f"ahead: frame {record.span[1]} lies beyond the video's last, {frame_count - 1}"
            )
        for name in (record.stop.part, record.stop.behind):
            if name is not None and name not in body.names:
                raise ValueError(f"ahead: the body has no part {name!r}")
