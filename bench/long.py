"""How quick long and large films are: opened, stepped through, edited, reviewed."""

from __future__ import annotations

import http.client
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from urllib.parse import quote

import av
import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright

from bench import long_films
from bench.keeping import ROOT, Absent
from bench.stand import sample, serving
from bench.table import Expected, Report, Table
from keypose.tracker.video import Video
from tests.app.serving import Keypose, Visitor
from tests.browser.chromium import ARGUMENTS, find
from tests.browser.interaction import until, until_counted, until_state
from tests.browser.shared import admit, opened

LARGE_OPENED_S = 4.0
"""Frames that lie far apart are looked at, to tell whether the camera stands still."""
OPENED_S = 1.0
NEXT_MS = 20.0
ANYWHERE_MS = 120.0
LARGE_MS = 60.0
EDITED_MS = 200.0
PLACE_MS = 100.0
STEPS = 60
JUMPS = 40
WORKED_FRAMES = 10_000
KEYFRAMES = 11
PLACES = 1000
KILLED_AT = 80
WALKER = "1010,370,1130,700"
WINDOW = (1440, 900)

_MAKE_PLACES = """
async (count) => {
  const { applySections } = await window.keypose.module('store/state.js');
  const { frames } = window.keypose.server.file;
  const places = Array.from({ length: count }, (_, i) => {
    const frame = Math.floor(((i * 7919) % count) * frames / count);
    return {
      id: `place ${i}`, kind: 'tracked', frame, part: 'left_hand', label: 'Left hand', side: 'L',
      cause: 'other', first: frame, last: frame, px: 50 - (40 * i) / count, cm: null, size: '12 px',
      reason: 'Expected error', end: [0, 0, 3], radius_m: 0.05, at: [320, 180], crop: 80,
      box: [280, 140, 360, 220],
    };
  });
  const review = { ...window.keypose.server.review, places, answered: [], untracked: 0 };
  applySections({ review });
}
"""


def long(report: Report) -> None:
    """The whole group."""
    hour, large = long_films.hour(), long_films.large()
    path = find()
    if path is None:
        raise Absent("a Chromium")
    _read(report, hour)
    _gone_on(report)
    with tempfile.TemporaryDirectory() as kept, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(ARGUMENTS))
        report.note(f"Chromium {browser.version}, drawn by software, {WINDOW[0]}×{WINDOW[1]}")
        with serving(_beside(Path(kept) / "hour", hour)) as keypose:
            _opening(report, keypose, hour, OPENED_S)
            _answers(report, keypose, "an hour", (NEXT_MS, ANYWHERE_MS), shrink=1)
            _edits(report, keypose)
            with admit(browser, drawn=False, size=WINDOW) as context:
                _in_page(report, opened(context, keypose), "an hour")
        with serving(_beside(Path(kept) / "large", large)) as keypose:
            _opening(report, keypose, large, LARGE_OPENED_S)
            _answers(report, keypose, "3840 × 2160, whole", (None, None), shrink=1)
            _answers(report, keypose, "3840 × 2160, as shown", (LARGE_MS, None), shrink=2)
            with admit(browser, drawn=False, size=WINDOW) as context:
                _in_page(report, opened(context, keypose), "3840 × 2160")
        with serving(sample(Path(kept) / "person")) as keypose:
            _review(report, browser, keypose)
        browser.close()


def _beside(folder: Path, film: Path) -> Path:
    """The sample's session, with another film beside it."""
    session = sample(folder)
    shutil.copy(film, folder)  # a link would lead out of the folder that may be looked into
    return session


def _read(report: Report, hour: Path) -> None:
    """Open a film without the program around it."""
    spent = []
    for _ in range(5):
        began = time.perf_counter()
        with Video.open(hour):
            spent.append(time.perf_counter() - began)
    report.expect("an hour of film indexed", float(np.median(spent)), OPENED_S, "s")


