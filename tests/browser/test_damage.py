"""Frames that are damaged in the file are hatched, and the page says so in a sentence."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from playwright.sync_api import Page

from tests.app.serving import Keypose, Visitor
from tests.browser.interaction import screen, until, until_state
from tests.tracker.video_cases import flip_bit

DAMAGED = "Frames 31–47 are damaged in the file and are not used for tracking."


@pytest.fixture
def sample(sample: Path) -> Path:
    """The sample with one bit of its video flipped: what follows is built on it."""
    video = sample.with_name("person.mp4")
    flip_bit(video, packet=32, byte=900)
    session = json.loads(sample.read_text())
    session["views"][0]["video"]["fingerprint"] = ""
    sample.write_text(json.dumps(session))
    return sample


def test_damaged_frames_are_hatched_and_said_to_be_damaged(page: Page, keypose: Keypose) -> None:
    until_state(page, "damage", lambda runs: runs == [[31, 47]])
    hatched = page.locator("#tsvg .damaged")
    until(lambda: hatched.count() == 1, "hatched")
    assert hatched.locator("title").text_content() == DAMAGED
    assert page.locator("#mdamaged").count() == 0
    visitor = Visitor(keypose)
    visitor.do(do="go", frame=40)
    visitor.leave()
    page.wait_for_selector("#mdamaged")
    assert page.locator("#mdamaged").inner_text() == DAMAGED
    page.wait_for_selector("#main canvas.vid[data-frame='40']")
    for theme in ("dark", "light"):
        page.evaluate("(theme) => { document.documentElement.dataset.theme = theme }", theme)
        assert hatched.is_visible()
        assert page.locator("#mdamaged").is_visible()
        screen(page, f"damaged_{theme}")
