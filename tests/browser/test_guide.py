"""The guide to a first pose, and the keys K and Delete, as a person meets them."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page

from keypose.tracker.storage.files import load_session, save_session
from tests.browser.interaction import answered, drag, section, settled, spot, until, until_state
from tests.browser.shared import Desk, desk
from tests.browser.test_surface import SAMPLE, arms


@pytest.fixture
def guided(at: Desk) -> Page:
    """The guide opened from the help, on a keyframe that stands."""
    page = at.page
    page.keyboard.press("?")
    page.get_by_text("Show the first-pose guide").click()
    until_state(page, "guide.done", lambda done: not any(done.values()))
    until(lambda: title(page) == "Drag the waist onto the hips", "the first step")
    return page


def title(page: Page) -> str:
    return page.locator("#guide h3").inner_text()


def button(page: Page, words: str) -> Locator:
    return page.locator("#guide").get_by_role("button", name=words, exact=True)


def up_to(page: Page, wanted: str) -> None:
    """Press Next until this step is shown, and its card has its place."""
    while (step := title(page)) != wanted:
        button(page, "Next").click()
        until(lambda step=step: title(page) != step, f"the step after {step}")  # type: ignore[misc]
    settled(page)


def pulled(page: Page, point: str, by: tuple[float, float], view: str = "main") -> None:
    x, y = spot(page, point, view)
    drag(page, (x, y), (x + by[0], y + by[1]), steps=4)
    answered(page)


def corner(page: Page) -> tuple[float, float]:
    """Left and bottom of the card."""
    box = page.locator("#guide .coach").bounding_box()
    assert box is not None
    return box["x"], round(box["y"] + box["height"])


# --- the guide


def test_the_guide_begins_anew_although_keyframes_stand(guided: Page) -> None:
    assert section(guided, "keys.frames") == [0, 24, 48, 72]
    assert guided.locator("#guide .foot").inner_text().startswith("Step 1 of 6")
    pulled(guided, "waist", (6, 4))
    until(lambda: title(guided) == "Match the size of the person", "the next step")


def test_a_step_does_not_end_under_a_drag(guided: Page) -> None:
    x, y = spot(guided, "waist")
    drag(guided, (x, y), (x + 9, y), drop=False)
    until_state(guided, "pose.stroke", lambda stroke: stroke is not None)
    guided.wait_for_timeout(1200)
    assert title(guided) == "Drag the waist onto the hips"
    assert not section(guided, "guide.done")["hips"]
    guided.mouse.up()
    until_state(guided, "guide.done", lambda done: done["hips"])
    until(lambda: title(guided) == "Match the size of the person", "the next step")


def test_a_drag_that_is_taken_back_does_no_step(at: Desk, guided: Page) -> None:
    x, y = spot(guided, "waist")
    drag(guided, (x, y), (x + 9, y), drop=False)
    until_state(guided, "pose.stroke", lambda stroke: stroke is not None)
    guided.keyboard.press("Escape")
    guided.mouse.up()
    assert not at.agreed("guide")["done"]["hips"]
    assert title(guided) == "Drag the waist onto the hips"


def test_the_guide_closes_when_a_session_is_opened_that_has_keyframes(
    browser: Browser, tmp_path: Path
) -> None:
    with desk(browser, tmp_path, own=True) as own:
        page = own.page
        page.keyboard.press("?")
        page.get_by_text("Show the first-pose guide").click()
        until(lambda: page.locator("#guide h3").count(), "the guide")
        before = section(page, "file.path")
        own.visitor.do(do="open", kind="sample", id="box")
        until_state(page, "file", lambda file: file and file["path"] != before)
        until_state(page, "guide.first", lambda first: first is False)
        until(lambda: not page.locator("#guide h3").count(), "the guide gone")


def test_a_button_turns_the_body_and_leads_on(at: Desk, guided: Page) -> None:
    before = at.served["pose"]
    up_to(guided, "Set the facing direction")
    # Its green ring is spoken of.
    until(lambda: section(guided, "view.selected") == "waist", "the waist")
    button(guided, "Faces left").click()
    until(lambda: title(guided) == "Pull the limbs into place", "the next step")
    after = at.agreed("pose")
    np.testing.assert_allclose(after["root"], before["root"], atol=1e-9)
    assert others(after) == others(before)
    T = np.array(after["T"]["waist"]).reshape(3, 4)
    x, _, z = -T[:, 2]
    np.testing.assert_allclose((x, z) / np.hypot(x, z), (-1, 0), atol=1e-6)
    assert at.agreed("undo")["undo"] == "turn the body"
    at.visitor.do(do="undo")
    np.testing.assert_allclose(at.served["pose"]["T"]["waist"], before["T"]["waist"])


def others(pose: dict[str, Any]) -> dict[str, Any]:
    return {name: angles for name, angles in pose["angles"].items() if name != "waist"}


def test_the_waist_is_taken_up_where_the_body_leans_wrongly(at: Desk, guided: Page) -> None:
    at.visitor.do(do="select", part="left_shin")
    up_to(guided, "Check from the side")
    at.visitor.do(do="select", part="left_shin")
    button(guided, "Rotate the waist").click()
    until_state(guided, "view.selected", lambda part: part == "waist")
    guided.locator("[data-view=side] [data-ring=x]").wait_for(state="attached")


def test_the_card_stays_in_its_place_during_a_step(guided: Page) -> None:
    up_to(guided, "Pull the limbs into place")
    stands = corner(guided)
    for point, by in (("left_foot", (-8, -6)), ("right_hand", (6, -9)), ("left_hand", (5, 4))):
        pulled(guided, point, by)
        assert corner(guided) == stands, point


def test_the_reading_of_a_drag_is_not_hidden_by_the_card(guided: Page) -> None:
    up_to(guided, "Match the size of the person")
    put_over(guided, spot(guided, "waist"))
    x, y = spot(guided, "waist")
    drag(guided, (x, y), (x + 4, y + 2), drop=False)
    guided.locator("#main .hud .flt").wait_for()
    guided.locator("#guide .coach.behind").wait_for()
    guided.mouse.up()
    answered(guided)
    until(lambda: guided.locator("#guide .coach.behind").count() == 0, "the card")


def put_over(page: Page, place: tuple[float, float]) -> None:
    """Carry the card until its left edge is a little right of a place: where a reading stands."""
    box = page.locator("#guide .coach").bounding_box()
    assert box is not None
    hold = (box["x"] + 20, box["y"] + box["height"] - 8)
    drag(page, hold, (place[0] + 80, place[1] + 60))
    settled(page)


def test_while_a_vertical_is_drawn_the_card_gives_way_and_the_tool_comes_back(
    guided: Page,
) -> None:
    guided.keyboard.press("r")
    guided.get_by_role("tab", name="Camera").click()
    guided.get_by_text("Draw verticals in the image").click()
    guided.locator("#guide .coach.behind").wait_for()
    box = guided.locator("#main canvas.vid").bounding_box()
    assert box is not None
    middle = box["x"] + box["width"] / 2
    drag(guided, (middle, box["y"] + 40), (middle + 9, box["y"] + box["height"] - 60))
    until_state(guided, "camera.up_origin", lambda origin: origin == "drawn")
    guided.keyboard.press("Escape")
    until(lambda: guided.evaluate("() => window.keypose.ui.tool") == "rotate", "the tool before")
    until(lambda: guided.locator("#guide .coach.behind").count() == 0, "the card")


def test_at_its_end_the_guide_says_what_is_to_be_done_and_praises_nothing(guided: Page) -> None:
    up_to(guided, "Press K")
    button(guided, "Next").click()
    until(lambda: title(guided) == "Press Track (T)", "the end")
    assert "stands" not in guided.locator("#guide").inner_text()


def test_a_pose_that_is_kept_early_ends_the_guide(at: Desk, guided: Page) -> None:
    at.visitor.do(do="go", frame=5)
    at.agreed("view")
    guided.keyboard.press("k")
    until(lambda: title(guided) == "Press Track (T)", "the end")
    guided.locator("#guide .steps button").first.click()
    guided.wait_for_timeout(1200)
    assert title(guided) == "Drag the waist onto the hips"  # looked up again, it stays


# --- of a thing


@pytest.fixture
def thing(request: pytest.FixtureRequest, at: Desk) -> Iterator[Page]:
    """The guide to a thing's first pose, opened from the help."""
    at.visitor.do(do="preset", name=request.param)
    at.agreed("body")
    page = at.page
    page.keyboard.press("?")
    page.get_by_text("Show the first-pose guide").click()
    until(lambda: title(page) == "Move it onto the thing", "the first step")
    yield page
    button(page, "Close guide").click()


