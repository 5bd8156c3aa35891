"""A foot is pinned with a key, its bar trimmed, what is proposed accepted, all of it undone."""

from __future__ import annotations

from playwright.sync_api import Locator, Page

from tests.browser.interaction import (
    screen,
    section,
    settled,
    spot,
    until,
    until_counted,
    until_state,
)
from tests.browser.shared import Desk

SIZE = (1440, 900)


def _spans(page: Page) -> list[list[int]]:
    spans: list[list[int]] = page.evaluate(
        "() => window.keypose.server.pins.map(({ first, last }) => [first, last])"
    )
    return spans


def _until_spans(page: Page, *wanted: list[int]) -> None:
    until(lambda: _spans(page) == list(wanted), f"pins over {wanted}")


def _bar(page: Page) -> Locator:
    return page.locator("#tsvg .pin.L")


def _select(page: Page, point: str) -> None:
    page.mouse.click(*spot(page, point))
    until_state(page, "view.selected", lambda part: part == point)


def _pinned(page: Page) -> list[int]:
    """Pin the left foot from keyframe to keyframe."""
    _select(page, "left_foot")
    page.keyboard.press("Shift+P")
    first, last = section(page, "keys.frames[0]"), section(page, "keys.frames[1]")
    _until_spans(page, [first, last])
    _bar(page).wait_for()
    settled(page)
    return [first, last]


def test_a_foot_is_pinned_with_the_key_trimmed_unpinned_and_had_back(at: Desk) -> None:
    page = at.page
    first, last = _pinned(page)
    until_counted(page, "#main .pinmark", 2)  # heel and toe
    box = _bar(page).bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"], box["y"] + box["height"] / 2
    per_frame = box["width"] / (last - first)
    page.mouse.move(x - 2, y)
    page.mouse.down()
    page.mouse.move(x - 2 - 9 * per_frame, y, steps=5)
    _until_spans(page, [first, last - 9])
    settled(page)
    words = page.locator("#tsvg .plate text").text_content() or ""
    assert words.strip() == f"Left foot 0–{last - 9} was {last}"
    screen(page, "pins-trim")
    page.mouse.up()
    at.agreed("pins")
    page.keyboard.press("Control+z")
    _until_spans(page, [first, last])
    page.keyboard.press("Shift+P")
    _until_spans(page)
    page.keyboard.press("Control+z")
    _until_spans(page, [first, last])


def test_a_trim_is_put_back_with_esc_and_a_clicked_pin_goes_with_delete(at: Desk) -> None:
    page = at.page
    span = _pinned(page)
    box = _bar(page).bounding_box()
    assert box is not None
    x, y = box["x"] + 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 90, y, steps=4)
    until(lambda: _spans(page) != [span], "the trim")
    page.keyboard.press("Escape")
    page.mouse.up()
    _until_spans(page, span)
    keys = section(page, "keys.frames")
    page.mouse.click(box["x"] + box["width"] / 2, y)
    until_state(page, "view.frame", lambda frame: span[0] < frame < span[1])
    page.keyboard.press("Delete")
    _until_spans(page)
    assert at.agreed("keys")["frames"] == keys


def test_a_foot_is_put_on_the_floor_from_its_menu_which_asks_where_that_is(at: Desk) -> None:
    page = at.page
    page.mouse.click(*spot(page, "left_foot"), button="right")
    menu = page.locator("#tmenu [role=menu]")
    menu.get_by_role("menuitem", name="Pin to floor").click()
    asked = page.locator(".toast", has_text="Where is the floor?")
    asked.get_by_role("button", name="Use this foot’s height").click()
    until_state(page, "floor.height_m", lambda height: height is not None)
    assert section(page, "pins[0].floor") is True
    page.keyboard.press("ContextMenu")
    menu.get_by_text("Left foot · pinned").wait_for()
    page.keyboard.press("Escape")
    menu.wait_for(state="detached")


def test_with_no_hand_or_foot_selected_the_key_says_what_to_select(at: Desk) -> None:
    page = at.page
    page.keyboard.press("Shift+P")
    page.locator(".toast", has_text="Select a foot or a hand to pin it.").wait_for()
    assert at.agreed("pins") == []
