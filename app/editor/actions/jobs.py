"""Long work: tracking, fitting, drafts and reduction to keyframes."""

from __future__ import annotations

from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, FiniteFloat, model_validator

from keypose.app.editor.actions.message import Coordinate, Message, Stroke
from keypose.tracker.body.body import Name
from keypose.tracker.session.settings import FrameIndex


class Track(Message):
    do: Literal["track"] = "track"
    what: Literal["this", "changed", "all"] = "changed"


class FitHere(Message):
    """The pose of the present frame improved from its picture."""

    do: Literal["fit_here"] = "fit_here"


class FitSizes(Message):
    """The body's sizes from the pictures of all keyframes; optionally the focal length too."""

    do: Literal["fit_sizes"] = "fit_sizes"
    focal: bool = False


class Draft(Message):
    """A pose for every frame, from a box around the person on one of them.

    box: left, top, right and bottom, pixels of the video.  first, last: of the frames to draft,
    those of the video where left out.
    """

    do: Literal["draft"] = "draft"
    frame: FrameIndex
    box: tuple[Coordinate, Coordinate, Coordinate, Coordinate]
    first: FrameIndex | None = None
    last: FrameIndex | None = None


class TrackAhead(Message):
    """The body followed on from the last keyframe, or back from the first."""

    do: Literal["track_ahead"] = "track_ahead"
    direction: Literal["forward", "backward"] = "forward"


class LookBefore(Message):
    """What stood before the last fit is shown, as long as `on`."""

    do: Literal["look_before"] = "look_before"
    on: bool


class PreviewPoses(Message):
    """New sizes are previewed with other poses, or with the poses as they are."""

    do: Literal["preview_poses"] = "preview_poses"
    on: bool


class ApplySizes(Message):
    """The previewed sizes are taken over."""

    do: Literal["apply_sizes"] = "apply_sizes"


class DiscardSizes(Message):
    """The previewed sizes are forgotten."""

    do: Literal["discard_sizes"] = "discard_sizes"


class Reduce(Message):
    """The motion as the fewest keyframes, as a preview.

    first, last: of the frames to reduce, those of the video where left out.  every: one keyframe in
    so many frames; else cm, px: a tolerance, at least one of them.  limbs: names of parts whose
    limbs are keyed alone.  replacing: whether keyframes that are there may go.  stroke: of the
    slider that is dragged, which changes nothing.
    """

    do: Literal["reduce"] = "reduce"
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    every: Annotated[int, Field(ge=1, le=10_000)] | None = None
    cm: Annotated[FiniteFloat, Field(ge=0.01, le=10_000)] | None = None
    px: Annotated[FiniteFloat, Field(ge=0.01, le=100_000)] | None = None
    limbs: Annotated[tuple[Name, ...], Field(max_length=1000)] = ()
    replacing: bool = False
    stroke: Stroke | None = None

    @model_validator(mode="after")
    def _has_one_goal(self) -> Self:
        if (self.every is None) == (self.cm is None and self.px is None):
            raise ValueError("a tolerance is needed, in cm or in px, or a number of frames")
        return self


class ApplyReduction(Message):
    """The previewed keyframes are taken over."""

    do: Literal["apply_reduction"] = "apply_reduction"


class DiscardReduction(Message):
    """The previewed keyframes are forgotten."""

    do: Literal["discard_reduction"] = "discard_reduction"


class CloseFit(Message):
    """What the last fit did has been read."""

    do: Literal["close_fit"] = "close_fit"


class Cancel(Message):
    do: Literal["cancel"] = "cancel"


Previewing: TypeAlias = PreviewPoses | ApplySizes | DiscardSizes
Reducing: TypeAlias = Reduce | ApplyReduction | DiscardReduction
Fitting: TypeAlias = FitHere | FitSizes | Draft | TrackAhead | LookBefore | CloseFit | Previewing
