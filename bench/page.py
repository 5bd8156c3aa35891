"""How soon the page answers: the server alone, and in a browser that draws by software."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from playwright.sync_api import Browser, BrowserContext, Page, sync_playwright

from bench.keeping import Absent
from bench.probe import Probe
from bench.stand import FPS, cpu_s, family, film, sample, serving
from bench.table import Expected, Report, Table
from tests.app.serving import Keypose, Visitor
from tests.browser.chromium import ARGUMENTS, find
from tests.browser.interaction import section, settled, spot, until, until_state
from tests.browser.shared import admit, opened

TIMES = 40
PASSES = 12
SERVER_MS = 100.0
FIRST_PASS_S = 2.0
RATIO = 1.5
FRAME = 24
"""A keyframe, where no pass moves the body while the pointer takes hold of it."""

PLAYED = (960, 540)
PLAYED_TURNS = 2
LONG = (640, 360)
LONG_TURNS = 20
"""A film whose job lasts: one that ended and began anew would end the drag under way."""

IDLE_S = 5.0
IDLE_PERCENT = {"server": 1.0, "page": 1.0}
PLAYED_FPS = 25.0
LOADS = 9
PAINTED_MS = 600.0
WINDOW = (1440, 900)
VIEWS = ("main", "top", "side", "front")
LIVE_MS = 40.0, 80.0
"""From the pointer's move to the motion drawn anew: median, and 95 of 100."""
Act: TypeAlias = Callable[[int, str], dict[str, Any]]
"""The action of a number, for a stroke of this name."""


def page(report: Report) -> None:
    """The whole group."""
    path = find()
    if path is None:
        raise Absent("a Chromium")
    busy, cores = os.getloadavg()[0], os.cpu_count()
    report.note(f"load when this began: {busy:.1f} on {cores} cores; beside others all is slower")
    with tempfile.TemporaryDirectory() as kept, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(ARGUMENTS))
        report.note(f"Chromium {browser.version}, drawn by software, {WINDOW[0]}×{WINDOW[1]}")
        folder = Path(kept)
        with serving(sample(folder / "person")) as keypose:
            _loads(report, browser, keypose)
            _alone(report, browser, keypose, folder)
        with serving(film(folder / "long", LONG, LONG_TURNS, passes=50)) as keypose:
            _beside_a_job(report, browser, keypose)
        with serving(film(folder / "played", PLAYED, PLAYED_TURNS)) as keypose:
            _playing(report, browser, keypose)
        browser.close()


def _loads(report: Report, browser: Browser, keypose: Keypose) -> None:
    """The page in a browser that has none of its files, as its own entries tell it."""
    found: dict[str, list[float]] = {}
    for _ in range(LOADS):
        with admit(browser, drawn=False, size=WINDOW) as context:
            tab = opened(context, keypose)
            tab.wait_for_selector("#main canvas.vid[data-frame]", state="attached")
            for name, ms in tab.evaluate(_PAINTED).items():
                found.setdefault(name, []).append(ms)
    table = report.table("the page loaded, nothing kept of it, ms", "median", "90 %")
    for name, spent in found.items():
        expected = [_under(spent, PAINTED_MS)] if name.startswith("first") else []
        table.row(name.replace("-", " "), *_spread(spent), expected=expected)


_PAINTED = """
() => {
  const entries = performance.getEntriesByType('paint');
  const [page] = performance.getEntriesByType('navigation');
  return {
    ...Object.fromEntries(entries.map(({ name, startTime }) => [name, startTime])),
    'all modules run': page.domContentLoadedEventEnd,
  };
}
"""


def _alone(report: Report, browser: Browser, keypose: Keypose, folder: Path) -> None:
    """All that there is, on the sample."""
    visitor = Visitor(keypose)
    table = report.table("the server alone: sent to answered, ms", "median", "90 %")
    for name, act in _acts().items():
        spent = _answers(visitor, act)
        table.row(name, *_spread(spent), expected=[_under(spent, SERVER_MS)])
    _put_back(visitor)
    with admit(browser, drawn=True, painted=True, size=WINDOW) as context:
        tab = _idle(report, context, keypose)
        probe = Probe(tab)
        moves = _moves(tab, probe, visitor)
        table = report.table("a hand dragged: from the pointer's move, ms", "median", "90 %")
        for name, spent in moves.items():
            table.row(name, *_spread(spent))
        _steps(report, tab, probe, visitor)
        _first_passes(report, tab, probe, visitor)
        _live(report, tab, probe, visitor, folder)
    visitor.leave()


