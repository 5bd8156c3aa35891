"""A drafted motion is reduced to keyframes on the timeline: shown first, applied as one step."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from tests.browser.dense import change_session, true_poses
from tests.browser.interaction import answered, screen, section, until, until_counted, until_state
from tests.browser.shared import desk


@pytest.fixture
def page(browser: Browser, tmp_path: Path) -> Iterator[Page]:
    """The page of the sample with drafts between its first and last frame, which are keyframes."""

    def begin(path: Path) -> None:
        first, *between, last = true_poses()
        drafts = tuple(draft.model_copy(update={"drafted": True}) for draft in between)
        change_session(path, keyframes=(first, last), drafts=drafts)

    with desk(browser, tmp_path, size=(1440, 900), begin=begin) as made:
        yield made.page


def is_found(reported: Any) -> bool:
    """Whether the keyframes are those of what was asked for last."""
    return reported is not None and not reported["busy"]


def ghosts(page: Page) -> int:
    """Diamonds of the reduction on the timeline."""
    return (page.locator("#tsvg path.reduced").get_attribute("d") or "").count("M")


def shown_goal(page: Page) -> float:
    """How many frames a keyframe stands for, as the slider shows it."""
    return float(page.locator(".reducecard .rng").get_attribute("aria-valuenow") or 0)


def begun(page: Page) -> None:
    """Ask for a reduction, and wait until its keyframes are shown."""
    page.keyboard.press("Control+k")
    page.locator("#search[open] input").fill("unbake")
    until_counted(page, "#search [role=option]", 1)
    page.keyboard.press("Enter")
    until_state(page, "reduction", is_found)
    until_counted(page, ".reducecard", 1)


def test_drafts_are_reduced_with_a_preview_and_one_step_of_undo(page: Page) -> None:
    drafted, revision = len(section(page, "keys.drafts")), section(page, "revision")
    begun(page)
    page.keyboard.press("Escape")
    until_counted(page, ".reducecard", 0)
    until_state(page, "reduction", lambda reported: reported is None)
    assert section(page, "revision") == revision
    begun(page)
    fine = section(page, "reduction.frames")
    until(lambda: ghosts(page) == len(fine) - 2)
    screen(page, "reduce")

    page.locator(".reducecard .rng").focus()
    for _ in range(8):
        page.keyboard.press("ArrowRight")
    answered(page)
    until_state(
        page,
        "reduction",
        lambda reported: reported["goal"] == shown_goal(page) and is_found(reported),
    )
    assert shown_goal(page) > 22
    coarse = section(page, "reduction.frames")
    assert 2 <= len(coarse) < len(fine)
    until(lambda: ghosts(page) == len(coarse) - 2)
    assert len(section(page, "keys.drafts")) == drafted
    assert len(section(page, "keys.frames")) == 2

    page.get_by_role("button", name="Reduce", exact=False).last.click()
    until_state(page, "keys.frames", lambda frames: frames == coarse)
    until_counted(page, ".reducecard", 0)
    until_state(page, "keys.drafts", lambda drafts: drafts == [])
    page.keyboard.press("Control+z")
    until_state(page, "keys.drafts", lambda drafts: len(drafts) == drafted)
    assert len(section(page, "keys.frames")) == 2
