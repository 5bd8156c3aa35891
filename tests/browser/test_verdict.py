"""What a tracked segment is expected to be off by, as the Track tab and the head of the
large view say it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass, interpolate
from keypose.tracker.session import Session
from keypose.tracker.session.verdict import GOOD
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import Results, save_results, segment_keys
from keypose.tracker.tracking.result import Diagnostics, SegmentResult
from tests.browser.interaction import (
    drag,
    screens,
    section,
    settled,
    spot,
    until,
    until_counted,
    until_state,
)
from tests.browser.shared import desk

WORST = {
    "right_upper_arm": (10.4, 12),
    "left_foot": (6.84, 9),
    "right_forearm": (4.1, 15),
    "head": (0.3, 3),
    "chest": (1.6, 5),
}
"""Pixels by which a part is expected to be off at most, and the frame of 0–24 where."""


def tracked(session: Session) -> SegmentResult:
    """The segment 0–24 as if it had been tracked."""
    skeleton = Skeleton.of(session.subject.body)
    one, other = (keyframe.pose(skeleton) for keyframe in session.subject.keyframes[:2])
    path, key = interpolate(one, other, 0, 24), segment_keys(session)[0, 24]
    error = np.full((25, skeleton.part_count), np.nan)
    for name, (px, frame) in WORST.items():
        error[:, session.subject.body.index(name)] = 0.8 * px
        error[frame, session.subject.body.index(name)] = px
    unknown = Diagnostics.side_by_side((), 25, skeleton.part_count, skeleton.dof_count)
    found = SegmentResult.on_the_way(Pass("pass", path, 1.0), key)
    return replace(found, verdict=GOOD, diagnostics=replace(unknown, expected_error=error))


@pytest.fixture(scope="module")
def page(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    def begin(path: Path) -> None:
        session = load_session(path)
        both = session.settings.model_copy(update={"cues": ("brightness", "keypoints")})
        session = session.changed({"settings": both})
        found = tracked(session)
        save_session(save_results(session, path, Results({found.key: found})), path)

    folder = tmp_path_factory.mktemp("verdict")
    with desk(browser, folder, size=(1440, 900), begin=begin) as made:
        made.page.get_by_role("tab", name="Track").click()
        yield made.page


def rows(page: Page) -> Locator:
    return page.get_by_role("group", name="Expected error").get_by_role("button")


def test_the_worst_parts_are_reported_in_pixels_and_centimetres(page: Page) -> None:
    until_counted(page, "#insp .error", 5)
    reported = [text.split("\n") for text in rows(page).all_inner_texts()]
    names = ["Right upper arm", "Left foot", "Right forearm", "Chest", "Head"]
    assert [name for name, _ in reported] == names
    assert reported[0][1].startswith("≈ 10 px · ")
    assert reported[1][1].startswith("≈ 6.8 px · ")
    assert reported[1][1].endswith(" cm")
    assert reported[4][1] == "under 0.5 px"
    screens(page, "verdict-1-errors")


def test_a_row_selects_its_part_and_goes_to_its_worst_frame(page: Page) -> None:
    rows(page).nth(1).focus()
    page.keyboard.press("Enter")
    until_state(page, "view.selected", lambda part: part == "left_foot")
    until_state(page, "view.frame", lambda frame: frame == 9)
    rows(page).nth(2).click()
    until_state(page, "view.selected", lambda part: part == "right_forearm")
    until_state(page, "view.frame", lambda frame: frame == 15)
    assert "frame 15" in (rows(page).nth(2).get_attribute("title") or "")
    screens(page, "verdict-2-worst")


def test_a_segment_that_was_not_tracked_says_what_will_be_there(page: Page) -> None:
    page.keyboard.press("End")
    page.get_by_text("Expected error appears here after tracking.").wait_for()
    assert rows(page).count() == 0
    screens(page, "verdict-3-empty")


# --- in the head of the large view


def head(page: Page) -> str:
    """What it says, in one line."""
    return " ".join(page.locator("#mhead").inner_text().split())


def test_the_head_says_how_far_a_tracked_segment_is_expected_to_be_off(page: Page) -> None:
    page.keyboard.press("Home")
    worst = "0–24 Good, ≈ 10 px at the right upper arm → 12"
    until(lambda: head(page).endswith(f"Keyframe 0 {worst}"), "the part that is worst")
    chip = page.locator("#mhead .chip.good")
    words = "0–24: Good. Least sure: right upper arm hidden behind the chest. Go to 12"
    assert chip.get_attribute("title") == words
    chip.click()
    until_state(page, "view.frame", lambda frame: frame == 12)
    until(lambda: head(page).endswith(f"Frame 12 tracked {worst}"), "the frame gone to")
    page.mouse.move(2, 2)  # what is pointed at has its title in a tip
    screens(page, "verdict-4-head")


def test_the_head_says_what_a_frame_between_keyframes_holds(page: Page) -> None:
    page.keyboard.press("Home")
    page.keyboard.press("ArrowRight")
    until(lambda: "Frame 1 tracked 0–24" in head(page), "a tracked frame")
    page.keyboard.press("End")
    page.keyboard.press("ArrowLeft")
    until(lambda: head(page).endswith("Frame 71 between keyframes"), "a frame without results")
    until_counted(page, "#mhead .chip", 0)


def test_beyond_the_keyframes_the_head_says_how_to_go_on(page: Page) -> None:
    page.keyboard.press("End")
    until_state(page, "view.frame", lambda frame: frame == 72)
    page.keyboard.press("Delete")
    until(lambda: "Frame 72 same as keyframe 48" in head(page), "the nearest keyframe")
    until(lambda: head(page).endswith("No motion yet Track ahead"), "what to do")
    page.locator("#mhead .chip[title^='Frames 49–72 have no motion yet.']").wait_for()
    screens(page, "verdict-5-beyond")
    page.keyboard.press("Control+z")
    until_counted(page, "#mhead .chip", 0)


def test_the_head_says_that_a_segment_is_outdated_once_its_keyframe_moves(page: Page) -> None:
    page.keyboard.press("Home")
    until_state(page, "view.frame", lambda frame: frame == 0)
    x, y = spot(page, "waist")
    drag(page, (x, y), (x + 9, y), steps=4)
    page.locator("#mhead .chip.old", has_text="0–24").wait_for()
    page.keyboard.press("Control+z")
    page.locator("#mhead .chip.good", has_text="0–24").wait_for()


@pytest.mark.parametrize("size", [(1440, 900), (1280, 720), (1100, 700)])
def test_the_head_never_lies_under_the_bar_beside_it(page: Page, size: tuple[int, int]) -> None:
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.keyboard.press("Home")
    settled(page)
    page.locator("#mhead").evaluate("(head) => { head.style.width = '100%'; }")
    head, display = (page.locator(name).bounding_box() for name in ("#mhead", "#mdisp"))
    page.locator("#mhead").evaluate("(head) => { head.style.width = ''; }")
    page.set_viewport_size({"width": 1440, "height": 900})
    assert head is not None
    assert display is not None
    assert head["x"] + head["width"] <= display["x"]


def test_of_what_is_not_plausible_in_space_the_worst_three_are_shown_and_all_on_a_press(
    page: Page,
) -> None:
    found = [
        {
            "kind": "slides", "words": f"Left foot slides {cm} cm", "part": "left_foot",
            "first": 4, "last": 9, "go": 5, "remedy": "pin",
        }
        for cm in (9, 8, 7, 6, 5)
    ]  # fmt: skip
    before = section(page, "space")
    feed_space = """async (space) =>
        (await window.keypose.module('store/state.js')).applySections({ space })"""
    page.evaluate(feed_space, found)
    until_counted(page, "#insp .finding", 3)
    page.get_by_role("button", name="Show 2 more").click()
    until_counted(page, "#insp .finding", 5)
    screens(page, "verdict-4-in-space")
    page.get_by_role("button", name="Show fewer").click()
    until_counted(page, "#insp .finding", 3)
    page.evaluate(feed_space, before)
