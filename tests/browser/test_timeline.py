"""The timeline under a person's hands: its menus, its drags and how they are taken back."""

from __future__ import annotations

import pytest
from playwright.sync_api import Locator, Page

from tests.browser.interaction import Spot, section, settled, until, until_state
from tests.browser.shared import Desk, opened

SIZE = (1440, 900)

DOT = """
() => {
  const { trail, view: { frame } } = window.keypose.server;
  const view = window.keypose.view('main');
  const { left, top } = view.over.getBoundingClientRect();
  const at = (point) => view.project(point.slice(1));
  const keys = trail.points.filter(([key]) => trail.keys.includes(key) && key !== frame);
  const here = at(trail.points.find(([key]) => key === frame) ?? keys[0]);
  const away = (point) => Math.hypot(at(point)[0] - here[0], at(point)[1] - here[1]);
  const farthest = keys.sort((a, b) => away(b) - away(a))[0];
  const [x, y] = at(farthest);
  return [x + left, y + top];
}
"""
"""Where the dot of the trail stands that is farthest from the body."""


def _on_key(page: Page, index: int) -> Spot:
    """Where a keyframe's diamond stands."""
    frame, last = section(page, f"keys.frames[{index}]"), section(page, "file.frames") - 1
    box = page.locator("#tsvg").bounding_box()
    assert box is not None
    left, right = box["x"] + 138, box["x"] + box["width"] - 26
    return left + frame * (right - left) / last, box["y"] + 22 + 17


def _menu(page: Page) -> Locator:
    return page.locator("#tmenu [role=menu]")


def _height(page: Page) -> int:
    return int(page.evaluate("() => document.getElementById('time').offsetHeight"))


def _focused(page: Page) -> str:
    return str(page.evaluate("() => document.activeElement.textContent.trim()"))


def test_a_keyframes_menu_is_walked_with_the_keys_and_goes_with_esc(at: Desk) -> None:
    page = at.page
    page.mouse.click(*_on_key(page, 1), button="right")
    frame = section(page, "keys.frames[1]")
    assert _menu(page).get_attribute("aria-label") == f"Keyframe {frame}"
    settled(page)
    walked = []
    for key in ("ArrowDown", "End", "ArrowDown", "ArrowUp", "Home"):
        page.keyboard.press(key)
        walked.append(_focused(page).split()[0])
    assert walked == ["Go", "Delete", "Go", "Delete", "Go"]
    assert at.agreed("view")["frame"] == 0, "the page has heard of none of these keys"
    page.keyboard.press("Escape")
    _menu(page).wait_for(state="detached")


def test_a_menu_goes_with_a_press_elsewhere_and_one_is_open_at_a_time(at: Desk) -> None:
    page = at.page
    page.mouse.click(*_on_key(page, 1), button="right")
    _menu(page).wait_for()
    page.get_by_role("button", name="Export").click()
    page.get_by_role("menuitem", name="BVH").wait_for()
    _menu(page).wait_for(state="detached")
    page.mouse.click(*_on_key(page, 1), button="right")
    _menu(page).wait_for()
    page.get_by_role("menuitem", name="BVH").wait_for(state="detached")
    page.keyboard.press("Escape")
    _menu(page).wait_for(state="detached")


def test_a_keyframe_is_copied_to_the_frame_that_was_typed_and_to_no_other(at: Desk) -> None:
    page = at.page
    keys = section(page, "keys.frames")
    page.mouse.click(*_on_key(page, 1), button="right")
    box = page.get_by_label("Duplicate to")
    for wrong in ("", "9999", "1.5"):
        box.fill(wrong)
        box.press("Enter")
        assert box.get_attribute("aria-invalid") == "true", wrong
    box.fill(str(keys[1] + 3))
    box.press("Enter")
    _menu(page).wait_for(state="detached")
    until_state(page, "keys.frames", lambda now: now == sorted({*keys, keys[1] + 3}))


