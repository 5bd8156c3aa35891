"""Orders of pictures and films of the body."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, Literal, TypeAlias

from keypose.app.orders.order import option
from keypose.app.orders.values import (
    Choice,
    FrameRange,
    Misread,
    Number,
    Percent,
    Pixels,
    Rate,
    Switch,
    Value,
    Whole,
)

Style: TypeAlias = Literal["wire", "solid", "both"]
Tint: TypeAlias = Literal["clay", "contact", "photo", "distance"]
View: TypeAlias = Literal["main", "top", "side", "front", "all"]
Background: TypeAlias = Literal["video", "none"]
MatteKind: TypeAlias = Literal["png", "webm", "mov"]
FilmView: TypeAlias = "View | Viewpoint | Literal['orbit']"
Size: TypeAlias = tuple[int, int]
"""Width and height, pixels."""

VIEWS: Final = ("main", "top", "side", "front", "all")
_LABELS: Final = {
    "main": "Camera",
    "all": "All four views",
    "top": "Top",
    "side": "Side",
    "front": "Front",
    "orbit": "Once round the body",
}
_STYLES: Final = {"wire": "Wire", "solid": "Solid", "both": "Both"}
ELEVATION_DEG: Final = 12.0
"""A little above, so that the floor is seen to lie."""


@dataclass(frozen=True)
class Viewpoint:
    """Where a camera stands about the body. distance_m None: as near as all of it is seen."""

    azimuth_deg: float = 0.0
    elevation_deg: float = ELEVATION_DEG
    distance_m: float | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Seen(Value):
    """A view by its name, or from a viewpoint that is written as `how` says."""

    metavar: str | None = "VIEW"
    names: tuple[str, ...] = VIEWS
    form = "view"

    def read(self, text: str) -> View | Viewpoint | Literal["orbit"]:
        if text in self.names:
            return text  # type: ignore[return-value]
        return _viewpoint(text, self.names)

    def shape(self) -> dict[str, object]:
        return {"options": [{"id": name, "label": _LABELS[name]} for name in self.names]}


def _viewpoint(text: str, names: tuple[str, ...]) -> Viewpoint:
    """orbit:AZIMUTH[,ELEVATION], which no film has, or camera:AZIMUTH,ELEVATION[,METRES]."""
    kind, _, numbers_text = text.partition(":")
    number = re.compile(r"[+-]?\d{1,6}(\.\d{0,9})?")
    numbers = [float(word) for word in numbers_text.split(",") if number.fullmatch(word)]
    least, most = {"orbit": (1, 2), "camera": (2, 3)}.get(kind, (1, 0))
    if len(numbers) != numbers_text.count(",") + 1 or not least <= len(numbers) <= most:
        how = "camera" if "orbit" in names else "orbit"
        views = ", ".join((*names, f"{how}:AZIMUTH,ELEVATION in degrees"))
        raise Misread(f"{text[:40]!r} is not a view; choose {views}")
    azimuth, elevation = math.fmod(numbers[0], 360.0), [*numbers, ELEVATION_DEG][1]
    if abs(elevation) > 90:
        raise Misread(f"{text!r}: an elevation is from -90 to 90 degrees")
    distance = numbers[2] if len(numbers) == 3 else None
    if distance is not None and not 0.1 <= distance <= 10_000:
        raise Misread(f"{text!r}: a distance is from 0.1 to 10000 metres")
    return Viewpoint(azimuth, elevation, distance)


@dataclass(frozen=True)
class Paint:
    """How the body is drawn over the video."""

    style: Style
    opacity: float


@dataclass(frozen=True)
class Drawn:
    """How the body is drawn over the video, and what colours an observed surface."""

    style: Style = option(
        Choice(names=("wire", "solid", "both"), labels=_STYLES),
        "how the body is drawn over the video",
        "both",
        label="Body",
    )
    opacity: float = option(
        Percent(), "opacity of the solid body over the video, 50 as a rule", 0.5
    )
    tint: Tint = option(
        Choice(names=("clay", "contact", "photo", "distance")),
        "colour an observed surface by its contact or photo weight, or by its distance from the "
        "body",
        "clay",
    )

    @property
    def paint(self) -> Paint:
        return Paint(self.style, self.opacity)


SIZE: Final = Pixels()


@dataclass(frozen=True, kw_only=True)
class PictureOrder(Drawn):
    """A picture of one frame, or of several.

    size: None for the video's, or what it gives with four views; scale: so many times that.
    background: none for the body alone, without video, observed surface, floor and letters.
    """

    view: View | Viewpoint = option(
        Seen(), "main, top, side, front, all, or orbit:AZIMUTH,ELEVATION", "main", label="View"
    )
    size: Size | None = option(
        SIZE, "size of the picture in pixels", label="Size", empty="As the video", group="size"
    )
    scale: float = option(
        Number("N", 0.05, 16), "scale the video's size by this factor", 1.0, group="size"
    )
    background: Background = option(
        Choice(names=("video", "none"), labels={"video": "Video", "none": "Transparent"}),
        "none: the body alone on a transparent background, without labels and floor",
        "video",
        label="Background",
    )

    @property
    def on_nothing(self) -> bool:
        return self.background == "none"

    @property
    def needs_video(self) -> bool:
        return self.view in ("main", "all") and not self.on_nothing

    @property
    def has_floor(self) -> bool:
        return isinstance(self.view, Viewpoint) and not self.on_nothing

    @property
    def is_plain(self) -> bool:
        """Whether the page draws it, too."""
        return self.size is None and self.scale == 1.0 and not self.on_nothing


@dataclass(frozen=True, eq=False, repr=False)
class _Which(Value):
    """Which frames to draw: those of keyframes, those that have a pose, or one."""

    form = "which"

    def read(self, text: str) -> str | int:
        return text if text in ("keyframes", "posed") else Whole().read(text)


@dataclass(frozen=True, kw_only=True)
class PicturesOrder(PictureOrder):
    """A picture of every keyframe, or of every frame that has a pose; or of one frame alone."""

    frames: Literal["keyframes", "posed"] | int = option(
        _Which(), default="keyframes", label="Frames", flag=""
    )


@dataclass(frozen=True, kw_only=True)
class FilmOrder(Drawn):
    """The motion as a film. frames: None for all from the first pose to the last. fps: None for the
    video's own times."""

    view: FilmView = option(
        Seen(names=(*VIEWS, "orbit")),
        "main, top, side, front, all, orbit, or camera:AZIMUTH,ELEVATION[,METRES] in degrees and "
        "metres from the body",
        "main",
        label="View",
    )
    frames: tuple[int, int] | None = option(
        FrameRange(), "first and last frame; default: all frames that have a pose", label="Frames"
    )
    size: Size | None = option(
        SIZE, "size of the film in pixels; default: the video's", label="Size", empty="As the video"
    )
    fps: Fraction | None = option(
        Rate(),
        "frames per second; default: the video's own timing",
        label="Rate",
        empty="As the video",
    )


