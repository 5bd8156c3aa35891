"""Edits that cannot be written are told as unsaved, with the reason, until they are written."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Page

from keypose.tracker.storage.files import open_session
from tests.browser.interaction import section, settled, until


def test_the_page_says_why_an_edit_is_unsaved_until_it_is_written(page: Page, sample: Path) -> None:
    elsewhere = sample.parent.with_name("renamed")
    sample.parent.rename(elsewhere)
    page.keyboard.press("Delete")  # the keyframe one stands at
    reported = page.locator(".notsaved")
    reported.wait_for()
    assert "is gone or was renamed" in reported.inner_text()
    page.set_viewport_size({"width": 1440, "height": 900})
    settled(page)
    assert reported.locator(".cut").evaluate("(reason) => reason.clientWidth") > 300
    assert page.evaluate("() => window.keypose.server.done > window.keypose.server.ack")
    elsewhere.rename(sample.parent)
    reported.wait_for(state="detached")
    until(lambda: section(page, "saved.state") == "saved", "the save")
    until(
        lambda: page.evaluate("() => window.keypose.server.done === window.keypose.server.ack"),
        "the ack",
    )
    assert len(open_session(sample).recovered.moment.history.past) == 1