def _beside_a_job(report: Report, browser: Browser, keypose: Keypose) -> None:
    """The same while segments are tracked, on a longer film."""
    visitor = Visitor(keypose)
    with admit(browser, drawn=True, painted=True, size=WINDOW) as context:
        tab = _opened(context, keypose)
        probe = Probe(tab)
        idle = {name: _answers(visitor, act) for name, act in _acts().items()}
        drawn = _moves(tab, probe, visitor)
        with _tracking(report, visitor):
            at_work = {name: _answers(visitor, act) for name, act in _acts().items()}
        with _tracking(report, visitor):
            drawn_at_work = _moves(tab, probe, visitor)
    columns = ("idle", "90 %", "tracking", "90 % then", "ratio")
    table = report.table(f"{visitor.seen['file']['frames']} frames beside a job, ms", *columns)
    for name in idle:
        _ratio(table, f"server: {name}", idle[name], at_work[name])
    for name in drawn:
        _ratio(table, f"page: {name}", drawn[name], drawn_at_work[name])
    visitor.leave()


def _ratio(table: Table, name: str, idle: list[float], at_work: list[float]) -> None:
    ratio = float(np.median(at_work) / np.median(idle))
    expected = [Expected("ratio", ratio, RATIO)]
    table.row(name, *_spread(idle), *_spread(at_work), ratio, expected=expected)


# --- the server alone


def _acts() -> dict[str, Act]:
    return {
        "a hand dragged": _drag({"kind": "end", "name": "left_hand"}),
        "a ring turned": _drag({"kind": "ring", "part": "right_shin", "axis": "x"}),
        "a length dragged": _drag({"kind": "size", "part": "left_shin", "key": "length"}),
        "a step to a frame": lambda i, _: {"do": "go", "frame": FRAME + i % 12},
    }


def _drag(handle: dict[str, Any]) -> Act:
    """The moves of one gesture."""

    def act(i: int, stroke: str) -> dict[str, Any]:
        at = [320 + 8 * np.sin(i / 3), 200 - 8 * np.cos(i / 3)]
        moved = {"view": "main", "handle": handle, "from": [320, 200], "at": at}
        return {"do": "drag", **moved, "stroke": stroke}

    return act


def _answers(visitor: Visitor, act: Act) -> list[float]:
    """From a message sent to its answer received, over a socket like the page's."""
    spent, stroke = [], str(time.monotonic_ns())
    visitor.do(do="go", frame=FRAME)
    for i in range(TIMES + 5):
        action = act(i, stroke)
        began = time.perf_counter()
        visitor.do(**action)
        spent.append(1000 * (time.perf_counter() - began))
    visitor.do(do="end_stroke", stroke=stroke)
    return spent[5:]


# --- in the browser


def _hand_taken(tab: Page, visitor: Visitor) -> tuple[float, float]:
    """Take hold of a hand at a keyframe; where it was."""
    visitor.do(do="go", frame=FRAME)
    until_state(tab, "view.frame", lambda frame: frame == FRAME)
    x, y = spot(tab, "left_hand")
    tab.mouse.move(x, y)
    tab.mouse.down()
    tab.mouse.move(x + 6, y)
    return x, y


def _moves(tab: Page, probe: Probe, visitor: Visitor) -> dict[str, list[float]]:
    """A hand dragged, each move once the one before is drawn everywhere."""
    x, y = _hand_taken(tab, visitor)
    found: dict[str, list[float]] = {"answered": [], "own view drawn": [], "the other three": []}
    for i in range(TIMES + 5):
        probe.arm("pointermove", "told", *VIEWS)
        tab.mouse.move(x + 14 * np.cos(i / 4), y - 14 * np.sin(i / 4))
        if (marks := probe.marks()) is not None and i >= 5:
            last = max(marks[view] for view in VIEWS[1:])
            for name, ms in zip(found, (marks["told"], marks["main"], last), strict=True):
                found[name].append(ms)
    tab.mouse.up()
    until_state(tab, "pose.stroke", lambda stroke: stroke is None)
    _put_back(visitor)
    return found


