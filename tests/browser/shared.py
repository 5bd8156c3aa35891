"""A server and its page for all tests of a module, each of which begins where the first did."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from playwright.sync_api import Browser, BrowserContext, Page

from tests.app.serving import ROOT, Keypose, Visitor
from tests.browser.interaction import PICTURES, answered, section, settled, until
from tests.browser.late import new_context

SIZE = (1280, 720)

_WITHOUT_PICTURES = """
(() => {
  const usual = Object.getOwnPropertyDescriptor(HTMLIFrameElement.prototype, 'src');
  Object.defineProperty(HTMLIFrameElement.prototype, 'src', {
    ...usual,
    set(address) {
      usual.set.call(this, String(address).startsWith('/view/') ? 'about:blank' : address);
    },
  });
})()
"""
"""Viser's pages are not asked for. In the page itself: were its requests intercepted, each of the
hundreds of a page would pass through the test, and none would be kept by the browser."""

_BY_VISER = """
try {
  localStorage.setItem('keypose.painted', localStorage.getItem('keypose.painted') ?? 'no');
} catch {} // a document without an origin keeps nothing
"""
"""viser draws the camera view too, which the page paints by itself where 3D is software."""


def copied(folder: Path) -> Path:
    """The session file of a copy of the person sample, its video beside it."""
    folder.mkdir(parents=True)
    for name in ("person.mp4", "session.json"):
        shutil.copy(ROOT / "sample_videos" / "person" / name, folder)
    return folder / "session.json"


@contextmanager
def served(
    folder: Path, begin: Callable[[Path], None] = lambda session: None
) -> Iterator[tuple[Keypose, Path]]:
    """A server of the person sample, and the session's file. It must end without a stumble."""
    session = copied(folder / "person")
    begin(session)
    keypose = Keypose(str(session), "--workspace", str(folder / "workspace"))
    try:
        yield keypose, session
    finally:
        code, words = keypose.end()
    assert code == 0, words
    assert "Traceback" not in words, words


@contextmanager
def admit(
    browser: Browser,
    *,
    drawn: bool,
    painted: bool = False,
    size: tuple[int, int] = SIZE,
    **more: Any,
) -> Iterator[BrowserContext]:
    """A browser of its own, in which no script may fail. Its pages do without viser's pictures,
    which software draws slowly, unless a test or a person is to see them.

    painted: the page paints the camera view all the same, as it does in such a browser.
    """
    viewport = {"width": size[0], "height": size[1]}
    context, complaints = new_watched_context(browser, drawn=drawn, viewport=viewport, **more)
    if drawn and not painted:
        context.add_init_script(_BY_VISER)
    yield context
    context.close()
    assert not complaints, complaints


def new_watched_context(
    browser: Browser, *, drawn: bool, **more: Any
) -> tuple[BrowserContext, list[str]]:
    """A browser of its own, and the list of what its scripts fail with."""
    context = new_context(browser, **more)
    complaints: list[str] = []
    context.on("weberror", lambda error: complaints.append(str(error.error)))
    if not (drawn or PICTURES):
        context.add_init_script(_WITHOUT_PICTURES)
    return context, complaints


def opened(context: BrowserContext, keypose: Keypose) -> Page:
    """One more tab with the page, ready for use."""
    return opened_in(context.new_page(), keypose)


def opened_in(page: Page, keypose: Keypose) -> Page:
    """The page in an empty tab, ready for use."""
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


@dataclass
class Office:
    """One server for the desks of many modules, one after the other, and a browser that keeps the
    page's files: to start both anew costs more than most modules' tests."""

    folder: Path
    keypose: Keypose
    browser: Browser
    contexts: dict[bool, tuple[BrowserContext, list[str]]] = field(default_factory=dict)

    @classmethod
    def opened(cls, browser: Browser, folder: Path) -> Self:
        """With a session, whose folder is the one that the others can be opened in."""
        session = copied(folder)
        keypose = Keypose(str(session), "--workspace", str(folder / "workspace"))
        return cls(folder, keypose, browser)

    @contextmanager
    def desk(
        self, source: Path, *, size: tuple[int, int] = SIZE, late: bool = True
    ) -> Iterator[Desk]:
        """A page of a session or film in the folder; there is one desk at a time."""
        self.keypose.enter_again()  # tests before this one may have let in many browsers
        visitor = Visitor(self.keypose)
        before = visitor.seen["file"]
        # The folder that Keypose runs in is 0, that of the session it was begun with 1.
        visitor.do(do="open", kind="file", id=f"1/{source.relative_to(self.folder)}")
        visitor.until(lambda: visitor.seen["file"] not in (None, before))
        session = Path(visitor.seen["file"]["path"])
        context, complaints = self._context(late)
        page = context.new_page()
        page.set_viewport_size({"width": size[0], "height": size[1]})
        yield Desk(opened_in(page, self.keypose), visitor, self.keypose, session)
        page.evaluate("() => localStorage.clear()")
        for each in context.pages:
            each.close()
        visitor.leave()
        assert not complaints, complaints

    def close(self) -> None:
        """It must end without a stumble."""
        for context, _ in self.contexts.values():
            context.close()
        code, words = self.keypose.end()
        assert code == 0, words
        assert "Traceback" not in words, words

    def _context(self, late: bool) -> tuple[BrowserContext, list[str]]:
        if late not in self.contexts:
            self.contexts[late] = new_watched_context(self.browser, drawn=False, late=late)
        return self.contexts[late]


_offices: dict[Browser, Office] = {}


def office(browser: Browser, folder: Path) -> Office:
    """That of this browser, which begins in a folder beside this one."""
    if browser not in _offices:
        _offices[browser] = Office.opened(browser, folder.parent / "office")
    return _offices[browser]


def close_office(browser: Browser) -> None:
    """Its end, where it has begun."""
    if browser in _offices:
        _offices.pop(browser).close()


@contextmanager
def desk(
    browser: Browser,
    folder: Path,
    *,
    drawn: bool = False,
    size: tuple[int, int] = SIZE,
    late: bool = True,
    own: bool = False,
    begin: Callable[[Path], None] = lambda session: None,
) -> Iterator[Desk]:
    """A page to work at, with everything that belongs to it.

    own: with a server that nobody else has, for what is done to the server itself, or beside
    another desk.  begin: changes the session's file before it is opened.
    """
    if not (own or drawn):
        place = office(browser, folder)
        source = copied(place.folder / folder.name / "person")
        begin(source)
        with place.desk(source, size=size, late=late) as made:
            yield made
        return
    with (
        served(folder, begin) as (keypose, session),
        admit(browser, drawn=drawn, size=size, late=late) as context,
    ):
        visitor = Visitor(keypose)
        yield Desk(opened(context, keypose), visitor, keypose, session)
        visitor.leave()