@pytest.mark.parametrize("thing", ["cylinder"], indirect=True)
def test_of_a_thing_the_guide_goes_from_its_place_to_its_keyframe(at: Desk, thing: Page) -> None:
    assert thing.locator("#guide .foot").inner_text().startswith("Step 1 of 4")
    tools, words = [], thing.locator("#guide").inner_text()
    for wanted in ("Set its sizes", "Turn it like the thing", "Press K"):
        up_to(thing, wanted)
        tools.append(thing.evaluate("() => window.keypose.ui.tool"))
        words += thing.locator("#guide").inner_text()
    assert tools[:2] == ["size", "rotate"]
    assert not any(word in words for word in ("person", "hips", "waist", "head", "Limbs"))
    at.visitor.do(do="go", frame=5)
    at.agreed("view")
    thing.keyboard.press("k")
    until(lambda: thing.locator("#guide .steps .c").count() == 0, "the end")
    assert 5 in at.agreed("keys")["frames"]


@pytest.mark.parametrize("thing", ["box"], indirect=True)
def test_a_drag_of_a_thing_ticks_its_step_and_waits_for_next(at: Desk, thing: Page) -> None:
    root = at.agreed("body")["parts"][0]["name"]
    pulled(thing, root, (9, 5))
    until_state(thing, "guide.done", lambda done: done["hips"])
    first = thing.locator("#guide .steps button").first
    until(lambda: "d" in (first.get_attribute("class") or "").split(), "the tick")
    assert title(thing) == "Move it onto the thing"
    button(thing, "Next").click()
    until(lambda: title(thing) == "Set its sizes", "the next step")


