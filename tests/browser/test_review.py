"""Review: from place to place where the motion is least sure, by the keyboard alone."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, Route

from keypose.tracker.storage.files import save_session
from keypose.tracker.storage.results import save_results
from tests.app.editor.test_review import doubting
from tests.browser.interaction import (
    answered,
    drag,
    screens,
    section,
    spot,
    until,
    until_counted,
    until_state,
)
from tests.browser.shared import Desk, desk

PLACES = {"right_forearm": (10, 14.0), "left_foot": (40, 9.0), "left_forearm": (60, 7.0)}


@pytest.fixture(scope="module")
def shared(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    state = doubting(**PLACES)

    def begin(path: Path) -> None:
        save_session(save_results(state.doc, path, state.results), path)

    folder = tmp_path_factory.mktemp("review")
    with desk(browser, folder, size=(1440, 900), begin=begin) as made:
        yield made


@pytest.fixture
def page(at: Desk) -> Page:
    return at.page


def rows(page: Page) -> list[str]:
    return [text.split("\n")[0] for text in page.locator(".rv-place .rv-name b").all_inner_texts()]


def current(page: Page) -> str | None:
    found = page.locator(".rv-place.on .rv-name b")
    return found.inner_text() if found.count() else None


def pressed(page: Page, key: str = "Enter") -> None:
    """Answer the place once its frame is seen."""
    until(lambda: page.evaluate(_IS_SEEN), "the frame of the place")
    page.keyboard.press(key)


_IS_SEEN = """() => {
  const { server, ui } = window.keypose;
  const row = ui.review?.rows.find(({ id }) => id === ui.review.current);
  return Boolean(row) && row.frame === server.view.frame && row.frame === ui.shown;
}"""


def window(page: Page) -> Any:
    return page.locator(".view#main canvas.vid").evaluate("(screen) => screen.style.transform")


def test_places_are_accepted_skipped_and_left_open_by_the_keyboard(page: Page) -> None:
    before = window(page)
    page.keyboard.press("Shift+R")
    until_counted(page, ".rv-place", 3)
    assert rows(page) == ["Right forearm", "Left foot", "Left forearm"]
    until_state(page, "view.frame", lambda frame: frame == 10)
    until_state(page, "view.selected", lambda part: part == "right_forearm")
    until_counted(page, "#main .doubt", 1)
    assert window(page) != before
    until_counted(page, "#tsvg .review-place", 3)
    until_counted(page, "frame-crop canvas", 3)
    assert page.locator("#status").inner_text().startswith("Enter")
    screens(page, "review-1-open")
    pressed(page)
    until_state(page, "review.answered.length", lambda many: many == 1)
    until_state(page, "view.frame", lambda frame: frame == 40)
    assert rows(page) == ["Right forearm", "Left foot", "Left forearm"], "rows stay"
    assert section(page, "undo.undo") == "accept right forearm"
    page.keyboard.press("n")
    until_state(page, "view.frame", lambda frame: frame == 60)
    assert rows(page) == ["Left foot", "Left forearm"]
    page.keyboard.press("Shift+N")
    until_state(page, "view.frame", lambda frame: frame == 40)
    pressed(page, "Shift+Enter")
    until_state(page, "review.answered.length", lambda many: many == 2)
    until(lambda: current(page) == "Left forearm")
    page.keyboard.press("Escape")
    until_counted(page, "section.review", 0)
    assert window(page) == before
    strip = page.locator("#tr .sug")
    until(lambda: "Review: 1 left" in strip.inner_text())
    screens(page, "review-2-left")
    strip.get_by_role("button", name="Continue").click()
    until(lambda: current(page) == "Left forearm")
    pressed(page)
    page.locator(".review .ended").get_by_text("Nothing left above 5 px").wait_for()
    screens(page, "review-3-ended")
    page.keyboard.press("Control+z")
    until(lambda: current(page) == "Left forearm")


def test_at_every_place_the_whole_body_is_in_sight(page: Page) -> None:
    page.keyboard.press("Shift+R")
    for part in ("Right forearm", "Left foot", "Left forearm"):
        until(lambda part=part: current(page) == part)  # type: ignore[misc]
        until(lambda: page.evaluate(_IS_SEEN), "the frame of the place")
        answered(page)
        view = page.locator("#main").bounding_box()
        assert view is not None
        for name in section(page, "pose.points"):
            x, y = spot(page, name)
            assert view["x"] < x < view["x"] + view["width"], name
            assert view["y"] + 50 < y < view["y"] + view["height"], name
        page.keyboard.press("n")
    page.keyboard.press("Escape")


def test_the_question_beside_the_timeline_is_not_cut(page: Page) -> None:
    page.keyboard.press("Shift+R")
    until(lambda: current(page) == "Right forearm")
    line = page.locator("#tr .sug .tx")
    until(lambda: "drag corrects" in line.inner_text())
    assert line.evaluate("(line) => line.scrollWidth <= line.clientWidth")


def test_enter_at_a_place_that_was_answered_already_leads_on(page: Page) -> None:
    page.keyboard.press("Shift+R")
    until(lambda: current(page) == "Right forearm")
    pressed(page)
    until(lambda: current(page) == "Left foot")
    page.locator(".rv-go").first.click()
    until(lambda: current(page) == "Right forearm")
    page.keyboard.press("Enter")
    until(lambda: current(page) == "Left foot")
    answered(page)
    assert len(section(page, "review.answered")) == 1
    pressed(page)
    until_state(page, "review.answered.length", lambda many: many == 2)


def test_enter_at_another_frame_leads_back_before_anything_is_accepted(page: Page) -> None:
    page.keyboard.press("Shift+R")
    until_state(page, "view.frame", lambda frame: frame == 10)
    page.keyboard.press("ArrowRight")
    until_state(page, "view.frame", lambda frame: frame == 11)
    until(lambda: "In review: frame 10" in page.locator("#tr .sug").inner_text(), "the place")
    screens(page, "review-elsewhere")
    page.keyboard.press("Enter")
    until_state(page, "view.frame", lambda frame: frame == 10)
    answered(page)
    assert section(page, "review.answered") == []
    pressed(page)
    until_state(page, "review.answered.length", lambda many: many == 1)


def test_what_is_not_seen_yet_is_not_accepted(page: Page) -> None:
    held: list[Route] = []
    page.route("**/frame/10.jpg*", lambda route: held.append(route))
    page.reload()  # with no pictures kept
    page.wait_for_selector("#main canvas.vid[data-frame]")
    page.keyboard.press("Shift+R")
    until_state(page, "view.frame", lambda frame: frame == 10)
    until(lambda: held, "the picture to be asked for")
    answer = page.locator(".rv-place.on .acts .btn.pri")
    until(lambda: answer.get_attribute("aria-disabled") == "true", "the answer to wait")
    for key in ("Enter", "Shift+Enter"):
        page.keyboard.press(key)
    answered(page)
    assert section(page, "review.answered") == []
    assert current(page) == "Right forearm"
    for route in held:
        route.continue_()
    pressed(page)
    until_state(page, "review.answered.length", lambda many: many == 1)
    page.unroute("**/frame/10.jpg*")


def test_its_end_says_how_many_were_accepted_and_how_many_left_open(page: Page) -> None:
    page.keyboard.press("Shift+R")
    until(lambda: current(page) == "Right forearm")
    for key, answers in (("Enter", 1), ("Shift+Enter", 2), ("Enter", 3)):
        pressed(page, key)
        until_state(
            page,
            "review.answered.length",
            lambda many, answers=answers: many == answers,  # type: ignore[misc]
        )
        until(lambda answers=answers: len(done(page)) == answers)  # type: ignore[misc]
    ended = page.locator(".review .ended")
    ended.get_by_text("3 reviewed: 2 accepted, 1 left open.").wait_for()
    page.get_by_text("3 done: 10, 40, 60").wait_for()
    page.locator(".review .past").get_by_role("button", name="Show").click()
    until_counted(page, ".rv-done li", 3)
    assert page.locator(".rv-done li").nth(1).inner_text() == "Left foot 40 left open"
    assert page.locator("#status").inner_text().startswith("Esc")
    screens(page, "review-6-counted")
    page.keyboard.press("Escape")
    until_counted(page, "section.review", 0)


def done(page: Page) -> Any:
    """What was answered, as the list has it."""
    return page.evaluate("() => window.keypose.ui.review.done")


def test_a_drag_keys_the_limb_alone_and_the_list_goes_on(page: Page) -> None:
    page.keyboard.press("Shift+R")
    until_state(page, "view.frame", lambda frame: frame == 10)
    until_counted(page, "#main .doubt", 1)
    drag_the_hand(page, 12, 8)
    keyed = until_state(page, "keys.parts", lambda parts: len(parts) == 1)
    assert keyed[0]["frame"] == 10
    assert "right_forearm" in keyed[0]["parts"]
    assert section(page, "keys.frames") == [0, 24, 48, 72]
    page.get_by_text("Corrected").wait_for()
    assert section(page, "undo.undo").startswith("move")
    screens(page, "review-4-corrected")
    page.keyboard.press("Control+z")
    until_state(page, "keys.parts", lambda parts: parts == [])
    until(lambda: current(page) == "Right forearm")


def test_a_limb_turned_in_depth_is_keyed_alone_as_by_a_drag(page: Page) -> None:
    page.keyboard.press("Shift+R")
    until_state(page, "view.frame", lambda frame: frame == 10)
    until_counted(page, "#main .doubt", 1)
    page.mouse.click(*spot(page, "left_hand"), button="right")
    page.locator("#tmenu .mi", has_text="Turn in depth").click()
    keyed = until_state(page, "keys.parts", lambda parts: len(parts) == 1)
    assert keyed[0]["frame"] == 10
    assert "left_hand" in keyed[0]["parts"]
    assert "right_hand" not in keyed[0]["parts"]
    assert section(page, "keys.drafts") == []
    assert section(page, "undo.undo").startswith("turn in depth")
    page.keyboard.press("Control+z")
    until_state(page, "keys.parts", lambda parts: parts == [])


HOLD_PAUSES = """() => {
  const { setTimeout: later, clearTimeout: never } = window;
  const held = new Map();
  window.setTimeout = (act, ms, ...more) =>
    ms === 400 ? (held.set(-1 - held.size, act), -held.size) : later(act, ms, ...more);
  window.clearTimeout = (id) => held.delete(id) || never(id);
  window.pausesPass = () => {
    const acts = [...held.values()];
    held.clear();
    acts.forEach((act) => act());
  };
  window.pausesRun = () => Object.assign(window, { setTimeout: later, clearTimeout: never });
}"""
"""From now on pauses of the review pass when the test says so."""


def drag_the_hand(page: Page, x: float, y: float) -> None:
    box = page.locator("#main [data-grip='grip:right_hand']").bounding_box()
    assert box is not None
    at = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    drag(page, at, (at[0] + x, at[1] + y), steps=4)


def test_a_second_drag_corrects_the_same_place_and_then_the_list_goes_on(page: Page) -> None:
    page.keyboard.press("Shift+R")
    until_counted(page, "#main .doubt", 1)
    page.evaluate(HOLD_PAUSES)
    drag_the_hand(page, 12, 8)
    until_state(page, "keys.parts", lambda parts: len(parts) == 1)
    answered(page)
    drag_the_hand(page, -6, 4)
    answered(page)
    assert current(page) == "Right forearm"

    def goes_on() -> bool:
        page.evaluate("() => window.pausesPass()")
        return current(page) == "Left foot"

    until(goes_on)
    page.evaluate("() => window.pausesRun()")
    assert [each["frame"] for each in section(page, "keys.parts")] == [10]
    for _ in range(2):
        page.keyboard.press("Control+z")
        answered(page)
    until_state(page, "keys.parts", lambda parts: parts == [])
    until(lambda: current(page) == "Right forearm")


def test_rows_do_not_move_under_the_pointer(page: Page) -> None:
    page.keyboard.press("Shift+R")
    until_counted(page, ".rv-place", 3)
    second = page.locator(".rv-place").nth(1)
    before = second.bounding_box()
    page.locator(".rv-place.on").get_by_role("button", name="Accept").click()
    until(lambda: current(page) == "Left foot")
    after = second.bounding_box()
    assert before is not None
    assert after is not None
    assert after["y"] == before["y"]


GO = """async (frame) =>
  (await window.keypose.module('store/link.js')).send({ do: 'go', frame })"""


def test_what_is_not_tracked_yet_may_bring_more(page: Page) -> None:
    page.evaluate(GO, 24)
    until_state(page, "view.frame", lambda frame: frame == 24)
    page.keyboard.press("Delete")
    until_state(page, "keys.frames", lambda keys: keys == [0, 48, 72])
    page.keyboard.press("Shift+R")
    until(lambda: current(page) == "Left forearm")
    pressed(page)
    page.get_by_text("Nothing left above 5 px so far").wait_for()
    page.keyboard.press("Escape")
    until_counted(page, "section.review", 0)


def test_before_tracking_it_says_what_to_do_first(page: Page) -> None:
    page.keyboard.press("Delete")
    until_state(page, "keys.frames", lambda keys: keys == [24, 48, 72])
    page.evaluate(GO, 48)
    until_state(page, "view.frame", lambda frame: frame == 48)
    page.keyboard.press("Delete")
    until_state(page, "keys.frames", lambda keys: keys == [24, 72])
    page.keyboard.press("Shift+R")
    page.get_by_text("Nothing to review. Track first.").wait_for()
    screens(page, "review-5-empty")
    page.keyboard.press("Escape")
    until_counted(page, "section.review", 0)
