"""The results in a session's file: where the motion is stored, and what was found."""

from __future__ import annotations

import operator
from typing import Annotated, Literal

from pydantic import Field, FiniteFloat

from keypose.tracker.session.pins import Pin
from keypose.tracker.session.settings import (
    FrameIndex,
    Initial,
    MethodName,
    Plain,
    Quality,
    TrackSettings,
    is_unknown,
)
from keypose.tracker.session.verdict import Verdict


class SegmentSummary(Plain):
    """What tracking found for the segment between two keyframes."""

    first_frame: FrameIndex
    last_frame: FrameIndex
    verdict: Verdict
    scores: tuple[FiniteFloat | None, ...] = Field(
        description="Score of the start and after every pass; null where nothing was seen."
    )
    best_pass: int
    closing_error: FiniteFloat | None = Field(
        description="Largest difference of the motion's ends from the keyframes, over entries of "
        "rotation matrices and metres; null when not finite."
    )
    notes: tuple[str, ...] = Field(
        default=(), description="What could not be done as wished, in sentences."
    )
    key: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")] | None = Field(
        default=None,
        description="SHA-256 of all that this segment's motion was tracked for; null when not "
        "known.",
    )
    quality: Quality | None = Field(
        default=None, description="This segment's own quality; null when it is that of all."
    )
    open_ends: tuple[FrameIndex, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="Its ends that had no keyframe, as those of surfaces may; left out where both "
        "had one.",
    )
    missing: Annotated[int, Field(ge=0)] = Field(
        default=0,
        exclude_if=operator.not_,
        description="Steps of the work that were not done, because it was stopped; left out where "
        "all is done.",
    )
    unreached: tuple[FrameIndex, FrameIndex] | None = Field(
        default=None,
        exclude_if=operator.not_,
        description="First and last frame that have no pose therefore; left out where all have.",
    )


class PinResult(Plain):
    """How well a pin holds in the motion."""

    part: str
    landmarks: tuple[str, ...] = Field(default=(), exclude_if=operator.not_)
    first_frame: FrameIndex
    last_frame: FrameIndex
    off_m: FiniteFloat = Field(description="Its point's greatest distance from its place, metres.")
    usual_off_m: FiniteFloat = Field(description="The median of that distance.")
    frame: FrameIndex = Field(description="Where it is greatest.")
    keyframe: FrameIndex | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="The exact keyframe that it contradicts most; left out where there is none.",
    )
    others: tuple[FrameIndex, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="Further exact keyframes that it contradicts, ascending; left out where there "
        "are none.",
    )


class SpaceFinding(Plain):
    """What is not plausible in space.

    slides: a foot that stands still moves by `amount` metres; off_floor, below_floor: it is so far
    above or below; keyframe_depth: at the keyframe `go` it stands so much nearer (negative) or
    farther than nearby; mirrored: at the keyframe `go` the limb from `part` on may point the other
    way in depth, its mirror image is `amount` metres nearer to a neighbouring keyframe; twisted: at
    the keyframe `go` it is turned about its own length by `amount` radians beyond what is allowed,
    signed; leans: the body is `amount` radians out of balance over its feet; shakes: `amount` m/s²,
    root mean square, at the waist; pulled: a pin of `part` moves its limb by `amount` pixels in the
    picture; bent: it bends the knee by `amount` radians beyond what was tracked; jumps: where it
    begins or ends, at `go`, the part is accelerated by `amount` m/s², which nothing shows.
    """

    kind: Literal[
        "slides",
        "off_floor",
        "below_floor",
        "keyframe_depth",
        "mirrored",
        "twisted",
        "leans",
        "shakes",
        "pulled",
        "bent",
        "jumps",
    ]
    part: str
    first_frame: FrameIndex
    last_frame: FrameIndex
    go: FrameIndex
    amount: FiniteFloat


class SpaceSummary(Plain):
    """What the last solve found, over neighbouring segments."""

    first_frame: FrameIndex
    last_frame: FrameIndex
    key: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")] = Field(
        description="SHA-256 of all that it was solved for."
    )
    pins: tuple[PinResult, ...] = ()
    proposed: tuple[Pin, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="Where feet seem to stand still, as pins that are not set.",
    )
    findings: tuple[SpaceFinding, ...] = Field(default=(), exclude_if=operator.not_)
    floor_m: FiniteFloat | None = Field(
        default=None, description="Height of the floor along up; null where no pin is on it."
    )


class Results(Plain):
    """Where the tracked motion is stored, and what was found."""

    tracks: Annotated[str, Field(pattern=r"^tracks-[0-9a-f]{12}\.npz$")] = Field(
        description="File of the trajectories, beside the session file."
    )
    method: MethodName
    quality: Quality
    initial: Initial | None = Field(
        default=None, description="Where segments started from; null: as the settings say."
    )
    left_out: tuple[str, ...] = ()
    segments: tuple[SegmentSummary, ...]
    space: tuple[SpaceSummary, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="Stretches whose motion was solved for in space; left out where none was.",
    )
    tracked_for: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")] | None = Field(
        default=None,
        description="SHA-256 of the body, the camera and the ignore masks that the motion was "
        "tracked with; null when not known.",
    )

    def settings_used(self, settings: TrackSettings) -> TrackSettings:
        """A session's settings with the method and the start of these results."""
        used = {"method": self.method, "initial": self.initial, "left_out": self.left_out}
        if self.initial is None:
            used = {"method": self.method}
        return settings.model_copy(update=used)
