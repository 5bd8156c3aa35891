"""Whole commands beside another revision, as a person starts them: rows of `bench/fast.py`.

Each is run anew in a folder of its own, on a session that the revision brings or has made itself,
with no keypoints kept from before. Loops are compiled already, but where the row says otherwise.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from bench.keeping import ROOT, Absent
from bench.markers import Film, opencap_squat
from bench.one_process import PAGE
from bench.revisions import python_of
from bench.table import Expected, Report
from bench.to_and_fro import to_and_fro

FIRST = "segment 1 of"
"""What `keypose track` says of its first result."""
WALKER = ("--box", "1010,370,1130,700", "--frame", "12")
"""The person of the sample film of a walk."""
LONG = 400, (640, 360)
"""Frames and size of the film by which memory is measured."""
LONG_HD = 2000, (1920, 1080)
"""Of a large one."""


@dataclass(frozen=True)
class Taken:
    """Seconds of processors and by the clock, and MB of peak memory."""

    cpu: float
    wall: float
    peak_mb: float

    def and_then(self, other: Taken) -> Taken:
        return Taken(self.cpu + other.cpu, self.wall + other.wall, max(self.peak_mb, other.peak_mb))


@dataclass(frozen=True)
class Program:
    """The command line of a revision, in a folder of its own.

    loops: where it keeps what it compiles.
    """

    tree: Path
    folder: Path
    loops: Path

    @property
    def session(self) -> Path:
        return self.folder / "walk" / "session.json"

    def keypose(self, *words: str, until: str | None = None) -> Taken:
        """What a command takes, until it has printed a word."""
        names = os.pathsep.join((str(self.tree / "build" / "names"), str(_known(self.folder))))
        environ = {
            **os.environ,
            "PYTHONPATH": names,
            "NUMBA_CACHE_DIR": str(self.loops),
            "XDG_CACHE_HOME": str(self.folder / "cache"),
            "PYTHONUNBUFFERED": "1",
            "KEYPOSE_CONFIG": str(self.folder / "none.toml"),
        }
        python = str(python_of(self.tree))
        asked = {"command": [python, "-m", "keypose.app", *words], "until": until}
        answer = subprocess.run(
            [python, str(ROOT / "bench" / "one_process.py"), json.dumps(asked)],
            env=environ,
            cwd=self.folder,
            check=True,
            stdout=subprocess.PIPE,
            text=True,
        ).stdout
        return Taken(**json.loads(answer))

    @contextmanager
    def anew(self) -> Iterator[Program]:
        """In another folder, which has the sample of a walk and nothing else."""
        with TemporaryDirectory() as folder:
            there = replace(self, folder=Path(folder))
            sample, place = self.tree / "sample_videos" / "walk", there.session.parent
            place.mkdir()
            for name in ("session.json", "walk.mp4"):
                shutil.copyfile(sample / name, place / name)
            yield there


def _known(folder: Path) -> Path:
    """A folder by which Python knows Keypose's version, which it says when it is asked."""
    facts = folder / "known" / "keypose-0.dist-info" / "METADATA"
    facts.parent.mkdir(parents=True, exist_ok=True)
    facts.write_text("Metadata-Version: 2.1\nName: keypose\nVersion: 0\n", encoding="utf-8")
    return facts.parents[1]


@dataclass(frozen=True)
class Row:
    """prepare: what is done before, and not measured.  wanted: by how much less of processors it
    should take than the revision beside it.  most_mb: of memory at its peak."""

    name: str
    work: Callable[[Program], Taken]
    turns: int = 3
    wanted: float | None = None
    prepare: Callable[[Program], object] = lambda program: None
    most_mb: float | None = None


def processes(report: Report, here: Path, beside: Path) -> None:
    """All rows, of two revisions by their folders."""
    report.note("commands, each in a process of its own: seconds, medians of turns")
    columns = ("here", "beside", "ratio", "clock here", "beside", "ratio", "MB here", "beside")
    table = report.table("what commands take", *columns)
    programs = [Program(tree, tree, tree / "build" / "loops") for tree in (here, beside)]
    for program in programs:
        _track(program)  # compiles
    for row in rows():
        found = _turns(row, programs)
        ours, theirs = map(_median, found)
        expected = []
        if row.wanted is not None:
            expected.append(Expected("its inverse", ours.cpu / theirs.cpu, 1 / row.wanted))
        if row.most_mb is not None:
            expected.append(Expected("memory", ours.peak_mb, row.most_mb, "MB"))
        table.row(
            row.name,
            f"{ours.cpu:.2f}",
            f"{theirs.cpu:.2f}",
            f"{theirs.cpu / ours.cpu:.2f}",
            f"{ours.wall:.2f}",
            f"{theirs.wall:.2f}",
            f"{theirs.wall / ours.wall:.2f}",
            f"{ours.peak_mb:.0f}",
            f"{theirs.peak_mb:.0f}",
            expected=expected,
        )


