"""The file formats of motion, one table: what each is for, its files, and what writes it.

What writes a format is loaded when it is used, so that a command line can list them all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

if TYPE_CHECKING:
    from tracker.formats.recording import Recording

MotionFormat: TypeAlias = Literal["bvh", "glb", "trc", "c3d", "csv", "npz", "camera", "chan"]


@dataclass(frozen=True)
class Format:
    """A file format of motion. In the page it is one entry of `static/actions/table.js` besides.

    words: what it is for, and in which units and axes.  write: one recording as it, with the bones
    of a rig by its name (`tracker.formats.rigs`), which formats without bones pass over.
    names: of its files, "motion" and what follows the session's name where the page saves one of
    them; of several it makes one zip.  media_type: of the one file.
    own_times: whether a film of varying rate keeps its own frames and times in it; the others are
    read at a constant rate.  rigged: whether it has bones, which may be another rig's.
    """

    words: str
    write: Callable[[Recording, str], Sequence[str | bytes]]
    names: tuple[str, ...]
    media_type: str = "application/octet-stream"
    own_times: bool = False
    rigged: bool = False


def _bvh(recording: Recording, _rig: str) -> Sequence[str]:
    from tracker.formats.bvh import bvh

    whole = recording.whole("BVH")
    return (bvh(recording.skeleton, whole.trajectory, 1 / whole.frames_per_second),)


def _glb(recording: Recording, rig: str) -> Sequence[bytes]:
    from app.render.palette import SIDE_COLOURS, part_sides
    from tracker.formats.glb import glb

    colours = {str(side): colour for side, colour in SIDE_COLOURS.items()}
    return (glb(recording, part_sides(recording.skeleton.body), colours, rig),)


def _csv(recording: Recording, _rig: str) -> Sequence[str]:
    from tracker.formats.csv import angles_csv, frames_csv, joints_csv

    motion = (recording.skeleton, recording.trajectory, recording.times_s)
    return joints_csv(*motion), angles_csv(*motion), frames_csv(recording)


def _trc(recording: Recording, _rig: str) -> Sequence[str]:
    from tracker.formats.trc import trc

    return (trc(recording, "motion.trc"),)


def _c3d(recording: Recording, _rig: str) -> Sequence[bytes]:
    from tracker.formats.c3d import c3d

    return (c3d(recording),)


def _npz(recording: Recording, _rig: str) -> Sequence[bytes]:
    from tracker.formats.npz import npz

    return (npz(recording),)


def _camera(recording: Recording, _rig: str) -> Sequence[str]:
    from tracker.formats.camera_files import camera_json

    return (camera_json(recording),)


def _chan(recording: Recording, _rig: str) -> Sequence[str]:
    from tracker.formats.camera_files import chan

    return (chan(recording),)


FORMATS: Final[Mapping[MotionFormat, Format]] = {
    "bvh": Format(
        "for animation programs, centimetres and degrees; x right, y up, z toward the camera",
        _bvh, ("motion.bvh",), "text/plain",
    ),
    "glb": Format(
        "a rig with skin, motion and camera for Blender, game engines and any 3D viewer, metres; "
        "y up, the floor at zero",
        _glb, ("motion.glb",), "model/gltf-binary", rigged=True,
    ),
    "trc": Format(
        "joints as markers for OpenSim, millimetres; x right, y up, z toward the camera",
        _trc, ("motion.trc",), "text/plain",
    ),
    "c3d": Format(
        "joints as markers for motion laboratories, millimetres; x right, y up, z toward the "
        "camera",
        _c3d, ("motion.c3d",),
    ),
    "csv": Format(
        "joints in metres in the camera frame (x right, y down, z forward), angles in degrees, and "
        "how far to trust every frame",
        _csv, ("joints.csv", "angles.csv", "frames.csv"), own_times=True,
    ),
    "npz": Format(
        "all of this and the camera for NumPy, metres and radians",
        _npz, ("motion.npz",), own_times=True,
    ),
    "camera": Format(
        "the film's camera alone, for rotomation, as JSON, metres; y up, the floor at zero",
        _camera, ("motion_camera.json",), "application/json", own_times=True,
    ),
    "chan": Format(
        "the film's camera for Nuke, metres and degrees, rotation order ZXY; y up, the floor at "
        "zero",
        _chan, ("motion_camera.chan",), "text/plain", own_times=True,
    ),
}  # fmt: skip


def formats_of(text: str) -> tuple[MotionFormat, ...]:
    """The formats in a list with commas between, each once; ValueError names one that is none."""
    asked = [name.strip().lower() for name in text.split(",")]
    for name in asked:
        if name not in FORMATS:
            raise ValueError(f"{name[:40]!r} (choose from {', '.join(FORMATS)})")
    return tuple(name for name in FORMATS if name in asked)
