"""One session in several tabs, after a reload, and after the line to the server was lost."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from tests.app.serving import Visitor
from tests.browser.interaction import answered, drag, section, spot, until, until_state
from tests.browser.proxy import Proxy, proxy
from tests.browser.shared import Desk, admit, opened, served

SHARED = ("file", "camera", "views", "body", "view", "pose", "keys", "segments", "undo", "masks")
"""What all tabs show alike."""

DRAWN = """
() => [...document.querySelectorAll('iframe.viser')].map((frame) => {
  const node = frame.contentWindow.__viserMutable?.nodeRefFromName['/camera/body/0'];
  return node ? node.position.toArray() : null;
})
"""
"""Where viser's four pictures have the body's first part, camera frame."""


REFUSED = """
() => [...document.querySelectorAll('iframe.viser')]
  .filter((frame) => !frame.contentDocument).length
"""
"""How many of viser's pictures could not be fetched: the browser's own page is of another origin.
Asked of the page, as requests are answered here only while it is asked something."""


WISHED_LONG_AGO = """
() => {
  const inside = document.querySelector('iframe.viser').contentWindow.__viserMutable;
  const usual = inside.scene.onBeforeRender;
  inside.scene.onBeforeRender = (...what) => {
    document.body.dataset.drawnLate = 'yes';
    inside.scene.onBeforeRender = usual;
    usual(...what);
  };
  inside.requestRender();
  const now = performance.now.bind(performance);
  performance.now = () => now() + 10_000;
}
"""
"""Wish for a picture and let ten seconds pass before the browser gets to it."""


SLOW = """
if (window === top) {
  let passed = 0;
  const now = performance.now.bind(performance);
  performance.now = () => now() + (passed += 10_000);
}
"""
"""As if ten seconds passed between any two looks at the clock."""


SMALL = (800, 480)
"""Software draws all that is seen, four times."""


@pytest.fixture(scope="module")
def wired(
    browser: Browser, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[Desk, Proxy]]:
    """A page whose line to the server can be cut."""
    with (
        proxy() as relay,
        served(tmp_path_factory.mktemp("tabs")) as (keypose, session),
        admit(browser, drawn=False, size=SMALL, proxy={"server": relay.address}) as context,
    ):
        visitor = Visitor(keypose)
        yield Desk(opened(context, keypose), visitor, keypose, session), relay
        visitor.leave()


@pytest.fixture
def at(wired: tuple[Desk, Proxy]) -> Desk:
    """The page as if it had just been opened."""
    wired[0].fresh()
    return wired[0]


@pytest.fixture(scope="module")
def drawn(browser: Browser, wired: tuple[Desk, Proxy]) -> Iterator[Desk]:
    """The same with viser's pictures, in a browser of its own."""
    desk, relay = wired
    with admit(browser, drawn=True, size=SMALL, proxy={"server": relay.address}) as context:
        page = opened(context, desk.keypose)
        until(lambda: page.locator(".view.drawn").count() == 4, "the four views")
        yield replace(desk, page=page)


@pytest.fixture
def at_views(at: Desk, drawn: Desk) -> Desk:
    """The page with viser's pictures as if it had just been opened."""
    drawn.fresh()
    return drawn


@pytest.fixture
def other(browser: Browser, at: Desk) -> Iterator[Page]:
    """Another tab, in a browser of its own."""
    with admit(browser, drawn=False, size=SMALL) as context:
        yield opened(context, at.keypose)


@pytest.fixture
def line(wired: tuple[Desk, Proxy]) -> Iterator[Proxy]:
    """The line, whole again afterwards."""
    yield wired[1]
    wired[1].mend()
    until(lambda: _connected(wired[0].page), "the line")


def _connected(page: Page) -> bool:
    return bool(page.evaluate("() => window.keypose.ui.connected"))


def _all(page: Page) -> dict[str, Any]:
    return {name: json.loads(json.dumps(section(page, name))) for name in SHARED}


def _alike(*pages: Page) -> bool:
    return all(_all(page) == _all(pages[0]) for page in pages)


def _is_drawn(page: Page) -> bool:
    """Whether all four pictures of viser show the pose that the page was told."""
    root = np.array(section(page, "pose.root"))
    there = page.evaluate(DRAWN)
    return len(there) == 4 and all(p is not None and np.allclose(p, root, atol=1e-4) for p in there)


def status(page: Page) -> str:
    """The words of the bar below, in small letters."""
    return page.locator("#status").inner_text().lower()


def test_what_one_tab_does_appears_in_the_other(at: Desk, other: Page) -> None:
    one = at.page
    until(lambda: _alike(one, other), "the same state")
    until_state(one, "tabs", lambda count: count == 3)
    until(lambda: "3 tabs open" in status(one), "the count")
    start = spot(one, "left_hand")
    drag(one, start, (start[0] + 16, start[1] - 20), steps=3)
    until(
        lambda: _alike(one, other) and section(other, "undo.undo") == "move left hand", "the edit"
    )
    answered(one)
    until(lambda: _alike(one, other), "the same state")
    np.testing.assert_allclose(spot(other, "left_hand"), spot(one, "left_hand"), atol=0.5)
    other.keyboard.press("ArrowRight")
    until(lambda: section(one, "view.frame") == 1, "the frame")
    one.wait_for_selector("#main canvas.vid[data-frame='1']")
    other.keyboard.press("k")
    until(lambda: 1 in section(one, "keys.frames"), "the keyframe")
    one.keyboard.press("Control+z")
    one.keyboard.press("Control+z")
    until(lambda: section(other, "undo.undo") is None, "the undo")
    until(lambda: _alike(one, other), "the same state")
    other.close()
    until_state(one, "tabs", lambda count: count == 2)