def _steps(report: Report, tab: Page, probe: Probe, visitor: Visitor) -> None:
    visitor.do(do="go", frame=0)
    until_state(tab, "view.frame", lambda frame: frame == 0)
    settled(tab)
    shown, stands = [], []
    for _ in range(TIMES):
        probe.arm("keydown", "film", "main")
        tab.keyboard.press("ArrowRight")
        if (marks := probe.marks()) is not None:
            shown.append(marks["film"])
            stands.append(marks["main"])
    table = report.table("a step to the next frame: from the key, ms", "median", "90 %")
    table.row("the film shows it", *_spread(shown))
    table.row("and the body stands there", *_spread(stands))


def _first_passes(report: Report, tab: Page, probe: Probe, visitor: Visitor) -> None:
    table = report.table("to the first pass of 24 frames, ms", "median", "90 %")
    for quality in ("preview", "full"):
        visitor.do(do="settings", quality=quality)
        visitor.do(do="go", frame=12)
        until_state(tab, "view.frame", lambda frame: frame == 12)
        _passes(table, f"{quality}: Track", tab, probe, lambda: tab.keyboard.press("Shift+T"))
    visitor.do(do="live", on=True)
    visitor.do(do="go", frame=FRAME)
    until_state(tab, "view.frame", lambda frame: frame == FRAME)
    ways = iter((-4, 4) * 100)

    def drag() -> None:
        x, y = spot(tab, "waist")
        tab.mouse.move(x, y)
        tab.mouse.down()
        tab.mouse.move(x + next(ways), y + 4, steps=2)
        tab.mouse.up()

    _passes(table, "live: a drag let go", tab, probe, drag, "pointerup")
    visitor.do(do="live", on=False)
    _put_back(visitor)


def _live(report: Report, tab: Page, probe: Probe, visitor: Visitor, folder: Path) -> None:
    """A hand dragged with Live on, and the motion of both segments beside it; alone, and while a
    batch tracks another film."""
    visitor.do(do="track", what="all")
    visitor.until(lambda: visitor.seen["job"]["state"] == "done", 120)
    visitor.do(do="live", on=True)
    table = report.table("a hand dragged with Live: the trail drawn, ms", "median", "95 %")
    _live_row(table, "alone", tab, probe, visitor)
    with _batch(folder):
        _live_row(table, "beside a batch", tab, probe, visitor)
    visitor.do(do="live", on=False)
    _put_back(visitor)


def _live_row(table: Table, name: str, tab: Page, probe: Probe, visitor: Visitor) -> None:
    x, y = _hand_taken(tab, visitor)
    spent = []
    for i in range(2 * TIMES + 5):
        probe.arm("pointermove", "trail")
        tab.mouse.move(x + 14 * np.cos(i / 4), y - 14 * np.sin(i / 4))
        if (marks := probe.marks()) is not None and i >= 5:
            spent.append(marks["trail"])
    tab.mouse.up()
    until_state(tab, "pose.stroke", lambda stroke: stroke is None)
    until_state(tab, "job.state", lambda state: state != "running", 120)
    median, late = float(np.median(spent)), float(np.percentile(spent, 95))
    expected = [Expected("median", median, LIVE_MS[0], "ms"), Expected("95 %", late, LIVE_MS[1])]
    table.row(name, median, late, expected=expected)


