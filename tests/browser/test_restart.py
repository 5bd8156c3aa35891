"""Keypose is killed and started again under an open tab: no edit is lost, none is made twice."""

from __future__ import annotations

import random
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page

from keypose.tracker.storage.files import load_session
from tests.app.serving import ROOT, Keypose, Visitor
from tests.browser.interaction import section, until
from tests.browser.marks import mark, marks, waiting
from tests.browser.proxy import Proxy, proxy
from tests.browser.shared import admit, opened

EDITS = 50


@dataclass
class Work:
    """A server that can be killed and started again, and the page of one browser."""

    folder: Path
    proxy: Proxy
    keypose: Keypose
    context: BrowserContext
    page: Page

    @property
    def session(self) -> Path:
        return self.folder / "person" / "session.json"

    def start(self, *arguments: str) -> None:
        """Start it again, with the session open unless something else is said."""
        given = arguments or (str(self.session),)
        self.keypose = Keypose(*given, *_workspace(self.folder), port=self.keypose.port)

    def mark(self, *numbers: int) -> None:
        mark(self.page, *numbers)

    def marks(self) -> list[int]:
        """Those that are on the disk, in their order."""
        return marks(self.session)

    def sent(self) -> None:
        """Wait until the server has everything."""
        until(lambda: waiting(self.page) == 0, "the last edit")

    def banner(self) -> str:
        return self.page.locator("#banner").inner_text()


def _workspace(folder: Path) -> tuple[str, str]:
    return "--workspace", str(folder / "workspace")


@pytest.fixture
def work(browser: Browser, tmp_path: Path) -> Iterator[Work]:
    with working(browser, tmp_path) as made:
        yield made


@pytest.fixture(scope="module")
def lasting(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Work]:
    """One that several tests add their edits to."""
    with working(browser, tmp_path_factory.mktemp("lasting")) as made:
        yield made


@contextmanager
def working(browser: Browser, tmp_path: Path) -> Iterator[Work]:
    shutil.copytree(
        ROOT / "sample_videos" / "person",
        tmp_path / "person",
        ignore=lambda _, names: [n for n in names if n not in ("person.mp4", "session.json")],
    )
    keypose = Keypose(str(tmp_path / "person" / "session.json"), *_workspace(tmp_path))
    with (
        proxy() as relay,
        admit(browser, drawn=False, proxy={"server": relay.address}) as context,
    ):
        at = Work(tmp_path, relay, keypose, context, opened(context, keypose))
        yield at
        code, words = at.keypose.end()
    assert code == 0, words
    assert "Traceback" not in words, words


@pytest.mark.parametrize("seed", range(2))
def test_of_50_edits_made_while_it_is_killed_and_started_again_each_is_there_once(
    lasting: Work, seed: int
) -> None:
    work, chance = lasting, random.Random(seed)
    before = work.marks()
    stops = sorted(chance.sample(range(1, EDITS), 4))
    at = 0
    for stop in (*stops, EDITS):
        while at < stop:
            many = min(chance.randint(1, 6), stop - at)
            work.mark(*range(at, at + many))
            at += many
            work.page.wait_for_timeout(chance.choice((0, 0, 5, 20, 60)))
        if stop < EDITS:
            work.keypose.kill()
            if chance.random() < 0.5:  # some edits are made while nobody answers
                work.mark(at)
                at += 1
            work.start()
    work.sent()
    assert work.marks() == [*before, *range(EDITS)]


def test_a_tab_that_is_opened_again_after_the_restart_still_has_its_edits(lasting: Work) -> None:
    work, before = lasting, lasting.marks()
    work.keypose.kill()
    until(lambda: not work.page.evaluate("() => window.keypose.ui.connected"), "the loss")
    work.mark(1, 2, 3)
    work.start()
    work.page.goto(work.keypose.origin)
    work.page.wait_for_selector("html[data-ready]", state="attached")
    work.sent()
    assert work.marks() == [*before, 1, 2, 3]


