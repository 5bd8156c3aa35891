"""`keypose draft`: a box around a person on one frame, and every frame gets a draft pose."""

from __future__ import annotations

import argparse
import math
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from keypose.app.cli.arguments import (
    order_of,
)
from keypose.app.cli.json_output import print_json
from keypose.app.cli.long_work import set_when_interrupted
from keypose.app.document.folder_lock import locked
from keypose.app.document.new import new_session
from keypose.app.editor.camera import as_taken
from keypose.app.editor.drafted import KEYPOINT_SOURCE, drafted_session, require_draftable
from keypose.app.jobs.draft import Drafted, drafted, taken_and_left
from keypose.app.jobs.rerun import with_repeats, with_settings
from keypose.app.orders.tracking import DraftOrder, FilmTaken, said
from keypose.app.words.jobs import about_words
from keypose.tracker.body.body import preset
from keypose.tracker.errors import KeypointError, SessionError
from keypose.tracker.fitting.draft import ClipDraft, DraftProgress
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.keypoints.region import Box
from keypose.tracker.session import Session
from keypose.tracker.storage.atomic import make_folder, require_absent, require_folder, write_file
from keypose.tracker.storage.files import session_json
from keypose.tracker.storage.fingerprints import needs_masks
from keypose.tracker.storage.pace import known_or_measured
from keypose.tracker.storage.sidecars import save_keypoints
from keypose.tracker.tracking.pool import Cancelled
from keypose.tracker.video import Video

DONE, INTERRUPTED = 0, 130

_REASONS = {
    "start": "first draft",
    "end": "last draft",
    "pose": "turning point of the motion",
    "residual": "joints lie beside their keypoints",
    "hidden": "joints are hidden",
    "flip": "may point the other way in depth",
    "person": "may be another person from here on",
}


def run(arguments: argparse.Namespace) -> int:
    if len(arguments.box) > 1:
        raise KeypointError("--box is given twice. Draft one person at a time.")
    (box,) = arguments.box
    body = None if arguments.body is None else preset(arguments.body)
    place = arguments.out / "session.json"
    if not arguments.overwrite:
        require_absent([place], error=SessionError)
    require_folder(arguments.out, error=SessionError)
    taken = said(order_of(FilmTaken, arguments))
    with Video.open(arguments.video, deinterlace=taken.get("deinterlace", True)) as video:
        session = as_taken(new_session(video, place), taken)
        session = with_settings(session, order_of(DraftOrder, arguments))
        if body is not None:
            session = session.changed({"body": body})
        if arguments.field_of_view is not None:
            given = {"camera": _camera(session, arguments), "lens_source": "person"}
            session = session.changed(given)
        frames = arguments.frames or (0, session.view.video.frame_count - 1)
        at = frames[0] if arguments.frame is None else arguments.frame
        require_draftable(session, at, box, frames)
        session = with_repeats(session, video, *frames)
        _say_how_long(session, frames, video.info.fps, arguments.json)
        try:
            found = _drafted(session, video, at, box, frames, arguments.json)
        except Cancelled:
            print("Interrupted: nothing was written.", file=sys.stderr)
            return INTERRUPTED
        draft, _, detected = found
        make_folder(arguments.out, error=SessionError)
        with locked(place, "close it there, or choose another --out"):
            written = _save(session, place, found, frames, at, box, video, arguments.overwrite)
    _print(draft, frames, detected or frames, written, arguments.json)
    if detected is None:
        return DONE
    words = "the same command with --overwrite goes on from there"
    print(f"Interrupted: frames {detected[0]}–{detected[1]} are drafted; {words}.", file=sys.stderr)
    return INTERRUPTED


def _say_how_long(session: Session, frames: tuple[int, int], fps: float, as_json: bool) -> None:
    """Say what a draft will take, where it takes long: as known of this computer, else measured."""
    if as_json:
        return
    count = frames[1] - frames[0] + 1
    network = session.settings.network_used
    seconds = count * known_or_measured(network)
    if not needs_masks(session) and find_model(network).skips_frames_at(fps):
        seconds /= 2
    if words := about_words(seconds):
        print(f"Drafting {count} frames takes {words}.", file=sys.stderr, flush=True)


