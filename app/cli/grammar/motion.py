"""Grammar of the commands that find, review and reduce a motion."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Container
from typing import TYPE_CHECKING

from keypose.app.cli.arguments import (
    SESSION_WORDS,
    UNITS,
    UP_AXES,
    Once,
    Subcommands,
    add_command,
    add_film_orders,
    add_json,
    add_order,
    add_overwrite,
    add_session,
    add_work,
    file_name,
    motion_formats,
    session_file,
    typed,
)
from keypose.app.orders.bodies import EachBody, OneBody
from keypose.app.orders.film import BesideOrder, FilmOrder, RunOrder
from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.order import options_of
from keypose.app.orders.tracking import DraftOrder, FilmTaken, TrackOrder, Within
from keypose.app.orders.values import FrameRange, Name, Number, Whole
from keypose.tracker.body.preset_names import PRESETS

if TYPE_CHECKING:
    from keypose.tracker.reduction.result import Every, Tolerance


_DRAFT_EXAMPLES = """\
  keypose draft jump.mp4 --out jump.keypose
  keypose draft jump.mp4 --box 210,80,420,610 --frame 12 --frames 0-45 --body adult_female --out j
  keypose draft jump.mp4 --accept --out accepted
  keypose draft jump.keypose --accept
"""


def add_draft(commands: Subcommands) -> None:
    details = (
        "A network finds the person's joints in every frame, and the body is fitted "
        "to them. The session and its keypoints are written to the folder. One camera cannot "
        "tell size from distance, so the body keeps its preset's height, or the one you give. "
        "Frames that do not show the person well enough get no draft. Drafts become keyframes when "
        "you confirm them in the page, or with --accept; the ones to confirm first are listed. "
        "With several --box each person becomes a body of the session: they are followed together, "
        "so that nobody is taken for another who passes. "
        "Ctrl+C keeps the frames the network has looked at; the same command with --overwrite goes "
        "on from there."
    )
    command = add_command(commands, "draft", details, _DRAFT_EXAMPLES)
    command.add_argument(
        "video",
        metavar="VIDEO",
        type=file_name,
        help="video file or folder of images; with --accept also a session that is drafted",
    )
    add_film_orders(command)
    command.set_defaults(more_box=())
    command.add_argument(
        "--accept",
        action="store_true",
        help="take the drafts that are proposed as approximate keyframes, without a look at them",
    )
    command.add_argument("--out", metavar="DIR", type=file_name, help="folder for the session")
    add_json(command)
    add_overwrite(command)


_ADD_FILM_EXAMPLES = """\
  keypose add-film jump.keypose side.mp4 --dry-run --json
  keypose add-film jump.keypose side.mp4
  keypose add-film jump.keypose side.mp4 --begins 3.4 --box 180,90,400,600
"""


def add_add_film(commands: Subcommands) -> None:
    details = (
        "One film tells how far away a limb is by guess; a second one sees it. Both films are "
        "tracked together from then on. When it was taken is found from the motion that both show, "
        "with its ±, and where its camera stands from the body itself; a lens that is a guess, in "
        "either film, is found with it. Keyframes that were posed in one film are mended by both. "
        "Where the motion repeats itself, every moment that is as likely is printed."
    )
    command = add_command(commands, "add-film", details, _ADD_FILM_EXAMPLES)
    add_session(command)
    command.add_argument(
        "video", metavar="FILM", type=file_name, help="video file or folder of images"
    )
    add_order(command, BesideOrder)
    add_order(command, FilmTaken)
    command.add_argument(
        "--calibration",
        metavar="FILE",
        type=file_name,
        help="the cameras of both films: Qualisys, TOML of Anipose, FreeMoCap or Pose2Sim, or a "
        "stereo calibration of OpenCV. Which are theirs is found, and they are refined by the body",
    )
    command.add_argument(
        "--dry-run", action="store_true", help="say what would change and write nothing"
    )
    add_json(command)


_ADD_BODY_EXAMPLES = """\
  keypose add-body jump.keypose child
  keypose add-body jump.keypose box --name ball
  keypose add-body jump.keypose --remove ball
