"""A server and its page for all tests of a module, each of which begins where the first did."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, BrowserContext, Page

from tests.app.serving import ROOT, Keypose, Visitor
from tests.browser.interaction import PICTURES, answered, section, settled, until
from tests.browser.late import new_context

SIZE = (1280, 720)


@contextmanager
def served(folder: Path) -> Iterator[tuple[Keypose, Path]]:
    """A server of the person sample, and the session's file. It must end without a stumble."""
    place = folder / "person"
    place.mkdir()
    for name in ("person.mp4", "session.json"):
        shutil.copy(ROOT / "sample_videos" / "person" / name, place)
    session = place / "session.json"
    keypose = Keypose(str(session), "--workspace", str(folder / "workspace"))
    try:
        yield keypose, session
    finally:
        code, words = keypose.end()
    assert code == 0, words
    assert "Traceback" not in words, words


@contextmanager
def let_in(
    browser: Browser, *, drawn: bool, size: tuple[int, int] = SIZE, **more: Any
) -> Iterator[BrowserContext]:
    """A browser of its own, in which no script may fail. Its pages do without viser's pictures,
    which software draws slowly, unless a test or a person is to see them."""
    viewport = {"width": size[0], "height": size[1]}
    context = new_context(browser, viewport=viewport, **more)
    complaints: list[str] = []
    context.on("weberror", lambda error: complaints.append(str(error.error)))
    if not (drawn or PICTURES):
        empty = "<!doctype html><title>no picture</title>"
        context.route("**/view/*", lambda route: route.fulfill(body=empty))
    yield context
    context.close()
    assert not complaints, complaints


def opened(context: BrowserContext, keypose: Keypose) -> Page:
    """One more tab with the page, ready for use."""
    page = context.new_page()
    page.goto(keypose.address)
    page.wait_for_selector("html[data-ready]", state="attached")
    page.wait_for_selector("#main canvas.vid[data-frame]")
    return page


@dataclass
class Desk:
    """The page; the state as another visitor receives it; the session on disk."""

    page: Page
    visitor: Visitor
    keypose: Keypose
    session: Path

    @property
    def served(self) -> dict[str, Any]:
        """The newest of every section, as the server sends it to others once it has dealt with all
        that was done at the page; what a page does without a connection is not waited for."""
        if self.page.evaluate("() => window.keypose.ui.connected"):
            answered(self.page)
        return self._sent

    def agreed(self, name: str) -> Any:
        """A section once the server has dealt with all that was done, and both have the same."""
        answered(self.page)
        until(lambda: section(self.page, name) == self._sent[name], name)
        return section(self.page, name)

    @property
    def _sent(self) -> dict[str, Any]:
        """The newest of every section, as the server sends it to others now."""
        self.visitor.do(do="end_stroke", stroke="-")  # whatever was sent before has come now
        return self.visitor.seen

    def fresh(self) -> None:
        """Everything as it was when the server began, the page with its usual tool and windows."""
        page, visitor = self.page, self.visitor
        page.mouse.up()
        page.keyboard.press("Escape")
        answered(page)
        while self._sent["undo"]["undo"] is not None:
            visitor.do(do="undo")
        visitor.do(do="go", frame=0)
        visitor.do(do="select", part=None)
        visitor.do(do="display", mode="both", opacity=0.5, ghosts=False, trail=False)
        for switch in ("limits", "link"):
            visitor.do(do=switch, on=True)
        visitor.do(do="axes", frame="part")
        page.keyboard.press("v")
        if page.evaluate("() => window.keypose.ui.layout") != "main":
            page.keyboard.press("1")
        page.evaluate(
            "() => ['main', 'top', 'side', 'front'].forEach((n) => window.keypose.view(n).fit())"
        )
        page.mouse.move(2, 2)
        answered(page)
        for name in ("pose", "view", "keys", "body", "masks", "undo"):
            until(lambda name=name: section(page, name) == self._sent[name], name)  # type: ignore[misc]
        settled(page)


@contextmanager
def desk(
    browser: Browser,
    folder: Path,
    *,
    drawn: bool = False,
    size: tuple[int, int] = SIZE,
    late: bool = True,
) -> Iterator[Desk]:
    """A page to work at, with everything that belongs to it."""
    with (
        served(folder) as (keypose, session),
        let_in(browser, drawn=drawn, size=size, late=late) as context,
    ):
        visitor = Visitor(keypose)
        yield Desk(opened(context, keypose), visitor, keypose, session)
        visitor.leave()
