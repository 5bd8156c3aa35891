"""What a second body costs, and what one body costs beside the revision that knew no second one."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Final

import cv2
import numpy as np
from threadpoolctl import threadpool_limits

from bench.bodies.film import all_tracked, rendered_film
from bench.bodies.people import FRAMES, passing_by
from bench.bodies.promises import Promise
from bench.fast import at_work, in_turn
from bench.keeping import Absent
from bench.measures import Over
from bench.table import Report
from bench.tracking import keyframes_every
from keypose.tracker.session import Session

EVERY: Final = 24
TURNS: Final = 5
MOST_RATIO: Final = 2.1
BEFORE: Final = "4e0f3fde3"
"""The last revision whose sessions had one body."""
ROWS: Final = ("track by brightness, walk", "track by keypoints, person")
"""Of those that `bench/fast.py` measures."""
MOST_BESIDE_BEFORE: Final = 1.05


def cost(report: Report) -> list[Promise]:
    """Processor time, by one thread."""
    promises = [_second_body(report)]
    try:
        promises.append(_beside_before(report))
    except Absent as absent:
        report.note(f"one body beside {BEFORE} is left out: {absent} is not here")
    return promises


def _second_body(report: Report) -> Promise:
    film = rendered_film("passing", passing_by())
    keyposes = film.keyposes(keyframes_every(EVERY, 0, FRAMES - 1))
    alone = {name: film.session({name: poses}) for name, poses in keyposes.items()}
    sessions: Mapping[str, Session] = {**alone, "both": film.session(keyposes)}
    spent: dict[str, list[float]] = {name: [] for name in sessions}
    cv2.setNumThreads(1)
    with threadpool_limits(1):
        for turn in range(TURNS + 1):
            for name, session in sessions.items():
                began = time.process_time()
                all_tracked(session, film.video)
                if turn:  # the first one compiles, and puts the film in memory
                    spent[name].append(time.process_time() - began)
    ones = np.mean([spent[name] for name in alone], axis=0)
    ratios = Over(tuple((np.array(spent["both"]) / ones).tolist()))
    report.note(f"processor time of {TURNS} turns, one thread, the same film: median (range)")
    table = report.table("what a second body costs", "s")
    for name, seconds in spent.items():
        table.row(name, str(Over(tuple(seconds))))
    table.row("both beside the mean of one", _of_ratios(ratios))
    return Promise.at_most("time of two bodies beside one", ratios.median, MOST_RATIO)


def _beside_before(report: Report) -> Promise:
    """Each revision with the packages that it brings, first in turn."""
    table = report.table(f"one body, processor time beside {BEFORE}", "ratio")
    medians = []
    with at_work(BEFORE) as (here, before):
        for row in ROWS:
            turns = zip(*in_turn(here, before, row), strict=True)
            ratios = Over(tuple(now.cpu / then.cpu for now, then in turns))
            table.row(row, _of_ratios(ratios))
            medians.append(ratios.median)
    return Promise.at_most("time of one body beside before", max(medians), MOST_BESIDE_BEFORE)


def _of_ratios(ratios: Over) -> str:
    return f"{ratios.median:.2f} ({ratios.low:.2f}–{ratios.high:.2f})"
