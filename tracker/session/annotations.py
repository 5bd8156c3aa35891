"""Annotate frames: drafts, reviews, corrected keypoints, notes, and how far a body was followed."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Final, Literal, Self, TypeAlias

from pydantic import Field, FiniteFloat, model_validator

from keypose.tracker.body.body import Body, Name
from keypose.tracker.session.settings import FrameIndex, Pixel, Plain, Position, is_unknown

Reason: TypeAlias = Literal["start", "end", "pose", "residual", "hidden", "flip", "wrong", "person"]
"""Why a draft should be confirmed: the first or the last one of a stretch; a pose unlike those of
the other drafts to confirm; joints lie far from their keypoints; joints are hidden; a limb may
point toward the camera or away from it; a limb is wrong and has to be corrected; the person may be
another one from here on."""


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


class FlippedDrafts(FrameRun):
    """Drafts of which a limb is wrong: it neither lies on its keypoints nor follows from the drafts
    before and after."""

    parts: tuple[Name, ...] = Field(description="The upper part of each such limb.")


class DraftRest(Plain):
    """Frames that a draft was cancelled before: asked for, and not looked at."""

    frame: FrameIndex = Field(description="The frame of the box around the person.")
    box: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat] = Field(
        description="Left, top, right and bottom, pixels of the video."
    )
    frames: Annotated[tuple[FrameRun, ...], Field(min_length=1)]


class Drafted(Plain):
    """Of the frames that were drafted: those without a draft, the drafts to confirm, and those that
    are wrong."""

    first_frame: FrameIndex
    last_frame: FrameIndex
    up_camera: Position | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="What was known to be up then; left out where nobody knew.",
    )
    missing: tuple[FrameRun, ...] = Field(default=(), description="Frames where nobody was found.")
    places: tuple[DraftPlace, ...] = ()
    flipped: tuple[FlippedDrafts, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="Drafts that are known to be wrong, which become keyframes only once somebody "
        "has posed them; left out where there are none.",
    )
    rest: DraftRest | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="What is left to draft; left out where nothing is.",
    )


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
    keypoint_corrections: Sequence[KeypointCorrection], frame_count: int, width: int, height: int
) -> None:
    """ValueError in one sentence where corrections are not of this video, or two of one joint."""
    for keypoint_correction, following in pairwise(keypoint_corrections):
        if (keypoint_correction.frame, keypoint_correction.joint) >= (
            following.frame,
            following.joint,
        ):
            raise ValueError(
                f"keypoint_corrections: {following.joint} at frame {following.frame} stands after "
                f"{keypoint_correction.joint} at frame {keypoint_correction.frame}; "
                "sort them by frame and joint, each once"
            )
    for each in keypoint_corrections:
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
    """Tell whether a place lies in the picture, or beside it by less than its size: a limb may
    reach out of it.
    """
    return all(-size < at < 2 * size for at, size in zip(uv, (width, height), strict=True))


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
    for note, following in pairwise(notes):
        if note.frame == following.frame:
            raise ValueError(f"notes: frame {note.frame} has two notes; one is allowed")
        if note.frame > following.frame:
            raise ValueError(
                f"notes: frame {following.frame} stands after {note.frame}; sort them by frame"
            )
    if notes and notes[-1].frame >= frame_count:
        raise ValueError(
            f"notes: frame {notes[-1].frame} is beyond the video, whose frames are 0 to "
            f"{frame_count - 1}"
        )


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
