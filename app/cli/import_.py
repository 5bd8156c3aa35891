"""`keypose import`: recorded motion as a start for tracking, keypoints as first poses."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from keypose.app.cli.arguments import (
    Subcommands,
    add_command,
    add_json,
    add_session,
    file_name,
    note,
    whole_number,
)
from keypose.app.cli.import_camera import add_camera, import_camera, require_no_other
from keypose.app.cli.json_output import print_json
from keypose.app.export.import_choices import EVERY, LEAST_TRACKED, KeypointChoices, MotionChoices
from keypose.app.words.imports import note_words
from keypose.tracker.errors import FormatError
from keypose.tracker.keypoints.layouts import LAYOUTS

if TYPE_CHECKING:
    from keypose.app.export.importing import DraftImport, MotionImport
    from keypose.tracker.formats.joint_motion import World
    from keypose.tracker.session import Session

WORLDS: Final[dict[str, World]] = {"camera": "camera", "y-up": "y up", "z-up": "z up"}

UNLIKE = 0.05
"""Share by which bodies differ in size before it is reported."""
MOST_NAMES, LONGEST_NAME = 12, 60
"""Names that are listed as left out, and letters of one; JSON has all of them."""

_EXAMPLES = """\
  keypose import session.json walk.bvh
  keypose import session.json walk.trc --offset-frames 12 --names names.json
  keypose import session.json openpose/ --keypoints --frames 0,24,48
  keypose import dog.json dogDLC.h5 --keypoints --map withers=neck --map tailtip=tail.end
  keypose import session.json shot.chan --camera