def test_an_edit_goes_to_the_frame_at_which_it_was_made(lasting: Work) -> None:
    work = lasting
    send = "async (action) => (await window.keypose.module('store/link.js')).send(action)"
    work.page.evaluate(send, {"do": "go", "frame": 48})
    until(lambda: section(work.page, "view.frame") == 48, "the frame")
    work.sent()
    work.keypose.kill()
    work.page.evaluate(send, {"do": "root", "z": 7.5})
    work.start()
    work.sent()
    depths = {k.frame: k.root_m[2] for k in load_session(work.session).subject.keyframes}
    assert depths[48] == pytest.approx(7.5)
    assert depths[0] != pytest.approx(7.5)


@pytest.fixture
def apart(work: Work) -> Work:
    """Edits of the tab wait, and the session has been changed by another since."""
    work.proxy.cut()
    until(lambda: not work.page.evaluate("() => window.keypose.ui.connected"), "the loss")
    work.mark(1, 2, 3)
    work.keypose.kill()
    work.start()
    other = Visitor(work.keypose)
    other.do(do="add_mask", polygon=[[9, 0], [10, 0], [9, 1]], first=0, last=1)
    other.leave()
    work.proxy.mend()
    until(lambda: "3 edits were not sent" in work.banner(), "the question")
    return work


def test_where_the_session_was_changed_meanwhile_the_person_is_asked(apart: Work) -> None:
    assert "This session has been changed since." in apart.banner()
    assert apart.marks() == [9]
    apart.mark(4)  # work goes on, whatever is answered later
    until(lambda: apart.marks() == [9, 4], "the edit")
    apart.page.get_by_role("button", name="Apply").click()
    apart.sent()
    assert apart.marks() == [9, 4, 1, 2, 3]
    assert apart.banner() == ""


def test_a_person_may_do_without_the_edits(apart: Work) -> None:
    apart.page.get_by_role("button", name="Discard").click()
    apart.sent()
    apart.page.reload()
    apart.page.wait_for_selector("html[data-ready]", state="attached")
    apart.mark(4)
    apart.sent()
    assert apart.marks() == [9, 4]


def test_where_another_session_is_open_the_edits_wait_for_their_own(work: Work) -> None:
    work.mark(0)
    until((work.folder / "workspace" / "recents.json").exists, "the session among the recent ones")
    work.keypose.kill()
    work.mark(1, 2)
    work.start("sample_videos/box/session.json", "--out", str(work.folder / "box"))
    until(lambda: "Open person to apply them." in work.banner(), "the question")
    work.page.get_by_role("button", name="Open person").click()
    work.sent()
    assert work.marks() == [0, 1, 2]
    assert not load_session(work.folder / "box" / "session.json").view.ignore_masks


def test_a_page_says_that_the_connection_is_lost_and_comes_back_by_itself(lasting: Work) -> None:
    work = lasting
    work.keypose.kill()
    until(lambda: "Connection lost. Edits will be sent when it is back." in work.banner(), "that")
    work.mark(1)
    until(lambda: "1 edit will be sent when it is back." in work.banner(), "the count")
    work.start()
    work.sent()
    until(lambda: work.banner() == "", "the end of it")


def test_a_server_that_does_not_know_the_browser_needs_the_new_link(work: Work) -> None:
    work.keypose.kill()
    work.mark(1)
    (work.folder / "workspace" / "browsers.json").unlink()
    work.start()
    words = "Open the newest link in the terminal. 1 edit will then be sent from this tab."
    until(lambda: f"Keypose does not know this browser any more. {words}" in work.banner(), "that")
    work.page.evaluate("() => localStorage.clear()")
    until(lambda: f"This browser’s data for Keypose was cleared. {words}" in work.banner(), "that")
    opened(work.context, work.keypose)
    work.sent()
    assert work.marks() == [1]