def _gone_on(report: Report) -> None:
    """A draft that is killed and begun again: how many frames are looked at once more."""
    with tempfile.TemporaryDirectory() as kept:
        film = Path(kept) / "walk.mp4"
        with (
            av.open(str(ROOT / "sample_videos" / "walk" / "walk.mp4")) as source,
            av.open(str(film), "w") as file,
        ):
            file.metadata["comment"] = str(time.time_ns())  # no film that was drafted before
            stream = file.add_stream_from_template(source.streams.video[0])
            for packet in source.demux(source.streams.video[0]):
                if packet.size:
                    packet.stream = stream
                    file.mux(packet)
        command = [sys.executable, "-m", "keypose.app", "draft", str(film), "--json"]
        command += ["--frame", "12", "--box", WALKER, "--out", str(Path(kept) / "draft")]
        killed = _draft_until(command, KILLED_AT)
        report.expect(
            "frames that a killed draft finds again", killed - _draft_until(command, 0), 32
        )


def _draft_until(command: list[str], wanted: int) -> int:
    """Draft until the keypoints of so many frames are found, then kill it; of how many they are."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        told = (json.loads(line) for line in child.stdout)
        done = next((one["done"] for one in told if one.get("done", -1) >= wanted), 0)
        child.kill()
    return int(done)


def _opening(report: Report, keypose: Keypose, film: Path, most_s: float) -> None:
    """From the order to open it until its first picture is there."""
    visitor = Visitor(keypose)
    began = time.perf_counter()
    visitor.do(do="open", kind="file", id=f"1/{film.name}")
    visitor.until(lambda: (visitor.seen["file"] or {}).get("video") == film.name, 30)
    _Pictures(keypose, visitor, 1).fetch(0)
    name = film.stem.rsplit("-", 1)[0]
    report.expect(
        f"{name} opened in the server, first picture", time.perf_counter() - began, most_s, "s"
    )
    visitor.leave()


class _Pictures:
    """Asks for pictures as the page does."""

    def __init__(self, keypose: Keypose, visitor: Visitor, shrink: int) -> None:
        self._line = http.client.HTTPConnection(*keypose.host.split(":"))
        self._headers = keypose.entered.headers
        version = quote(visitor.seen["camera"]["image_version"])
        self._query = f"v={version}&shrink={shrink}"

    def fetch(self, frame: int) -> float:
        """Milliseconds until a frame's picture is there."""
        began = time.perf_counter()
        self._line.request("GET", f"/frame/{frame}.jpg?{self._query}", headers=self._headers)
        answer = self._line.getresponse()
        answer.read()
        assert answer.status == 200, answer.status
        return 1000 * (time.perf_counter() - began)


