"""How soon the page answers: the server alone, and in a browser whose pictures software draws."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright

from tests.app.serving import Keypose, Visitor
from tests.benchmarks.keeping import ROOT, Absent
from tests.benchmarks.probe import Probe
from tests.benchmarks.table import Expected, Report, Table
from tests.browser.chromium import ARGUMENTS, find
from tests.browser.hands import settled, spot, until, until_told
from tests.browser.shared import let_in, opened
from tracker.video import Video

TIMES = 40
SERVER_MS, FIRST_PASS_S, RATIO, FPS = 100.0, 2.0, 1.5, 30.0
FRAME = 24
"""A keyframe, where no pass moves the body while the pointer takes hold of it."""

FILM = (960, 540)
IDLE_S = 5.0
VIEWS = ("main", "top", "side", "front")
Act = Callable[[int, str], dict[str, Any]]
"""The action of a number, for a stroke of this name."""


def page(report: Report) -> None:
    """The whole group."""
    path = find()
    if path is None:
        raise Absent("a Chromium")
    busy, cores = os.getloadavg()[0], os.cpu_count()
    report.note(f"load when this began: {busy:.1f} on {cores} cores; beside others all is slower")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        session = _sample(Path(folder) / "person")
        with _served(session) as keypose:
            _server(report, keypose)
            browser = playwright.chromium.launch(executable_path=path, args=list(ARGUMENTS))
            report.note(f"\nChromium {browser.version}, pictures drawn by software, 1440×900")
            _browser(report, browser, keypose)
        with _served(_film(Path(folder) / "film", report)) as keypose:
            _playing(report, browser, keypose)
        browser.close()


# --- what is measured


def _server(report: Report, keypose: Keypose) -> None:
    """From a message sent to the answer received, over a socket like the page's."""
    visitor = Visitor(keypose)
    visitor.do(do="go", frame=FRAME)
    acts: dict[str, Act] = {
        "a hand dragged": _drag({"kind": "end", "name": "left_hand"}),
        "a ring turned": _drag({"kind": "ring", "part": "right_shin", "axis": "x"}),
        "a length dragged": _drag({"kind": "size", "part": "left_shin", "key": "length"}),
        "a step to a frame": lambda i, _: {"do": "go", "frame": FRAME + 1 + i % 12},
    }
    table = report.table(
        "the server: sent to answered, ms",
        *("median", "90 %", "tracking", "90 % then", "ratio"),
    )
    idle = {name: _answers(visitor, act) for name, act in acts.items()}
    with _tracking(keypose):
        until(lambda: _job(visitor) == "running", "the job")
        at_work = {name: _answers(visitor, act) for name, act in acts.items()}
    for name in acts:
        ratio = float(np.median(at_work[name]) / np.median(idle[name]))
        expected = [_under(idle[name], SERVER_MS), Expected("ratio", ratio, RATIO)]
        table.row(name, *_spread(idle[name]), *_spread(at_work[name]), ratio, expected=expected)
    _put_back(visitor)
    visitor.leave()


def _drag(handle: dict[str, Any]) -> Act:
    """The moves of one gesture."""

    def act(i: int, stroke: str) -> dict[str, Any]:
        at = [320 + 8 * np.sin(i / 3), 200 - 8 * np.cos(i / 3)]
        moved = {"view": "main", "handle": handle, "from": [320, 200], "at": at}
        return {"do": "drag", **moved, "stroke": stroke}

    return act


def _answers(visitor: Visitor, act: Act) -> list[float]:
    spent, stroke = [], str(time.monotonic_ns())
    for i in range(TIMES + 5):
        action = act(i, stroke)
        began = time.perf_counter()
        visitor.do(**action)
        spent.append(1000 * (time.perf_counter() - began))
    visitor.do(do="end_stroke", stroke=stroke)
    return spent[5:]


def _browser(report: Report, browser: Browser, keypose: Keypose) -> None:
    visitor = Visitor(keypose)
    with let_in(browser, drawn=True, size=(1440, 900)) as context:
        tab = opened(context, keypose)
        until(lambda: tab.locator(".view.drawn").count() == 4, "the four views", 120)
        _idle(report, tab, keypose)
        probe = Probe(tab)
        visitor.do(do="go", frame=FRAME)
        _drags(report, tab, probe, keypose, visitor)
        _steps(report, tab, probe, visitor)
        _first_passes(report, tab, probe, visitor)
    visitor.leave()


