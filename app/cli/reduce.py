"""`keypose reduce`: a dense motion as a few keyframes to edit it by."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from keypose.app.cli.arguments import note
from keypose.app.cli.bodies import about_one
from keypose.app.cli.change import Change, run_change
from keypose.app.editor.reduced import Reducible, reduced_session, reducible
from keypose.app.words.problems import off_words
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.reduction.reduce import reduce_motion
from keypose.tracker.reduction.result import Reduction
from keypose.tracker.session import Session
from keypose.tracker.storage.files import open_video_of
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.storage.results import load_results
from keypose.tracker.storage.sidecars import load_first_motion, save_own_motion
from keypose.tracker.storage.tracks import load_tracks

_FOUND = {"tracked": "tracked", "drafts": "drafted", "imported": "imported"}


def run(arguments: argparse.Namespace) -> int:
    return run_change(arguments, _change)


def _change(whole: Session, arguments: argparse.Namespace) -> Change:
    session = about_one(whole, arguments)
    reducible_motion, reduction = _reduced(session, arguments)
    if reducible_motion.source != "tracked" and arguments.source is None:
        _say_outdated(session, arguments.session)
    facts = _facts(session, reducible_motion, reduction)
    return Change(
        lambda: _with_reduction(session, reducible_motion, reduction, arguments).about(
            whole.subject.id
        ),
        tuple(_lines(reducible_motion, reduction, facts)),
        {**facts, "written": None if arguments.dry_run else str(arguments.session)},
    )


def _say_outdated(session: Session, path: Path) -> None:
    """Say why what was tracked is not what is reduced."""
    if session.subject.results is None:
        return
    words = outdated_words(session, load_tracks(session, path))
    if words is not None:
        note(f"{words} Track it again and reduce that, or choose with --source.")


def _reduced(session: Session, arguments: argparse.Namespace) -> tuple[Reducible, Reduction]:
    reducible_motion = reducible(
        session,
        load_results(session, arguments.session).fitting(session),
        load_first_motion(session, arguments.session.parent),
        frames=arguments.frames,
        source=arguments.source,
        limbs=arguments.limb,
        replacing=arguments.replace_keyframes,
    )
    skeleton, camera = Skeleton.of(session.subject.body), session.view.camera
    with _progress() as progress:
        reduction = reduce_motion(
            skeleton,
            camera,
            reducible_motion.motion,
            arguments.goal,
            reducible_motion.required,
            reducible_motion.parts,
            progress,
            session.camera_path,
        )
    return reducible_motion, reduction


def _with_reduction(
    session: Session,
    reducible_motion: Reducible,
    reduction: Reduction,
    arguments: argparse.Namespace,
) -> Session:
    """The session with its keyframes; the motion between them is written beside it."""
    path = arguments.session
    with open_video_of(session, path) as video:
        times_s = session.evidence.times_s(video.info.times_s)
    own = (
        None
        if reducible_motion.parts is not None
        else save_own_motion(session, path, reducible_motion.motion)
    )
    replacing = arguments.replace_keyframes
    return reduced_session(
        session, reducible_motion, reduction.frames, times_s, own, replacing=replacing
    )


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


def _lines(
    reducible_motion: Reducible, reduction: Reduction, facts: Mapping[str, Any]
) -> Iterator[str]:
    noun = "part keyframes" if reducible_motion.parts is not None else "keyframes"
    kept = f", {facts['kept']} of them there before" if facts["kept"] else ""
    yield (
        f"{len(reduction.frames)} {noun} for {reduction.known_count} "
        f"{_FOUND[reducible_motion.source]} frames"
        f"{kept}: one in {reduction.frames_per_keyframe:.1f} frames."
    )
    yield f"Frames: {', '.join(map(str, reduction.frames))}"
    if reducible_motion.parts is None:
        yield "The motion between them stays as it is, for tracking to start from."
    off = off_words(facts["off_cm"], facts["off_px"])
    yield f"Interpolated alone, no point of the body is off by more than {off}."
    if facts["frames_without_a_pose"]:
        yield f"{facts['frames_without_a_pose']} frames have no pose; keyframes lead over them."


def _facts(session: Session, reducible_motion: Reducible, reduction: Reduction) -> dict[str, Any]:
    posed = (
        session.subject.keyframes
        if reducible_motion.parts is None
        else session.subject.part_keyframes
    )
    own, tolerance = {keyframe.frame for keyframe in posed}, reduction.tolerance
    return {
        "source": reducible_motion.source,
        "frames": list(reduction.frames),
        "kept": sum(frame in own for frame in reduction.frames),
        "frames_per_keyframe": reduction.frames_per_keyframe,
        "off_cm": None if math.isinf(tolerance.metres) else 100 * reduction.worst_m,
        "off_px": None if math.isinf(tolerance.pixels) else reduction.worst_px,
        "frames_without_a_pose": len(reduction.misses) - reduction.known_count,
    }
