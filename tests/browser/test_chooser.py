"""The file chooser walks folders by mouse and keyboard, with small pictures."""

from __future__ import annotations

import shutil
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, BrowserContext, Page

from tests.app.serving import ROOT, Keypose
from tests.browser.interaction import section, until
from tests.browser.shared import admit

SAMPLES = ROOT / "sample_videos"


@pytest.fixture(scope="module")
def shared(
    browser: Browser, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[BrowserContext, Keypose]]:
    """A server that may look into one folder more, and a browser."""
    films = tmp_path_factory.mktemp("chooser") / "films"
    (films / "2026" / "May").mkdir(parents=True)
    shutil.copy(SAMPLES / "person" / "person.mp4", films / "2026" / "May")
    shutil.copytree(SAMPLES / "box", films / "2026" / "box")
    keypose = Keypose(
        str(films / "2026" / "box" / "session.json"), "--workspace", str(films / "workspace")
    )
    with admit(browser, drawn=False) as context:
        yield context, keypose
    code, words = keypose.end()
    assert code == 0, words


@pytest.fixture
def page(shared: tuple[BrowserContext, Keypose]) -> Iterator[Page]:
    """The start screen, in a browser that remembers nothing."""
    context, keypose = shared
    tab = context.new_page()
    tab.goto(keypose.address)
    tab.wait_for_selector("html[data-ready]", state="attached")
    send = "async (a) => (await window.keypose.module('store/link.js')).send(a)"
    tab.evaluate(send, {"do": "close"})
    until(lambda: section(tab, "file") is None, "the start screen")
    yield tab
    tab.evaluate("() => localStorage.clear()")
    tab.close()


def test_folders_are_walked_by_keyboard_and_a_video_shows_its_first_frame(page: Page) -> None:
    page.get_by_role("button", name="Choose a video").click()
    page.locator(".filerow.folder", has_text="box").click()
    until(lambda: page.locator(".crumb").all_inner_texts() == ["Folders", "box"], "the folder")
    row = page.locator(".filerow.video", has_text="box.mp4")
    row.locator("img").wait_for()
    address = row.locator("img").get_attribute("src")
    assert address is not None
    assert address.startswith("blob:")
    row.focus()
    page.keyboard.press("Backspace")
    until(lambda: page.locator(".crumb").count() == 1, "the folders there are")
    page.get_by_label("Find a file").fill("box.mp4")
    rows = page.locator(".filerow")
    until(lambda: {"box.mp4" in words for words in rows.all_inner_texts()} == {True}, "no others")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    until(lambda: section(page, "file") is not None, "the session of that video")


def test_a_session_is_told_from_videos_and_the_place_is_kept_for_the_next_time(page: Page) -> None:
    page.get_by_role("button", name="Open a session").click()
    page.locator(".filerow.folder", has_text="box").click()
    until(lambda: page.locator(".filerow.session").count() == 1, "the session")
    assert page.locator(".filerow.video").count() == 0
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Choose a video").click()
    until(lambda: page.locator(".crumb").all_inner_texts() == ["Folders", "box"], "the place")
