"""`python -m bench.profile SESSION FIRST-LAST`: where the time of tracking goes.

The segments that touch these frames are tracked twice as the session asks for, without keypoints
kept from before, and the second time is profiled: what loads and compiles is not of interest.
"""

from __future__ import annotations

import argparse
import cProfile
import pstats
import time
from pathlib import Path

from keypose.app.cli.arguments import session_file
from keypose.app.jobs.worker_cache import WorkerCache
from keypose.tracker.errors import KeyposeError
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, video_path
from keypose.tracker.tracking.pool import SegmentTracker

ROWS = 30
"""Functions that are listed, of those with the most time of their own, and in all."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m bench.profile", description=__doc__)
    parser.add_argument("session", type=session_file, metavar="SESSION")
    parser.add_argument("frames", type=_frames, metavar="FIRST-LAST")
    asked = parser.parse_args()
    try:
        _profile(asked.session, asked.frames)
    except KeyposeError as error:
        parser.error(str(error))


def _profile(place: Path, frames: tuple[int, int]) -> None:
    session = load_session(place)
    cache = WorkerCache()
    tracker = cache.tracker(session, str(video_path(session, place)), place.parent)
    first, last = frames
    touching = [n for n, (a, b) in enumerate(tracker.spans) if a < last and first < b]
    if not touching:
        raise KeyposeError(f"No segment of the session lies between frames {first} and {last}.")
    _track(tracker, session, touching)
    tracker = WorkerCache().tracker(session, str(video_path(session, place)), place.parent)
    profile, began = cProfile.Profile(), time.process_time()
    profile.runcall(_track, tracker, session, touching)
    seconds = time.process_time() - began
    count = sum(b - a for a, b in (tracker.spans[n] for n in touching))
    print(f"{count} frames, {1e3 * seconds / count:.1f} ms of a processor each, under the profiler")
    table = pstats.Stats(profile)
    table.sort_stats("tottime").print_stats(ROWS)
    table.sort_stats("cumtime").print_stats(ROWS)


def _track(tracker: SegmentTracker, session: Session, segments: list[int]) -> None:
    """On this thread, which alone is profiled."""
    for segment in segments:
        tracker.run_segment(tracker.spans[segment], session.settings, lambda step, number: None)


def _frames(text: str) -> tuple[int, int]:
    first, _, last = text.partition("-")
    try:
        return int(first), int(last)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"frames are two numbers, such as 0-30, not {text!r}"
        ) from None


if __name__ == "__main__":
    main()
