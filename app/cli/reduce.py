"""`keypose reduce`: a dense motion as a few keyframes to edit it by."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING, Any

from keypose.app.cli.arguments import (
    Subcommands,
    add_command,
    add_json,
    add_session,
    frames_asked,
    whole_number,
)
from keypose.app.cli.json_output import print_json

if TYPE_CHECKING:
    from keypose.app.editor.reduced import Reducible
    from keypose.tracker.reduction.result import Every, Reduction, Tolerance
    from keypose.tracker.session import Session

EVERY = 20
"""Frames that one keyframe stands for, where nothing else is asked for."""
_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
_SOURCES = ("tracked", "drafts", "imported")
"""As in app.editor.reduced, which would load more than help needs."""
_FOUND = {"tracked": "tracked", "drafts": "drafted", "imported": "imported"}

_EXAMPLES = """\
  keypose reduce jump.keypose
  keypose reduce jump.keypose --every 40 --frames 40-120
  keypose reduce jump.keypose --tolerance 2cm
  keypose reduce jump.keypose --tolerance 4px --from drafts
  keypose reduce jump.keypose --limb left_forearm --dry-run
"""


def add(commands: Subcommands) -> None:
    details = (
        "The motion that was tracked, drafted or imported becomes keyframes to edit it by: one in "
        "20 frames, where it bends most. What lies between stays as it is, beside the session: a "
        "keyframe you correct bends the two segments beside it and nothing else, and tracking "
        "starts from it and keeps to it where the film shows nothing. With --tolerance there are "
        "the fewest from which interpolation alone gives the motion back, for programs that know "
        "nothing else. Keyframes that are there stay."
    )
    command = add_command(commands, "reduce", run, details, _EXAMPLES)
    add_session(command)
    goal = command.add_mutually_exclusive_group()
    goal.add_argument(
        "--every",
        dest="goal",
        metavar="N",
        type=_every,
        default=str(EVERY),
        help=f"one keyframe in about so many frames; default: {EVERY}",
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
        type=frames_asked,
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


def run(arguments: argparse.Namespace) -> int:
    from keypose.app.document.folder_lock import locked
    from keypose.tracker.storage.files import load_session

    path = arguments.session
    # Reading it reports one that is not there.
    held = path.is_file() and not arguments.dry_run
    with locked(path, "close it there first") if held else nullcontext():
        session = load_session(path)
        found, reduction = _reduced(session, arguments)
        if not arguments.dry_run:
            _save(session, found, reduction, arguments)
    _print(session, found, reduction, arguments)
    return 0


def _reduced(session: Session, arguments: argparse.Namespace) -> tuple[Reducible, Reduction]:
    from keypose.app.editor.reduced import reducible
    from keypose.tracker.body.skeleton import Skeleton
    from keypose.tracker.reduction.reduce import reduce_motion
    from keypose.tracker.storage.results import load_results
    from keypose.tracker.storage.sidecars import load_first_motion_of

    found = reducible(
        session,
        load_results(session, arguments.session).fitting(session),
        load_first_motion_of(session, arguments.session.parent),
        frames=arguments.frames,
        source=arguments.source,
        limbs=arguments.limb,
        replacing=arguments.replace_keyframes,
    )
    skeleton, camera = Skeleton.of(session.body), session.camera
    with _progress() as progress:
        reduction = reduce_motion(
            skeleton, camera, found.motion, arguments.goal, found.required, found.parts,
            progress,
        )  # fmt: skip
    return found, reduction


def _save(
    session: Session, found: Reducible, reduction: Reduction, arguments: argparse.Namespace
) -> None:
    from keypose.app.editor.reduced import reduced_session
    from keypose.tracker.storage.files import open_video_of, save_session
    from keypose.tracker.storage.sidecars import save_own_motion

    path = arguments.session
    with open_video_of(session, path) as video:
        times_s = session.evidence.times_s(video.info.times_s)
    own = None if found.parts is not None else save_own_motion(session, path, found.motion)
    given = (found, reduction.frames, times_s, own)
    save_session(reduced_session(session, *given, replacing=arguments.replace_keyframes), path)


@contextmanager
def _progress() -> Iterator[Callable[[int, int], None]]:
    """A bar at a terminal; a log needs none."""
    if not sys.stderr.isatty():
        yield lambda done, expected: None
        return
    from tqdm import tqdm

    with tqdm(unit="frame", file=sys.stderr, dynamic_ncols=True, leave=False) as bar:

        def report(done: int, expected: int) -> None:
            bar.n, bar.total = done, expected
            bar.refresh()

        yield report


# --- what is printed


def _print(
    session: Session,
    found: Reducible,
    reduction: Reduction,
    arguments: argparse.Namespace,
) -> None:
    facts = _facts(session, found, reduction)
    if arguments.json:
        print_json({**facts, "written": None if arguments.dry_run else str(arguments.session)})
        return
    what = "part keyframes" if found.parts is not None else "keyframes"
    kept = f", {facts['kept']} of them there before" if facts["kept"] else ""
    print(
        f"{len(reduction.frames)} {what} for {reduction.known_count} "
        f"{_FOUND[found.source]} frames"
        f"{kept}: one in {reduction.frames_per_keyframe:.1f} frames."
    )
    print(f"Frames: {', '.join(map(str, reduction.frames))}")
    if found.parts is None:
        print("The motion between them stays as it is, for tracking to start from.")
    print(f"Interpolated alone, no point of the body is off by more than {_off(facts)}.")
    if facts["frames_without_a_pose"]:
        print(f"{facts['frames_without_a_pose']} frames have no pose; keyframes lead over them.")
    if not arguments.dry_run:
        print(f"Written: {arguments.session}")


def _off(facts: dict[str, Any]) -> str:
    off = {"cm": facts["off_cm"], "px": facts["off_px"]}
    return " and ".join(f"{value:.2g} {unit}" for unit, value in off.items() if value is not None)


def _facts(session: Session, found: Reducible, reduction: Reduction) -> dict[str, Any]:
    posed = session.keyframes if found.parts is None else session.part_keyframes
    own, tolerance = {keyframe.frame for keyframe in posed}, reduction.tolerance
    return {
        "source": found.source,
        "frames": list(reduction.frames),
        "kept": sum(frame in own for frame in reduction.frames),
        "frames_per_keyframe": reduction.frames_per_keyframe,
        "off_cm": None if math.isinf(tolerance.metres) else 100 * reduction.worst_m,
        "off_px": None if math.isinf(tolerance.pixels) else reduction.worst_px,
        "frames_without_a_pose": len(reduction.misses) - reduction.known_count,
    }


# --- arguments


def _every(text: str) -> Every:
    from keypose.tracker.reduction.result import Every

    return Every(whole_number(1)(text))


def _tolerance(text: str) -> Tolerance:
    """ "2cm", "5px", or both with a comma between."""
    from keypose.tracker.errors import ReductionError
    from keypose.tracker.reduction.result import Tolerance

    given = {"metres": math.inf, "pixels": math.inf}
    for word in text.split(","):
        match = re.fullmatch(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*(m|cm|mm|px)\s*", word)
        if match is None:
            raise argparse.ArgumentTypeError(
                f"{text!r} is not a distance such as 2cm, 15mm, 5px or 2cm,5px"
            )
        number, unit = float(match[1]), match[2]
        if unit == "px":
            given["pixels"] = number
        else:
            given["metres"] = number * _METRES[unit]
    try:
        return Tolerance(**given)
    except ReductionError as error:
        raise argparse.ArgumentTypeError(str(error).rstrip(".")) from None
