"""Grammar of the commands for files of other programs, surfaces, videos and networks."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from keypose.app.cli.arguments import (
    Subcommands,
    add_command,
    add_json,
    add_order,
    add_orders,
    add_output,
    add_overwrite,
    add_session,
    file_name,
    motion_formats,
)
from keypose.app.export.motion_formats import FORMATS
from keypose.app.orders.bodies import EachBody, OneBody
from keypose.app.orders.imports import IMPORTS
from keypose.app.orders.motion import MotionOrder
from keypose.tracker.errors import listed

_EXPORT_EXAMPLES = """\
  keypose export session.json --format bvh --out motion
  keypose export session.json --format csv,npz --out tables --overwrite
  keypose export session.json --format glb --rig mixamo --out rig
  keypose export session.json --format trc --filter 6Hz --fps 30 --frames 10-60 --out walk
  keypose export session.json --format trc,mot --markers halpe26 --out markers
  keypose export session.json --format glb,trc --together --out scene
  keypose export session.json --format mot --model Model_Pose2Sim_simple.osim --out opensim
"""


def add_export(commands: Subcommands) -> None:
    command = add_command(commands, "export", _export_details(), _EXPORT_EXAMPLES)
    add_session(command)
    add_order(command, EachBody)
    command.add_argument(
        "--format",
        metavar="FORMAT[,FORMAT]",
        type=motion_formats,
        required=True,
        help=f"one or several of {', '.join(FORMATS)}",
    )
    add_order(command, MotionOrder)
    command.add_argument(
        "--model",
        metavar="FILE.osim",
        type=Path,
        help="a full-body model of OpenSim 4 after Rajagopal: adds motion.trc and motion.mot for "
        "it, what OpenSim's tools need to scale it to the body and to follow the markers "
        "(markers.xml, scale.xml, ik.xml), and the scaled model where OpenSim is installed "
        "(pip install 'keypose[opensim]')",
    )
    add_output(command, "DIR", "folder; created if missing")


def _export_details() -> str:
    kinds = (f"{name}: {', '.join(kind.names)}, {kind.words}." for name, kind in FORMATS.items())
    gaps = listed([name for name, kind in FORMATS.items() if kind.gaps])
    no_gaps = listed([name for name, kind in FORMATS.items() if not kind.gaps])
    scenes = listed([name for name, kind in FORMATS.items() if kind.scene])
    own_times = listed([name for name, kind in FORMATS.items() if kind.own_times])
    return (
        f"{' '.join(kinds)} Frames that are not tracked stay empty in {gaps}; "
        f"{no_gaps} cannot have gaps. If the video's frame rate varies, {own_times} keep "
        "the time of every frame and the others use the mean rate. Of several bodies there is one "
        f"world; {scenes} hold them all in one scene, and of the others each body has a file of "
        "its own, NAME.bvh, unless --together puts those that can into one."
    )


_IMPORT_EXAMPLES = """\
  keypose import session.json walk.bvh
  keypose import session.json walk.trc --offset-frames 12 --names names.json
  keypose import session.json openpose/ --keypoints --frames 0,24,48
  keypose import dog.json dogDLC.h5 --keypoints --map withers=neck --map tailtip=tail.end
  keypose import session.json shot.chan --camera
  keypose import session.json plate.chan --camera --offset-frames -1001 --rotation-order xyz
"""


def add_import(commands: Subcommands) -> None:
    details = (
        "BVH, TRC, C3D, CSV, or SMPL poses of AMASS, GVHMR, GEM or WHAM (.npz, .pt): the motion "
        "is fitted to the session's body, aligned with its keyframes and saved as an initial "
        "guess, which tracking uses where it fits better than its own. With --keypoints, COCO, "
        "AlphaPose, OpenPose, MediaPipe, SLEAP or DeepLabCut: drafts poses at some frames. With "
        "--camera: the film's camera as another program found it. Where file and session have "
        "several, individuals go to the bodies of their names, the others in their order to those "
        "that are left, and which went where is said. "
        "Keyframes are never changed."
    )
    command = add_command(commands, "import", details, _IMPORT_EXAMPLES)
    add_session(command)
    add_order(command, OneBody)
    file_help = "motion file; with --keypoints a JSON, CSV or HDF5 file, or OpenPose's folder"
    command.add_argument("file", metavar="FILE", type=file_name, help=file_help)
    command.add_argument("--keypoints", action="store_true", help="the file holds 2D keypoints")
    command.add_argument(
        "--camera",
        action="store_true",
        help="the file holds a camera, which may move: .json or .chan as export writes them, .glb "
        "or .gltf, transforms.json, cameras.json of 3D Gaussian splatting, COLMAP's images.txt or "
        "a path of TUM; sets the lens, what is up, how the camera moves and, where the file has "
        "it, the floor; compared with the background of the film",
    )
    add_orders(command, IMPORTS)
    add_json(command)


_HULL_EXAMPLES = """\
  keypose hull cameras.json --out meshes
  keypose hull cameras.json --voxel 0.02 --out meshes --overwrite
  keypose hull cameras.json --person --out meshes