def _answers(
    report: Report,
    keypose: Keypose,
    name: str,
    most: tuple[float | None, float | None],
    shrink: int,
) -> None:
    """Pictures that were not asked for before, the server alone."""
    visitor = Visitor(keypose)
    pictures, frames = _Pictures(keypose, visitor, shrink), visitor.seen["file"]["frames"]
    table = report.table(f"{name}: a picture asked for until there, ms", "median", "95 %")
    start, random = frames // 2 + 7, np.random.default_rng(shrink)
    steps = min(STEPS, frames // 4)
    pictures.fetch(start)
    next_ones = [pictures.fetch(start + i) for i in range(1, steps + 1)]
    _row(table, "the next one", next_ones, most[0])
    pictures.fetch(start - 1)
    back = [pictures.fetch(start - i) for i in range(2, steps + 1)]
    _row(table, "the one before", back, None)
    anywhere = [pictures.fetch(int(frame)) for frame in random.integers(0, frames, JUMPS)]
    _row(table, "any other", anywhere, most[1])
    visitor.leave()


def _edits(report: Report, keypose: Keypose) -> None:
    """A film of which some minutes are worked on, each message until it is dealt with."""
    visitor = Visitor(keypose)
    apart = WORKED_FRAMES // (KEYFRAMES - 1)
    for i in range(KEYFRAMES):
        visitor.do(do="go", frame=i * apart)
        visitor.do(do="add_key", frame=i * apart)
    middle = WORKED_FRAMES // 2
    table = report.table(
        f"{KEYFRAMES} keyframes over {WORKED_FRAMES} frames of an hour, the server alone, ms",
        *("median", "95 %"),
    )
    go = _spent(visitor, ({"do": "go", "frame": middle + i} for i in range(STEPS)))
    _row(table, "a step to a frame", go, NEXT_MS)
    edits = ({"do": do} for _ in range(8) for do in ("undo", "redo"))
    _row(table, "a keyframe undone, redone", _spent(visitor, edits), EDITED_MS)
    parts = [part["name"] for part in visitor.seen["body"]["parts"]]
    selects: Iterable[dict[str, Any]] = ({"do": "select", "part": part} for part in parts)
    _row(table, "another part selected", _spent(visitor, selects), EDITED_MS)
    visitor.leave()


def _spent(visitor: Visitor, actions: Iterable[dict[str, Any]]) -> list[float]:
    spent = []
    for action in actions:
        began = time.perf_counter()
        visitor.do(**action)
        spent.append(1000 * (time.perf_counter() - began))
    return spent


# --- in the browser


def _in_page(report: Report, tab: Page, name: str) -> None:
    """From a key until the film shows its frame."""
    table = report.table(f"{name}: a step in the page, from the key, ms", "median", "95 %")
    tab.mouse.move(2, 2)
    for way, key in (("forward", "ArrowRight"), ("back", "ArrowLeft")):
        tab.wait_for_timeout(1000)
        spent = [_after_key(tab, key, _SHOWN, 50) for _ in range(min(STEPS, 40))]
        _row(table, way, spent, None)


_SHOWN = """
new Promise((done) => {
  let began = null;
  const begin = ({ timeStamp }) => (began = timeStamp);
  addEventListener('keydown', begin, { capture: true, once: true });
  const shown = new MutationObserver(() => {
    shown.disconnect();
    requestAnimationFrame(() => done(performance.now() - began));
  });
  shown.observe(document.querySelector('#main canvas.vid'), { attributeFilter: ['data-frame'] });
})
"""
"""Milliseconds from the next key until the film shows another frame."""
_DRAWN = """
new Promise((done) => addEventListener('keydown', ({ timeStamp }) => requestAnimationFrame(() =>
  requestAnimationFrame(() => setTimeout(() => done(performance.now() - timeStamp)))
), { capture: true, once: true }))
"""
"""Milliseconds from the next key until the page has drawn what follows, and can go on."""


def _after_key(tab: Page, key: str, script: str, rest_ms: int) -> float:
    tab.wait_for_timeout(rest_ms)
    tab.evaluate(f"() => {{ window.benchFound = {script.strip()}; }}")
    tab.keyboard.press(key)
    found: float = tab.evaluate("() => window.benchFound")
    return found


def _review(report: Report, browser: Browser, keypose: Keypose) -> None:
    """A list of a thousand places, which the page is given without a server that has them."""
    with admit(browser, drawn=False, size=WINDOW) as context:
        tab = opened(context, keypose)
        asked: list[str] = []
        tab.on("request", lambda request: asked.append(request.url))
        tab.mouse.move(2, 2)
        tab.evaluate(_MAKE_PLACES, PLACES)
        until_state(tab, "review.places.length", lambda count: count == PLACES)
        table = report.table(f"a review of {PLACES} places in the page, ms", "median", "95 %")
        _row(table, "opened", [_after_key(tab, "Shift+R", _DRAWN, 300)], 10 * PLACE_MS)
        until_counted(tab, ".rv-place", PLACES)
        until(lambda: tab.locator("frame-crop canvas").count() > 0, "its pictures")
        steps = [_after_key(tab, "n", _DRAWN, 300) for _ in range(20)]
        _row(table, "to the next place", steps, PLACE_MS)
        pictures = sum("/frame/" in url for url in asked)
        report.expect("pictures fetched for the list and 20 steps", pictures, PLACES / 4)


def _row(table: Table, name: str, ms: list[float], most: float | None) -> None:
    spread = float(np.median(ms)), float(np.percentile(ms, 95))
    expected = [] if most is None else [Expected("95 %", spread[1], most, "ms")]
    table.row(name, *spread, expected=expected)