@contextmanager
def _batch(folder: Path) -> Iterator[None]:
    """Another film is tracked at the command line meanwhile, again and again."""
    session = film(folder / "batch", LONG, LONG_TURNS, passes=50)
    command = [sys.executable, "-m", "keypose", "batch", "--overwrite", str(session)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def _passes(
    table: Table,
    name: str,
    tab: Page,
    probe: Probe,
    act: Callable[[], object],
    kind: str = "keydown",
) -> None:
    """Again and again, each time once the job before is done."""
    here, seen = [], []
    for i in range(PASSES + 1):
        until_state(tab, "job.state", lambda state: state != "running", 120)
        probe.arm(kind, "pass seen", gate="pass")
        act()
        if (marks := probe.marks()) is not None and i:
            here.append(marks["pass"])
            seen.append(marks["pass seen"])
    until_state(tab, "job.state", lambda state: state != "running", 120)
    table.row(f"{name}, here", *_spread(here))
    table.row(f"{name}, drawn", *_spread(seen), expected=[_under(seen, 1000 * FIRST_PASS_S)])


def _playing(report: Report, browser: Browser, keypose: Keypose) -> None:
    with admit(browser, drawn=True, painted=True, size=WINDOW) as context:
        tab = _opened(context, keypose)
        probe = Probe(tab)
        frames = section(tab, "file.frames")
        title = f"playing {frames} frames of {PLAYED[0]}×{PLAYED[1]}"
        table = report.table(title, "frames/s", "longest, ms")
        for name in ("the first time", "again"):
            tab.keyboard.press("Home")
            tab.wait_for_selector("#main canvas.vid[data-frame='0']")
            tab.keyboard.press("Space")
            times = np.array(probe.played())
            shown = 1000 * (len(times) - 1) / (times[-1] - times[0])
            missing = Expected("missing", FPS - shown, FPS - PLAYED_FPS, "frames/s")
            table.row(name, float(shown), float(np.diff(times).max()), expected=[missing])


def _idle(report: Report, context: BrowserContext, keypose: Keypose) -> Page:
    """What is spent while nothing happens; the page."""
    table = report.table(f"nothing happens for {IDLE_S:.0f} s: % of a core", "server", "browser")
    empty = context.new_page()
    empty.wait_for_timeout(1000 * IDLE_S)
    alone = _shares(empty, keypose)
    table.row("an empty page", *alone)
    empty.close()
    tab = _opened(context, keypose)
    tab.mouse.move(2, 2)
    tab.wait_for_timeout(2000 * IDLE_S)
    server, browser = _shares(tab, keypose)
    found = {"server": server, "page": browser - alone[1]}
    most = [Expected(what, found[what], most, "%") for what, most in IDLE_PERCENT.items()]
    table.row("the page", server, browser, expected=most)
    return tab


def _shares(tab: Page, keypose: Keypose) -> tuple[float, float]:
    """Percent of a core that server and browser take, for a while."""
    server = family(keypose.process.pid)
    browser = family(os.getpid()) - server - {os.getpid()}
    before = cpu_s(server), cpu_s(browser)
    tab.wait_for_timeout(1000 * IDLE_S)
    spent = cpu_s(server) - before[0], cpu_s(browser) - before[1]
    return 100 * spent[0] / IDLE_S, 100 * spent[1] / IDLE_S


# --- what all of them need


def _opened(context: BrowserContext, keypose: Keypose) -> Page:
    """The page, with all its pictures."""
    tab = opened(context, keypose)
    until(lambda: tab.locator(".view.drawn").count() == 4, "the four views", 120)
    return tab


@contextmanager
def _tracking(report: Report, visitor: Visitor) -> Iterator[None]:
    """All segments are being tracked; said, when that ends too soon."""
    visitor.do(do="track", what="all")
    visitor.until(lambda: any(s["state"] == "tracking" for s in visitor.seen["segments"]))
    yield
    _put_back(visitor)
    if visitor.seen["job"]["state"] != "running":
        report.note("the job was done before the drags were")
    visitor.do(do="cancel")
    visitor.until(lambda: visitor.seen["job"]["state"] != "running")


def _put_back(visitor: Visitor) -> None:
    """Take back all edits of poses and sizes."""
    visitor.do(do="end_stroke", stroke="-")
    while visitor.seen["undo"]["undo"] is not None:
        visitor.do(do="undo")


def _spread(ms: list[float]) -> tuple[float, float]:
    return float(np.median(ms)), float(np.percentile(ms, 90))


def _under(ms: list[float], most: float) -> Expected:
    return Expected("median", float(np.median(ms)), most, "ms")
