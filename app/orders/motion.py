"""Orders of motion files."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Final, Literal, TypeAlias

from keypose.app.orders.order import option
from keypose.app.orders.values import Choice, FrameRange, Number, Rate, Switch
from keypose.tracker.formats.rigs import OWN, RIGS
from keypose.tracker.formats.units import FILE_UNITS, ORIGINS, FileUnit, Origin

MarkerSetName: TypeAlias = Literal["keypose", "halpe26"]

_RIGS: Final = {OWN: "Own names", **{n: w.split(",")[0] for n, w in RIGS.items() if n != OWN}}
_RIG_NOTES: Final = {"mixamo": "three.js drops the colons of its names"}
_UNITS: Final = {"m": "Metres", "cm": "Centimetres", "in": "Inches"}
_UNIT_NOTES: Final = {"m": "Blender", "cm": "MotionBuilder, Maya, Daz"}
_ORIGINS: Final = {"body": "Below the body, x ahead", "camera": "Below the camera"}
_ORIGIN_NOTES: Final = {"camera": "the same for every session of a film"}
_MARKERS: Final = {"keypose": "The body’s joints", "halpe26": "HALPE 26, Pose2Sim"}


@dataclass(frozen=True)
class MotionOrder:
    """What may be asked for besides a format of motion.

    rig: whose bones a format has that has bones.  unit: of lengths where a format names none.
    markers: which markers files of markers have.  origin: whose ground the world of files is.
    frames: of the film, all when None.
    fps: frames a second, those of the film when None; where these vary, formats that are read at a
    constant rate get their mean.  from_zero: whether times and frames begin at 0 instead of where
    they are in the film.  together: whether several bodies share one file in every format that can
    hold them, not only in scenes.  filter_hz: at which the low-pass filter is 3 dB down, none when
    None.
    """

    rig: str = option(
        Choice("NAME", tuple(RIGS), _RIGS, _RIG_NOTES),
        "names and rest pose of bones: "
        + "; ".join(f"{name}: {words}" for name, words in RIGS.items()),
        OWN,
        label="Rig",
        only="rigged",
        persons=True,
    )
    unit: FileUnit = option(
        Choice(None, tuple(FILE_UNITS), _UNITS, _UNIT_NOTES),
        "of lengths in bvh, which cannot name its own: "
        + "; ".join(f"{name}: {words}" for name, words in FILE_UNITS.items()),
        "m",
        label="Unit",
        only="unitless",
    )
    markers: MarkerSetName = option(
        Choice(None, ("keypose", "halpe26"), _MARKERS),
        "of trc and c3d: keypose, the body's joints and landmarks; halpe26, a person's by the "
        "names of Pose2Sim",
        "keypose",
        label="Markers",
        only="marked",
        persons=True,
    )
    origin: Origin = option(
        Choice(None, tuple(ORIGINS), _ORIGINS, _ORIGIN_NOTES),
        "of the world that all formats have in common, y up, the floor at zero: "
        + "; ".join(f"{name}: {words}" for name, words in ORIGINS.items()),
        "body",
        label="Origin",
    )
    frames: tuple[int, int] | None = option(
        FrameRange(), "first and last frame of the video; default: all", label="Frames"
    )
    fps: Fraction | None = option(
        Rate(),
        "sample the motion at so many frames per second, as fast as it was; default: the video's "
        "rate. How fast it was recorded is said by `keypose open --recorded-fps`",
        label="Rate",
        empty="As the video",
    )
    from_zero: bool = option(
        Switch(labels=("As in the video", "From 0")),
        "times and frames begin at 0, as game engines and web players expect, and not where they "
        "are in the film",
        False,
        label="Times",
        note="From 0 for game engines and web players",
    )
    together: bool = option(
        Switch(),
        "of several bodies, also write csv, npz, trc and c3d as one file, with names such as "
        "NAME:left_hand; default: a file each. glb, fbx and usd always hold all bodies in one "
        "scene",
        False,
        label="All bodies in one file",
        only="together",
    )
    filter_hz: float | None = option(
        Number("HZ", 0.01, 1000, "a cut-off such as 6Hz", "Hz"),
        "frequency at which a zero-phase low-pass filter is 3 dB down, such as 6Hz: a "
        "second-order Butterworth filter forward and back, both passes together. Where a program "
        "runs one of 6 Hz forward and back, it is 6 dB down there: that is --filter 4.8Hz, 5Hz at "
        "30 frames a second; default: none",
        flag="filter",
        label="Low-pass filter",
        empty="None",
        note="3 dB down there, both passes together",
    )


AS_TRACKED: Final = MotionOrder()
