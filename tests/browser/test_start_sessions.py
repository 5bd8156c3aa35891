"""Sessions on the start screen and in the top bar: renamed, duplicated, deleted, put back."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import APIResponse, Browser, Page, Route

from keypose.tracker.storage.files import load_session
from tests.app.serving import ROOT, Keypose
from tests.browser.interaction import section, settled, until
from tests.browser.shared import admit, opened

MARK_CHANGE = """async () => {
  const { listen } = await window.keypose.module('store/link.js');
  listen('library', () => { document.documentElement.dataset.changed = 'yes'; });
}"""
"""The page shows that the server has reported a change of the sessions."""

ASK_ANEW = """async () => {
  const { loadLibrary } = await window.keypose.module('store/library.js');
  void loadLibrary();
}"""
"""The page asks for the list of sessions, and the test goes on meanwhile."""


@pytest.fixture
def work(browser: Browser, tmp_path: Path) -> Iterator[tuple[Page, Path]]:
    """A page with a session open, and that session's file."""
    folder = tmp_path / "person"
    folder.mkdir()
    for name in ("person.mp4", "session.json"):
        shutil.copy(ROOT / "sample_videos" / "person" / name, folder)
    keypose = Keypose(str(folder / "session.json"), "--workspace", str(tmp_path / "workspace"))
    with admit(browser, drawn=False) as context:
        yield opened(context, keypose), folder / "session.json"
    code, words = keypose.end()
    assert code == 0, words
    assert "Traceback" not in words, words


def names(page: Page) -> list[str]:
    return page.locator(".recrow .b").all_inner_texts()


def close(page: Page) -> None:
    page.locator("#top .file").click()
    page.get_by_role("menuitem", name="Close").click()
    page.locator(".recrow").first.wait_for()


def test_on_the_start_screen_a_session_is_renamed_duplicated_deleted_and_put_back(
    work: tuple[Page, Path],
) -> None:
    page, session = work
    close(page)
    page.locator(".recrow .rec").click(button="right")
    page.get_by_role("menuitem", name="Rename").click()
    page.locator(".renamebox").fill("First try")
    page.keyboard.press("Enter")
    until(lambda: names(page) == ["First try"], "the name")
    assert load_session(session).title == "First try"

    page.locator(".recrow").hover()
    page.get_by_role("button", name="Menu of First try").click()
    page.get_by_role("menuitem", name="Duplicate").click()
    until(lambda: names(page) == ["First try copy", "First try"], "the copy")

    page.locator(".recrow .rec").last.focus()
    page.keyboard.press("Delete")
    until(lambda: names(page) == ["First try copy"], "one session fewer")
    assert not session.exists()
    assert session.with_name("person.mp4").exists()
    page.locator(".toast", has_text="First try moved to the trash").get_by_role(
        "button", name="Undo"
    ).click()
    until(lambda: names(page) == ["First try", "First try copy"], "the session again")
    assert load_session(session).title == "First try"


def test_a_name_given_while_the_list_is_on_its_way_is_shown(work: tuple[Page, Path]) -> None:
    page, session = work
    close(page)
    on_its_way: list[tuple[Route, APIResponse]] = []
    page.route("**/library*", lambda route: on_its_way.append((route, route.fetch())), times=1)
    page.evaluate(MARK_CHANGE)
    page.evaluate(ASK_ANEW)
    until(lambda: settled(page) or on_its_way, "the list with the old name")
    page.locator(".recrow .rec").focus()
    page.keyboard.press("F2")
    page.locator(".renamebox").fill("First try")
    page.keyboard.press("Enter")
    page.wait_for_selector("html[data-changed]", state="attached")
    assert load_session(session).title == "First try"
    [(route, old)] = on_its_way
    route.fulfill(response=old)
    until(lambda: names(page) == ["First try"], "the name")


def test_the_open_session_is_renamed_with_undo_and_deleted_with_undo(
    work: tuple[Page, Path],
) -> None:
    page, session = work
    page.locator("#top .file").click()
    page.get_by_role("menuitem", name="Rename").click()
    page.locator(".renamebox").fill("Walk")
    page.keyboard.press("Enter")
    until(lambda: section(page, "file.name") == "Walk", "the name")
    page.keyboard.press("Control+z")
    until(lambda: section(page, "file.name") == "person", "the name before")

    page.locator("#top .file").click()
    page.get_by_role("menuitem", name="Move to the trash").click()
    until(lambda: section(page, "file") is None and not session.exists(), "the start screen")
    page.get_by_role("button", name="Undo", exact=True).click()
    until(lambda: (section(page, "file") or {}).get("name") == "person", "the session again")
    assert session.exists()
