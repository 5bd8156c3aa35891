"""A limb is keyed alone, moved on the timeline, made whole, and had back by undo."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page

from tests.browser.interaction import (
    Spot,
    answered,
    drag,
    screen,
    screens,
    section,
    settled,
    spot,
    until_counted,
    until_state,
)
from tests.browser.shared import Desk

SIZE = (1440, 900)


def _pull(page: Page, point: str, by: Spot) -> None:
    """Drag a handle by pixels."""
    x, y = spot(page, point)
    drag(page, (x, y), (x + by[0], y + by[1]), steps=5)


def _on_frame(page: Page, frame: int) -> Spot:
    """Where a frame's keyframe stands on the timeline."""
    last = section(page, "file.frames") - 1
    box = page.locator("#tsvg").bounding_box()
    assert box is not None
    left, right = box["x"] + 138, box["x"] + box["width"] - 26
    return left + frame * (right - left) / last, box["y"] + 22 + 17


def _keyed_arm(page: Page) -> int:
    """Key the right arm alone amid the first interval, a little to the side of where it was; the
    frame."""
    first, last = section(page, "keys.frames")[:2]
    frame = int((first + last) // 2)
    page.keyboard.press("Home")
    page.keyboard.press("/")
    until_state(page, "pose.frame", lambda now: now == frame)
    settled(page)
    _pull(page, "right_hand", (24, -10))
    answered(page)
    assert section(page, "keys.drafts") == [frame]
    page.keyboard.press("Shift+K")
    until_state(page, "keys.parts", lambda parts: [part["frame"] for part in parts] == [frame])
    return frame


def test_a_limb_that_was_pulled_is_keyed_alone_and_shown_half_filled(at: Desk) -> None:
    page = at.page
    keys = section(page, "keys.frames")
    frame = _keyed_arm(page)
    assert section(page, "keys.frames") == keys
    assert section(page, "keys.drafts") == []
    assert section(page, "keys.parts[0].words") == "right arm only"
    page.keyboard.press("Shift+ArrowRight")
    until_state(page, "view.frame", lambda now: now == frame + 10)
    until_counted(page, "#tsvg .partkey .fill.R", 1)
    page.mouse.move(*_on_frame(page, frame))
    page.locator("#tsvg .plate").first.wait_for()
    settled(page)
    words = " ".join(page.locator("#tsvg .plate text").all_text_contents())
    assert f"Part keyframe {frame}" in words
    assert "right arm only" in words
    screen(page, "part-keyframe-tip")


def test_it_is_dragged_copied_deleted_and_made_whole_like_a_keyframe(at: Desk) -> None:
    page = at.page
    keys = section(page, "keys.frames")
    frame = _keyed_arm(page)
    drag(page, _on_frame(page, frame), _on_frame(page, frame + 4), steps=5)
    until_state(page, "keys.parts[0].frame", lambda now: now == frame + 4)
    page.keyboard.press("Delete")
    until_state(page, "keys.parts", lambda parts: parts == [])
    page.keyboard.press("Control+z")
    until_state(page, "keys.parts", lambda parts: len(parts) == 1)
    page.mouse.dblclick(*_on_frame(page, frame + 4))
    until_state(page, "keys.frames", lambda now: frame + 4 in now)
    assert section(page, "keys.parts") == []
    page.keyboard.press("Control+z")
    until_state(page, "keys.frames", lambda now: now == keys)
    at.agreed("keys")


def test_a_second_limb_shares_the_diamond_and_leaves_it_from_the_inspector(at: Desk) -> None:
    page = at.page
    _keyed_arm(page)
    _pull(page, "left_foot", (-12, -20))
    until_state(page, "keys.parts[0].limbs", lambda limbs: len(limbs) == 2)
    until_counted(page, "#tsvg .partkey.current .fill.L", 1)
    screen(page, "part-keyframe-two")
    page.get_by_role("button", name="Leave the right arm to the tracker").click()
    until_state(page, "keys.parts[0].words", lambda words: words == "left leg only")


def test_with_live_on_the_limb_is_tracked_at_once_and_the_rest_stays_where_it_was(at: Desk) -> None:
    page = at.page
    page.keyboard.press("Home")
    page.keyboard.press("/")
    until_state(page, "pose.frame", lambda now: now == 12)
    page.keyboard.press("Shift+T")
    until_state(page, "pose.source", lambda source: source == "tracked")
    until_state(page, "job.state", lambda state: state == "done")
    at.visitor.do(do="live", on=True)
    at.agreed("view")
    before = spot(page, "left_foot")
    _pull(page, "right_hand", (24, -10))
    until_state(page, "keys.drafts", lambda drafts: drafts == [12])
    answered(page)
    dropped = spot(page, "right_hand")
    page.keyboard.press("Shift+K")
    until_state(page, "keys.parts", lambda parts: len(parts) == 1)
    until_state(
        page,
        "segments[0].state",
        lambda state: state in ("good", "check", "lost"),
    )
    until_state(page, "pose.source", lambda source: source == "tracked")
    at.agreed("pose")
    assert spot(page, "right_hand") == pytest.approx(dropped, abs=0.5)
    assert spot(page, "left_foot") == pytest.approx(before, abs=0.01)
    screens(page, "part-keyframe-live")