def _drags(report: Report, tab: Page, probe: Probe, keypose: Keypose, visitor: Visitor) -> None:
    """From the pointer's move to the pictures, idle and while a job runs."""
    marks = ("told", "main", "others")
    columns = ("median", "90 %", "tracking", "90 % then", "ratio")
    idle = _moves(tab, probe, visitor)
    with _tracking(keypose):
        until_told(tab, "job.state", lambda state: state == "running")
        at_work = _moves(tab, probe, visitor)
    table = report.table("a hand dragged: from the pointer's move, ms", *columns)
    words = ("the answer is here", "own view redrawn", "the other three")
    for name, mark in zip(words, marks, strict=True):
        ratio = float(np.median(at_work[mark]) / np.median(idle[mark]))
        expected = [Expected("ratio", ratio, RATIO)]
        table.row(name, *_spread(idle[mark]), *_spread(at_work[mark]), ratio, expected=expected)


def _moves(tab: Page, probe: Probe, visitor: Visitor) -> dict[str, list[float]]:
    """Each move waits until the one before is drawn everywhere."""
    visitor.do(do="go", frame=FRAME)
    until_told(tab, "view.frame", lambda frame: frame == FRAME)
    x, y = spot(tab, "left_hand")
    tab.mouse.move(x, y)
    tab.mouse.down()
    tab.mouse.move(x + 6, y)
    found: dict[str, list[float]] = {"told": [], "main": [], "others": []}
    for i in range(TIMES + 5):
        probe.arm("pointermove", "told", *VIEWS)
        tab.mouse.move(x + 14 * np.cos(i / 4), y - 14 * np.sin(i / 4))
        if (marks := probe.marks()) is not None and i >= 5:
            found["told"].append(marks["told"])
            found["main"].append(marks["main"])
            found["others"].append(max(marks[view] for view in VIEWS[1:]))
    tab.mouse.up()
    until_told(tab, "pose.stroke", lambda stroke: stroke is None)
    _put_back(visitor)
    return found


def _steps(report: Report, tab: Page, probe: Probe, visitor: Visitor) -> None:
    """From an arrow key to the picture of the next frame, and to the body on it."""
    visitor.do(do="go", frame=0)
    until_told(tab, "view.frame", lambda frame: frame == 0)
    settled(tab)
    film, body = [], []
    for _ in range(TIMES):
        probe.arm("keydown", "film", "main")
        tab.keyboard.press("ArrowRight")
        if (marks := probe.marks()) is not None:
            film.append(marks["film"])
            body.append(marks["main"])
    table = report.table("a step to the next frame: from the key, ms", "median", "90 %")
    table.row("the film shows it", *_spread(film))
    table.row("and the body stands there", *_spread(body))


def _first_passes(report: Report, tab: Page, probe: Probe, visitor: Visitor) -> None:
    table = report.table("from Track to the first pass, 24 frames, ms", "median", "90 %")
    for quality in ("preview", "full"):
        visitor.do(do="settings", quality=quality)
        visitor.do(do="go", frame=12)
        until_told(tab, "view.frame", lambda frame: frame == 12)
        _passes(table, f"{quality}: Track", tab, probe, lambda: tab.keyboard.press("Shift+T"))
    visitor.do(do="live", on=True)
    visitor.do(do="go", frame=24)
    until_told(tab, "view.frame", lambda frame: frame == 24)

    def release() -> None:
        x, y = spot(tab, "waist")
        tab.mouse.move(x, y)
        tab.mouse.down()
        tab.mouse.move(x + (4 if len(turns) % 2 else -4), y + 4, steps=2)
        turns.append(0)
        tab.mouse.up()

    turns: list[int] = []
    _passes(table, "live: a key let go", tab, probe, release, "pointerup")
    visitor.do(do="live", on=False)
    _put_back(visitor)


def _passes(
    table: Table, name: str, tab: Page, probe: Probe, act: Callable[[], object],
    kind: str = "keydown",
) -> None:  # fmt: skip
    """Of many runs; each one waits until the last is done."""
    here, seen = [], []
    for i in range(31):
        until_told(tab, "job.state", lambda state: state != "running", 120)
        probe.arm(kind, "pass seen", gate="pass")
        act()
        if (marks := probe.marks()) is not None and i:
            here.append(marks["pass"])
            seen.append(marks["pass seen"])
    until_told(tab, "job.state", lambda state: state != "running", 120)
    table.row(f"{name}: here", *_spread(here))
    table.row(f"{name}: drawn", *_spread(seen), expected=[_under(seen, 1000 * FIRST_PASS_S)])


def _playing(report: Report, browser: Browser, keypose: Keypose) -> None:
    with let_in(browser, drawn=True, size=(1440, 900)) as context:
        tab = opened(context, keypose)
        until(lambda: tab.locator(".view.drawn").count() == 4, "the four views", 120)
        probe = Probe(tab)
        table = report.table(
            f"playing {FILM[0]}×{FILM[1]} at {FPS:.0f} frames/s", "frames/s", "longest, ms"
        )
        for name in ("the first time", "again"):
            tab.keyboard.press("Home")
            tab.wait_for_selector("#main canvas.vid[data-frame='0']")
            tab.keyboard.press("Space")
            times = np.array(probe.played())
            shown = 1000 * (len(times) - 1) / (times[-1] - times[0])
            slower = [Expected("missing", FPS - shown, 0.02 * FPS, "frames/s")]
            table.row(name, float(shown), float(np.diff(times).max()), expected=slower)