"""


def add(commands: Subcommands) -> None:
    summary = "Import a motion recorded elsewhere, 2D keypoints, or a camera"
    details = (
        "BVH, TRC, C3D, CSV, or SMPL poses of AMASS, GVHMR, GEM or WHAM (.npz, .pt): the motion "
        "is fitted to the session's body, aligned with its keyframes and saved as an initial "
        "guess, which tracking uses where it scores better than its own. With --keypoints, COCO, "
        "AlphaPose, OpenPose, MediaPipe, SLEAP or DeepLabCut: drafts poses at some frames. "
        "Keyframes are never changed."
    )
    command = add_command(commands, "import", run, summary, details, _EXAMPLES)
    add_session(command)
    what = "motion file; with --keypoints a JSON, CSV or HDF5 file, or OpenPose's folder"
    command.add_argument("file", metavar="FILE", type=file_name, help=what)
    both = command.add_argument_group("motion and keypoints")
    both.add_argument(
        "--map",
        metavar="NAME=PLACE",
        type=_pair,
        action="append",
        help="where on the body a joint or keypoint is, if its name does not say: a part, PART.end "
        "or a landmark; may be repeated",
    )
    both.add_argument(
        "--offset-frames",
        metavar="N",
        type=int,
        help="video frame at the file's time or frame 0; may be negative, as -1 is for pictures "
        "counted from 1",
    )
    both.add_argument("--individual", metavar="NAME", help="which of several subjects to read")
    motion = command.add_argument_group("motion")
    motion.add_argument(
        "--names", metavar="MAP.json", type=file_name, help='{"their name": "our joint", …}'
    )
    motion.add_argument(
        "--offset-s", metavar="S", type=_seconds, help="video time at the file's time 0, in seconds"
    )
    motion.add_argument(
        "--unit",
        choices=("m", "cm", "mm", "auto"),
        help="unit of the file's lengths; auto scales them to the body; default: the file's "
        "unit, else auto",
    )
    motion.add_argument(
        "--world",
        choices=tuple(WORLDS),
        help="the file's frame, where no keyframe overlaps and it does not say: the camera's, or "
        "a world with y or z up",
    )
    motion.add_argument("--fps", metavar="X", type=_rate, help="frames per second of the file")
    points = command.add_argument_group("keypoints")
    points.add_argument("--keypoints", action="store_true", help="the file holds 2D keypoints")
    points.add_argument(
        "--layout",
        metavar="NAME",
        type=str.upper,
        choices=tuple(LAYOUTS),
        help=f"order of the keypoints if the file does not state it: {', '.join(LAYOUTS)}",
    )
    points.add_argument("--exchange", action="store_true", help="swap left and right keypoints")
    points.add_argument("--frames", metavar="N,N,…", type=_frames, help="frames to draft")
    points.add_argument(
        "--every",
        metavar="N",
        type=whole_number(1),
        help=f"frames from one draft to the next; default: {EVERY}",
    )
    add_camera(command)
    add_json(command)


def run(arguments: argparse.Namespace) -> int:
    from keypose.app.document.folder_lock import locked
    from keypose.tracker.formats.apart import reading_apart
    from keypose.tracker.formats.keypoint_files import read_people
    from keypose.tracker.formats.reading import load_motion
    from keypose.tracker.storage.files import load_session, open_video_of

    path: Path = arguments.session
    # Reading it reports one that is not there.
    alone = locked(path, "close it there first") if path.is_file() else nullcontext()
    if arguments.camera:
        require_no_other(arguments, ("keypoints", *_MOTION, *_KEYPOINTS, *_BOTH))
        with alone:
            import_camera(arguments)
        return 0
    _require_of_a_kind(arguments)
    file: Path = arguments.file
    reader: Callable[..., Any] = read_people if arguments.keypoints else load_motion
    with reading_apart(reader) as read, alone:
        from keypose.app.export.importing import (
            DraftImport,
            as_chosen,
            import_keypoints,
            import_motion,
        )

        session = load_session(arguments.session)
        with open_video_of(session, arguments.session) as video:
            info = video.info
        if arguments.keypoints:
            chosen, people = _keypoint_choices(arguments), read(file, arguments.individual)
            drafts = import_keypoints(session, people, file.name, chosen, info)
            _keep_drafts(session, drafts, arguments)
        else:
            choices = _motion_choices(arguments)
            motion = as_chosen(file.name, read(file), choices)
            times_s = session.evidence.times_s(info.times_s)
            made = import_motion(session, motion, file.name, choices, times_s)
            if isinstance(made, DraftImport):
                _keep_drafts(session, made, arguments)
            else:
                _keep_motion(session, made, arguments)
    return 0


_MOTION = ("names", "offset_s", "unit", "world", "fps")
_KEYPOINTS = ("layout", "exchange", "frames", "every")
_BOTH = ("map", "offset_frames", "individual")
"""Options of a motion, of keypoints, of both."""


def _require_of_a_kind(arguments: argparse.Namespace) -> None:
    """An option of the other kind would be ignored in silence."""
    others = _MOTION if arguments.keypoints else _KEYPOINTS
    given = [name for name in others if getattr(arguments, name) not in (None, False)]
    if given:
        kind = "motion, not for --keypoints" if arguments.keypoints else "--keypoints"
        raise FormatError(f"--{given[0].replace('_', '-')} is for {kind}.")
    for one, other in (("offset_frames", "offset_s"), ("frames", "every")):
        if getattr(arguments, one) is not None and getattr(arguments, other) is not None:
            names = (f"--{name.replace('_', '-')}" for name in (one, other))
            raise FormatError(f"{' and '.join(names)} mean the same; give one of them.")


# --- motion


def _motion_choices(arguments: argparse.Namespace) -> MotionChoices:
    from keypose.tracker.formats.joint_names import load_names

    return MotionChoices(
        names=None if arguments.names is None else load_names(arguments.names),
        places=_places(arguments),
        offset_frames=arguments.offset_frames,
        offset_s=arguments.offset_s,
        unit=arguments.unit,
        world=None if arguments.world is None else WORLDS[arguments.world],
        fps=arguments.fps,
        individual=arguments.individual,
    )


def _keep_motion(session: Session, made: MotionImport, arguments: argparse.Namespace) -> None:
    from keypose.tracker.storage.files import save_session
    from keypose.tracker.storage.sidecars import save_first_motion

    found, file = made.found, arguments.file.name
    motion = found.fit.trajectory
    saved = save_first_motion(session, arguments.session, motion, file, made.matched)
    save_session(saved, arguments.session)
    assert saved.first_motion is not None
    written = arguments.session.parent / saved.first_motion.file
    _print_motion(_facts(made, written), arguments.json)
    for words in note_words(found.notes):
        note(words)
    if found.scale == 1.0 and abs(found.size - 1.0) > UNLIKE:
        percent, word = 100 * abs(1 / found.size - 1), "larger" if found.size < 1 else "smaller"
        note(f"its body is {percent:.0f} % {word} than the session's; --unit auto would scale it.")
    if len(session.keyframes) < LEAST_TRACKED:
        note(
            f"keypose reduce {arguments.session} makes keyframes of it, to edit and to track from."
        )


def _facts(made: MotionImport, written: Path) -> dict[str, Any]:
    import numpy as np

    from keypose.app.export.importing import names_of
    from keypose.tracker.solver.fit_joints import POOR_M

    found = made.found
    fit, rms = found.fit, found.fit.rms_m
    worst = int(np.nanargmax(rms))
    return {
        "written": str(written),
        "first_frame": fit.trajectory.first_frame,
        "last_frame": fit.trajectory.last_frame,
        **names_of(found.matched, made.names),
        "size": found.size,
        "scale": found.scale,
        "rms_cm": float(100 * np.sqrt(np.nanmean(rms**2))),
        "worst_rms_cm": float(100 * rms[worst]),
        "worst_frame": fit.trajectory.first_frame + worst,
        "not_converged": [
            fit.trajectory.first_frame + int(n)
            for n in np.flatnonzero(~fit.converged & (rms > POOR_M))
        ],
        "keyframes": list(found.aligned),
        "from_keyframes_cm": 100 * found.keyframes_m,
        "notes": note_words(found.notes),
    }


def _print_motion(facts: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(facts)
        return
    print(f"Frames {facts['first_frame']}–{facts['last_frame']}.")
    _print_names(facts, "joints")
    if f"{facts['scale']:.3g}" != "1":
        print(f"Scaled to the body's size: × {facts['scale']:.4g}")
    print(
        f"Joint error {facts['rms_cm']:.2f} cm (rms), at most "
        f"{facts['worst_rms_cm']:.2f} cm at frame {facts['worst_frame']}."
    )
    if facts["keyframes"]:
        frames = ", ".join(str(frame) for frame in facts["keyframes"])
        print(f"Aligned with keyframes {frames}: {facts['from_keyframes_cm']:.1f} cm from them.")
    else:
        print("No keyframe overlaps: the motion is placed before the camera for now.")
    if facts["not_converged"]:
        note(f"the fit did not converge at {len(facts['not_converged'])} frames.")
    print(f"Written: {facts['written']}")


# --- keypoints


def _keypoint_choices(arguments: argparse.Namespace) -> KeypointChoices:
    return KeypointChoices(
        layout=arguments.layout,
        places=_places(arguments),
        individual=arguments.individual,
        exchange=arguments.exchange,
        frames=arguments.frames,
        every=arguments.every,
        offset_frames=arguments.offset_frames,
    )


def _keep_drafts(session: Session, found: DraftImport, arguments: argparse.Namespace) -> None:
    from keypose.tracker.storage.files import save_session

    if found.drafts:
        save_session(found.added_to(session), arguments.session)
    _print_drafts(session, found, arguments)


def _print_drafts(session: Session, found: DraftImport, arguments: argparse.Namespace) -> None:
    from keypose.app.export.importing import names_of

    drafts, frames, names = found.drafts, found.frames, names_of(found.known, found.names)
    made = {draft.keyframe.frame for draft in drafts}
    posed = {k.frame for k in (*session.keyframes, *session.drafts)}
    kept = [frame for frame in frames if frame in posed]
    empty = [frame for frame in frames if frame not in posed and frame not in made]
    if arguments.json:
        drafts_json = [
            {
                "frame": draft.keyframe.frame,
                "keypoints": draft.keypoints,
                "miss_px": draft.miss_px,
                "converged": draft.converged,
                "doubtful": draft.doubtful,
            }
            for draft in drafts
        ]
        notes = note_words(found.notes)
        facts = {"drafts": drafts_json, "kept": kept, "without_keypoints": empty, "notes": notes}
        print_json({**names, **facts})
        return
    _print_names(names, "keypoints")
    for draft in drafts:
        doubt = "; look at it closely" if draft.doubtful or not draft.converged else ""
        print(
            f"Draft at frame {draft.keyframe.frame}: {draft.keypoints} keypoints, missed by "
            f"{draft.miss_px:.1f} px on average{doubt}"
        )
    if kept:
        print(f"Left as posed: {', '.join(map(str, kept))}")
    if empty:
        print(f"Too few keypoints: {', '.join(map(str, empty))}")
    for words in note_words(found.notes):
        note(words)
    if drafts:
        print(f"Written: {arguments.session}")


# --- names


def _places(arguments: argparse.Namespace) -> dict[str, str]:
    """Return what --map says."""
    wanted = dict(arguments.map or ())
    if len(wanted) < len(arguments.map or ()):
        raise FormatError("--map names a keypoint twice.")
    return wanted


def _print_names(facts: dict[str, Any], what: str) -> None:
    matched = facts["matched"].items()
    pairs = ", ".join(f"{theirs[:LONGEST_NAME]} = {ours}" for theirs, ours in matched)
    print(f"Matched {len(facts['matched'])} {what} ({facts['convention']}): {pairs}")
    if facts["left_out"]:
        count, more = len(facts["left_out"]), ", …" if len(facts["left_out"]) > MOST_NAMES else ""
        names = (name[:LONGEST_NAME] for name in facts["left_out"][:MOST_NAMES])
        print(f"Left out {count}: {', '.join(names)}{more}")


# --- arguments


def _pair(text: str) -> tuple[str, str]:
    name, sign, place = text.rpartition("=")
    if not (name and sign and place):
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=PLACE, such as tailtip=tail.end")
    return name, place


def _seconds(text: str) -> float:
    return _number(text, -1e6, 1e6)


def _rate(text: str) -> float:
    return _number(text, 1e-3, 1e5)


def _number(text: str, least: float, most: float) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not least <= number <= most:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from {least:g} to {most:g}")
    return number


def _frames(text: str) -> list[int]:
    parse = whole_number(0)
    return [parse(word) for word in text.split(",")]
