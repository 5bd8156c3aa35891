"""`keypose track --ahead`: the body followed on from a keyframe, its poses saved as drafts."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from keypose.app.cli.exit_codes import DONE, INTERRUPTED, NOT_ALL_DONE
from keypose.app.cli.json_output import print_json
from keypose.app.cli.long_work import set_when_interrupted, warm_tracker
from keypose.app.cli.outcome import locked_place, require_place, write_copy
from keypose.app.editor.ahead import followed_session, found_sentence, start_frame
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.outdated import up_to_date
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.operations.track import track_ahead
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import Direction
from keypose.tracker.storage.files import open_video_of, save_session
from keypose.tracker.storage.sidecars import keypoints_of_session
from keypose.tracker.tracking.ahead.follow import FoundAhead
from keypose.tracker.tracking.pool import Cancelled
from keypose.tracker.video import Video

_WAYS: Mapping[str, tuple[Direction, ...]] = {
    "forward": ("forward",),
    "backward": ("backward",),
    "both": ("forward", "backward"),
}


def track_ahead_and_save(
    session: Session,
    asked: Session,
    posed: str,
    arguments: argparse.Namespace,
) -> int:
    """Follow the body as the session was asked for, save the drafts and print how far it came; the
    exit code.

    session: what is saved, about the body that is followed.  asked: the same with the command
    line's settings, for this run alone.  posed: the id of the body that the file is about.
    arguments: session, ahead, out, overwrite, json.
    """
    require_place(arguments)
    ways = _ways(session, arguments.ahead)
    stop, followed = threading.Event(), []
    with open_video_of(asked, arguments.session) as video, locked_place(arguments) as place:
        warm_tracker(asked)
        with set_when_interrupted(stop):
            for direction in ways:
                if not stop.is_set():
                    followed.append(_followed(asked, video, direction, stop, arguments))
        times_s = session.evidence.times_s(video.info.times_s)
        for each in followed:
            session = followed_session(
                up_to_date(session), each.frame, each.motion, each.to_frame, each.stop, times_s
            )
        if any(each.to_frame != each.frame for each in followed):
            if arguments.out is None:
                save_session(session.about(posed), place)
            else:
                write_copy(session.changed({"results": None}), arguments)
    _print(followed, str(place), arguments.json)
    if stop.is_set():
        return INTERRUPTED
    return DONE if all(each.to_frame != each.frame for each in followed) else NOT_ALL_DONE


def _ways(session: Session, asked: str) -> list[Direction]:
    """Keep the ways that lead anywhere; refused, before any work, where none of them does."""
    possible: list[Direction] = []
    why: ActionRefused | None = None
    for direction in _WAYS[asked]:
        try:
            start_frame(session, direction)
        except ActionRefused as refused:
            why = refused
        else:
            possible.append(direction)
    if why is not None and not possible:
        raise why
    return possible


def _followed(
    session: Session,
    video: Video,
    direction: Direction,
    stop: threading.Event,
    arguments: argparse.Namespace,
) -> FoundAhead:
    keypoints = keypoints_of_session(session, arguments.session.parent)
    with _reporter(arguments.json) as report:

        def emit(motion: Trajectory) -> None:
            if stop.is_set():
                raise Cancelled
            report(len(motion) - 1)

        return track_ahead(session, video, direction, emit=emit, keypoints=keypoints)


@contextmanager
def _reporter(as_json: bool) -> Iterator[Callable[[int], None]]:
    """JSON lines, a count at a terminal, or nothing: a log needs no progress."""
    if as_json:
        yield lambda frames: print_json({"event": "progress", "frames": frames})
    elif sys.stderr.isatty():
        from tqdm import tqdm

        with tqdm(unit="frame", file=sys.stderr, dynamic_ncols=True) as bar:

            def report(frames: int) -> None:
                bar.n = frames
                bar.refresh()

            yield report
    else:
        yield lambda frames: None


def _print(followed: list[FoundAhead], place: str, as_json: bool) -> None:
    if as_json:
        facts = [
            {"from": f.frame, "to": f.to_frame, **f.stop.model_dump(), "notes": list(f.notes)}
            for f in followed
        ]
        print_json({"event": "finished", "ahead": facts, "session": place})
        return
    for each in followed:
        print(found_sentence(each))
        for note in each.notes:
            print(f"  {note}")
    if any(each.to_frame != each.frame for each in followed):
        print(f"Written: {place}")
