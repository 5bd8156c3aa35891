"""How much a person has to do until a clip is right, and how long that takes them.

A scripted person (`human/`) sees pictures and joints in them, with errors of 2 px and 2°, and works
with what the page offers, until every joint is at most 5 px off in the median and 10 px at worst.
How far off it is in space then is said beside, where that is known. Actions are clicks, keys and
drags; looks are counted beside them. The times are of the
keystroke-level model, see `human/counting.py`: 1.3 s a click, 0.28 s a key, 3.75 s a drag, 2 s a
frame that is judged, 1/15 s one that is watched. What is done once a clip is given as it is; the
rest for 1,800 frames. What is begun once a clip and not before the first frame, such as keyframes
at both ends, weighs a short clip down. So work is divided into what it consists of, and a clip is
worked in its first half as well: what the second half costs beyond that is what a film costs for
each further frame, and what is left is done once a film, however long it is.

"watched" plays the motion and is done when nothing looks wrong (`human/watching.py`); that is how
it is expected to be worked. "linear" and "paper" pose both ends and then the middle of whatever is
longest unseen, and learn from somebody else when all is right: they are compared with.

What begins with a draft begins as a clip is opened, with the body of a preset, which the draft
sizes. What does not has a body that is sized already.

Trials run through the product's own editor and jobs, without its page.
"""

from __future__ import annotations

import time
from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from bench.human.clips import CLIPS, Watched, noisy, watched
from bench.human.counting import KINDS, LONG_FRAMES, SHARES, Effort, Kind
from bench.human.desk import desk
from bench.human.first import FIRSTS, first_keyframe
from bench.human.hand import Hand
from bench.human.strategies import (
    KNEES_DEG,
    OFF_MM,
    STRATEGIES,
    WATCHED,
    InSpace,
    Outcome,
    Strategy,
    in_space,
    outcome,
)
from bench.keeping import Absent
from bench.measures import Over
from bench.table import Expected, Report, Table

SEEDS = 3
SIGMA_PX = 2.0
"""Persons, and how far off they see a joint."""
MOST_ACTIONS = 45.0
MOST_MINUTES = 5.0
COLUMNS = (
    "right",
    "in space too",
    "mm in space",
    "knees deg",
    "keyframes",
    "clicks",
    "keys",
    "drags",
    "looks",
    "frames watched",
    "seconds",
    "first keyframe",
    "s a frame after",
    "actions for 1800",
    "minutes for 1800",
)
LONG_CLIP = 60
"""From so many frames on a clip is worked in its first half as well."""
WIDE = COLUMNS[1:]
CAUSES = 12
ACTIONS: tuple[Kind, ...] = ("click", "key", "drag")


@dataclass(frozen=True)
class Trial:
    """One person at one clip. seconds: that the computer took."""

    effort: Effort
    outcome: Outcome
    keyframes: int
    seconds: float
    in_space: InSpace | None = None


def effort(report: Report) -> None:
    """The whole group."""
    report.note("clicks, keys and drags are actions; looks are frames judged; computing is not")
    report.note(f"counted. Median (least–most) over {SEEDS} persons. right: how many got every")
    report.note(
        "joint to 5 px in the median and 10 px at worst. For 1800 frames: clips are a second"
    )
    report.note("or two of fast motion, so that is work for a minute of nothing else")
    report.note(
        f"in space too: of these, whose joints are {OFF_MM:g} mm off in the median, as seen"
    )
    report.note(
        f"from the hips, with knees bent within {KNEES_DEG:g} deg; empty where nobody knows"
    )
    with threadpool_limits(1):
        _first_keyframes(report)
        for name in CLIPS:
            try:
                _clip(report, watched(name))
            except Absent as absent:
                report.note(f"{name} left out: {absent} is not here")


def trial(clip: Watched, strategy: Strategy, seed: int) -> Trial:
    """One person's work on a clip."""
    began = time.process_time()
    clip = clip.unsized() if strategy.drafts else clip
    with desk(noisy(clip, SIGMA_PX, seed), strategy.settings) as there:
        there.tracks = strategy.tracks
        strategy.work(Hand.of(there, seed, strategy.by_picture))
        done = there.ledger.effort(clip.frames)
        seconds = time.process_time() - began
        return Trial(done, outcome(there), len(there.keys), seconds, in_space(there))


def _first_keyframes(report: Report) -> None:
    """From a clip that was just opened to its first keyframe, the body not known."""
    columns = ("right", "actions", "seconds", "worst, px")
    table = report.table("the first keyframe, from nothing", *columns, wide=columns[1:])
    for name in CLIPS:
        try:
            clip = watched(name)
        except Absent:
            continue
        for first in FIRSTS:
            found = [
                first_keyframe(noisy(clip, SIGMA_PX, seed), first, seed) for seed in range(SEEDS)
            ]
            actions = Over(tuple(float(f.effort.actions) for f in found))
            table.row(
                f"{name}, {first.name}",
                f"{sum(f.outcome.right for f in found)} of {SEEDS}",
                actions,
                Over(tuple(f.effort.seconds for f in found)),
                Over(tuple(f.outcome.worst for f in found)),
                expected=[Expected("actions", actions.median, first.most)],
            )


