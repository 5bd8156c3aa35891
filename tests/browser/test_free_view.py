"""The free view: a key opens it, the right button turns it, the motion plays in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.sync_api import Page

from tests.browser.interaction import answered, section, until, until_counted, until_state
from tests.browser.shared import Desk, opened_in


@pytest.fixture
def page(shared: Desk) -> Page:
    """The page in the free view, nothing of which is kept from before."""
    answered(shared.page)  # where it played, its last frame has come
    shared.visitor.do(do="go", frame=0)
    shared.visitor.do(do="display", ghosts=True, trail=True)
    shared.page.evaluate("() => { localStorage.clear(); sessionStorage.clear(); }")
    tab = opened_in(shared.page, shared.keypose)
    until_state(tab, "view.frame", lambda frame: frame == 0)
    tab.keyboard.press("6")
    tab.wait_for_selector("#free .floor path", state="attached")
    return tab


def eye(page: Page) -> Any:
    return page.evaluate("() => window.keypose.view('free').state")


def seen(page: Page, point: str) -> list[float]:
    """Where a point of the body is on the screen."""
    found = page.evaluate(
        """(point) => {
          const view = window.keypose.view('free');
          const { left, top } = view.el.getBoundingClientRect();
          const [x, y] = view.project(window.keypose.server.pose.points[point]);
          return [left + x, top + y];
        }""",
        point,
    )
    return [float(value) for value in found]


def pull(page: Page, button: str, start: list[float], by: tuple[float, float]) -> None:
    page.mouse.move(*start)
    page.mouse.down(button=button)  # type: ignore[arg-type]
    page.mouse.move(start[0] + by[0], start[1] + by[1], steps=4)
    page.mouse.up(button=button)  # type: ignore[arg-type]


def test_the_right_button_turns_it_about_the_selected_part(page: Page) -> None:
    until(lambda: page.is_visible("#morbit"), "the hint")
    before, pivot = eye(page), "waist"
    selected = section(page, "view.selected")
    if selected:
        pivot = selected
    at = seen(page, pivot)
    pull(page, "right", [at[0] + 150, at[1]], (-90, 20))
    after = eye(page)
    assert after["azimuth"] > before["azimuth"] + 20  # what is near goes with the pointer
    assert after["elevation"] > before["elevation"] + 3
    if selected:
        assert seen(page, pivot) == pytest.approx(at, abs=1)
    until(lambda: not page.is_visible("#morbit"), "the hint to go, for good")
    page.keyboard.press("0")
    assert eye(page)["azimuth"] == pytest.approx(before["azimuth"])


def test_it_moves_along_and_comes_nearer_and_its_place_is_kept(page: Page) -> None:
    before = eye(page)
    page.keyboard.down("Shift")
    pull(page, "right", seen(page, "waist"), (60, 0))
    page.keyboard.up("Shift")
    assert eye(page)["azimuth"] == before["azimuth"]
    assert eye(page)["target"] != before["target"]
    page.mouse.wheel(0, -120)
    until(lambda: eye(page)["distance"] < before["distance"], "nearer")
    pull(page, "middle", seen(page, "waist"), (30, 0))
    kept = eye(page)
    assert kept["azimuth"] != before["azimuth"]
    until(lambda: "keypose.free" in page.evaluate("() => Object.keys(localStorage).join()"), "kept")
    page.reload()
    page.wait_for_selector("#main canvas.vid[data-frame]")
    page.keyboard.press("6")
    until(lambda: eye(page) is not None, "an eye")
    assert eye(page)["azimuth"] == pytest.approx(kept["azimuth"])
    page.keyboard.press("0")


def test_the_motion_plays_in_it_with_its_shadow(page: Page) -> None:
    shadow = page.get_attribute("#free .shadow", "d")
    page.keyboard.press("Space")
    until(lambda: section(page, "view.frame") > 3, "playing")
    page.keyboard.press("Space")
    until(lambda: page.get_attribute("#free .shadow", "d") != shadow, "the body to move")
    until_counted(page, "#free .way.future", 2)
    until_counted(page, "#free > .under .ghost", 2)


def test_a_click_of_the_right_button_opens_the_part_s_menu_and_a_handle_can_be_pulled(
    page: Page,
) -> None:
    x, y = seen(page, "head")
    page.mouse.click(x, y - 12, button="right")
    page.wait_for_selector(".tmenu >> text=Follow the body")
    page.keyboard.press("Escape")
    before = section(page, "pose.points.left_hand")
    hand = seen(page, "left_hand")
    pull(page, "left", hand, (14, -10))
    there = pytest.approx([hand[0] + 14, hand[1] - 10], abs=2)
    until(lambda: seen(page, "left_hand") == there, "the hand under the pointer")
    page.keyboard.press("Control+z")
    until(lambda: section(page, "pose.points.left_hand") == before, "undone")


def test_its_key_again_or_1_or_the_camera_in_it_leads_back(page: Page) -> None:
    layout = "() => window.keypose.ui.layout"
    page.keyboard.press("6")
    assert page.evaluate(layout) == "main"
    page.dblclick("[data-view=side] .lab")
    assert page.evaluate(layout) == "free"
    page.keyboard.press("1")
    assert page.evaluate(layout) == "main"
    until(lambda: not page.is_visible("#free"), "the camera's view")
    until(lambda: page.is_visible("[data-view=top]"), "the small views")


def test_its_picture_is_saved_as_one_looks(page: Page, tmp_path: Path) -> None:
    with page.expect_download() as download:
        page.keyboard.press("Shift+E")
    assert download.value.suggested_filename.endswith("-0-free.png")
    saved = tmp_path / "free.png"
    download.value.save_as(saved)
    picture = cv2.imread(str(saved))
    assert picture is not None
    assert picture.shape == (1200, 1600, 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 100  # a body, and no empty floor
