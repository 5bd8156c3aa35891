"""What somebody may choose for a file that is imported. Light: nothing else is loaded with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

if TYPE_CHECKING:
    from keypose.tracker.formats.joint_motion import Unit, World

EVERY: Final = 24
"""Frames from one draft to the next, when none are named."""
LEAST_TRACKED: Final = 2
"""Keyframes; with fewer there is nothing between them that would be shown or tracked."""


@dataclass(frozen=True)
class MotionChoices:
    """How a recorded motion is read.

    names: our joints by the file's, in place of the usual ones; places: the same, beside these.
    offset_frames, offset_s: the video's frame or time at the file's time 0; one of them at most.
    unit, world, fps: in place of what the file says; `auto` scales it to the body.
    individual: which of several subjects.
    """

    names: Mapping[str, str] | None = None
    places: Mapping[str, str] = field(default_factory=dict)
    offset_frames: int | None = None
    offset_s: float | None = None
    unit: Unit | Literal["auto"] | None = None
    world: World | None = None
    fps: float | None = None
    individual: str | None = None


@dataclass(frozen=True)
class KeypointChoices:
    """How keypoints are read, and at which frames poses are drafted from them.

    layout: the order of the keypoints, where the file does not name them.
    places: places of the body by the file's names, beside those that are known.
    individual: which of several; exchange: left is right.
    offset_frames: the video's frame at the file's frame 0.
    frames: those to draft, or else one in `every`.
    """

    layout: str | None = None
    places: Mapping[str, str] = field(default_factory=dict)
    individual: str | None = None
    exchange: bool = False
    frames: Sequence[int] | None = None
    every: int | None = None
    offset_frames: int | None = None


@dataclass(frozen=True)
class CameraChoices:
    """A camera leaves nothing to choose."""


Choices: TypeAlias = MotionChoices | KeypointChoices | CameraChoices