# --- of observed surfaces


def test_of_surfaces_the_guide_speaks_of_them_and_ends_with_the_keyframe(
    browser: Browser, tmp_path: Path
) -> None:
    with unposed_arms(browser, tmp_path) as desk:
        page = desk.page
        until(lambda: page.locator("#guide h3").count(), "the guide")
        assert page.locator("#guide .foot").inner_text().startswith("Step 1 of 4")
        words = ""
        for wanted in ("Rotate it like the surface", "Pull the limbs near", "Press F, then K"):
            words += page.locator("#guide").inner_text()
            up_to(page, wanted)
        words += page.locator("#guide").inner_text()
        assert not any(word in words for word in ("person", "hips", "waist", "head"))
        page.locator("#guide .steps button").first.click()
        page.keyboard.press("k")
        until(lambda: title(page) == "Press Fit (T)", "the end")


def test_of_surfaces_a_drag_in_any_view_places_the_body(browser: Browser, tmp_path: Path) -> None:
    with unposed_arms(browser, tmp_path) as desk:
        page = desk.page
        first = page.locator("#guide .steps button").first
        first.wait_for()
        pulled(page, "arm_a", (9, 5), view="side")
        until(lambda: "d" in (first.get_attribute("class") or "").split(), "the tick")


@contextmanager
def unposed_arms(browser: Browser, folder: Path) -> Iterator[Desk]:
    """The page of observed surfaces in which nothing has been posed yet."""
    place = folder / "arms"
    shutil.copytree(SAMPLE, place)
    session = load_session(place / "session.json")
    save_session(session.changed({"keyframes": (), "results": None}), place / "session.json")
    with arms(browser, folder, drawn=False) as desk:
        yield desk


# --- K and Delete


def test_k_on_a_keyframe_that_was_corrected_keeps_it(at: Desk) -> None:
    pulled(at.page, "left_hand", (7, -5))
    corrected = at.agreed("pose")
    at.page.keyboard.press("k")
    at.page.get_by_text("Frame 0 is already a keyframe.").wait_for()
    assert at.agreed("keys")["frames"] == [0, 24, 48, 72]
    assert at.agreed("pose")["points"] == corrected["points"]
    assert at.agreed("undo")["undo"] == "move left hand"


def test_what_delete_takes_away_its_message_brings_back(at: Desk) -> None:
    page = at.page
    in_bar = page.get_by_role("button", name="Delete keyframe", exact=True)
    for pressed in (True, False):
        if pressed:
            page.keyboard.press("Delete")
        else:
            in_bar.click()
        until_state(page, "keys.frames", lambda frames: frames == [24, 48, 72])
        page.locator(".toast", has_text="Keyframe 0 deleted.").get_by_text("Undo").click()
        until_state(page, "keys.frames", lambda frames: frames == [0, 24, 48, 72])


def test_what_is_undone_by_key_has_no_message_to_undo_it_any_more(at: Desk) -> None:
    page = at.page
    page.evaluate("performance.now = () => 0")  # no message goes because it is old
    page.keyboard.press("Delete")
    deleted = page.locator(".toast", has_text="Keyframe 0 deleted.")
    deleted.wait_for()
    page.keyboard.press("Control+z")
    until_state(page, "keys.frames", lambda frames: frames == [0, 24, 48, 72])
    deleted.wait_for(state="detached")