"""


def add_add_body(commands: Subcommands) -> None:
    details = (
        f"A body is one of {', '.join(PRESETS)}, or a file as `keypose schema body` describes it. "
        "It has no keyframes yet: `keypose import` brings it some, or write them into the session. "
        "Every body is tracked by itself. What is removed goes with its keyframes and its motion; "
        "session.json.previous has them until the next save."
    )
    command = add_command(commands, "add-body", details, _ADD_BODY_EXAMPLES)
    command.add_argument("session", metavar="SESSION", type=session_file, help=SESSION_WORDS)
    command.add_argument(
        "preset",
        metavar="PRESET|BODY.json",
        nargs="?",
        help="the body to add; default: that of `keypose config`",
    )
    command.add_argument(
        "--name",
        metavar="NAME",
        type=typed(Name()),
        help="what it is called: its id is made of that; default: the body's own name",
    )
    command.add_argument(
        "--remove", metavar="NAME", help="instead, remove a body, by its id or name"
    )
    command.add_argument(
        "--dry-run", action="store_true", help="say what would change and write nothing"
    )
    add_json(command)


_TRACK_EXAMPLES = """\
  keypose track session.json
  keypose track session.json --quality preview --workers 2 --out try
  keypose track session.json --json > events.jsonl
  keypose track session.json --method paper --initial templates --leave-out right_hand
  keypose track session.json --cues brightness
  keypose track session.json --frames 10-50
  keypose track session.json --ahead forward
"""


def add_track(commands: Subcommands) -> None:
    details = (
        "Results are written beside the session. With --out, a copy of the session and the "
        "results are written to that folder and the session is not changed. Ctrl+C or SIGTERM "
        "keeps finished segments. A session that is open in the page is not tracked. The exit "
        "code is 1 when tracking was lost somewhere."
    )
    command = add_command(commands, "track", details, _TRACK_EXAMPLES)
    add_session(command)
    add_order(command, EachBody)
    add_order(command, TrackOrder)
    add_order(command, Within)
    command.add_argument(
        "--ahead",
        choices=("forward", "backward", "both"),
        help="instead, follow the body on from the last keyframe, back from the first, or both, as "
        "far as it is seen well; one keyframe is enough. The poses become drafts of the session",
    )
    add_order(command, FilmTaken)
    add_work(command)


_STAND_EXAMPLES = """\
  keypose stand jump.keypose
  keypose stand jump.keypose --dry-run --json
"""


def add_stand(commands: Subcommands) -> None:
    details = (
        "Where feet stand still they become pins on the floor; keyframes stay exact in the picture "
        "and give way in depth. Where nobody has said what is up, upright lines in the picture, "
        "how the person stands and where the feet stand show it together, with its ±. Then the "
        "motion is solved for in space once more. What is left is printed: how far soles are off "
        "the floor, and frames in the air."
    )
    command = add_command(commands, "stand", details, _STAND_EXAMPLES)
    add_session(command)
    add_order(command, EachBody)
    command.add_argument(
        "--dry-run", action="store_true", help="say what would change and write nothing"
    )
    add_json(command)


_CAMERA_EXAMPLES = """\
  keypose camera jump.keypose
  keypose camera jump.keypose --kind turns --dry-run --json
  keypose camera jump.keypose --background hall.png
  keypose camera jump.keypose --forget
"""


def add_camera(commands: Subcommands) -> None:
    details = (
        "Points of the background are followed through the film, beside the body where it is posed "
        "or tracked, and beside what is masked. They tell how the camera turned and zoomed, so "
        "that the world stands still: floor, pins, smoothness and exports are in it. What was set "
        "right at frames stays as it was set."
    )
    command = add_command(commands, "camera", details, _CAMERA_EXAMPLES)
    add_session(command)
    actions = command.add_mutually_exclusive_group()
    actions.add_argument(
        "--kind", choices=("static", "turns", "moves"), help="how it moves, where you know"
    )
    actions.add_argument(
        "--background",
        type=file_name,
        metavar="FILE.png",
        help="write what stands behind the body, put together all around, of a camera that turns "
        "and is known; nothing else is done",
    )
    actions.add_argument(
        "--went",
        type=typed(Number(least=0.01, most=10_000, unit="m")),
        metavar="METRES",
        help="how far the camera went from where it began, where you know: the scale of its path; "
        "a motion that is known is not looked for again",
    )
    actions.add_argument("--forget", action="store_true", help="leave the camera as it was")
    command.add_argument(
        "--dry-run", action="store_true", help="say what would change and write nothing"
    )
    add_json(command)
    add_overwrite(command)


GOALS = (3, 5, 8, 12)
"""As in app.editor.review, which would load more than help needs."""

_REVIEW_EXAMPLES = """\
  keypose review session.json
  keypose review session.json --above 8 --frames 10-50
  keypose review session.json --json
