"""The file formats of motion, one table: what each is for, its files, and what writes it.

What writes a format is loaded when it is used, so that a command line can list them all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.rigs import OWN
from keypose.tracker.formats.units import FileUnit

if TYPE_CHECKING:
    from keypose.tracker.formats.recording import Recording

MotionFormat: TypeAlias = Literal[
    "bvh", "glb", "usd", "trc", "mot", "c3d", "csv", "npz", "amass", "camera", "chan"
]  # fmt: skip


@dataclass(frozen=True)
class Bones:
    """How bones are written: of which rig, by its name (`keypose.tracker.formats.rigs`), and in
    which unit where the format names none."""

    rig: str = OWN
    unit: FileUnit = "m"


MARKER_SETS: Final = ("keypose", "halpe26")
"""As in tracker.formats.recording, which would load more than help needs."""


@dataclass(frozen=True)
class Format:
    """A file format of motion. Its name is in `MotionFormat`; in the page it is one entry of
    `static/actions/table/export.js`.

    words: what it is for, and in which units and axes.  write: one recording as it, with bones as
    they are asked for, which formats without bones pass over.
    names: of its files, "motion" and what follows the session's name where the page saves one of
    them; of several it makes one zip.  media_type: of the one file.
    own_times: whether a film of varying rate keeps its own frames and times in it; the others are
    read at a constant rate.  gaps: whether frames that are not tracked may lie between others.
    rigged: whether it has bones, which may be another rig's.
    timed: whether its file says when in the film it begins.
    """

    words: str
    write: Callable[[Recording, Bones], Sequence[str | bytes]]
    names: tuple[str, ...]
    media_type: str = "application/octet-stream"
    own_times: bool = False
    gaps: bool = True
    rigged: bool = False
    timed: bool = True


def _bvh(recording: Recording, bones: Bones) -> Sequence[str]:
    from keypose.tracker.formats.bvh import bvh
    from keypose.tracker.formats.conventions import floor_from_camera, parts_in_world
    from keypose.tracker.formats.rigs.rig import rig_of

    whole = recording.whole("BVH")
    rig = rig_of(whole.skeleton, bones.rig, parallel=True)
    Ts_world_part = parts_in_world(whole, floor_from_camera(whole))
    return (bvh(rig, Ts_world_part, 1 / whole.frames_per_second, bones.unit),)


def _glb(recording: Recording, bones: Bones) -> Sequence[bytes]:
    from keypose.tracker.formats.glb import glb

    return (glb(recording, *_colours(recording), bones.rig),)


def _usd(recording: Recording, bones: Bones) -> Sequence[bytes]:
    try:
        from keypose.tracker.formats.usd import usd
    except ModuleNotFoundError as error:
        if error.name != "pxr":
            raise
        raise FormatError("USD files need usd-core: pip install 'keypose[usd]'.") from None
    return (usd(recording, *_colours(recording), bones.rig),)


def _colours(recording: Recording) -> tuple[list[str], dict[str, tuple[int, int, int]]]:
    """Return which side each part is of, and the colours of the sides."""
    from keypose.app.render.palette import SIDE_COLOURS, part_sides

    colours = {str(side): colour for side, colour in SIDE_COLOURS.items()}
    return [str(side) for side in part_sides(recording.skeleton.body)], colours


def _csv(recording: Recording, _bones: Bones) -> Sequence[str]:
    from keypose.tracker.formats.csv import angles_csv, frames_csv, joints_csv

    motion = (recording.skeleton, recording.trajectory, recording.times_s)
    angles = angles_csv(*motion, recording.joint_angles)
    return joints_csv(*motion), angles, frames_csv(recording)


def _trc(recording: Recording, _bones: Bones) -> Sequence[str]:
    from keypose.tracker.formats.marker_files import trc

    return (trc(recording, "motion.trc"),)


def _mot(recording: Recording, _bones: Bones) -> Sequence[str]:
    from keypose.tracker.formats.opensim.mot import mot

    return (mot(recording),)


def _c3d(recording: Recording, _bones: Bones) -> Sequence[bytes]:
    from keypose.tracker.formats.marker_files import c3d

    return (c3d(recording),)


def _npz(recording: Recording, _bones: Bones) -> Sequence[bytes]:
    from keypose.tracker.formats.npz import npz

    return (npz(recording),)


def _amass(recording: Recording, _bones: Bones) -> Sequence[bytes]:
    from keypose.tracker.formats.smpl import amass

    return (amass(recording),)


def _camera(recording: Recording, _bones: Bones) -> Sequence[str]:
    from keypose.tracker.formats.camera_files import camera_json

    return (camera_json(recording),)


def _chan(recording: Recording, _bones: Bones) -> Sequence[str]:
    from keypose.tracker.formats.camera_files import chan

    return (chan(recording),)


FORMATS: Final[Mapping[MotionFormat, Format]] = {
    "bvh": Format(
        "bones in motion for animation programs, metres unless --unit says another, degrees; y up, "
        "the floor at zero",
        _bvh, ("motion.bvh",), "text/plain", gaps=False, rigged=True, timed=False,
    ),
    "glb": Format(
        "a rig with skin, motion and camera for Blender, game engines and any 3D viewer, metres; "
        "y up, the floor at zero",
        _glb, ("motion.glb",), "model/gltf-binary", gaps=False, rigged=True,
    ),
    "usd": Format(
        "the same rig, motion and camera for film and game studios, metres; y up, the floor at "
        "zero; needs usd-core",
        _usd, ("motion.usd",), gaps=False, rigged=True,
    ),
    "trc": Format(
        "joints as markers for OpenSim, millimetres, metres with --markers halpe26; x ahead, y up, "
        "z right, on the floor",
        _trc, ("motion.trc",), "text/plain",
    ),
    "mot": Format(
        "joint angles for OpenSim, in degrees, of its full-body models after Rajagopal; x ahead, y "
        "up, z right, on the floor",
        _mot, ("motion.mot",), "text/plain", gaps=False,
    ),
    "c3d": Format(
        "joints as markers for motion laboratories, millimetres; x ahead, y up, z right, on the "
        "floor",
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
    "amass": Format(
        "a person's poses of the SMPL-H body for motion research, as in AMASS, metres and radians; "
        "z up, on the floor",
        _amass, ("motion_poses.npz",), gaps=False, timed=False,
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
