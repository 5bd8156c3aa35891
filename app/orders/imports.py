"""Orders of imports: how a motion, keypoints or a camera from elsewhere are read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from keypose.app.orders.order import option
from keypose.app.orders.values import (
    Choice,
    Frames,
    Misread,
    Name,
    Number,
    Rate,
    Switch,
    Value,
    Whole,
)
from keypose.tracker.keypoints.layouts import LAYOUTS

if TYPE_CHECKING:
    from keypose.tracker.formats.cameras.camera_file import CameraWorld, LensColumn, RotationOrder
    from keypose.tracker.formats.joint_motion import Unit, World

EVERY: Final = 24
"""Frames from one draft to the next, when none are named."""
LEAST_TRACKED: Final = 2
"""Keyframes; with fewer there is nothing between them that would be shown or tracked."""
_OFFSET: Final = Whole("N", -1_000_000, 1_000_000)
_OFFSET_WORDS: Final = (
    "video frame at the file's time or frame 0; may be negative, as -1 is for pictures counted "
    "from 1; default: 0, for a camera as its frames or the video's image files are numbered"
)
_OFFSET_NOTE: Final = "of the video, at the file’s frame 0; −1 for pictures counted from 1"
_UNIT_WORDS: Final = (
    "unit of the file's lengths; auto scales a motion to the body; default: the file's unit, else "
    "auto, for a camera m"
)
_WORLD_WORDS: Final = (
    "the file's frame, where no keyframe overlaps and it does not say: the camera's, or a world "
    "with y or z up; of a camera y-up, the default, or z-up"
)
_UNITS: Final = {"m": "Metres", "cm": "Centimetres", "mm": "Millimetres"}
_ROTATION_ORDERS: Final = ("zxy", "zyx", "xyz", "xzy", "yxz", "yzx")
_UP: Final = {"y-up": "Y up", "z-up": "Z up"}


@dataclass(frozen=True, eq=False, repr=False)
class _Place(Value):
    """A name in a file, and where on the body that is; the first "=" from the right parts them."""

    metavar: str | None = "NAME=PLACE"
    form = "places"

    def read(self, text: str) -> tuple[str, str]:
        name, sign, place = text.rpartition("=")
        if not (name and sign and place) or len(text) > 400:
            raise Misread(f"{text[:40]!r} is not NAME=PLACE, such as tailtip=tail.end")
        return name, place


@dataclass(frozen=True, eq=False, repr=False)
class _Names(Value):
    """A file that says which of our joints each of theirs is."""

    metavar: str | None = "MAP.json"

    def read(self, text: str) -> Path:
        return Path(text).expanduser()


@dataclass(frozen=True, eq=False, repr=False)
class _World(Choice):
    def read(self, text: str) -> str:
        return super().read(text).replace("-", " ")


@dataclass(frozen=True, eq=False, repr=False)
class _Layout(Choice):
    def read(self, text: str) -> str:
        return super().read(text.upper())


@dataclass(frozen=True)
class _Both:
    """What may be said of motion and keypoints alike.

    places: the body's by the file's names, beside those that are known.  individual: which of
    several.  offset_frames: the video's frame at the file's time or frame 0.
    """

    individual: str | None = option(
        Name("NAME"), "which of several subjects to read", label="Individual", empty="Choose…"
    )
    offset_frames: int | None = option(
        _OFFSET,
        _OFFSET_WORDS,
        label="Start frame",
        empty="0",
        group="offset",
        note=_OFFSET_NOTE,
    )
    places: tuple[tuple[str, str], ...] = option(
        _Place(),
        "where on the body a joint or keypoint is, if its name does not say: a part, PART.end or a "
        "landmark; may be repeated",
        (),
        flag="map",
        repeated=True,
        label="Other names",
        note="optional",
    )


@dataclass(frozen=True)
class ImportMotion(_Both):
    """How a recorded motion is read.

    names: a file of our joints by the file's, in place of the usual ones.  offset_s: the video's
    time at the file's time 0.  unit, world, fps: in place of what the file says; `auto` scales it
    to the body.
    """

    fps: Fraction | None = option(
        Rate("X", Fraction(1, 1000), 100_000),
        "frames per second of the file",
        label="Rate",
        empty="As the video",
    )
    unit: Unit | Literal["auto"] | None = option(
        Choice(names=(*_UNITS, "auto"), labels={**_UNITS, "auto": "Scale to the body"}),
        _UNIT_WORDS,
        label="Unit",
        empty="Scale to the body",
    )
    world: World | None = option(
        _World(names=("camera", *_UP), labels={"camera": "As the camera sees", **_UP}),
        _WORLD_WORDS,
        label="World",
        empty="Not said by the file",
    )
    names: Path | None = option(_Names(), '{"their name": "our joint", …}', page=False)
    offset_s: float | None = option(
        Number("S", -1e6, 1e6), "video time at the file's time 0, in seconds", group="offset"
    )


@dataclass(frozen=True)
class ImportKeypoints(_Both):
    """How keypoints are read, and at which frames poses are drafted from them.

    layout: the order of the keypoints, where the file does not name them.  exchange: left is right.
    frames: those to draft, or else one in `every`.
    """

    layout: str | None = option(
        _Layout("NAME", tuple(LAYOUTS)),
        f"order of the keypoints if the file does not state it: {', '.join(LAYOUTS)}",
        label="Layout",
        empty="Choose…",
    )
    every: int | None = option(
        Whole("N", 1, 1_000_000),
        f"frames from one draft to the next; default: {EVERY}",
        label="Drafts every",
        empty=str(EVERY),
        note="frames",
        group="drafted",
    )
    frames: tuple[int, ...] | None = option(
        Frames(), "frames to draft", label="or at frames", empty="0, 24, 48", group="drafted"
    )
    exchange: bool = option(
        Switch(labels=("As the file says", "Swap left and right")),
        "swap left and right keypoints",
        False,
        label="Sides",
    )


@dataclass(frozen=True)
class ImportCamera:
    """How a camera is read where its file does not say.

    offset_frames: the video's frame at the file's frame or time 0; by itself as the file or the
    video's image files are numbered.  rotation_order, lens_column: of .chan.
    """

    offset_frames: int | None = option(
        _OFFSET, _OFFSET_WORDS, label="Start frame", empty="As numbered", note=_OFFSET_NOTE
    )
    unit: Unit | None = option(
        Choice(names=tuple(_UNITS), labels=_UNITS), _UNIT_WORDS, label="Unit", empty="Metres"
    )
    world: CameraWorld | None = option(
        _World(names=tuple(_UP), labels=_UP), _WORLD_WORDS, label="World", empty="Y up"
    )
    rotation_order: RotationOrder | None = option(
        Choice(names=_ROTATION_ORDERS, labels={name: name.upper() for name in _ROTATION_ORDERS}),
        "axes about which a .chan file turns the camera, the first one first; default: zxy",
        label="Rotation order",
        empty="ZXY",
    )
    lens_column: LensColumn | None = option(
        Choice(
            names=("vertical", "horizontal", "mm", "session"),
            labels={
                "vertical": "Vertical field of view",
                "horizontal": "Horizontal field of view",
                "mm": "Focal length, mm",
                "session": "Nothing: keep the lens",
            },
        ),
        "what the last column of a .chan file is: the vertical or horizontal field of view, the "
        "focal length in mm of film 36 mm wide, or nothing that counts, the session's lens "
        "staying; default: vertical",
        label="Last column",
        empty="Vertical field of view",
    )


ImportOrder: TypeAlias = ImportMotion | ImportKeypoints | ImportCamera

IMPORTS: Final[Mapping[str, type[ImportOrder]]] = {
    "motion": ImportMotion,
    "keypoints": ImportKeypoints,
    "camera": ImportCamera,
}