def _clip(report: Report, clip: Watched) -> None:
    table = report.table(f"{clip.name}, {clip.frames} frames", *COLUMNS, wide=WIDE)
    for strategy in STRATEGIES:
        trials = [trial(clip, strategy, seed) for seed in range(SEEDS)]
        _row(table, strategy, trials)
        _shares(report, f"{clip.name}, {strategy.name}", trials)
        if strategy is WATCHED:
            _causes(report, f"{clip.name}, {strategy.name}", trials)
            if clip.frames >= LONG_CLIP:
                _further_frame(report, clip, trials)


def _row(table: Table, strategy: Strategy, trials: list[Trial]) -> None:
    right = sum(t.outcome.right for t in trials)
    counts = [Over(tuple(float(t.effort.count(kind)) for t in trials)) for kind in KINDS]
    actions = Over(tuple(t.effort.scaled_actions() for t in trials))
    minutes = Over(tuple(t.effort.scaled_minutes() for t in trials))
    expected = []
    if strategy is WATCHED:
        expected = [
            Expected("actions", actions.median, MOST_ACTIONS),
            Expected("minutes", minutes.median, MOST_MINUTES),
        ]
    keyframes = Over(tuple(float(t.keyframes) for t in trials))
    seconds = Over(tuple(t.effort.seconds for t in trials))
    first = Over(tuple(t.effort.first_seconds for t in trials))
    then = Over(tuple(t.effort.seconds_a_frame for t in trials))
    measured = (keyframes, *counts, seconds, first, then, actions, minutes)
    cells = (f"{right} of {len(trials)}", *_space_cells(trials), *measured)
    table.row(strategy.name, *cells, expected=expected)


def _space_cells(trials: list[Trial]) -> tuple[str | Over, ...]:
    """How many are right in the picture and in space, and by how much they are off in space; empty
    where that is not known."""
    known = [t.in_space for t in trials if t.in_space is not None]
    if not known:
        return "", "", ""
    both = sum(t.outcome.right and t.in_space is not None and t.in_space.right for t in trials)
    off = Over(tuple(each.off_mm for each in known))
    return f"{both} of {len(trials)}", off, Over(tuple(each.knees_deg for each in known))


def _further_frame(report: Report, clip: Watched, trials: list[Trial]) -> None:
    """What a frame costs once the work has begun: the clip against its first half."""
    half = clip.until((clip.first + clip.last) // 2)
    begun = [trial(half, WATCHED, seed) for seed in range(SEEDS)]
    frames = clip.frames - half.frames
    more = [(a.effort, b.effort) for a, b in zip(trials, begun, strict=True)]
    columns = ("once", "a frame", f"for {LONG_FRAMES}")
    table = report.table(f"{clip.name}: what a further frame costs", *columns)
    for what in ("actions", "seconds"):
        whole = float(np.median([getattr(a, what) for a, _ in more]))
        each = float(np.median([getattr(a, what) - getattr(b, what) for a, b in more])) / frames
        once = whole - each * clip.frames
        name = f"  {what}, {half.frames} to {clip.frames}"
        table.row(name, once, each, once + each * LONG_FRAMES)


def _shares(report: Report, name: str, trials: list[Trial]) -> None:
    """What the work consists of: its beginning, further keyframes, limbs corrected, and looks."""
    table = report.table(f"{name}: what it consists of", "actions", "seconds", "s a frame")
    for share in SHARES:
        actions, seconds = np.median([t.effort.of_share(share) for t in trials], axis=0).tolist()
        per_frame = "" if share == "begin" else seconds / trials[0].effort.frames
        table.row(f"  {share}", actions, seconds, per_frame)


def _causes(report: Report, name: str, trials: list[Trial]) -> None:
    """What the work consists of, the most time first."""
    spent: dict[str, list[float]] = defaultdict(lambda: [0.0, 0.0])
    for found in trials:
        for why, count, seconds in found.effort.by_cause():
            spent[why][0] += count / len(trials)
            spent[why][1] += seconds / len(trials)
    whole = sum(seconds for _, seconds in spent.values())
    table = report.table(f"{name}: where the time goes", "times", "seconds", "share, %")
    most = sorted(spent.items(), key=lambda row: -row[1][1])[:CAUSES]
    for why, (times, seconds) in most:
        table.row(f"  {why}", float(np.round(times, 1)), seconds, 100 * seconds / whole)
