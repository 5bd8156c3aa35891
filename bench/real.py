"""Real people: pixels at the marked joints between keyframes that were posed on marks alone.

`keyed.py` says what keyframes are made of. Each figure is the median over keyframes disturbed
by 0.5° a joint and 3 mm at the root, with its smallest and largest value beside it; no difference
smaller than that spread is one. A stance, where a planted ankle must not shake, is given for each
clip in `clips.py`: frames over which the marks of that ankle move by less than a mark is good to.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from bench.clips import Clip, clip
from bench.indicators import INDICATORS, Record, by_segment, judged, records
from bench.keeping import ROOT, Absent
from bench.keyed import Keyed, jittered, keyed
from bench.measures import Over, figures, marks_between
from bench.needed import (
    Choose,
    Outcome,
    steps_to_enough,
    where_suggested,
    where_worst,
    words,
)
from bench.options import Options
from bench.sheets import OUT, Shown, sheet
from bench.table import Expected, Report, Table
from bench.tracking import Tracked, linear, track
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass, Trajectory, joined
from keypose.tracker.keypoints.model_files import FULL, Model, find_model
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.tracking.cues.sources import DetectedKeypoints
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video


@dataclass(frozen=True, eq=False)
class Posed:
    """A clip between keyframes; its pictures are prepared once for all disturbances of these."""

    clip: Clip
    video: Video
    skeleton: Skeleton
    keyposes: Mapping[int, Pose]
    prepared: dict[bool, Tracker] = field(default_factory=dict)

    def tracker(self, static_camera: bool = False, network: Model | None = None) -> Tracker:
        """A tracker of these keyframes, with a picture of the empty scene or without, and with a
        network's keypoints or without."""
        if static_camera not in self.prepared:
            self.prepared[static_camera] = Tracker(
                self.video, self.clip.camera, self.skeleton, self.keyposes,
                static_camera=static_camera,
            )  # fmt: skip
        source = None
        if network is not None:
            source = DetectedKeypoints(self.video, self.clip.camera, model=network)
        plain = self.prepared[static_camera]
        return plain.renewed(self.skeleton, self.keyposes, keypoints=source)

    def disturbed(self, seed: int) -> Posed:
        """The same, its keyframes disturbed."""
        return replace(self, keyposes=jittered(self.skeleton, self.keyposes, seed))


Way = Callable[[Posed], Tracked]
"""A way to get from keyframes to the motion between them."""


@dataclass(frozen=True)
class Row:
    """Keyframes on a clip; a row that is held out is measured last, once all is decided.

    most: pixels that mean and median should not exceed.
    """

    name: str
    clip: str
    keyframes: tuple[int, ...]
    most: tuple[float, float] | None = None
    held_out: bool = False


ROWS = (
    Row("person-30", "person", (0, 30, 60, 90), (4.0, 3.2)),
    Row("person-60", "person", (0, 60), (4.5, 3.7)),
    Row("person-90", "person", (0, 90), (6.0, 5.0)),
    Row("walk-20", "walk", (30, 50, 70)),  # at double support
    Row("walk-20-mid", "walk", (40, 60), (4.5, 3.5)),  # at mid-stance
    Row("walk-40", "walk", (30, 70), (4.5, 3.5)),
    Row("arms-20", "arms", (20, 40, 60)),
    Row("arms-40", "arms", (20, 60)),
    Row("camera4-30", "camera4", (0, 30, 60, 90), held_out=True),
    Row("camera4-60", "camera4", (0, 60), held_out=True),
)
NEEDED = {"walk 60 frames": ("walk", 30, 90), "person 90 frames": ("person", 0, 90)}
CHOICES: dict[str, Choose] = {"worst": where_worst, "suggested": where_suggested}
PRINTED = (
    "mean",
    "median",
    "p90",
    "worst",
    "over_10",
    "root_mm",
    "keys_mm",
    "depth_mm",
    "jitter_px",
)


