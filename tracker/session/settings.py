"""How a session is to be tracked: the settings, as plain validated data."""

from __future__ import annotations

import re
from typing import Annotated, Final, Literal, Self, TypeAlias

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    FiniteFloat,
    model_validator,
)

from keypose.tracker.errors import ID_PATTERN

_OF_OLDER_FILES: Final = {"linear": "auto", "both-ways": "auto", "fast": "full"}
"""Choices that are no more, and what files that name them mean now."""


def _as_now(choice: object) -> object:
    return _OF_OLDER_FILES.get(choice, choice) if isinstance(choice, str) else choice


FrameIndex: TypeAlias = Annotated[int, Field(ge=0, le=100_000_000)]
FARTHEST_M: Final = 1e5
"""Along each axis, of every pose however it is made."""
Metres: TypeAlias = Annotated[FiniteFloat, Field(ge=-FARTHEST_M, le=FARTHEST_M)]
Position: TypeAlias = tuple[Metres, Metres, Metres]
SceneId: TypeAlias = Annotated[str, Field(pattern=ID_PATTERN)]
Title: TypeAlias = Annotated[str, Field(max_length=120)]
Pixel: TypeAlias = tuple[FiniteFloat, FiniteFloat]
MethodName: TypeAlias = Literal["keypose", "paper"]
Quality: TypeAlias = Annotated[Literal["full", "preview"], BeforeValidator(_as_now)]
Weights: TypeAlias = Literal["both", "contact", "photo", "none"]
Units: TypeAlias = Literal["m", "dm", "cm", "mm", "in", "ft"]
UpAxis: TypeAlias = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
Cue: TypeAlias = Literal["brightness", "keypoints", "depth", "silhouette"]
Initial: TypeAlias = Annotated[Literal["auto", "templates", "import"], BeforeValidator(_as_now)]


def network_name(text: str) -> str:
    """A name that a network may have; ValueError where it is none."""
    if not re.fullmatch("[a-z0-9_-]{1,32}", text):
        raise ValueError("a network's name has 1 to 32 lower-case letters, digits, - and _")
    return text


NetworkName: TypeAlias = Annotated[str, AfterValidator(network_name)]
ALL_CUES: Final[tuple[Cue, ...]] = ("brightness", "keypoints", "depth", "silhouette")
LEADING_CUES: Final = frozenset({"brightness", "keypoints"})
"""Those that a motion is found from; the others need one of them."""


def _lead_to_a_motion(cues: tuple[Cue, ...]) -> tuple[Cue, ...]:
    if not LEADING_CUES & set(cues):
        raise ValueError(f"{cues[0]} finds no motion alone; add brightness or keypoints")
    return cues


Cues: TypeAlias = Annotated[tuple[Cue, ...], Field(min_length=1), AfterValidator(_lead_to_a_motion)]


def is_unknown(value: object) -> bool:
    """Whether a field is left out of files: `exclude_if`."""
    return value is None


class Plain(BaseModel):
    """Immutable plain data. Unknown fields are kept: another program may have written them."""

    model_config = ConfigDict(frozen=True, extra="allow")


class IgnoreMask(Plain):
    """A polygon, in pixels of the video, whose pixels are kept out over a range of frames."""

    polygon: Annotated[tuple[Pixel, ...], Field(min_length=3)]
    first_frame: FrameIndex
    last_frame: FrameIndex
    note: str = ""

    @model_validator(mode="after")
    def _runs_forward(self) -> Self:
        if self.last_frame < self.first_frame:
            raise ValueError("last_frame must not be before first_frame")
        return self


class TrackSettings(Plain):
    """How to track. The defaults are right for most videos."""

    method: MethodName = "keypose"
    quality: Quality = Field(default="full", description="How much work `keypose` does.")
    static_camera: bool | None = Field(
        default=None,
        description="The camera stands still: a background plate keeps foreign pixels out. Null: "
        "as it was found in the film, `video.stands_still`.",
    )
    find_camera: bool | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="Tracking without a page first finds how the camera moves, where that is not "
        "known and it does not stand still. Left out: not, as before.",
    )
    cues: Cues | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="What the motion between keyframes is found from: brightness, how it changes "
        "from frame to frame; keypoints, where a detector sees a person's joints; depth, how far "
        "these are from one another along the view, as a network lifts them from a second of "
        "keypoints; and silhouette, what moves before a camera that stands still, or else where a "
        "network sees the person, which shows where the body does not match it. Left out: "
        "brightness alone, as before there were others.",
    )
    network: NetworkName | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="The network that finds keypoints: thunder, which looks beside full; full "
        "alone, meant where this is left out; heavy, which is slower and has to be added; or one "
        "that a person added under this name.",
    )
    smooth: bool | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="The whole motion is made smooth in space, as bodies move, as far as the "
        "pictures allow. Left out: not, as before.",
    )
    passes: Annotated[int, Field(ge=1, le=50)] | None = Field(
        default=None, description="Passes over a segment; the method's own number when left out."
    )
    initial: Initial = Field(
        default="auto",
        description="Where a segment starts from: auto, whichever way scores best; templates, "
        "head, hands and feet followed by what they look like; import, the imported motion "
        "wherever it reaches.",
    )
    left_out: tuple[Annotated[str, Field(min_length=1)], ...] = Field(
        default=(), description="Names of parts that are not followed by templates."
    )

    @property
    def cues_used(self) -> tuple[Cue, ...]:
        """The cues, where none are named those of before."""
        return ("brightness",) if self.cues is None else self.cues

    @property
    def network_used(self) -> NetworkName:
        """The network, where none is named the one of before."""
        return self.network or "full"