"""


def add_review(commands: Subcommands) -> None:
    details = (
        "Each with its frame, its part, the error expected there and the reason; what a person has "
        "answered on the page is left out. Drafts to confirm come first."
    )
    command = add_command(commands, "review", details, _REVIEW_EXAMPLES)
    add_session(command)
    add_order(command, EachBody)
    add_order(command, Within)
    command.add_argument(
        "--above",
        metavar="PIXELS",
        type=int,
        choices=GOALS,
        help="list what is expected to be off by more: 3, 5, 8 or 12; default: 5, or the least "
        "that this video allows",
    )
    add_json(command)


REDUCED_EVERY = 20
"""Frames that one keyframe stands for, where nothing else is asked for."""

_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}

_SOURCES = ("tracked", "drafts", "imported")
"""As in app.editor.reduced, which would load more than help needs."""

_REDUCE_EXAMPLES = """\
  keypose reduce jump.keypose --tolerance 4px --from drafts
  keypose reduce jump.keypose
  keypose reduce jump.keypose --every 40 --frames 10-60
  keypose reduce jump.keypose --tolerance 2cm
  keypose reduce jump.keypose --limb left_forearm --dry-run
"""


def add_reduce(commands: Subcommands) -> None:
    details = (
        "The motion that was tracked, drafted or imported becomes keyframes to edit it by: one in "
        "20 frames, where it bends most. What lies between stays as it is, beside the session: a "
        "keyframe you correct bends the two segments beside it and nothing else, and tracking "
        "starts from it and keeps to it where the film shows nothing. With --tolerance there are "
        "the fewest from which interpolation alone gives the motion back, for programs that know "
        "nothing else. Keyframes that are there stay."
    )
    command = add_command(commands, "reduce", details, _REDUCE_EXAMPLES)
    add_session(command)
    add_order(command, OneBody)
    goal = command.add_mutually_exclusive_group()
    goal.add_argument(
        "--every",
        dest="goal",
        metavar="N",
        type=_every,
        default=str(REDUCED_EVERY),
        help=f"one keyframe in about so many frames; default: {REDUCED_EVERY}",
    )
    goal.add_argument(
        "--tolerance",
        dest="goal",
        metavar="DISTANCE",
        type=_tolerance,
        help="instead as many as interpolation needs to stay so near to the motion: in space, such "
        "as 2cm, in the picture, such as 5px, or both, 2cm,5px",
    )
    command.add_argument(
        "--frames",
        metavar="A-B",
        type=typed(FrameRange()),
        help="first and last frame to reduce; default: all",
    )
    command.add_argument(
        "--limb",
        metavar="PART",
        action="append",
        default=[],
        help="key the limb of this part alone, as part keyframes; may be repeated",
    )
    command.add_argument(
        "--from",
        dest="source",
        choices=_SOURCES,
        help="the motion to reduce; default: the first of these that there is",
    )
    command.add_argument(
        "--replace-keyframes",
        action="store_true",
        help="let keyframes that are there go where the motion does not need them",
    )
    command.add_argument(
        "--dry-run", action="store_true", help="print what would be, write nothing"
    )
    add_json(command)


def _every(text: str) -> Every:
    from keypose.tracker.reduction.result import Every

    return Every(typed(Whole(least=1))(text))


def _tolerance(text: str) -> Tolerance:
    """ "2cm", "5px", or both with a comma between."""
    from keypose.tracker.errors import ReductionError
    from keypose.tracker.reduction.result import Tolerance

    limits = {"metres": math.inf, "pixels": math.inf}
    for word in text.split(","):
        match = re.fullmatch(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*(m|cm|mm|px)\s*", word)
        if match is None:
            raise argparse.ArgumentTypeError(
                f"{text!r} is not a distance such as 2cm, 15mm, 5px or 2cm,5px"
            )
        number, unit = float(match[1]), match[2]
        if unit == "px":
            limits["pixels"] = number
        else:
            limits["metres"] = number * _METRES[unit]
    try:
        return Tolerance(**limits)
    except ReductionError as error:
        raise argparse.ArgumentTypeError(str(error).rstrip(".")) from None


_FIT_EXAMPLES = """\
  keypose open scan
  keypose fit scan
  keypose fit --session session.json --weights contact --out try --json > events.jsonl