def _camera(session: Session, arguments: argparse.Namespace) -> Camera:
    video = session.view.video
    angle = math.radians(arguments.field_of_view)
    return Camera.from_field_of_view(video.width, video.height, angle)


def _drafted(
    session: Session,
    video: Video,
    at: int,
    box: Box,
    frames: tuple[int, int],
    as_json: bool,
) -> Drafted:
    stop = threading.Event()
    with set_when_interrupted(stop), _reporter(as_json) as report:
        return drafted(
            session,
            video,
            at,
            box,
            frames,
            proportions=True,
            report=report,
            cancelled=stop.is_set,
        )


def _save(
    session: Session, place: Path, found: Drafted, frames: tuple[int, int], at: int, box: Box,
    video: Video, overwrite: bool,
) -> tuple[Path, Path]:  # fmt: skip
    """The session's file and that of the keypoints, both written."""
    draft, network, detected = found
    only, rest = taken_and_left(range(frames[0], frames[1] + 1), detected, at, box)
    session = save_keypoints(
        session, place, draft.keypoints, KEYPOINT_SOURCE, network=network, seeds=(at,)
    )
    times_s = session.evidence.times_s(video.info.times_s)
    given = (draft.body, draft.poses, session.view.keypoints, draft.proposals, times_s)
    done = drafted_session(session, frames, *given, session.world.up_world, only, rest)
    write_file(
        place, session_json(done), overwrite=overwrite, keep_previous=True, error=SessionError
    )
    assert done.view.keypoints is not None
    return place, place.with_name(done.view.keypoints.file)


# --- what is printed


@contextmanager
def _reporter(as_json: bool) -> Iterator[Callable[[DraftProgress], None]]:
    """JSON lines, a bar at a terminal, or nothing: a log needs no progress."""
    if as_json:
        yield _print_progress
    elif sys.stderr.isatty():
        with _bar() as report:
            yield report
    else:
        yield lambda progress: None


def _print_progress(progress: DraftProgress) -> None:
    event = {"event": "progress", "stage": progress.stage}
    print_json({**event, "done": progress.done, "expected": progress.expected})


@contextmanager
def _bar() -> Iterator[Callable[[DraftProgress], None]]:
    """A bar that counts frames, of the network first and then of the poses."""
    from tqdm import tqdm

    words = {"keypoints": "Looking for the person", "poses": "Posing"}
    with tqdm(unit="frame", file=sys.stderr, dynamic_ncols=True) as bar:

        def report(progress: DraftProgress) -> None:
            bar.set_description(words[progress.stage], refresh=False)
            bar.n, bar.total = progress.done, progress.expected
            bar.refresh()

        yield report


def _print(
    draft: ClipDraft,
    frames: tuple[int, int],
    detected: tuple[int, int],
    written: tuple[Path, Path],
    as_json: bool,
) -> None:
    if as_json:
        print_json(_facts(draft, frames, detected, written))
        return
    count = frames[1] - frames[0] + 1
    print(f"Drafts at {len(draft.poses)} of {count} frames.")
    print("Confirm these first:")
    for proposal in draft.proposals:
        about = ", ".join(part.replace("_", " ") for part in proposal.parts)
        words = f"{about}: {_REASONS[proposal.reason]}" if about else _REASONS[proposal.reason]
        print(f"  frame {proposal.frame}: {words}")
    for path in reversed(written):
        print(f"Written: {path}")


def _facts(
    draft: ClipDraft,
    frames: tuple[int, int],
    detected: tuple[int, int],
    written: tuple[Path, Path],
) -> dict[str, Any]:
    seen = set(range(detected[0], detected[1] + 1))
    missing, left = sorted(seen - set(draft.poses)), set(range(frames[0], frames[1] + 1)) - seen
    proposals = [
        {"frame": p.frame, "reason": p.reason, "parts": list(p.parts)} for p in draft.proposals
    ]
    session, keypoints = map(str, written)
    return {
        "event": "finished", "drafts": len(draft.poses), "missing": missing,
        "left": sorted(left),
        "proposals": proposals, "session": session, "keypoints": keypoints,
    }  # fmt: skip


# --- arguments