def interpolated(posed: Posed) -> Tracked:
    """Nothing tracked, nothing found."""
    steps = [Pass("interpolation", trajectory, None) for trajectory in linear(posed.tracker())]
    return Tracked([SegmentResult.on_the_way(step) for step in steps])


def with_settings(settings: TrackSettings) -> Way:
    """Tracked as settings say."""

    def way(posed: Posed) -> Tracked:
        network = find_model(settings.network or FULL.name)
        used = network if "keypoints" in settings.cues_used else None
        tracker = posed.tracker(bool(settings.static_camera), used)
        return track(tracker, **settings.model_dump())

    return way


WAYS: dict[str, Way] = {
    "linear": interpolated,
    "brightness": with_settings(TrackSettings(cues=("brightness",))),
    "keypoints alone": with_settings(TrackSettings(cues=("keypoints",))),
    "keypoints": with_settings(TrackSettings(cues=("brightness", "keypoints"))),
}
"""What is compared; more are added by name, or on the command line by their settings."""
SINGLE = ("linear", "brightness", "keypoints alone")
"""Of these nothing is expected: both cues together are to be no worse."""


def real(report: Report) -> None:
    """The whole group."""
    options = report.options
    ways = {**WAYS, **{name: with_settings(s) for name, s in options.ways.items()}}
    rows = _chosen(options)
    report.note("px at marked joints strictly between keyframes posed on their marks alone;")
    report.note(f"median (least–most) over {options.jitters} disturbances of 0.5° and 3 mm")
    kept = _Kept(options.out)
    table = report.table("by keyframes", "way", *PRINTED, wide=PRINTED)
    found_records: list[Record] = []
    for row in rows:
        try:
            found_records += _measured(row, ways, options.jitters, table, kept)
        except Absent as absent:
            report.note(f"{row.name} left out: {absent} is not here")
    _verdicts(report, ways, found_records, kept)
    report.note(f"contact sheets of every row, a line for each way: {OUT.relative_to(ROOT)}")
    if not options.rows and not options.held_out:
        _needed(report, ways, kept)


def _chosen(options: Options) -> list[Row]:
    """The rows asked for by name, or those held out, or all others."""
    by_name = {row.name: row for row in ROWS}
    if unknown := [name for name in options.rows if name not in by_name]:
        raise SystemExit(f"there is no row {unknown[0]!r}; the rows are {', '.join(by_name)}")
    if options.rows:
        return [by_name[name] for name in options.rows]
    return [row for row in ROWS if row.held_out == options.held_out]


class _Kept:
    """A file of all figures, written anew after each of them."""

    def __init__(self, path: Path) -> None:
        self.path, self.whole = path, dict[str, Any](runs=[], records=[], indicators=[], needed=[])
        path.parent.mkdir(parents=True, exist_ok=True)

    def add(self, kind: str, *facts: dict[str, Any]) -> None:
        self.whole[kind] += [_plain(fact) for fact in facts]
        written = self.path.with_suffix(".part")
        written.write_text(json.dumps(self.whole, ensure_ascii=False), encoding="utf-8")
        written.replace(self.path)


def _plain(value: Any) -> Any:
    """Without numbers that JSON does not have."""
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


@contextmanager
def _opened(shown: Clip, hand: Keyed) -> Iterator[Posed]:
    """Between these keyframes, while the film is open."""
    with Video.open(shown.video) as video:
        yield Posed(shown, video, hand.skeleton, hand.poses)


