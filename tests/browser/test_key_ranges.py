"""Several keyframes at a time: chosen with a box, moved, stretched, copied and deleted."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page

from tests.browser.interaction import Spot, drag, screen, section, settled, until, until_state
from tests.browser.shared import Desk

SIZE = (1440, 900)
KEYS = [0, 24, 48, 72]


@pytest.fixture
def at(shared: Desk) -> Desk:
    """The page as if it had just been opened, with nothing selected."""
    shared.fresh()
    shared.page.keyboard.press("Escape")
    until(lambda: _chosen(shared.page) == [], "nothing selected")
    return shared


def _spot(page: Page, frame: float, dy: float = 17) -> Spot:
    """A frame in the row of keyframes."""
    last = section(page, "file.frames") - 1
    box = page.locator("#tsvg").bounding_box()
    assert box is not None
    left, right = box["x"] + 138, box["x"] + box["width"] - 26
    return left + frame * (right - left) / last, box["y"] + 22 + dy


def _chosen(page: Page) -> list[int]:
    return list(page.evaluate("() => window.keypose.ui.timeKeys"))


def _box(page: Page, first: float, last: float) -> None:
    drag(page, _spot(page, first, 5), _spot(page, last, 5))
    settled(page)


def test_a_box_selects_and_esc_selects_none_while_the_playhead_stays(at: Desk) -> None:
    page = at.page
    _box(page, 12, 60)
    assert _chosen(page) == [24, 48]
    assert at.agreed("view")["frame"] == 0
    page.keyboard.press("Control+a")
    assert _chosen(page) == KEYS
    page.keyboard.press("Escape")
    assert _chosen(page) == []


def test_the_ruler_scrubs_as_ever(at: Desk) -> None:
    page = at.page
    drag(page, _spot(page, 10, -12), _spot(page, 40, -12))
    until_state(page, "view.frame", lambda frame: frame == 40)
    assert _chosen(page) == []


def test_shift_selects_a_range_and_ctrl_one_more_or_less(at: Desk) -> None:
    page = at.page
    page.mouse.click(*_spot(page, 24))
    until_state(page, "view.frame", lambda frame: frame == 24)
    page.keyboard.down("Shift")
    page.mouse.click(*_spot(page, 72))
    page.keyboard.up("Shift")
    assert _chosen(page) == [24, 48, 72]
    page.keyboard.down("Control")
    page.mouse.click(*_spot(page, 48))
    page.mouse.click(*_spot(page, 0))
    page.keyboard.up("Control")
    assert _chosen(page) == [0, 24, 72]
    assert at.agreed("view")["frame"] == 24


def test_one_that_is_dragged_takes_all_selected_along_as_one_step(at: Desk) -> None:
    page = at.page
    _box(page, 12, 60)
    drag(page, _spot(page, 24), _spot(page, 30), drop=False)
    screen(page, "timeline-several-moved")
    page.mouse.up()
    until_state(page, "keys.frames", lambda now: now == [0, 30, 54, 72])
    until(lambda: _chosen(page) == [30, 54], "the same keyframes selected")
    assert at.agreed("undo")["undo"] == "move 2 keyframes"
    page.keyboard.press("Control+z")
    until_state(page, "keys.frames", lambda now: now == KEYS)
    until(lambda: _chosen(page) == [24, 48], "what was selected before")


def test_keyframes_are_selected_without_a_mouse(at: Desk) -> None:
    page = at.page
    for key in ("Shift+S", ".", "Shift+S", "."):
        page.keyboard.press(key)
    until_state(page, "view.frame", lambda frame: frame == 48)
    assert _chosen(page) == [0, 24]
    page.keyboard.press("Shift+S")
    assert _chosen(page) == [0, 24, 48]
    page.keyboard.press("Delete")
    until_state(page, "keys.frames", lambda now: now == [72])


def test_others_in_the_way_are_reported_and_nothing_moves(at: Desk) -> None:
    page = at.page
    _box(page, 12, 60)
    drag(page, _spot(page, 24), _spot(page, 48), drop=False)
    until(lambda: page.evaluate("() => window.keypose.ui.timeGrabbed?.taken"), "the reason")
    page.locator("#tsvg .plate", has_text="Frame 72 is already a keyframe").wait_for()
    page.mouse.up()
    until(lambda: page.evaluate("() => window.keypose.ui.timeGrabbed === null"), "the end of it")
    assert at.agreed("keys")["frames"] == KEYS


def test_the_end_of_a_selection_stretches_it(at: Desk) -> None:
    page = at.page
    _box(page, -2, 60)
    x, y = _spot(page, 48)
    drag(page, (x + 10, y), (_spot(page, 64)[0] + 10, y), drop=False)
    screen(page, "timeline-stretched")
    page.mouse.up()
    until_state(page, "keys.frames", lambda now: now == [0, 32, 64, 72])
    assert at.agreed("undo")["undo"] == "stretch 3 keyframes"


def test_shift_drag_copies_and_delete_deletes_all_selected(at: Desk) -> None:
    page = at.page
    _box(page, 12, 60)
    page.keyboard.down("Shift")
    drag(page, _spot(page, 24), _spot(page, 30))
    page.keyboard.up("Shift")
    until_state(page, "keys.frames", lambda now: now == [0, 24, 30, 48, 54, 72])
    until(lambda: _chosen(page) == [30, 54], "the copies selected")
    page.keyboard.press("Delete")
    until_state(page, "keys.frames", lambda now: now == KEYS)
    page.get_by_role("button", name="Undo", exact=True).last.click()
    until_state(page, "keys.frames", lambda now: len(now) == 6)


def test_a_key_that_stays_down_moves_the_selection_as_one_step(at: Desk) -> None:
    page = at.page
    _box(page, 12, 60)
    page.keyboard.down("Control")
    for _ in range(3):
        page.keyboard.down("ArrowRight")
    page.keyboard.up("ArrowRight")
    page.keyboard.up("Control")
    until_state(page, "keys.frames", lambda now: now == [0, 27, 51, 72])
    page.keyboard.press("Control+z")
    until_state(page, "keys.frames", lambda now: now == KEYS)
