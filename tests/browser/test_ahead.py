"""Tracking ahead from a single keyframe: begun, watched, stopped and kept by a person."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page

from tests.browser.interaction import screens, section, until
from tests.browser.shared import Desk

SIZE = (1440, 900)


@pytest.fixture
def page(shared: Desk) -> Page:
    """One keyframe alone, at 24."""
    shared.fresh()
    for frame in (0, 48, 72):
        shared.visitor.do(do="delete_key", frame=frame)
    shared.visitor.do(do="go", frame=24)
    shared.agreed("keys")
    return shared.page


def test_one_keyframe_is_followed_and_k_keeps_where_it_led(shared: Desk, page: Page) -> None:
    strip = page.locator(".sug")
    screens(page, "ahead-1-offered")
    strip.get_by_role("button", name="Track ahead").click()
    until(lambda: section(page, "job")["kind"] == "ahead", "the job")
    screens(page, "ahead-2-running")
    until(lambda: section(page, "job")["state"] != "running", "its end")
    until(lambda: section(page, "keys")["drafts"], "drafts")
    screens(page, "ahead-3-followed")
    to = section(page, "suggest")["frame"]
    page.keyboard.press("n")
    until(lambda: section(page, "view")["frame"] == to, "the frame to key")
    page.locator(".say", has_text="Tracked ahead, press K to keep").wait_for()
    screens(page, "ahead-4-there")
    page.keyboard.press("k")
    until(lambda: section(page, "keys")["frames"] == [24, to], "two keyframes")
    screens(page, "ahead-5-kept")
    page.keyboard.press("Control+z")
    until(lambda: section(page, "keys")["drafts"], "the drafts again")
    page.keyboard.press("Control+z")
    until(lambda: not section(page, "keys")["drafts"], "none")