def _measured(
    row: Row, ways: dict[str, Way], jitters: int, table: Table, kept: _Kept
) -> list[Record]:
    """One row of keyframes, every way and every disturbance."""
    shown = clip(row.clip)
    hand = keyed(shown, row.keyframes)
    runs: dict[str, list[dict[str, float]]] = {name: [] for name in ways}
    found_records: list[Record] = []
    motions: dict[str, Trajectory] = {}
    with _opened(shown, hand) as posed:
        for seed, (name, way) in product(range(jitters), ways.items()):
            began = time.process_time()
            found = way(posed.disturbed(seed))
            spent = {"cpu_s": round(time.process_time() - began, 1)}
            motion = motions[name] = joined(found.trajectories)
            runs[name].append(figures(shown, hand.skeleton, motion, row.keyframes))
            some = []
            if name != "linear":
                some = records(shown, hand.skeleton, found.segments, row.name, name, seed)
            found_records += some
            about = {"row": row.name, "way": name, "jitter": seed, "verdicts": found.verdicts}
            kept.add("runs", {**about, **spent, **runs[name][-1]})
            kept.add("records", *(record.as_json() for record in some))
    for name, values in runs.items():
        over = {figure: Over(tuple(v[figure] for v in values)) for figure in values[0]}
        expected = []
        if row.most is not None and name not in SINGLE:
            both = zip(("mean", "median"), row.most, strict=True)
            expected = [Expected(what, over[what].median, most, "px") for what, most in both]
        table.row(row.name, name, *(over.get(f, "–") for f in PRINTED), expected=expected)
    look = Shown(shown.video, shown.camera, hand.skeleton)
    sheet(row.name, look, motions, list(row.keyframes), sorted(shown.marks))
    return found_records


def _verdicts(
    report: Report, ways: dict[str, Way], found_records: list[Record], kept: _Kept
) -> None:
    """How well what a result says of itself separates wrong joints from right ones."""
    report.note(
        "\nwrong: more than 10 px off on a person 400 px tall; left out: by a curve that was"
    )
    report.note(
        "fitted to the other clips, > 15 px: of joints as far off; calibration: mean distance"
    )
    report.note("of predicted and true share")
    columns = ("AUROC", "left out", "> 15 px", "Brier", "calibration", "wrong %")
    table = report.table("verdicts compared with errors, by joint", *columns)
    segments = report.table("by segment", "segments", "under 5 px", "said good %", "good true %")
    for name in ways:
        some = [record for record in found_records if record.way == name]
        if name == "linear" or not some:
            continue
        share = 100 * float(np.mean([record.wrong for record in some]))
        for indicator in INDICATORS:
            found = judged(some, indicator)
            clips = (found.left_out, found.very_far)
            cells = (found.auroc, *clips, found.brier, found.calibration, share)
            table.row(f"{name}: {indicator}", *cells)
            kept.add("indicators", {"way": name, "indicator": indicator, **found.__dict__})
        whole = by_segment(some)
        shares = 100 * whole.called_good, 100 * whole.good_is_right
        segments.row(name, whole.count, whole.right, *shares)
        kept.add("indicators", {"way": name, "indicator": "segments", **whole.__dict__})


def _needed(report: Report, ways: dict[str, Way], kept: _Kept) -> None:
    """How many keyframes it takes; keyframes are disturbed once."""
    report.note(
        "\nkeyframes until the median is ≤ 5 px and the worst mark ≤ 10 px; the next one is"
    )
    report.note("where the worst joint is, or where the verdicts say")
    columns = [f"{name}, {how}" for name in ways if name != "linear" for how in CHOICES]
    table = report.table("keyframes needed", *columns, wide=tuple(columns))
    for title, (name, first, last) in NEEDED.items():
        try:
            shown = clip(name)
        except Absent as absent:
            report.note(f"{title} left out: {absent} is not here")
            continue
        marked = [frame for frame in sorted(shown.marks) if first <= frame <= last]
        cells = []
        for (called, way), (how, choose) in product(ways.items(), CHOICES.items()):
            if called == "linear":
                continue
            steps = steps_to_enough(partial(_outcome, shown, way), marked, choose)
            cells.append(words(steps))
            about = {"clip": title, "way": called, "choice": how}
            kept.add("needed", *({**about, **step.__dict__} for step in steps))
        table.row(title, *cells)


def _outcome(shown: Clip, way: Way, keyframes: Sequence[int]) -> Outcome:
    hand = keyed(shown, keyframes)
    with _opened(shown, hand) as posed:
        found = way(posed.disturbed(0)).segments
    motion = joined([segment.trajectory for segment in found])
    return found, marks_between(shown, hand.skeleton, motion, keyframes)
