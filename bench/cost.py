"""What tracking costs: time, memory, and the time to a first result."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from threadpoolctl import threadpool_limits

from bench import children
from bench.keeping import ROOT
from bench.sequences import Sequence, walking
from bench.table import Report
from bench.tracking import keyframes_every, scene_of
from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.tracking.cycle import track_segment
from keypose.tracker.tracking.method import Paper
from keypose.tracker.tracking.pool import run
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video
from keypose.tracker.video.clip_loader import ONCE, Memory

LIVE_FRAME = 36
LIVE_MS = {2: {"preview": 16.0, "full": 60.0}, 1: {"preview": 24.0, "full": 90.0}}
"""By threads."""
PAPERS_SECONDS = 10.0
LINEAR_WITHIN = 1.15
MEMORY_WITHIN = 1.15
START_SECONDS = 0.6
OPEN_SECONDS = 0.5
COLD_SECONDS = 12.0
PLENTY = Memory(4_000_000_000, 400_000_000)
"""So that all pictures stay prepared while the chain alone is timed."""
SMALL_MEMORY_MB = 300
MEMORY_FRAMES = (100, 400, 1000)
LARGE_MEMORY_MB = 500
LARGE_FRAMES = 120
"""Of 2,000 frames as much is held as of so many: memory no longer grows."""


@dataclass(frozen=True)
class Timing:
    """Milliseconds: the least and the median of several runs."""

    least: float
    median: float

    @classmethod
    def of(cls, work: Callable[[], object], repeats: int = 7, per: float = 1.0) -> Timing:
        """Time `work`, run once before, and divide by `per` (frames, solves)."""
        work()
        return cls.spent([_seconds(work) for _ in range(repeats)], per)

    @classmethod
    def spent(cls, seconds: list[float], per: float = 1.0) -> Timing:
        ms = 1000 * np.array(seconds) / per
        return cls(float(ms.min()), float(np.median(ms)))

    def __str__(self) -> str:
        digits = 3 if self.median < 0.1 else 2 if self.median < 10 else 1
        return f"{self.least:.{digits}f}/{self.median:.{digits}f}"


def _seconds(work: Callable[[], object]) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def cost(report: Report) -> None:
    """The whole group."""
    cv2.setNumThreads(1)
    shown = walking()
    busy, cores = os.getloadavg()[0], os.cpu_count()
    report.note("one thread, least/median; 640×360, a walk, 16 parts")
    report.note(f"load when this began: {busy:.1f} on {cores} cores; beside others all is slower")
    with threadpool_limits(1):
        _chains(report, shown)
        _preparation(report, shown)
        _papers_own(report)
        _live(report, shown)
        _by_length(report, shown)
    _memory(report)
    _start(report)


def _tracker(shown: Sequence, interval: int, last: int = 72) -> Tracker:
    """Ready to track, its pictures prepared."""
    frames = keyframes_every(interval, 0, last)
    tracker = Tracker(
        shown.video(), shown.camera, shown.skeleton, shown.keyposes(frames), memory=PLENTY
    )
    for a, b in tracker.spans:
        tracker.loader((a, b)).load(a, b)
    return tracker


def _run(tracker: Tracker, segments: list[int] | None = None, workers: int = 1, **how: str) -> None:
    for _ in run(tracker, TrackSettings(**how), segments, workers):  # type: ignore[arg-type]
        pass


def _chains(report: Report, shown: Sequence) -> None:
    """The whole chain on prepared pictures."""
    table = report.table("the whole chain, prepared pictures, ms a frame", "every 12", "every 24")
    trackers = [_tracker(shown, interval) for interval in (12, 24)]
    for quality in ("full", "preview"):
        runs = (Timing.of(lambda t=t, q=quality: _run(t, quality=q), 7, 72) for t in trackers)
        table.row(quality, *runs)
    table.row("paper", *(Timing.of(lambda t=t: _run(t, method="paper"), 1, 72) for t in trackers))


def _preparation(report: Report, shown: Sequence) -> None:
    table = report.table("before tracking, ms a frame", "least/median")
    video = shown.video()
    frames = keyframes_every(24, 0, 72)

    def prepare() -> None:
        tracker = Tracker(video, shown.camera, shown.skeleton, shown.keyposes(frames))
        for a, b in pairwise(frames):
            tracker.loader((a, b)).load(a, b)

    table.row("preparation", Timing.of(prepare, 5, 75))
    for name in ("box", "person"):
        path = ROOT / "sample_videos" / name / f"{name}.mp4"
        with Video.open(path) as sample:
            info = sample.info
        spent = Timing.of(lambda path=path: _decoded(path), 5, info.frame_count)
        table.row(f"decoding {info.width}×{info.height} {info.codec}", spent)


def _decoded(path: object) -> None:
    with Video.open(str(path)) as video:
        for _ in video.frames(0, video.info.frame_count):
            pass


def _papers_own(report: Report) -> None:
    """The paper's own measurement: 10 frames, 10 passes, half size."""
    shown = walking((0, 10), (320, 180))
    tracker = _tracker(shown, 10, 10)
    start, end = tracker.keyposes[0], tracker.keyposes[10]
    segment = Segment(0, 10, start, end, tracker.loader((0, 10)).load(0, 10))
    method = Paper(passes=10, patience=100)
    scene = scene_of(tracker, (0, 10), method.density)
    spent = Timing.of(lambda: list(track_segment(scene, segment, method)), 3, 1000)
    report.note("\nthe paper's own measurement: 10 frames, 10 passes, 320×180, method paper")
    report.expect("Pentium 4, 2 GHz took about 10 s; here", spent.median, PAPERS_SECONDS, "s")


