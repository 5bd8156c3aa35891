"""The same session again and again: the same bytes, whatever runs side by side."""

from __future__ import annotations

import hashlib

from bench.sequences import Sequence, sequence
from bench.table import Report
from bench.tracking import keyframes_every, track
from keypose.tracker.tracking.tracker import Tracker

TIMES, INTERVAL = 10, 12


def repeat(report: Report) -> None:
    """The whole group."""
    shown = sequence("throw")
    table = report.table(f"tracked {TIMES} times anew", "segments", "answers")
    digests: dict[int, list[str]] = {}
    for workers in (1, 2):
        digests[workers] = [_digest(shown, workers) for _ in range(TIMES)]
        segments = (len(shown.grey) - 1) // INTERVAL
        table.row(f"{workers} at a time", segments, len(set(digests[workers])))
    both = {digest for found in digests.values() for digest in found}
    report.expect("different answers", len(both), 1)


def _digest(shown: Sequence, workers: int) -> str:
    """Of the trajectories' bytes and their scores."""
    frames = keyframes_every(INTERVAL, 0, len(shown.grey) - 1)
    tracker = Tracker(shown.video(), shown.camera, shown.skeleton, shown.keyposes(frames))
    whole = hashlib.sha256()
    for segment in track(tracker, workers).segments:
        whole.update(segment.trajectory.Rs_parent_part.tobytes())
        whole.update(segment.trajectory.ps_camera_root.tobytes())
        whole.update(repr(segment.scores).encode())
    return whole.hexdigest()