"""


def add_hull(commands: Subcommands) -> None:
    details = (
        "Writes the visual hulls as step_0000.ply and so on, in the units and axes of the "
        "cameras' file. If the file also names images, each vertex gets a zncc that says how "
        "well the cameras that see it agree; fitting uses it to ignore false volume. A step "
        "that fails is reported and skipped. Ctrl+C keeps finished steps."
    )
    command = add_command(commands, "hull", details, _HULL_EXAMPLES)
    command.add_argument(
        "rig", metavar="CAMERAS", type=file_name, help="JSON file with the calibrated cameras"
    )
    command.add_argument(
        "--out", metavar="DIR", type=file_name, required=True, help="folder for the surfaces"
    )
    command.add_argument(
        "--voxel",
        metavar="METRES",
        type=_length,
        default=0.01,
        help="edge length of a voxel in metres; default: 0.01",
    )
    command.add_argument(
        "--person",
        action="store_true",
        help="find a person in the cameras' images instead of reading silhouettes: no masks and no "
        "clean background are needed; of several people, the one in the camera's box in the file",
    )
    add_json(command)
    add_overwrite(command)


def _length(text: str) -> float:
    try:
        metres = float(text)
    except ValueError:
        metres = math.nan
    if not 0.0005 <= metres <= 1.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a length from 0.0005 to 1 metre")
    return metres


_INFO_EXAMPLES = """\
  keypose info jump.mp4
  keypose info jump.mp4 --json
  keypose info jump.mp4 --check
  keypose info scan --check
  keypose info jump.keypose
"""


def add_info(commands: Subcommands) -> None:
    details = (
        "For a folder of meshes, one per time step: the number of steps, their size, whether "
        "the first one has holes, and which steps have no file. Of a session: its bodies."
    )
    command = add_command(commands, "info", details, _INFO_EXAMPLES)
    command.add_argument(
        "video",
        metavar="VIDEO|MESHES|SESSION",
        type=file_name,
        help="video file, folder of images, folder of meshes, or a session's file or folder",
    )
    add_order(command, EachBody)
    command.add_argument(
        "--check",
        action="store_true",
        help="decode every frame of a video and list the damaged ones; of meshes, read all and "
        "list those that cannot be used",
    )
    add_json(command)


_MODELS_EXAMPLES = """\
  keypose models
  keypose models add heavy
  keypose models add heavy --from pose-0.5.1675469404.tgz
  keypose models add my-rtmw --from rtmw-x.zip --sha256 DIGEST
  keypose models add dogs --from rtmpose-m-ap10k.zip --sha256 DIGEST --animals
  keypose models remove my-rtmw
"""


def add_models(commands: Subcommands) -> None:
    about = (
        "Without arguments, lists them. `add` downloads heavy or copies it from a file, or adds a "
        "network of a whole person's joints that you have under a name of your own: RTMPose, RTMW, "
        "RTMO, ViTPose or MoveNet as .onnx of at most 256 MB, or MMDeploy's .zip of one. It looks "
        "beside BlazePose, which gives depth. One trained on AP-10K's 17 keypoints of animals "
        "drafts a dog or a horse. What its weights may be used for, their publisher says. "
        "`remove` removes an added one."
    )
    command = add_command(commands, "models", about, _MODELS_EXAMPLES)
    command.add_argument(
        "what",
        nargs="?",
        choices=("list", "add", "remove"),
        default="list",
        help="list (default), add or remove",
    )
    command.add_argument("name", nargs="?", help="with add and remove: which network")
    command.add_argument(
        "--from",
        dest="file",
        type=Path,
        metavar="FILE",
        help="of heavy the .tflite file or the npm .tgz; otherwise .onnx or .zip",
    )
    command.add_argument(
        "--sha256",
        metavar="DIGEST",
        help="of your own file: by it you say that you trust it and no other",
    )
    command.add_argument(
        "--animals",
        action="store_true",
        help="it finds AP-10K's keypoints of animals; default: where its file's name says ap10k",
    )
    add_json(command)
