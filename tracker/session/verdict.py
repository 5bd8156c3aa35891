"""The verdict on a segment, as facts only. Each interface makes its own sentences of them."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from typing import Annotated, Final, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from keypose.tracker.session.settings import FrameIndex, Plain

Kind: TypeAlias = Literal["good", "check", "lost"]
VERDICT_KINDS: Final[tuple[Kind, ...]] = ("good", "check", "lost")
WORST_FIRST: Final = VERDICT_KINDS[::-1]
Cause: TypeAlias = Literal[
    "good",
    "uncertain",
    "not_seen",
    "beyond_limits",
    "diverged",
    "damaged",
    "no_surface",
    "not_fitted",
    "one_keyframe",
    "keyframe_off_surface",
    "body_off_surface",
    "keyframe_off_keypoints",
    "moves_beside_body",
    "depth",
    "not_followed",
    "nothing_seen",
    "contradiction",
    "other",
]
CAUSES: Final = """\
good: nothing against it.
uncertain: the evidence about the part disagrees.
not_seen: the pictures, or the surfaces, do not show the part.
beyond_limits: the part is bent beyond its joint limits.
diverged: a pass diverged.
damaged: the frames are damaged in the video.
no_surface: the frames have no surface that can be used.
not_fitted: the fit was stopped before these frames.
one_keyframe: the fit was stopped before it came from the second keyframe.
keyframe_off_surface: the keyframe lies off the surface of its frame.
body_off_surface: the body was posed off the surface that moves with it.
keyframe_off_keypoints: at the keyframe the part, or all of the body, is not where keypoints are.
moves_beside_body: the body does not match the silhouette.
depth: right in the picture, but where the part points in depth is a guess.
not_followed: the body was lost; a keyframe is needed.
nothing_seen: nothing of the body is seen in the pictures.
contradiction: the neighbouring keyframes contradict each other.
other: none of these; `text` says what."""

_OF_A_PART: Final = ("uncertain", "not_seen", "beyond_limits", "depth")
_WITHOUT_A_PLACE: Final = ("good", "nothing_seen", "other")


def worst_of(kinds: Iterable[Kind | None]) -> Kind | None:
    """The worst verdict of several segments, some of which may have none; None where none has."""
    kinds_present = set(kinds)
    return next((kind for kind in WORST_FIRST if kind in kinds_present), None)


class Verdict(Plain):
    """Whether a segment can be trusted; if not, why, and where to look."""

    kind: Kind = Field(description="good, check (look at these frames) or lost.")
    cause: Cause = Field(description=CAUSES)
    part: Annotated[str, Field(min_length=1)] | None = Field(
        default=None, description="Name of the part it is about."
    )
    frames: tuple[FrameIndex, FrameIndex] | None = Field(
        default=None, description="First and last frame it is about."
    )
    go: FrameIndex | None = Field(
        default=None, description="The frame to go to: to look there, or to add a keyframe."
    )
    text: str = Field(
        default="",
        exclude_if=operator.not_,
        description="A sentence of somebody else's, where the cause is other; left out otherwise.",
    )

    @classmethod
    def check(cls, cause: Cause, frames: tuple[int, int], part: str | None = None) -> Self:
        """These frames are to be checked; the middle one is the one to go to."""
        middle = (frames[0] + frames[1] + 1) // 2
        return cls(kind="check", cause=cause, part=part, frames=frames, go=middle)

    @classmethod
    def not_followed(cls, frame: int) -> Self:
        """Lost, and a keyframe at this frame would help most."""
        return cls(kind="lost", cause="not_followed", frames=(frame, frame), go=frame)

    @classmethod
    def off_person(cls, keyframe: int) -> Self:
        """Lost, as the body of a keyframe is not on the person."""
        at = keyframe, keyframe
        return cls(kind="lost", cause="keyframe_off_keypoints", frames=at, go=keyframe)

    @classmethod
    def nothing_seen(cls, first: int, last: int) -> Self:
        """Lost from one keyframe to the other; no frame is better to look at than another."""
        return cls(kind="lost", cause="nothing_seen", frames=(first, last))

    @classmethod
    def contradiction(cls, first: int, last: int) -> Self:
        """Lost between neighbouring keyframes."""
        return cls(kind="lost", cause="contradiction", frames=(first, last), go=first)

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        if (self.kind == "good") != (self.cause == "good") and self.cause != "other":
            raise ValueError(f"the cause {self.cause} does not go with {self.kind}")
        if self.cause in _OF_A_PART and self.part is None:
            raise ValueError(f"the cause {self.cause} needs a part")
        if self.cause not in _WITHOUT_A_PLACE and (self.frames is None or self.go is None):
            raise ValueError(f"the cause {self.cause} needs frames and go")
        if self.frames is not None and self.frames[0] > self.frames[1]:
            raise ValueError("frames: the first must not be after the last")
        return self


GOOD: Final = Verdict(kind="good", cause="good")