def _live(report: Report, shown: Sequence) -> None:
    """A keyframe is changed again and again: the two segments beside it, preview then full."""
    tracker = _tracker(shown, 12)
    beside = [tracker.spans.index(s) for s in tracker.spans if LIVE_FRAME in s]
    rng = np.random.default_rng(0)
    report.note("\nlive: the two 12-frame segments beside a changed keyframe, ms for both")
    for workers in (2, 1):
        spent: dict[str, list[float]] = {"preview": [], "full": []}
        for turn in range(16):
            tracker.move_keyframe(LIVE_FRAME, _nudged(shown, rng))
            for quality, seconds in spent.items():
                began = time.perf_counter()
                _run(tracker, beside, workers, quality=quality)
                if turn:  # the first one lays the points
                    seconds.append(time.perf_counter() - began)
        for quality, seconds in spent.items():
            timing = Timing.spent(seconds)
            what = f"{quality}, {workers} thread{'s' * (workers > 1)}, least {timing.least:.1f}:"
            report.expect(f"{what} median", timing.median, LIVE_MS[workers][quality], "ms")


def _nudged(shown: Sequence, rng: np.random.Generator) -> Pose:
    """The true pose at LIVE_FRAME, a degree and half a centimetre off."""
    skeleton: Skeleton = shown.skeleton
    turns = skeleton.dof_turns == 1
    sigma = np.where(turns, np.radians(1.0), 0.005)
    return moved(skeleton, shown.truth.pose(LIVE_FRAME), rng.normal(0.0, sigma))


def _by_length(report: Report, shown: Sequence) -> None:
    table = report.table("by length, full, keyframes every 12", "ms", "ms a frame")
    trackers = {frames: _tracker(shown, 12, frames) for frames in (24, 48, 72)}
    seconds: dict[int, list[float]] = {frames: [] for frames in trackers}
    for _ in range(9):  # in turn, so that a busy moment meets them all
        for frames, tracker in trackers.items():
            began = time.perf_counter()
            _run(tracker)
            seconds[frames].append(time.perf_counter() - began)
    each = [1000 * min(spent) / frames for frames, spent in seconds.items()]
    for (frames, spent), ms in zip(seconds.items(), each, strict=True):
        table.row(f"{frames} frames", Timing.spent(spent), ms)
    report.expect("dearest frame over cheapest", max(each) / min(each), LINEAR_WITHIN)


def _memory(report: Report) -> None:
    """Peak memory of child processes that track films, as `keypose track` does."""
    children.peak_mb(children.looped_film(MEMORY_FRAMES[0] // 2, 1, 12), None)  # compiles
    columns = tuple(f"{frames} frames" for frames in MEMORY_FRAMES)
    table = report.table("peak memory, MB, 640×360, keyframes every 12, full", *columns)
    films = [children.looped_film(frames, 1, 12) for frames in MEMORY_FRAMES]
    for limit in (SMALL_MEMORY_MB, None):
        peaks = [children.peak_mb(each, limit) for each in films]
        words = f"within {limit or ONCE.most // 1_000_000} MB"
        table.row(words, *(round(peak) for peak in peaks))
        filled = peaks if limit else peaks[1:]
        what = f"{words}, filled: most frames over fewest"
        report.expect(what, filled[-1] / filled[0], MEMORY_WITHIN)
        if limit:
            report.expect("the whole process", max(peaks), SMALL_MEMORY_MB, "MB")
    large = children.peak_mb(children.looped_film(LARGE_FRAMES, 3, 20), LARGE_MEMORY_MB)
    report.expect("1920×1080, keyframes every 20, whole process", large, LARGE_MEMORY_MB, "MB")


def _start(report: Report) -> None:
    """Child processes: `keypose track` on the box sample and `keypose open`, everything compiled,
    and the page's worker where nothing is."""
    spent = children.start_seconds(5)
    table = report.table("`keypose track` on the box sample, s", "least/median")
    for what, seconds in spent.items():
        table.row(what, f"{min(seconds):.2f}/{np.median(seconds):.2f}")
    first = float(np.median(spent["to the first trajectory"]))
    report.expect("start to first result", first, START_SECONDS, "s")
    report.note(f"share of imports: {np.median(spent['imports alone']) / first:.0%}")
    opened = float(np.median(children.open_seconds(5)))
    report.expect("`keypose open` to its first answer", opened, OPEN_SECONDS, "s")
    cold = children.cold_seconds()
    report.expect("nothing compiled: until a segment can be tracked", cold, COLD_SECONDS, "s")
