"""Set how one tracks; track, fit, draft and reduce."""

from __future__ import annotations

from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, FiniteFloat, model_validator

from keypose.app.editor.actions.message import Coordinate, Edit, Message, Metres, Spot, Stroke
from keypose.tracker.body.body import Name
from keypose.tracker.session.references import FramesPerSecond
from keypose.tracker.session.settings import (
    ALL_CUES,
    Cues,
    FrameIndex,
    MethodName,
    NetworkName,
    Quality,
    Units,
    UpAxis,
    Weights,
)

Polygon: TypeAlias = Annotated[tuple[Spot, ...], Field(min_length=3, max_length=500)]


class AddMask(Edit):
    do: Literal["add_mask"] = "add_mask"
    polygon: Polygon
    first: FrameIndex
    last: FrameIndex


class ChangeMask(Edit):
    do: Literal["change_mask"] = "change_mask"
    index: Annotated[int, Field(ge=0, le=10_000)]
    polygon: Polygon | None = None
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    note: Annotated[str, Field(max_length=200)] | None = None


class DeleteMask(Edit):
    do: Literal["delete_mask"] = "delete_mask"
    index: Annotated[int, Field(ge=0, le=10_000)]


class Settings(Edit):
    """Fields that are left out stay; `static_camera` may be given as null, as it was found, and
    `smooth`, not."""

    do: Literal["settings"] = "settings"
    method: MethodName | None = None
    quality: Quality | None = None
    static_camera: bool | None = None
    smooth: bool | None = None
    cues: Annotated[Cues, Field(max_length=len(ALL_CUES))] | None = None
    network: NetworkName | None = None


class Observe(Edit):
    """How observed surfaces are read and fitted. Fields that are left out stay; `model_frame` may
    be null, the first keyframe. about: the point, camera frame, that other axes turn about."""

    do: Literal["observe"] = "observe"
    units: Units | None = None
    up: UpAxis | None = None
    about: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.0)
    fps: Annotated[FiniteFloat, Field(ge=0.001, le=10_000)] | None = None
    model_frame: FrameIndex | None = None
    weights: Weights | None = None
    distance: Literal["plane", "point"] | None = None
    binding: Literal["nearest", "smooth"] | None = None


class ReadFilm(Edit):
    """How a film was taken. Fields that are left out stay; `recorded_fps` may be null, as its file
    says."""

    do: Literal["read_film"] = "read_film"
    recorded_fps: FramesPerSecond | None = None
    deinterlace: bool | None = None


Choosing: TypeAlias = AddMask | ChangeMask | DeleteMask | Settings | Observe | ReadFilm


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
