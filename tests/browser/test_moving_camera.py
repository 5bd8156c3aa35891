"""A film whose camera pans: a person finds its motion, sees it, corrects it and leaves it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from keypose.tracker.geometry.rotations import exp_rotation
from tests.app.serving import Keypose
from tests.browser.interaction import (
    Spot,
    answered,
    screens,
    section,
    until,
    until_counted,
    until_state,
)
from tests.browser.shared import admit, opened
from tests.browser.test_everyone import AXE, complaints
from tests.tracker import panned_cases as panned

SECONDS_TO_FIND = 400


@pytest.fixture(scope="module")
def page(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """The Camera tab of a film whose camera pans. What a test does, the next one finds."""
    folder = tmp_path_factory.mktemp("panned")
    keypose = Keypose(str(panned.write(folder)), "--workspace", str(folder / "workspace"))
    try:
        with admit(browser, drawn=False, size=(1440, 900)) as context:
            made = opened(context, keypose)
            made.keyboard.press("Escape")
            made.get_by_role("tab", name="Camera").click()
            yield made
    finally:
        code, words = keypose.end()
    assert code == 0, words


def panel(page: Page) -> Any:
    return page.get_by_role("region", name="Motion", exact=True)


def on_screen(page: Page, uv: tuple[float, float]) -> Spot:
    """Where a pixel of the film is seen."""
    x, y = page.evaluate(
        """(uv) => {
          const view = window.keypose.view('main');
          const [a, b] = view.fromView(uv);
          const { left, top } = view.el.getBoundingClientRect();
          return [left + a, top + b];
        }""",
        list(uv),
    )
    return x, y


def go(page: Page, frame: int) -> None:
    page.evaluate(
        "async (to) => (await window.keypose.module('actions/playhead.js')).goTo(to)", frame
    )
    until_state(page, "view.frame", lambda at: at == frame)
    answered(page)


def in_free_view(page: Page, point: str) -> list[float]:
    """Where a point of the body is in the free view, pixels."""
    found = page.evaluate(
        "(point) => window.keypose.view('free').project(window.keypose.server.pose.points[point])",
        point,
    )
    return [float(value) for value in found[:2]]


def R_here_camera(page: Page) -> Any:
    """The rotation of the camera at the present frame in the world."""
    return np.array(section(page, "camera_here")).reshape(3, 4)[:, :3]


def test_the_motion_is_found_by_one_press(page: Page) -> None:
    assert "does not stand still" in panel(page).inner_text()
    assert page.locator("#tsvg .camera-error").count() == 0
    panel(page).get_by_role("button", name="Find the camera’s motion").click()
    until_state(page, "camera_motion", lambda found: found is not None, SECONDS_TO_FIND)
    until(lambda: "The camera turns" in panel(page).inner_text(), "what was found")
    until_counted(page, "#tsvg .camera-error", 1)
    for frame in (6, 23):
        go(page, frame)
        truth = panned.Rs_camera_world()[frame]
        assert np.abs(R_here_camera(page) - truth.T).max() < 2e-3
    chosen = panel(page).get_by_role("button", name="Turns", exact=True)
    assert chosen.get_attribute("aria-pressed") == "true"


def test_points_of_the_background_are_shown_good_and_refused(page: Page) -> None:
    go(page, 12)
    panel(page).get_by_role("checkbox", name="Show background points").click()
    until_state(page, "background", lambda shown: bool(shown and shown["uv"]))
    good = section(page, "background.good")
    drawn = page.get_attribute("#main .background .agrees", "d") or ""
    refused = page.get_attribute("#main .background .refused", "d") or ""
    assert drawn.count("M") == sum(good) > 20
    assert refused.count("M") == len(good) - sum(good)
    assert f"{sum(good)} agree" in panel(page).inner_text()
    colours = page.evaluate(
        """() => ['agrees', 'refused'].map((name) =>
          getComputedStyle(document.querySelector(`#main .background .${name}`)).stroke)"""
    )
    assert colours[0] != colours[1]
    screens(page, "moving-camera-1-points")


def test_a_body_that_stands_still_stays_where_it_was_in_the_free_view(page: Page) -> None:
    page.keyboard.press("6")
    page.wait_for_selector("#free .floor path", state="attached")
    places = []
    point = next(iter(section(page, "pose.points")))
    for frame in (3, 11, 20):
        go(page, frame)
        places.append(in_free_view(page, point))
    assert np.abs(np.array(places) - places[0]).max() < 1
    page.keyboard.press("1")


def test_matched_points_of_two_frames_correct_the_camera_here(page: Page) -> None:
    go(page, 4)
    before = R_here_camera(page)
    panel(page).get_by_role("button", name="Match points of two frames").click()
    marked = [(120.0, 60.0), (260.0, 70.0), (240.0, 130.0)]
    for uv in marked:
        page.mouse.click(*on_screen(page, uv))
    until_counted(page, "#main .matched [data-match]", 3)
    go(page, 16)
    until_counted(page, "#main .matched [data-match]", 0)
    turn = exp_rotation(np.radians([0.0, -2.0, 0.0])) @ R_here_camera(page).T @ before
    for uv in marked:
        seen = panned.CAMERA.project(turn @ panned.CAMERA.back_project(np.array(uv), 1.0))
        assert page.get_by_role("button", name="Correct the camera here").count() == 1
        page.mouse.click(*on_screen(page, (float(seen[0]), float(seen[1]))))
    page.get_by_role("button", name="Correct the camera here").click()
    until_state(page, "camera_motion.keys", lambda keys: keys == [16])
    answered(page)
    assert np.abs(R_here_camera(page).T @ before - turn).max() < 5e-3
    until_counted(page, "#tsvg .camera-key", 1)
    page.keyboard.press("Escape")
    until(lambda: page.evaluate("() => window.keypose.ui.tool") == "select", "the tool to go")
    screens(page, "moving-camera-2-corrected")


def test_nothing_of_it_is_hidden_from_those_who_read_aloud(page: Page) -> None:
    if not AXE.exists():
        pytest.skip("axe-core is not installed: npm ci --prefix tests/page.")
    page.evaluate(AXE.read_text())
    assert complaints(page) == []


def test_a_correction_is_reached_and_deleted_from_the_list_and_comes_back(page: Page) -> None:
    go(page, 2)
    panel(page).get_by_role("button", name="Frame 16", exact=True).click()
    until_state(page, "view.frame", lambda at: at == 16)
    panel(page).get_by_role("button", name="Delete the correction at frame 16").click()
    until_state(page, "camera_motion.keys", lambda keys: keys == [])
    page.keyboard.press("Control+z")
    until_state(page, "camera_motion.keys", lambda keys: keys == [16])


def test_a_camera_said_to_stand_still_is_the_world_until_it_turns_again(page: Page) -> None:
    panel(page).get_by_role("button", name="Stands still").click()
    until_state(page, "settings.static_camera", lambda said: said is True)
    until_counted(page, "#tsvg .camera-error", 0)
    assert "as you said" in panel(page).inner_text()
    panel(page).get_by_role("button", name="Turns", exact=True).click()
    until_state(page, "camera_motion.counts", lambda counts: counts is True)
    until_counted(page, "#tsvg .camera-error", 1)


def test_it_is_left_as_it_was_and_undone(page: Page) -> None:
    panel(page).get_by_role("button", name="Leave the camera as it was").click()
    until_state(page, "camera_motion", lambda motion: motion is None)
    until(lambda: "does not stand still" in panel(page).inner_text(), "the words")
    until_counted(page, "#tsvg .camera-error", 0)
    page.keyboard.press("Control+z")
    until_state(page, "camera_motion", lambda motion: motion is not None)
    until_counted(page, "#tsvg .camera-error", 1)


def test_the_horizon_tool_says_which_of_both_it_is(page: Page) -> None:
    button = panel(page).get_by_role("button", name="Correct the camera by the horizon")
    assert button.get_attribute("aria-disabled") == "true"
    assert "what is up" in (button.get_attribute("title") or "")
    page.get_by_role("button", name="Draw the horizon").click()
    page.mouse.move(*on_screen(page, (20, 89)))
    page.mouse.down()
    page.mouse.move(*on_screen(page, (300, 89)), steps=4)
    page.mouse.up()
    until_state(page, "camera.up_origin", lambda origin: origin == "drawn")
    up = section(page, "camera.up")
    page.keyboard.press("Escape")
    go(page, 9)
    keys = section(page, "camera_motion.keys")
    button.click()
    until(lambda: "what is up stays" in page.inner_text("#mhint"), "its words")
    page.keyboard.press("Alt+ArrowUp")
    until_state(page, "camera_motion.keys", lambda now: now == sorted({*keys, 9}))
    page.keyboard.press("Escape")
    go(page, 16)
    assert section(page, "camera.up_origin") == "drawn"
    assert len(up) == 3