def test_tool_and_layout_are_each_tabs_own(at: Desk, other: Page) -> None:
    own = "() => [window.keypose.ui.tool, window.keypose.ui.layout]"
    at.page.keyboard.press("r")
    at.page.keyboard.press("2")
    assert at.page.evaluate(own) == ["rotate", "top"]
    assert other.evaluate(own) == ["select", "main"]


def test_a_reload_comes_back_to_the_same(at: Desk) -> None:
    at.page.keyboard.press("ArrowRight")
    until_state(at.page, "view.frame", lambda frame: frame == 1)
    start = spot(at.page, "waist")
    drag(at.page, start, (start[0] + 30, start[1] + 10), steps=3)
    until_state(at.page, "undo.undo", lambda label: label == "move the body")
    at.page.keyboard.press("w")
    until_state(at.page, "view.mode", lambda mode: mode != "both")
    answered(at.page)
    before, place = _all(at.page), spot(at.page, "waist")
    at.page.reload()
    at.page.wait_for_selector("html[data-ready]", state="attached")
    at.page.wait_for_selector("#main canvas.vid[data-frame='1']")
    until(lambda: _all(at.page) == before, "all that was there")
    np.testing.assert_allclose(spot(at.page, "waist"), place, atol=0.5)


def test_a_page_reloaded_in_the_middle_of_a_job_shows_what_it_found(other: Page) -> None:
    other.keyboard.press("t")
    until_state(other, "job.state", lambda state: state == "running")
    other.reload()
    other.wait_for_selector("html[data-ready]", state="attached")
    until_state(other, "job.state", lambda state: state == "done")
    found = until_state(other, "segments", lambda segments: all(one["px"] for one in segments))
    assert {one["state"] for one in found} <= {"good", "check", "lost"}


def test_without_a_line_edits_wait_and_arrive_in_order(at: Desk, line: Proxy) -> None:
    page = at.page
    line.cut()
    until(lambda: "reconnecting…" in status(page), "the word")
    for key in ("ArrowRight", "k", "ArrowRight", "k", "Control+z", "ArrowRight", "k"):
        page.keyboard.press(key)
    until(lambda: "4 edits waiting" in status(page), "the count")
    assert at.served["view"]["frame"] == 0
    assert at.served["undo"]["undo"] is None
    line.mend()
    until(lambda: at.served["keys"]["frames"] == [0, 1, 3, 24, 48, 72], "the edits")
    until(lambda: "connected" in status(page), "the word")
    assert at.agreed("view")["frame"] == 3
    for name in SHARED:
        at.agreed(name)
    until(lambda: at.agreed("saved")["state"] == "saved", "the file")


def test_a_drag_is_one_step_though_the_line_is_lost_meanwhile(at: Desk, line: Proxy) -> None:
    page, before = at.page, at.served["pose"]
    start = spot(page, "left_hand")
    drag(page, start, (start[0] + 6, start[1] - 6), steps=2, drop=False)
    until_state(page, "pose.gesture", bool)
    line.cut()
    until(lambda: not _connected(page), "the loss")
    page.mouse.move(start[0] + 12, start[1] - 12, steps=5)
    line.mend()
    page.mouse.up()
    until(lambda: _connected(page), "the line")
    until(lambda: at.agreed("pose")["stroke"] is None, "the end of the drag")
    for name in SHARED:
        at.agreed(name)
    assert at.served["undo"]["undo"] == "move left hand"
    at.visitor.do(do="undo")
    assert at.agreed("pose") == before
    assert at.served["undo"]["undo"] is None


# --- viser's pictures


def test_after_the_line_was_lost_all_four_views_come_back(at_views: Desk, line: Proxy) -> None:
    until(lambda: _is_drawn(at_views.page), "viser's pictures")
    line.cut()
    until(lambda: not _connected(at_views.page), "the loss")
    at_views.visitor.do(do="root", x=0.4, z=6.0)
    line.mend()
    until(lambda: _connected(at_views.page), "the line")
    at_views.agreed("pose")
    until(lambda: _is_drawn(at_views.page), "viser's pictures")
    start = spot(at_views.page, "waist")
    drag(at_views.page, start, (start[0] - 30, start[1]), steps=3)
    at_views.agreed("pose")
    until(lambda: _is_drawn(at_views.page), "viser's pictures")


def test_a_picture_wished_for_in_the_background_is_drawn_when_the_browser_comes_to_it(
    at_views: Desk,
) -> None:
    at_views.page.wait_for_timeout(1500)  # whatever was wished for before is drawn
    at_views.page.evaluate(WISHED_LONG_AGO)
    until(lambda: at_views.page.locator("body[data-drawn-late]").count(), "the picture")


def test_views_that_could_not_be_fetched_are_drawn_once_they_can_be(at_views: Desk) -> None:
    page = at_views.page
    context = page.context
    context.route("**/view/*", lambda route: route.abort())
    page.reload()
    page.wait_for_selector("html[data-ready]", state="attached")
    page.wait_for_selector("#main canvas.vid[data-frame]")
    until(lambda: page.evaluate(REFUSED) == 4, "the browser's own pages")
    assert not page.locator(".view.drawn").count()
    context.unroute("**/view/*")
    page.evaluate("() => document.querySelectorAll('iframe.viser').forEach((f) => (f.src = f.src))")
    until(lambda: page.locator(".view.drawn").count() == 4, "the four views")
    until(lambda: _is_drawn(page), "viser's pictures")


def test_on_a_very_slow_screen_all_four_views_are_drawn_nevertheless(
    browser: Browser, at_views: Desk
) -> None:
    with admit(browser, drawn=True, size=SMALL) as context:
        context.add_init_script(SLOW)
        page = opened(context, at_views.keypose)
        until(lambda: page.locator(".view.drawn").count() == 4, "the four views")