@pytest.mark.parametrize("way", ["Escape", "right button"])
def test_a_keyframe_that_is_dragged_is_put_back(at: Desk, way: str) -> None:
    page = at.page
    keys = section(page, "keys.frames")
    x, y = _on_key(page, 1)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y, steps=4)
    until(lambda: page.evaluate("() => window.keypose.ui.timeGrabbed?.kind") == "key", "the drag")
    page.keyboard.press("k")  # while it is dragged no key edits
    if way == "Escape":
        page.keyboard.press("Escape")
    else:
        page.mouse.down(button="right")
        page.mouse.move(x + 41, y)
        page.mouse.up(button="right")
    until(lambda: page.evaluate("() => window.keypose.ui.timeGrabbed === null"), "the end of it")
    page.mouse.up()
    assert _menu(page).count() == 0
    assert at.agreed("keys")["frames"] == keys


def test_a_keyframe_that_is_dragged_goes_where_it_was_let_go(at: Desk) -> None:
    page = at.page
    keys = section(page, "keys.frames")
    x, y = _on_key(page, 1)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y, steps=4)
    page.mouse.up()
    moved = until_state(page, "keys.frames", lambda now: now != keys)
    assert len(moved) == len(keys)
    assert moved[1] > keys[1]


def test_an_angle_dragged_on_the_curve_is_one_step_and_esc_takes_it_back(at: Desk) -> None:
    page = at.page
    at.visitor.do(do="select", part="right_shin")
    until_state(page, "curve?.part", lambda part: part == "right_shin")
    settled(page)
    path = page.locator("#tsvg .curvekey:not(.current)").first.get_attribute("d") or ""
    assert path, "the curve has a diamond for each keyframe"
    box = page.locator("#tsvg").bounding_box()
    assert box is not None
    # A diamond is written from its upper corner: M x y.
    starts = [piece.split("l")[0].split() for piece in path.split("M")[1:]]
    x, y = float(starts[1][0]) + box["x"], float(starts[1][1]) + 4.5 + box["y"]
    frame = section(page, "keys.frames[1]")
    axis = page.locator("#tsvg .axis.chosen").get_attribute("aria-label") or ""
    where = f"curve?.{axis[0].lower()}[{frame}]"
    before = section(page, where)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 12, steps=4)
    until_state(page, where, lambda now: now != before)
    page.keyboard.press("Escape")
    page.mouse.up()
    until_state(page, where, lambda now: now == before)
    assert at.agreed("undo")["undo"] is None
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 12, steps=4)
    page.mouse.up()
    until_state(page, where, lambda now: now != before)
    assert at.agreed("undo")["undo"] is not None
    page.keyboard.press("Control+z")
    until_state(page, where, lambda now: now == before)
    assert at.agreed("undo")["undo"] is None


def test_a_height_that_was_dragged_is_there_again_after_a_reload(at: Desk) -> None:
    page = opened(at.page.context, at.keypose)
    before = _height(page)
    box = page.get_by_role("separator", name="Height of the timeline").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 60, steps=3)
    page.mouse.up()
    page.mouse.move(x, y - 120)
    height = _height(page)
    assert height > before
    page.reload()
    page.wait_for_selector("html[data-ready]", state="attached")
    until(lambda: _height(page) == height, "the height")
    page.get_by_role("separator", name="Height of the timeline").dblclick()
    until(lambda: _height(page) == before, "the usual height")
    page.close()


def test_a_press_on_a_dot_of_the_trail_that_moves_pans_the_view_from_its_first_move(
    at: Desk,
) -> None:
    page = at.page
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    at.visitor.do(do="display", mode="both", opacity=0.5, ghosts=True, trail=True)
    until(lambda: section(page, "trail"), "the trail")
    settled(page)
    x, y = page.evaluate(DOT)
    page.mouse.move(x, y)
    until(lambda: page.evaluate("() => document.querySelector('#main .over')?.style.cursor ?? ''"))
    page.mouse.down()
    page.mouse.move(x + 60, y)
    page.mouse.up()
    until(lambda: abs(page.evaluate(DOT)[0] - x - 60) < 1, "the pan")
    assert complaints == []