def _turns(row: Row, programs: list[Program]) -> tuple[list[Taken], list[Taken]]:
    """What both took, each first in turn."""
    found: tuple[list[Taken], list[Taken]] = ([], [])
    for turn in range(row.turns):
        for k in (0, 1) if turn % 2 else (1, 0):
            with programs[k].anew() as program:
                row.prepare(program)
                found[k].append(row.work(program))
    return found


def _median(some: list[Taken]) -> Taken:
    figures = np.array([(each.cpu, each.wall, each.peak_mb) for each in some])
    return Taken(*np.median(figures, axis=0).tolist())


def rows() -> list[Row]:
    """In the order in which a person meets them."""
    return [
        Row("start: --version", lambda program: program.keypose("--version")),
        Row("start: --help", lambda program: program.keypose("--help")),
        Row("open, to its page", _open, wanted=1.5),
        Row("draft of a walk", _draft, wanted=2.0),
        Row("track, to the first result", _first, wanted=1.5),
        Row("the same, nothing compiled", _first_compiled, turns=2, wanted=2.0),
        Row("export of bvh and csv", _export, prepare=_tracked),
        *_stood(),
        Row(_long_name(LONG), lambda p: _long(p, "person", LONG), turns=1, most_mb=300.0),
        Row(_long_name(LONG_HD), lambda p: _long(p, "walk", LONG_HD), turns=1, most_mb=500.0),
    ]


def _open(program: Program) -> Taken:
    words = ("--port", "0", "--no-browser", "--workspace", "workspace")
    return program.keypose("open", str(program.session), *words, until=PAGE)


def _draft(program: Program) -> Taken:
    film = str(program.session.with_name("walk.mp4"))
    return program.keypose("draft", film, *WALKER, "--out", "drafted")


def _track(program: Program) -> None:
    with program.anew() as there:
        _tracked(there)


def _tracked(program: Program) -> Taken:
    return program.keypose("track", str(program.session))


def _first(program: Program) -> Taken:
    return program.keypose("track", str(program.session), until=FIRST)


def _first_compiled(program: Program) -> Taken:
    return _first(replace(program, loops=program.folder / "loops"))


def _export(program: Program) -> Taken:
    words = ("--format", "bvh,csv", "--out", "exported")
    return program.keypose("export", str(program.session), *words)


# --- from a box to a motion that stands


def _stood() -> Iterator[Row]:
    """Of a film of one phone, where it is here."""
    try:
        film = opencap_squat()
    except Absent:
        return
    yield Row(
        "from a box to stood", lambda program: _box_to_stood(program, film), turns=1, wanted=2.5
    )


def _box_to_stood(program: Program, film: Film) -> Taken:
    """By one command, or where a revision has none by three, its drafts accepted between them."""
    assert film.box is not None
    assert film.frames is not None
    words = (
        str(film.video),
        "--box",
        ",".join(map(str, film.box)),
        "--frame",
        str(film.frame),
        "--frames",
        film.frames,
        "--field-of-view",
        str(film.view_deg),
        "--out",
        "drafted",
    )
    if (program.tree / "app" / "cli" / "run.py").is_file():
        return program.keypose("run", *words)
    session = program.folder / "drafted" / "session.json"
    spent = program.keypose("draft", *words)
    _accept(session)
    for command in ("track", "stand"):
        spent = spent.and_then(program.keypose(command, str(session)))
    return spent


def _accept(path: Path) -> None:
    """Make keyframes of the drafts that a session proposes."""
    session = json.loads(path.read_text(encoding="utf-8"))
    body = session["bodies"][0]
    proposed = {place["frame"] for place in body["drafted"]["places"]}
    body["keyframes"] = [draft for draft in body["drafts"] if draft["frame"] in proposed]
    body["drafts"] = [draft for draft in body["drafts"] if draft["frame"] not in proposed]
    path.write_text(json.dumps(session), encoding="utf-8")


# --- memory


def _long_name(kind: tuple[int, tuple[int, int]]) -> str:
    frames, (width, height) = kind
    return f"track {frames} frames of {width}×{height}"


def _long(program: Program, sample: str, kind: tuple[int, tuple[int, int]]) -> Taken:
    """Track a sample's film that runs to and fro, by brightness: memory goes by pictures."""
    session = to_and_fro(program.tree / "sample_videos" / sample, *kind, program.folder / "long")
    return program.keypose("track", str(session), "--cues", "brightness")