"""

_FIT_DETAILS = (
    "Pose the body in at least one mesh first, with `keypose open MESHES`; the surface of that"
    " mesh then moves with the body. Results are written beside the session. With --out, a "
    "copy of the session and the results are written to that folder and the session is not "
    "changed. An unusable mesh is skipped and reported. Ctrl+C or SIGTERM keeps finished "
    "steps. The exit code is 1 when the body was lost somewhere."
)


def add_fit(commands: Subcommands) -> None:
    command = add_command(commands, "fit", _FIT_DETAILS, _FIT_EXAMPLES)
    command.add_argument(
        "meshes",
        metavar="MESHES",
        type=file_name,
        nargs="?",
        help="a folder of numbered PLY, OBJ or GLB files; default: the session's meshes",
    )
    command.add_argument(
        "--session",
        metavar="SESSION",
        type=session_file,
        help="the session's file or folder; default: the one beside the meshes, or in this folder",
    )
    of_session = "; default: the session's setting"
    command.add_argument(
        "--cameras",
        metavar="FILE",
        type=file_name,
        help="JSON file with the calibrated cameras, whose images tell which parts of the "
        f"surfaces are reliable{of_session}",
    )
    command.add_argument(
        "--weights",
        choices=("both", "contact", "photo", "none"),
        help="give surface near other parts (contact), surface where cameras disagree "
        f"(photo), or both less weight{of_session}",
    )
    command.add_argument(
        "--distance",
        choices=("plane", "point"),
        help=f"measure distance to the surface's tangent plane or to its nearest point{of_session}",
    )
    command.add_argument(
        "--binding",
        choices=("nearest", "smooth"),
        help="nearest: each surface point moves with the nearest part; smooth: near joints "
        f"with both parts{of_session}",
    )
    command.add_argument(
        "--units", choices=UNITS, help="unit of the meshes; must match the session's"
    )
    command.add_argument(
        "--up",
        choices=UP_AXES,
        help="up axis of the meshes, such as --up=-z; must match the session's",
    )
    command.add_argument(
        "--quality",
        choices=("full", "preview"),
        help=f"full, or less accurate and faster{of_session}",
    )
    add_work(command)


MOST_WORKERS = 256

_BATCH_EXAMPLES = """\
  keypose batch recordings
  keypose batch recordings --only outdated --export bvh,glb --out motion
  keypose batch */session.json --quality preview --workers 4 --json > events.jsonl
  keypose batch films.csv --out films --export bvh
  keypose batch /shared/recordings --scheduler tcp://10.0.0.1:8786

A table has a row for each film and columns film, name (of its session), box, frame, frames, body,
height, lens and others as the options of `keypose draft`; empty is as where the option is left
out. Films are taken as by `keypose run`, and a session that is there is tracked as it is.

