"""Many sessions without the page: on one process, on two, on a cluster that loses a worker."""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bench.keeping import ROOT, digest
from bench.table import Expected, Report
from tests.app.jobs.batch.dask_cases import cluster

SESSIONS = 20
SAMPLES = ("box", "person", "balance")
APART_M = 0.0005
"""Of the first keyframe's depth from one copy of a sample to the next: no two are the same."""
TWO_OVER_ONE = 0.65

Event = dict[str, Any]


def batch(report: Report) -> None:
    """The whole group."""
    busy, cores = os.getloadavg()[0], os.cpu_count()
    report.note(f"{SESSIONS} sessions, the samples in turn, each a little different, full")
    report.note(f"load when this began: {busy:.1f} on {cores} cores; beside others all is slower")
    table = report.table("keypose batch", "seconds", "of computing", "done", "answers")
    found: set[str] = set()
    spent: list[float] = []
    with tempfile.TemporaryDirectory() as kept:
        folder = Path(kept)
        _run(_sessions(folder / "warm", 2), "--workers", "2")
        for workers in (1, 2):
            root = _sessions(folder / str(workers), SESSIONS)
            seconds, computing, done = _run(root, "--workers", str(workers))
            found.add(_digest(root))
            spent.append(seconds)
            share = [Expected("of one's", seconds / spent[0], TWO_OVER_ONE)] * (workers - 1)
            name = f"{workers} process{'es' * (workers > 1)}"
            table.row(name, seconds, computing, done, len(found), expected=share)
        root = _sessions(folder / "cluster", SESSIONS)
        with cluster(folder, 2) as (address, (victim, _)):
            killed = _Once(lambda: os.kill(victim, signal.SIGKILL))
            seconds, _, done = _run(root, "--scheduler", address, after=killed)
        found.add(_digest(root))
        table.row("Dask, 1 of 2 workers killed", seconds, "", done, len(found))
        report.expect("workers not killed", 1 - killed.done, 0)
        report.expect("sessions not done after the kill", SESSIONS - done, 0)
    report.expect("different answers", len(found), 1)


class _Once:
    """Does something when the third session has ended: both workers are at work then."""

    def __init__(self, act: Callable[[], None]) -> None:
        self._act = act
        self._ended = 0
        self.done = False

    def __call__(self, event: Event) -> None:
        self._ended += event["event"] == "session_finished"
        if self._ended >= 3 and not self.done:
            self._act()
            self.done = True


def _run(
    root: Path, *how: str, after: Callable[[Event], None] = lambda event: None
) -> tuple[float, float, int]:
    """Seconds from the start of the command to its end, those of computing in it and its workers,
    and how many sessions it has done."""
    command = [sys.executable, "-m", "keypose.app", "batch", str(root), "--json", *how]
    began, computed = time.perf_counter(), _children_s()
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        last: Event = {}
        for line in child.stdout:
            last = json.loads(line)
            after(last)
    seconds = time.perf_counter() - began
    return seconds, _children_s() - computed, len(last["sessions"]) - len(last["not_done"])


def _children_s() -> float:
    """What processes that have ended had computed."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _sessions(root: Path, count: int) -> Path:
    """A folder of so many sessions that have not been tracked."""
    for i in range(count):
        name = SAMPLES[i % len(SAMPLES)]
        folder = root / f"{i:02} {name}"
        folder.mkdir(parents=True)
        shutil.copy(ROOT / "sample_videos" / name / f"{name}.mp4", folder)
        session = json.loads((ROOT / "sample_videos" / name / "session.json").read_text("utf-8"))
        session["results"] = None
        session["keyframes"][0]["root_m"][2] += i * APART_M
        (folder / "session.json").write_text(json.dumps(session), encoding="utf-8")
    return root


def _digest(root: Path) -> str:
    """Of all sessions and their tracks."""
    files = [*root.glob("*/session.json"), *root.glob("*/tracks-*.npz")]
    return digest(*(path.read_bytes() for path in sorted(files)))
