"""The whole job, as a person does it: look, pose, key, size, undo, track, export, come back."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.sync_api import Page

from keypose.tracker.storage.files import load_session
from tests.browser.interaction import (
    answered,
    between,
    drag,
    screen,
    section,
    settled,
    spot,
    until,
    until_state,
)


@pytest.mark.parametrize("drawn", [True])
def test_the_whole_job(page: Page, sample: Path, tmp_path: Path) -> None:
    _looks_around(page)
    _selects_and_turns(page)
    _pulls_a_hand(page)
    _sets_a_keyframe(page)
    _changes_a_size(page)
    _undoes_and_redoes(page)
    _tracks(page)
    _exports(page, tmp_path)
    _comes_back(page, sample)


def _looks_around(page: Page) -> None:
    page.wait_for_selector("#main canvas.vid[data-frame='0']")
    screen(page, "01-opened")
    ruler = page.locator("#tsvg").bounding_box()
    assert ruler is not None
    y = ruler["y"] + 8
    drag(page, (ruler["x"] + ruler["width"] * 0.3, y), (ruler["x"] + ruler["width"] * 0.6, y))
    answered(page)
    frame = section(page, "view.frame")
    assert frame > 30
    screen(page, "02-scrubbed")
    page.keyboard.press("ArrowRight")
    until_state(page, "view.frame", lambda f: f == frame + 1)
    page.keyboard.press("Home")
    until_state(page, "view.frame", lambda f: f == 0)


def _selects_and_turns(page: Page) -> None:
    page.mouse.click(*between(page, "right_shin", "right_foot"))
    until_state(page, "view.selected", lambda part: part == "right_shin")
    screen(page, "03-selected")
    before = section(page, "pose.angles.right_shin")
    knob = page.locator('#main [data-ring="x"] .knob')
    box = until(knob.bounding_box, "the ring")
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    drag(page, middle, (middle[0] + 8, middle[1] + 30), drop=False)
    until(lambda: section(page, "pose.gesture"), "the reading")
    screen(page, "04-turning")
    page.mouse.up()
    answered(page)
    after = section(page, "pose.angles.right_shin")
    assert np.abs(np.subtract(after, before)).max() > 1
    assert section(page, "undo.undo") == "turn right shin"


def _pulls_a_hand(page: Page) -> None:
    page.keyboard.press("ArrowRight")
    until_state(page, "view.frame", lambda f: f == 1)
    start = spot(page, "left_hand")
    end = (start[0] + 22, start[1] - 14)
    drag(page, start, end, drop=False)
    until(lambda: section(page, "pose.gesture"), "the reading")
    screen(page, "05-hand")
    page.mouse.up()
    answered(page)
    np.testing.assert_allclose(spot(page, "left_hand"), end, atol=1.5)
    assert section(page, "keys.drafts") == [1]


def _sets_a_keyframe(page: Page) -> None:
    page.keyboard.press("k")
    until_state(page, "keys.frames", lambda frames: frames == [0, 1, 24, 48, 72])
    screen(page, "06-keyframe")


def _changes_a_size(page: Page) -> None:
    page.get_by_role("tab", name="Body").click()
    field = page.get_by_role("spinbutton", name="Height").first
    field.click()
    page.keyboard.press("Control+a")
    page.keyboard.type("181")
    page.keyboard.press("Enter")
    until_state(page, "body.height_cm", lambda cm: abs(cm - 181) < 0.01)
    screen(page, "07-height")


def _undoes_and_redoes(page: Page) -> None:
    page.keyboard.press("Control+z")
    until_state(page, "body.height_cm", lambda cm: abs(cm - 181) > 0.5)
    page.keyboard.press("Control+z")
    until_state(page, "keys.frames", lambda frames: frames == [0, 24, 48, 72])
    page.keyboard.press("Control+Shift+z")
    until_state(page, "keys.frames", lambda frames: 1 in frames)
    page.keyboard.press("k")
    page.get_by_text("Frame 1 is already a keyframe.").wait_for()
    page.keyboard.press("Delete")
    until_state(page, "keys.frames", lambda frames: frames == [0, 24, 48, 72])
    answered(page)


def _tracks(page: Page) -> None:
    page.keyboard.press("t")
    # A page that is looked at seldom may show the first segment only when it is tracked.
    begun = {"tracking", "good", "check", "lost"}
    until_state(page, "segments", lambda segments: any(s["state"] in begun for s in segments))
    screen(page, "08-tracking")
    until_state(page, "job.state", lambda state: state == "done")
    assert {s["state"] for s in section(page, "segments")} <= {"good", "check", "lost"}
    page.keyboard.press("End")
    page.keyboard.press("Shift+ArrowLeft")
    until_state(page, "pose.source", lambda source: source == "tracked")
    page.keyboard.press("o")
    until_state(page, "view.ghosts", bool)
    screen(page, "09-tracked")


def _exports(page: Page, folder: Path) -> None:
    with page.expect_download() as waiting:
        page.keyboard.press("Shift+E")
    waiting.value.save_as(folder / "view.png")
    picture = cv2.imread(str(folder / "view.png"))
    assert picture is not None
    assert picture.shape == (360, 640, 3)
    page.get_by_role("button", name="Export").click()
    screen(page, "10-export")
    with page.expect_download() as waiting:
        page.get_by_role("menuitem", name="BVH").click()
    waiting.value.save_as(folder / "motion.bvh")
    assert (folder / "motion.bvh").read_text().startswith("HIERARCHY")


def _comes_back(page: Page, sample: Path) -> None:
    answered(page)
    until_state(page, "saved.state", lambda state: state == "saved")
    before = _all(page)
    page.reload()
    page.wait_for_selector("html[data-ready]", state="attached")
    until(lambda: _all(page) == before, "all that was there")
    screen(page, "11-reloaded")
    assert len(load_session(sample).subject.keyframes) == 4


def _all(page: Page) -> dict[str, Any]:
    names = ("file", "camera", "body", "view", "pose", "keys", "segments", "undo", "masks")
    return {name: json.loads(json.dumps(section(page, name))) for name in names}


def test_nothing_is_cut_off_in_a_small_window(page: Page) -> None:
    for theme, size in product(("dark", "light"), ((1280, 720), (1440, 900))):
        page.set_viewport_size({"width": size[0], "height": size[1]})
        page.evaluate(f"() => document.documentElement.dataset.theme = '{theme}'")
        settled(page)
        _lies_inside(page, size)
        screen(page, f"size-{theme}-{size[0]}")


def _lies_inside(page: Page, size: tuple[int, int]) -> None:
    """All that the page consists of is in the window."""
    wide, high = page.evaluate(
        "() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
    )
    assert (wide, high) == size
    for name in ("#top", "#main", "#views .sv >> nth=2", "#insp", "#time", "#status"):
        box = page.locator(name).bounding_box()
        assert box is not None
        assert box["x"] + box["width"] <= size[0] + 0.5, name
        assert box["y"] + box["height"] <= size[1] + 0.5, name