On a cluster, `dask scheduler` and `dask worker` of the Dask project do the work; they need Keypose
installed and see the sessions and videos under the same paths as this computer. Their lines have
no password: keep them to a network you trust.
"""


def add_batch(commands: Subcommands) -> None:
    details = (
        "Results are written beside each session. Keyframes are never changed, and a session "
        "that is open in the page is skipped. An error in one session does not stop the "
        "others. A table and a page, batch-report.html, show the outcome. Ctrl+C or SIGTERM "
        "keeps finished segments; run the same command again to continue with the sessions "
        "that are left. The exit code is 1 when tracking was lost somewhere or a session was "
        "not tracked."
    )
    command = add_command(commands, "batch", details, _BATCH_EXAMPLES)
    command.add_argument(
        "paths",
        metavar="PATH",
        type=file_name,
        nargs="+",
        help="a session file, a folder to search for sessions (hidden folders are skipped), or a "
        "table of films (.csv, .tsv)",
    )
    command.add_argument(
        "--only",
        choices=("outdated",),
        help="track only segments whose results are missing, outdated or of a lower quality",
    )
    add_order(command, TrackOrder)
    _add_export(command)
    command.add_argument(
        "--out",
        metavar="DIR",
        type=file_name,
        help="folder for the report, the exported files and the sessions of a table's films, which "
        "otherwise lie beside the films; default: the deepest folder that contains all sessions. "
        "The progress of the batch is kept there too, in .keypose-batch",
    )
    _add_workers(command, "sessions")
    command.add_argument(
        "--scheduler", metavar="ADDRESS", help="use the Dask cluster of this scheduler instead"
    )
    add_json(command, "print JSON lines: events, the summary last")
    add_overwrite(command)


def _add_export(command: argparse.ArgumentParser, *, but: Container[str] = ()) -> None:
    command.add_argument(
        "--export",
        metavar="FORMAT[,FORMAT]",
        type=motion_formats,
        action=Once,
        default=(),
        help="also export the motion, beside each session or below --out; formats as in "
        "keypose export",
    )
    add_order(command, MotionOrder, but=but)


def _add_workers(command: argparse.ArgumentParser, subject: str) -> None:
    command.add_argument(
        "--workers",
        metavar="N",
        type=typed(Whole(least=1, most=MOST_WORKERS)),
        help=f"{subject} at the same time, one process each; default: one per core, with 2 GB of "
        "memory each",
    )


_RUN_EXAMPLES = """\
  keypose run jump.mp4 --out motion
  keypose run jump.mp4 --box 210,80,420,610 --frame 12 --out boxed --export bvh,glb
  keypose run recordings --height 178 --out all --export csv --json > events.jsonl
"""


def add_run(commands: Subcommands) -> None:
    details = (
        "The person is found, every frame drafted, the proposed drafts taken as approximate "
        "keyframes, the motion of a camera that moves found, the motion tracked and stood on the "
        "floor: what "
        "the page does, with nobody looking. Each film has a session of its own in the folder, to "
        "be opened in the page. What was decided and where to look is printed, and reported with "
        "pictures in batch-report.html. A film in which several people, or none, are found ends "
        "with that reason, and the others go on. Ctrl+C or SIGTERM keeps what is done; the same "
        "command goes on from there. The exit code is 1 when a film was not done, or tracking was "
        "lost somewhere."
    )
    command = add_command(commands, "run", details, _RUN_EXAMPLES)
    command.add_argument(
        "films",
        metavar="FILM",
        type=file_name,
        nargs="+",
        help="a video file, a folder of images, or a folder of video files",
    )
    command.add_argument(
        "--beside",
        metavar="FILM",
        type=file_name,
        action="append",
        help="another film of the same motion, tracked together with it, as `keypose add-film` "
        "adds it; may be given again",
    )
    add_film_orders(command)
    add_order(command, RunOrder)
    add_order(command, TrackOrder, but=options_of(DraftOrder))
    _add_export(command, but=options_of(FilmOrder))
    command.add_argument(
        "--out", metavar="DIR", type=file_name, required=True, help="folder for all that is written"
    )
    _add_workers(command, "films")
    command.set_defaults(scheduler=None)
    add_json(command, "print JSON lines: events, the summary last")
    add_overwrite(command)


_EVALUATE_EXAMPLES = """\
  keypose evaluate session.json --reference truth.npz
  keypose evaluate session.json --reference marked_joints.json --json
"""


def add_evaluate(commands: Subcommands) -> None:
    details = (
        "Only frames strictly between the keyframes of the tracking count. Linear "
        "interpolation between them is shown for comparison. The reference is an .npz file of "
        "poses or joint positions, or a .json file of marked joints in pixels."
    )
    command = add_command(commands, "evaluate", details, _EVALUATE_EXAMPLES)
    add_session(command)
    add_order(command, OneBody)
    command.add_argument(
        "--reference",
        metavar="FILE",
        type=file_name,
        required=True,
        help="poses or joint positions (.npz), or marked joints (.json)",
    )
    add_json(command)
