"""How long people wait, beside another revision: both in turn, in one run, on one machine.

    python -m bench fast --beside REV

Figures of another machine, or of another hour, prove nothing: what counts is the ratio of medians
of processor time. The other revision is checked out into a folder of its own and works on the same
films, bodies and poses. Each has the packages that a plain installation of it brings, in an
environment of its own that is kept. Rows are in `bench/fast_rows.py`, and of whole commands in
`bench/fast_processes.py`.
"""

from __future__ import annotations

import json
import os
import pickle
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bench.clips import clip
from bench.fast_processes import processes
from bench.keeping import ROOT
from bench.keyed import keyed
from bench.revisions import checked_out, linked, python_of
from bench.table import Expected, Report
from keypose.tracker.keypoints.region import MARGIN, Region

TURNS = 3
BESIDE = "c1d0ac7e"
FILMS: Mapping[str, tuple[str, tuple[int, ...]]] = {
    "person": ("person", (0, 60)),
    "walk": ("walk", (30, 50, 70)),
    "arms": ("arms", (20, 40, 60)),
}
"""Clip and keyframes."""
WANTED: Mapping[str, float] = {
    "networks": 2.0,
    "pictures": 4.0,
    "track by keypoints": 3.0,
    "live preview": 2.0,
    "live full": 2.5,
}
"""By how much less a row should take than the revision beside it."""


@dataclass(frozen=True)
class Spent:
    """Of one turn of a row, milliseconds a unit: of processors, and by the clock."""

    cpu: float
    wall: float


class Worker:
    """A revision at work in a process of its own."""

    def __init__(self, tree: Path, films: Path) -> None:
        environ = {**os.environ, "PYTHONPATH": str(tree / "build" / "names")}
        environ["NUMBA_CACHE_DIR"] = str(tree / "build" / "loops")
        environ |= _threads(tree, environ)
        script = str(ROOT / "bench" / "fast_rows.py")
        self._process = subprocess.Popen(
            [str(python_of(tree)), "-P", script, str(films)],
            env=environ,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        self.rows: list[str] = self._answer()
        self.peak_mb = 0.0

    def _answer(self) -> Any:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError("a revision ended at work")
        return json.loads(line)

    def spent(self, row: str) -> Spent:
        assert self._process.stdin is not None
        print(row, file=self._process.stdin, flush=True)
        found = self._answer()
        self.peak_mb = max(self.peak_mb, found["peak_mb"])
        return Spent(*(1e3 * found[what] / found["units"] for what in ("cpu", "wall")))

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def _threads(tree: Path, environ: dict[str, str]) -> dict[str, str]:
    """How many threads a revision's program lets its libraries have."""
    asked = (
        "import json, keypose.app.cli.main as program; "
        "print(json.dumps(getattr(program, 'THREADS', {})))"
    )
    command = [str(python_of(tree)), "-c", asked]
    answer = subprocess.run(command, env=environ, check=True, stdout=subprocess.PIPE, text=True)
    return {"OPENBLAS_NUM_THREADS": "1", **json.loads(answer.stdout)}


def fast(report: Report, beside: str = BESIDE) -> None:
    """The whole group."""
    processes(report, linked(ROOT), checked_out(beside))
    report.note(f"ms of processors a frame, a look or a move, here and at {beside}, medians of")
    report.note(f"{TURNS} turns, each revision first in turn; only ratios count")
    table = report.table("what people wait for", "here", "beside", "ratio", "clock ratio")
    with at_work(beside) as (here, other):
        for row in here.rows:
            turns = in_turn(here, other, row)
            cpu = [float(np.median([each.cpu for each in some])) for some in turns]
            wall = [float(np.median([each.wall for each in some])) for some in turns]
            ratio = cpu[1] / cpu[0]
            wanted = WANTED.get(row.partition(",")[0])
            expected = [] if wanted is None else [Expected("its inverse", 1 / ratio, 1 / wanted)]
            table.row(
                row,
                f"{cpu[0]:.1f}",
                f"{cpu[1]:.1f}",
                f"{ratio:.2f}",
                f"{wall[1] / wall[0]:.2f}",
                expected=expected,
            )
        table.row("peak memory, MB", f"{here.peak_mb:.0f}", f"{other.peak_mb:.0f}", "", "")


def in_turn(here: Worker, other: Worker, row: str) -> tuple[list[Spent], list[Spent]]:
    """What a row takes both, each first in turn."""
    turns: tuple[list[Spent], list[Spent]] = ([], [])
    for worker in (here, other):
        worker.spent(row)  # compiled, prepared, in memory
    for turn in range(TURNS):
        order = ((0, here), (1, other)) if turn % 2 else ((1, other), (0, here))
        for k, worker in order:
            turns[k].append(worker.spent(row))
    return turns


@contextmanager
def at_work(beside: str) -> Iterator[tuple[Worker, Worker]]:
    """This revision and the other, at work on the same films."""
    with _films() as films, _both(beside, films) as workers:
        yield workers


@contextmanager
def _films() -> Iterator[Path]:
    """A file of what both revisions work on."""
    known = {}
    for name, (clip_name, frames) in FILMS.items():
        shown = clip(clip_name)
        posed = keyed(shown, frames)
        around = Region.of_pose(posed.skeleton, posed.poses[frames[0]], shown.camera)
        r = around.side / (2 * MARGIN)
        known[name] = {
            "video": str(shown.video),
            "camera": shown.camera.model_dump_json(),
            "body": posed.skeleton.body.model_dump_json(),
            "poses": {
                frame: (pose.Rs_parent_part.tolist(), pose.p_camera_root.tolist())
                for frame, pose in posed.poses.items()
            },
            "box": (around.x - r, around.y - r, around.x + r, around.y + r),
        }
    with TemporaryDirectory() as folder:
        path = Path(folder) / "films.pickle"
        path.write_bytes(pickle.dumps(known))
        yield path


@contextmanager
def _both(beside: str, films: Path) -> Iterator[tuple[Worker, Worker]]:
    """This revision and the other, at work."""
    workers = (Worker(linked(ROOT), films), Worker(checked_out(beside), films))
    try:
        yield workers
    finally:
        for worker in workers:
            worker.close()
