"""The page's address leads to the session: Back, Forward, reload, a bookmark, another Keypose."""

from __future__ import annotations

import re
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page

from tests.app.serving import ROOT, Keypose
from tests.browser.interaction import section, until
from tests.browser.marks import mark, marks, waiting
from tests.browser.shared import admit, opened


@pytest.fixture
def workspace(tmp_path: Path) -> tuple[str, str]:
    return _workspace(tmp_path)


def _workspace(folder: Path) -> tuple[str, str]:
    """Two sessions in a folder, and what Keypose is given for a workspace beside them."""
    for name in ("person", "box"):
        (folder / name).mkdir()
        for file in (f"{name}.mp4", "session.json"):
            shutil.copy(ROOT / "sample_videos" / name / file, folder / name)
    return "--workspace", str(folder / "workspace")


@pytest.fixture(scope="module")
def shared(
    browser: Browser, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[BrowserContext, Keypose]]:
    """A Keypose that has opened one session, and a browser that it has let in."""
    folder = tmp_path_factory.mktemp("address")
    workspace = _workspace(folder)
    keypose = Keypose(str(folder / "box" / "session.json"), *workspace)
    with admit(browser, drawn=False) as context:
        page = opened(context, keypose)
        until(lambda: _asked(page) is not None, "the first session's address")
        page.close()
        yield context, keypose
    code, words = keypose.end()
    assert code == 0, words
    assert "Traceback" not in words, words


@pytest.fixture
def visit(shared: tuple[BrowserContext, Keypose]) -> Iterator[tuple[Page, Keypose]]:
    """A tab at the start screen, after a session was open."""
    context, keypose = shared
    page = context.new_page()
    page.goto(keypose.origin)
    page.wait_for_selector("html[data-ready]", state="attached")
    _send(page, {"do": "close"})
    until(lambda: section(page, "file") is None and _asked(page) is None, "the start screen")
    yield page, keypose
    page.close()


def _asked(page: Page) -> str | None:
    found = re.search(r"\?session=([0-9a-f]{16})$", _address(page))
    return found[1] if found else None


def _address(page: Page) -> str:
    return str(page.evaluate("() => location.href"))


def _send(page: Page, action: dict[str, str]) -> None:
    page.evaluate(
        "async (action) => (await window.keypose.module('store/link.js')).send(action)", action
    )


def _name(page: Page) -> str | None:
    file = section(page, "file")
    return None if file is None else str(file["name"])


def test_back_forward_reload_and_a_bookmark_lead_to_the_session(
    visit: tuple[Page, Keypose],
) -> None:
    page, _ = visit
    assert _asked(page) is None
    page.locator(".rec", has_text="box").click()
    until(lambda: _name(page) == "box" and _asked(page) is not None, "the session")
    address = _address(page)
    page.go_back()
    until(lambda: _name(page) is None and _asked(page) is None, "the start screen")
    page.go_forward()
    until(lambda: _name(page) == "box" and _address(page) == address, "the session again")
    page.reload()
    page.wait_for_selector("html[data-ready]", state="attached")
    assert _name(page) == "box"
    assert _address(page) == address
    _send(page, {"do": "close"})
    until(lambda: _asked(page) is None, "the start screen")
    page.goto(address)
    until(lambda: _name(page) == "box", "what the bookmark leads to")
    assert "token" not in _address(page)


def test_a_view_that_is_drawn_just_as_its_session_is_closed_draws_nothing(
    visit: tuple[Page, Keypose],
) -> None:
    page, _ = visit
    page.locator(".rec", has_text="box").click()
    page.wait_for_selector("#main canvas.vid[data-frame]")
    page.evaluate(
        """() => {
          window.keypose.server.camera = null; // the eyes of the views follow a moment later
          for (const name of ['main', 'top', 'side', 'front']) window.keypose.view(name).draw();
        }"""
    )
    assert page.locator("#main rect.edge").count() == 0


def test_an_address_that_leads_nowhere_is_reported_and_corrected(
    visit: tuple[Page, Keypose],
) -> None:
    page, keypose = visit
    page.goto(f"{keypose.origin}/?session={'0' * 16}")
    page.get_by_text("This session no longer exists.").wait_for()
    until(lambda: _asked(page) is None, "the address of the start screen")


def test_a_tab_returns_to_its_session_at_another_keypose_of_the_workspace_with_its_edits(
    browser: Browser, tmp_path: Path, workspace: tuple[str, str]
) -> None:
    session = tmp_path / "person" / "session.json"
    keypose = Keypose(str(session), *workspace)
    with admit(browser, drawn=False) as context:
        page = opened(context, keypose)
        until(lambda: _asked(page) is not None, "the address")
        mark(page, *range(25))
        keypose.kill()
        mark(page, *range(25, 50))
        again = Keypose(*workspace, port=keypose.port)  # nothing is named: the tab knows
        until(lambda: _name(page) == "person" and waiting(page) == 0, "the return")
        assert page.locator("#banner").inner_text() == ""
        assert marks(session) == list(range(50))
    code, words = again.end()
    assert code == 0, words


def test_a_silent_server_is_reported_and_what_was_done_meanwhile_arrives_once(
    browser: Browser, tmp_path: Path, workspace: tuple[str, str]
) -> None:
    session = tmp_path / "person" / "session.json"
    keypose = Keypose(str(session), *workspace)
    with admit(browser, drawn=False) as context:
        page = opened(context, keypose)
        banner = page.locator("#banner")
        keypose.process.send_signal(signal.SIGSTOP)
        mark(page, 1, 2)
        banner.get_by_text("2 edits will be sent when it is back.").wait_for()
        keypose.process.send_signal(signal.SIGCONT)
        until(lambda: waiting(page) == 0, "the edits")
        until(lambda: banner.inner_text() == "", "the end of it")
        assert marks(session) == [1, 2]
    code, words = keypose.end()
    assert code == 0, words
