"""The file formats of motion, one table: what each is for, its files, and what writes it.

What writes a format is loaded when it is used, so that a command line can list them all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Final, TypeAlias

from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.order import options_of
from keypose.tracker.errors import FormatError, listed

if TYPE_CHECKING:
    from keypose.tracker.formats.recording import Recording

MotionFormat: TypeAlias = str
"""A name of `FORMATS`."""
Write: TypeAlias = "Callable[[Recording, MotionOrder], Sequence[str | bytes]]"
WriteTogether: TypeAlias = (
    "Callable[[Recording, MotionOrder, Sequence[Recording]], Sequence[str | bytes]]"
)


@dataclass(frozen=True)
class Format:
    """A file format of motion.

    words: what it is for, and in which units and axes.  write: one recording as it; or the dotted
    name of what writes a recording where no option matters.
    names: of its files, "motion" and what follows the session's name where the page saves one of
    them; of several it makes one zip.  also: files beside them, of a motion that has something to
    put there.  media_type: of the one file.
    reader, icon, search, remark: in the page who reads it, its sign, words it is found by, and what
    a person should know; then: what is left to do with its files, a sentence.
    title: what its action is called in lists; label: its short name.
    library: the package and the module that it needs, which an extra of its name installs.
    own_times: whether a film of varying rate keeps its own frames and times in it; the others are
    read at a constant rate.  gaps: whether frames that are not tracked may lie between others.
    rigged: whether it has bones, which may be another rig's; unitless: whether it cannot name its
    unit of length; marked: whether it has markers.
    timed: whether its file says when in the film it begins.  numbered: whether it has numbers of
    frames alone, and no rate.
    together: what writes several bodies into its files, where these can hold them: a recording, and
    those beside it; or the dotted name of what does where no option matters.  scene: whether it
    does so unasked, as its files are scenes.  of_camera: whether no body is in its files.
    """

    words: str
    write: Write | str
    names: tuple[str, ...]
    media_type: str = "application/octet-stream"
    reader: str = ""
    icon: str = ""
    search: str = ""
    title: str = ""
    label: str = ""
    remark: str = ""
    then: str = ""
    library: tuple[str, str] | None = None
    own_times: bool = False
    gaps: bool = True
    rigged: bool = False
    unitless: bool = False
    marked: bool = False
    timed: bool = True
    also: tuple[str, ...] = ()
    numbered: bool = False
    together: WriteTogether | str | None = None
    scene: bool = False
    of_camera: bool = False

    def is_changed_by(self, only: str) -> bool:
        """Whether its files depend on an option of formats of a kind: scenes hold all bodies
        anyway."""
        return bool(getattr(self, only)) and not (only == "together" and self.scene)

    def contents(
        self, recording: Recording, order: MotionOrder, beside: Sequence[Recording] = ()
    ) -> Sequence[str | bytes]:
        """What its files hold; FormatError when it cannot hold the motion.

        beside: other bodies, of a format that holds them together.
        """
        if not beside:
            return (
                (_named(self.write)(recording),)
                if isinstance(self.write, str)
                else self.write(recording, order)
            )
        assert self.together is not None
        if isinstance(self.together, str):
            return (_named(self.together)(recording, beside),)
        return self.together(recording, order, beside)


def _named(dotted: str) -> Callable[..., str | bytes]:
    module, name = dotted.rsplit(".", 1)
    write: Callable[..., str | bytes] = getattr(
        import_module(f"keypose.tracker.formats.{module}"), name
    )
    return write


def _bvh(recording: Recording, order: MotionOrder) -> Sequence[str]:
    from keypose.tracker.formats.bvh import bvh
    from keypose.tracker.formats.conventions import parts_in_world
    from keypose.tracker.formats.rigs.rig import rig_of

    whole = recording.whole("BVH")
    rig = rig_of(whole.skeleton, order.rig, parallel=True)
    Ts_world_part = parts_in_world(whole, whole.T_world_camera)
    return (bvh(rig, Ts_world_part, 1 / whole.frames_per_second, order.unit),)


def _glb(
    recording: Recording, order: MotionOrder, beside: Sequence[Recording] = ()
) -> Sequence[bytes]:
    from keypose.tracker.formats.glb import glb

    return (glb(recording, *_colours(recording), order.rig, _with_sides(beside)),)


def _fbx(
    recording: Recording, order: MotionOrder, beside: Sequence[Recording] = ()
) -> Sequence[str | bytes]:
    from keypose.tracker.formats.fbx_script import fbx_script

    return (*_glb(recording, order, beside), fbx_script(recording, beside))


def _usd(
    recording: Recording, order: MotionOrder, beside: Sequence[Recording] = ()
) -> Sequence[bytes]:
    try:
        from keypose.tracker.formats.usd import usd
    except ModuleNotFoundError as error:
        if error.name != "pxr":
            raise
        raise FormatError("USD files need usd-core: pip install 'keypose[usd]'.") from None
    return (usd(recording, *_colours(recording), order.rig, _with_sides(beside)),)


def _with_sides(bodies: Sequence[Recording]) -> list[tuple[Recording, list[str]]]:
    return [(body, _colours(body)[0]) for body in bodies]


def _colours(recording: Recording) -> tuple[list[str], dict[str, tuple[int, int, int]]]:
    """Which side each part is of, and the colours of the sides."""
    from keypose.app.render.palette import SIDE_COLOURS, part_sides

    colours = {str(side): colour for side, colour in SIDE_COLOURS.items()}
    return [str(side) for side in part_sides(recording.skeleton.body)], colours


def _csv(recording: Recording, _order: MotionOrder) -> Sequence[str]:
    from keypose.tracker.formats.csv import angles_csv, frames_csv, joints_csv

    angles = angles_csv(
        recording.skeleton,
        recording.trajectory,
        recording.times_s,
        recording.joint_angles,
        recording.up_camera,
    )
    world = recording.world if recording.tracks.tracked.any() else None
    joints = joints_csv(
        recording.skeleton, recording.trajectory, recording.times_s, world, recording.ps_seen_joint
    )
    return joints, angles, frames_csv(recording)


def _csv_together(
    recording: Recording, order: MotionOrder, beside: Sequence[Recording]
) -> Sequence[str]:
    from keypose.tracker.formats.csv import tables_together

    bodies = (recording, *beside)
    tables = [_csv(body, order) for body in bodies]
    return [tables_together(bodies, kind) for kind in zip(*tables, strict=True)]


def _mot(recording: Recording, _order: MotionOrder) -> Sequence[str]:
    from keypose.tracker.formats.opensim.mot import mot_files

    return mot_files(recording)


FORMATS: Final[Mapping[MotionFormat, Format]] = {
    "bvh": Format(
        "bones in motion for animation programs, metres unless --unit says another, degrees",
        _bvh,
        ("motion.bvh",),
        "text/plain",
        "Blender, MotionBuilder, Daz",
        "bone",
        "blender maya motionbuilder unreal unity animation mocap",
        remark="The file cannot say where in the video it begins",
        gaps=False,
        rigged=True,
        unitless=True,
        timed=False,
    ),
    "glb": Format(
        "a rig with skin, motion and camera for Blender, game engines and any 3D viewer, metres",
        _glb,
        ("motion.glb",),
        "model/gltf-binary",
        "Blender, Unreal, Unity, web",
        "both",
        "blender gltf unreal unity three web 3d animation rig armature skeleton mixamo metahuman "
        "vrm",
        gaps=False,
        rigged=True,
        together=_glb,
        scene=True,
    ),
    "fbx": Format(
        "the GLB, and a script with which Blender makes FBX of it",
        _fbx,
        ("motion.glb", "motion_to_fbx.py"),
        reader="through Blender",
        icon="both",
        search="fbx blender maya motionbuilder unreal unity 3ds max rig retarget",
        title="Export FBX through Blender",
        then="For motion.fbx run: blender --background --python motion_to_fbx.py",
        gaps=False,
        rigged=True,
        together=_fbx,
        scene=True,
    ),
    "usd": Format(
        "the same rig, motion and camera for film and game studios, metres; needs usd-core",
        _usd,
        ("motion.usd",),
        reader="Omniverse, Houdini, Maya",
        icon="both",
        search="usdz usdc openusd universal scene description omniverse houdini maya unreal "
        "animation",
        remark="In Blender, set the frame rate to the video’s",
        library=("usd-core", "pxr"),
        gaps=False,
        rigged=True,
        together=_usd,
        scene=True,
    ),
    "trc": Format(
        "joints as markers for OpenSim, millimetres, metres with --markers halpe26",
        "marker_files.trc",
        ("motion.trc",),
        "text/plain",
        "OpenSim",
        "trail",
        "opensim markers biomechanics",
        marked=True,
        together="marker_files.trc",
    ),
    "mot": Format(
        "joint angles for OpenSim, in degrees, of its full-body models after Rajagopal",
        _mot,
        ("motion.mot",),
        "text/plain",
        "OpenSim joint angles",
        "rot",
        title="Export joint angles as MOT",
        gaps=False,
        also=("motion-errors.mot",),
    ),
    "c3d": Format(
        "joints as markers for motion laboratories, millimetres",
        "marker_files.c3d",
        ("motion.c3d",),
        reader="motion laboratories",
        icon="ghost",
        search="vicon qualisys biomechanics lab markers",
        library=("ezc3d", "ezc3d"),
        marked=True,
        together="marker_files.c3d",
    ),
    "csv": Format(
        "joints in metres in the camera frame (x right, y down, z forward) and in the world, "
        "angles in degrees, a person's by clinical names too, and how far to trust every frame",
        _csv,
        ("joints.csv", "angles.csv", "frames.csv"),
        reader="joints, angles, verdicts",
        icon="copy",
        search="table excel spreadsheet angles positions data",
        title="Export CSV tables",
        own_times=True,
        together=_csv_together,
    ),
    "npz": Format(
        "all of this and the camera for NumPy, metres and radians",
        "npz.npz",
        ("motion.npz",),
        reader="NumPy",
        icon="quad",
        search="numpy python arrays data",
        own_times=True,
        together="npz.npz",
    ),
    "amass": Format(
        "a person's poses of the SMPL-H body for motion research, as in AMASS, metres and radians; "
        "z up",
        "smpl.amass",
        ("motion_poses.npz",),
        reader="SMPL, motion research",
        icon="ghost",
        search="smpl smplh smplx research npz poses",
        title="Export AMASS, SMPL poses",
        gaps=False,
        timed=False,
    ),
    "camera": Format(
        "the film's camera alone, for rotomation, as JSON, metres",
        "camera_files.camera_json",
        ("motion_camera.json",),
        "application/json",
        "rotomation, JSON",
        "camcorder",
        "rotomation matchmove json lens",
        title="Export the camera as JSON",
        label="Camera",
        own_times=True,
        of_camera=True,
    ),
    "chan": Format(
        "the film's camera for Nuke, metres and degrees, rotation order ZXY",
        "camera_files.chan",
        ("motion_camera.chan",),
        "text/plain",
        "the camera for Nuke",
        "camcorder",
        "camera nuke rotomation matchmove compositing",
        title="Export the camera for Nuke",
        own_times=True,
        numbered=True,
        of_camera=True,
    ),
}


def require_meant(order: MotionOrder, formats: Sequence[MotionFormat]) -> None:
    """FormatError for an option that none of the formats heeds: it would be ignored."""
    for name, option in options_of(MotionOrder).items():
        if option.only is None or getattr(order, name) == getattr(MotionOrder(), name):
            continue
        heeding = [
            format_name for format_name, kind in FORMATS.items() if getattr(kind, option.only)
        ]
        if not set(heeding) & set(formats):
            words = option.label or f"--{name}"
            raise FormatError(f"{words} is for {listed(heeding)} alone.")


def formats_of(text: str) -> tuple[MotionFormat, ...]:
    """The formats in a list with commas between, each once; FormatError names one that is none."""
    asked = [name.strip().lower() for name in text.split(",")]
    for name in asked:
        if name not in FORMATS:
            raise FormatError(
                f"There is no format {name[:40]!r}; choose from {', '.join(FORMATS)}."
            )
    return tuple(name for name in FORMATS if name in asked)
