"""The file formats of motion, one table: what each is for, its files, and what writes it.

What writes a format is loaded when it is used, so that a command line can list them all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

if TYPE_CHECKING:
    from tracker.formats.recording import Recording

MotionFormat: TypeAlias = Literal["bvh", "glb", "trc", "mot", "c3d", "csv", "npz"]

MARKER_SETS: Final = ("keypose", "halpe26")
"""As in tracker.formats.recording, which would load more than help needs."""


@dataclass(frozen=True)
class Format:
    """A file format of motion. In the page it is one entry of `static/actions/table.js` besides.

    words: what it is for, and in which units and axes.  write: one recording as it.
    names: of its files; of several the page makes one zip.  media_type: of the one file.
    own_times: whether a film of varying rate keeps its own frames and times in it; the others are
    read at a constant rate.
    """

    words: str
    write: Callable[[Recording], Sequence[str | bytes]]
    names: tuple[str, ...]
    media_type: str = "application/octet-stream"
    own_times: bool = False


def _bvh(recording: Recording) -> Sequence[str]:
    from tracker.formats.bvh import bvh

    whole = recording.whole("BVH")
    return (bvh(recording.skeleton, whole.trajectory, 1 / whole.frames_per_second),)


def _glb(recording: Recording) -> Sequence[bytes]:
    from app.render.palette import SIDE_COLOURS, part_sides
    from tracker.formats.glb import glb

    colours = {str(side): colour for side, colour in SIDE_COLOURS.items()}
    return (glb(recording, part_sides(recording.skeleton.body), colours),)


def _csv(recording: Recording) -> Sequence[str]:
    from tracker.formats.csv import angles_csv, frames_csv, joints_csv

    motion = (recording.skeleton, recording.trajectory, recording.times_s)
    angles = angles_csv(*motion, recording.joint_angles)
    return joints_csv(*motion), angles, frames_csv(recording)


def _trc(recording: Recording) -> Sequence[str]:
    from tracker.formats.trc import trc

    return (trc(recording, "motion.trc"),)


def _mot(recording: Recording) -> Sequence[str]:
    from tracker.formats.opensim.mot import mot

    return (mot(recording),)


def _c3d(recording: Recording) -> Sequence[bytes]:
    from tracker.formats.c3d import c3d

    return (c3d(recording),)


def _npz(recording: Recording) -> Sequence[bytes]:
    from tracker.formats.npz import npz

    return (npz(recording),)


FORMATS: Final[Mapping[MotionFormat, Format]] = {
    "bvh": Format(
        "for animation programs, centimetres and degrees; x right, y up, z toward the camera",
        _bvh, ("motion.bvh",), "text/plain",
    ),
    "glb": Format(
        "the moving body for any 3D viewer, metres; x right, y up, z toward the camera",
        _glb, ("motion.glb",), "model/gltf-binary",
    ),
    "trc": Format(
        "joints as markers for OpenSim, millimetres; x right, y up, z toward the camera",
        _trc, ("motion.trc",), "text/plain",
    ),
    "mot": Format(
        "joint angles for OpenSim, in degrees, of its full-body models after Rajagopal; x ahead, y "
        "up, z right, on the floor",
        _mot, ("motion.mot",), "text/plain",
    ),
    "c3d": Format(
        "joints as markers for motion laboratories, millimetres; x right, y up, z toward the "
        "camera",
        _c3d, ("motion.c3d",),
    ),
    "csv": Format(
        "joints in metres in the camera frame (x right, y down, z forward), angles in degrees, a "
        "person's by clinical names too, and how far to trust every frame",
        _csv, ("joints.csv", "angles.csv", "frames.csv"), own_times=True,
    ),
    "npz": Format(
        "all of this and the camera for NumPy, metres and radians",
        _npz, ("motion.npz",), own_times=True,
    ),
}  # fmt: skip


def formats_of(text: str) -> tuple[MotionFormat, ...]:
    """The formats in a list with commas between, each once; ValueError names one that is none."""
    asked = [name.strip().lower() for name in text.split(",")]
    for name in asked:
        if name not in FORMATS:
            raise ValueError(f"{name[:40]!r} (choose from {', '.join(FORMATS)})")
    return tuple(name for name in FORMATS if name in asked)