@dataclass(frozen=True)
class SheetOrder(Drawn):
    """All keyframes on one picture."""

    columns: int | None = option(
        Whole("N", 1, 100),
        "pictures per row; default: automatic",
        label="Columns",
        empty="As it fits",
    )


_MATTES: Final = {"png": "PNG, ZIP", "webm": "WebM", "mov": "MOV"}


@dataclass(frozen=True)
class MatteOrder:
    """The person cut out of the film. frames: None for all of the video."""

    kind: MatteKind = option(
        Choice(names=tuple(_MATTES), labels=_MATTES),
        "png: a folder of pictures; webm: a film, VP9; mov: a film, ProRes 4444",
        "png",
        label="Format",
    )
    frames: tuple[int, int] | None = option(
        FrameRange(), "first and last frame; default: all frames of the video", label="Frames"
    )
    alpha_only: bool = option(
        Switch(labels=("With alpha", "Alpha alone, grey")),
        "write the alpha alone, in grey",
        False,
        label="Picture",
    )


DRAWN: Final[Mapping[str, type[FilmOrder | PicturesOrder | SheetOrder | MatteOrder]]] = {
    "film": FilmOrder,
    "pictures": PicturesOrder,
    "sheet": SheetOrder,
    "matte": MatteOrder,
}
