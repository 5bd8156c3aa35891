"""Rendered motions with exact keyframes and exact truth: cm and px between the keyframes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from bench.keeping import Absent
from bench.sequences import LOOKS, Sequence, sequence
from bench.table import Expected, Pair, Report, Table
from bench.tracking import (
    Tracked,
    against,
    best_tried,
    forward,
    keyframes_every,
    linear,
    mean_errors,
    noted_rounds,
    track,
)
from keypose.tracker.tracking.tracker import Tracker

STRETCHES = {
    "walk": (0, 72),
    "jump": (24, 120),
    "speech": (0, 72),
    "throw": (47, 119),
    "tumbling_box": (0, 48),
}
"""What is shown of each motion when the conditions are hard."""
INTERVALS = (8, 12, 16, 24, 32, 48)
OURS = 24
PAPERS = 12
"""Keyframe intervals of `keypose` and `paper` at which ours is to be no worse."""
COLUMNS = (
    "segments",
    "linear",
    "forward",
    "paper",
    "keypose",
    "best tried",
    "kept",
    "verdicts",
)
WIDE = ("verdicts",)
CLOSED = 1e-9
ROUNDS = 8


@dataclass(frozen=True)
class Row:
    """The figures of one case; each pair is cm and px."""

    segments: int
    linear: Pair
    forward: Pair
    paper: Pair
    keypose: Pair
    best_tried: Pair
    found: Tracked


@dataclass(eq=False)
class Closing:
    """The largest closing error so far, and all rounds that drift correction took."""

    error: float = 0.0
    rounds: list[int] = field(default_factory=list)

    def tracked(self, tracker: Tracker, **settings: str) -> Tracked:
        """Track and take note."""
        with noted_rounds() as rounds:
            found = track(tracker, **settings)
        self.rounds += rounds
        self.error = max(self.error, found.closing_error)
        return found


def measured(shown: Sequence, interval: int, closing: Closing) -> Row:
    """One case, tracked by every method."""
    frames = keyframes_every(interval, 0, len(shown.grey) - 1)
    tracker = Tracker(shown.video(), shown.camera, shown.skeleton, shown.keyposes(frames))
    ours, papers = closing.tracked(tracker), closing.tracked(tracker, method="paper")
    measure = against(shown.skeleton, shown.camera, shown.truth)
    return Row(
        len(tracker.spans),
        mean_errors(measure, linear(tracker)),
        mean_errors(measure, forward(tracker)),
        mean_errors(measure, papers.trajectories),
        mean_errors(measure, ours.trajectories),
        best_tried(measure, ours.tried),
        ours,
    )


def write(table: Table, name: str, row: Row, *expected: Expected) -> None:
    """One line of a table."""
    pairs = (row.linear, row.forward, row.paper, row.keypose, row.best_tried)
    table.row(name, row.segments, *pairs, row.found.kept, row.found.verdicts, expected=expected)


def rendered(report: Report) -> None:
    """The whole group."""
    closing = Closing()
    report.note("mean error strictly between keyframes, cm/px; kept: interpolation, both ways,")
    report.note("pass or refinement; best tried: had the truth chosen among the candidates")
    table = report.table("by keyframe interval", *COLUMNS, wide=WIDE)
    for name in STRETCHES:
        _if_here(report, partial(_by_interval, table, name, closing))
    table = report.table(f"hard conditions, keyframes every {OURS}", *COLUMNS, wide=WIDE)
    for name in STRETCHES:
        for look in LOOKS:
            if look != "textured":
                _if_here(report, partial(_hard, table, name, look, closing))
    table = report.table("two keyframes only", *COLUMNS, wide=WIDE)
    _two_keyframes(table, closing)
    _closed(report, closing)


def _if_here(report: Report, work: Callable[[], None]) -> None:
    try:
        work()
    except Absent as absent:
        report.note(f"left out: {absent} is not here")


def _by_interval(table: Table, name: str, closing: Closing) -> None:
    shown = sequence(name)
    papers = None
    for interval in INTERVALS:
        row = measured(shown, interval, closing)
        papers = row.paper if interval == PAPERS else papers
        expected = _no_worse(row.keypose, papers) if interval == OURS and papers else []
        write(table, f"{name} {interval}", row, *expected)


def _no_worse(ours: Pair, papers: Pair) -> list[Expected]:
    return [
        Expected(f"paper@{PAPERS}", ours.first, papers.first, "cm"),
        Expected("", ours.second, papers.second, "px"),
    ]


def _hard(table: Table, name: str, look: str, closing: Closing) -> None:
    shown = sequence(name, look, STRETCHES[name])
    papers = _paper_only(shown, closing)
    row = measured(shown, OURS, closing)
    write(table, f"{name} {look}", row, *_no_worse(row.keypose, papers))


def _paper_only(shown: Sequence, closing: Closing) -> Pair:
    frames = keyframes_every(PAPERS, 0, len(shown.grey) - 1)
    tracker = Tracker(shown.video(), shown.camera, shown.skeleton, shown.keyposes(frames))
    found = closing.tracked(tracker, method="paper")
    return mean_errors(against(shown.skeleton, shown.camera, shown.truth), found.trajectories)


def _two_keyframes(table: Table, closing: Closing) -> None:
    row = measured(sequence("speech"), 180, closing)
    most = [Expected("", row.keypose.first, 0.5, "cm"), Expected("", row.keypose.second, 0.4, "px")]
    write(table, "speech 180", row, *most)
    for look in ("textured", "texture-poor"):
        row = measured(sequence("tumbling_box", look, (0, 40)), 40, closing)
        write(table, f"tumbling_box 40 {look}", row, Expected("", row.keypose.second, 0.5, "px"))


def _closed(report: Report, closing: Closing) -> None:
    found = [r for r in closing.rounds if r >= 0]
    report.expect("largest closing error", closing.error, CLOSED)
    report.expect("most rounds until X is found to 1e-10", max(found, default=0), ROUNDS)
    times = {k: found.count(k) for k in sorted(set(found))}
    words = ", ".join(f"{k}: {count}" for k, count in times.items())
    report.note(
        f"rounds, and how often: {words}; no single X: {len(closing.rounds) - len(found)} times"
    )