def _idle(report: Report, tab: Page, keypose: Keypose) -> None:
    """What is spent while nothing happens."""
    table = report.table(f"nothing happens for {IDLE_S:.0f} s: % of a core", "server", "browser")
    empty = tab.context.new_page()
    empty.wait_for_timeout(3000)
    alone = _shares(empty, keypose)
    table.row("an empty page stands before it", *alone)
    empty.close()
    tab.mouse.move(2, 2)
    tab.wait_for_timeout(8000)
    shares = _shares(tab, keypose)
    most = [
        Expected("server", shares[0], 3.0, "%"),
        Expected("page", shares[1] - alone[1], 5.0, "%"),
    ]
    table.row("the page is seen", *shares, expected=most)


def _shares(tab: Page, keypose: Keypose) -> tuple[float, float]:
    """Percent of a core that server and browser take, for a while."""
    server = _family(keypose.process.pid)
    browser = _family(os.getpid()) - server - {os.getpid()}
    before = _cpu_s(server), _cpu_s(browser)
    tab.wait_for_timeout(1000 * IDLE_S)
    return 100 * (_cpu_s(server) - before[0]) / IDLE_S, 100 * (_cpu_s(browser) - before[1]) / IDLE_S


# --- servers, films, figures


@contextmanager
def _served(session: Path) -> Iterator[Keypose]:
    workspace = session.parent / "workspace"
    keypose = Keypose(str(session), "--workspace", str(workspace))
    try:
        yield keypose
    finally:
        keypose.end()


@contextmanager
def _tracking(keypose: Keypose) -> Iterator[None]:
    """All segments are tracked again and again by somebody else."""
    stop = threading.Event()

    def work() -> None:
        visitor = Visitor(keypose)
        while not stop.is_set():
            visitor.do(do="track", what="all")
            visitor.until(lambda: _job(visitor) != "running")
        visitor.leave()

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


def _job(visitor: Visitor) -> str:
    visitor.do(do="end_stroke", stroke="-")
    return str(visitor.seen["job"]["state"])


def _put_back(visitor: Visitor) -> None:
    visitor.do(do="end_stroke", stroke="-")
    while visitor.seen["undo"]["undo"] is not None:
        visitor.do(do="undo")


def _sample(folder: Path) -> Path:
    folder.mkdir()
    for name in ("person.mp4", "session.json"):
        shutil.copy(ROOT / "sample_videos" / "person" / name, folder)
    return folder / "session.json"


def _film(folder: Path, report: Report) -> Path:
    """The sample, larger, there and back, with its session."""
    session = _sample(folder)
    with Video.open(str(folder / "person.mp4")) as video:
        there = [cv2.resize(frame, FILM) for frame in video.frames(0, video.info.frame_count)]
    pictures = there + there[-2::-1]
    _encode(folder / "person.mp4", pictures)
    told = json.loads(session.read_text())
    scale = FILM[0] / told["camera"]["width"]
    for name in ("fx", "fy"):
        told["camera"][name] *= scale
    for name, size in (("cx", FILM[0]), ("cy", FILM[1])):
        told["camera"][name] = (size - 1) / 2
    size = {"width": FILM[0], "height": FILM[1]}
    told["camera"].update(size)
    told["video"].update(size, fingerprint="", frame_count=len(pictures))
    session.write_text(json.dumps(told))
    report.note(f"\na film of {len(pictures)} frames")
    return session


def _encode(path: Path, pictures: list[np.ndarray]) -> None:  # type: ignore[type-arg]
    with av.open(str(path), "w") as file:
        stream = file.add_stream("h264", rate=Fraction(30))
        stream.width, stream.height = FILM
        stream.pix_fmt = "yuv420p"
        for picture in pictures:
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, "rgb24")))
        file.mux(stream.encode())


def _spread(ms: list[float]) -> tuple[float, float]:
    return float(np.median(ms)), float(np.percentile(ms, 90))


def _under(ms: list[float], most: float) -> Expected:
    return Expected("median", float(np.median(ms)), most, "ms")


def _family(pid: int) -> set[int]:
    """A process and all below it."""
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    children = [int(child) for task in tasks for child in task.read_text().split()]
    return {pid}.union(*(_family(child) for child in children))


def _cpu_s(pids: set[int]) -> float:
    """Seconds of computing that these have done."""
    ticks = 0
    for pid in pids:
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")
