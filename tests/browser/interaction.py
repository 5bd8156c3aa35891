"""What a person does at the page, and what they see of it."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any, TypeAlias

from playwright.sync_api import Page

from tests.app.serving import LONGEST_S, ROOT

SCREENS = ROOT / "out" / "screens"
"""Where the pictures of every step are kept, to be looked at."""

PICTURES = bool(os.environ.get("KEYPOSE_TEST_PICTURES"))
"""Whether they are wanted: nothing is asserted of them, and they take as long as the tests."""

Spot: TypeAlias = tuple[float, float]
"""Pixels of the window."""

_WHEN_FADED = """
() => Promise.allSettled(
  document.getAnimations()
    .filter(({ effect }) => Number.isFinite(effect.getComputedTiming().endTime))
    .map(({ finished }) => finished),
).then(() => null)
"""
_FRAME = "() => new Promise((drawn) => requestAnimationFrame(() => drawn()))"
_IS_CAUGHT_UP = "async () => (await window.keypose.module('store/edits.js')).isCaughtUp()"


def section(page: Page, path: str) -> Any:
    """A part of the state that the page has from the server, such as "view.frame"."""
    return page.evaluate(f"() => window.keypose.server.{path}")


def until(there: Callable[[], Any], what: str = "it", seconds: float = LONGEST_S) -> Any:
    """Wait until something is so. The page allows no scripts from strings, hence from outside:
    soon at first, then more seldom, as every look costs the page time."""
    end = time.monotonic() + seconds
    pause = 0.01
    while True:
        found = there()
        if found:
            return found
        assert time.monotonic() < end, f"{what} never came"
        time.sleep(pause)
        pause = min(1.5 * pause, 0.1)


def until_state(
    page: Page, path: str, wanted: Callable[[Any], bool], seconds: float = LONGEST_S
) -> Any:
    """Wait until a section is as wanted; its value then."""
    until(lambda: wanted(section(page, path)), path, seconds)
    return section(page, path)


def until_counted(page: Page, selector: str, count: int) -> None:
    """Wait until so many of these are in the page: it draws a moment after a message."""
    until(lambda: page.locator(selector).count() == count, f"{count} of {selector}")


def settled(page: Page) -> None:
    """Wait until the page has drawn what it received."""
    page.evaluate(
        "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
    )


def answered(page: Page) -> None:
    """Wait until the server has dealt with all that was done at the page, and the page shows it."""
    page.evaluate(_FRAME)  # what is sent once per redraw is on its way
    until(lambda: page.evaluate(_IS_CAUGHT_UP), "the answer")
    settled(page)


def copied_to_clipboard(page: Page, copy: Callable[[], None]) -> None:
    """Copy, and wait until it is known whether the browser's clipboard took it."""
    page.evaluate(
        "async () => (await window.keypose.module('store/state.js')).setUi('copiedHere', null)"
    )
    copy()
    until(lambda: page.evaluate("() => window.keypose.ui.copiedHere !== null"), "the copy")
    answered(page)


def spot(page: Page, point: str, view: str = "main") -> Spot:
    """Where a joint or landmark is seen."""
    settled(page)
    x, y = page.evaluate(
        """([point, name]) => {
          const view = window.keypose.view(name);
          const [x, y] = view.project(window.keypose.server.pose.points[point]);
          const box = view.el.getBoundingClientRect();
          return [box.left + x, box.top + y];
        }""",
        [point, view],
    )
    return x, y


def between(page: Page, one: str, other: str, view: str = "main") -> Spot:
    """The middle between two joints: on the surface of what lies there."""
    (x0, y0), (x1, y1) = spot(page, one, view), spot(page, other, view)
    return (x0 + x1) / 2, (y0 + y1) / 2


def drag(page: Page, start: Spot, end: Spot, steps: int = 8, drop: bool = True) -> None:
    """From one spot to another with the left button."""
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(*end, steps=steps)
    if drop:
        page.mouse.up()


def faded(page: Page) -> None:
    """Wait until nothing fades in or out any more; what goes on for ever is not waited for."""
    settled(page)
    page.evaluate(_WHEN_FADED)


def screen(page: Page, name: str) -> None:
    """Keep a picture of what the page looks like now, where pictures are wanted."""
    settled(page)
    if not PICTURES:
        return
    SCREENS.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=SCREENS / f"{name}.png")


def screens(page: Page, name: str) -> None:
    """The same in both themes, and in a small window."""
    screen(page, name)
    if not PICTURES:
        return
    size = page.viewport_size
    assert size is not None
    themed(page, "light")
    screen(page, f"{name}-light")
    themed(page, "dark")
    page.set_viewport_size({"width": 1280, "height": 720})
    screen(page, f"{name}-small")
    page.set_viewport_size(size)
    settled(page)  # or the page would hear of it in the middle of what follows


def themed(page: Page, theme: str) -> None:
    """Draw in this theme, until another one is chosen."""
    page.evaluate("(theme) => { document.documentElement.dataset.theme = theme }", theme)
