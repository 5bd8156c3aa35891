"""Hundreds of events, faster than anything can follow: page, server and disk end alike."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page

from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.storage.files import load_session
from tests.app.serving import Visitor
from tests.browser.interaction import Spot, section, settled, spot, until, until_state
from tests.browser.shared import Desk

MANY = 500
TURNS = 10
FIRST = 16
LAST = 30
UNDER_PX = 1.5

BURST = 10
MOVES = """
async (element, [places, burst]) => {
  for (let i = 0; i < places.length; i++) {
    const [clientX, clientY] = places[i];
    const more = { clientX, clientY, pointerId: 1, buttons: 1, bubbles: true };
    element.dispatchEvent(new PointerEvent('pointermove', more));
    if (i % burst === 0) await new Promise(requestAnimationFrame);
  }
}
"""
"""Moves of the held pointer, several within each animation frame, which the browser would merge."""


def all_agree(desk: Desk) -> dict[str, Any]:
    """The pose at this frame, once page, server, a newcomer and the file have the same."""
    until(lambda: desk.agreed("pose")["stroke"] is None, "the end of the gesture")
    for name in ("view", "keys", "undo", "body"):
        desk.agreed(name)
    until(lambda: desk.agreed("saved")["state"] == "saved", "the file")
    newcomer = Visitor(desk.keypose)
    reported = newcomer.seen
    newcomer.leave()
    assert reported["pose"] == section(desk.page, "pose")
    kept = [*reported["keys"]["frames"], *reported["keys"]["drafts"]]
    if reported["view"]["frame"] in kept:
        there = np.array([rows for rows in reported["pose"]["T"].values()]).reshape(-1, 3, 4)
        np.testing.assert_allclose(
            _saved(desk.session, reported["view"]["frame"]), there, atol=2e-5
        )
    return dict(reported["pose"])


def _saved(path: Path, frame: int) -> Array:
    """(P, 3, 4) the parts at a posed frame, as the file has it."""
    session = load_session(path)
    skeleton = Skeleton.of(session.subject.body)
    posed = next(
        k for k in (*session.subject.keyframes, *session.subject.drafts) if k.frame == frame
    )
    return pose_transforms(skeleton, posed.pose(skeleton))[:, :3]


def undone(desk: Desk) -> list[str]:
    """The steps that could be taken back, newest first; they are taken back."""
    steps = []
    while (label := desk.served["undo"]["undo"]) is not None:
        steps.append(label)
        desk.visitor.do(do="undo")
    return steps


def angle_field(page: Page) -> Any:
    return page.get_by_role("region", name="Rotation").get_by_role("spinbutton").first


def shown_deg(page: Page) -> float:
    settled(page)
    return float(angle_field(page).input_value().replace("−", "-"))


def zigzag(start: Spot, end: Spot, count: int) -> list[Spot]:
    """A way from one spot to another that wanders; it ends exactly there."""
    share = np.linspace(0.0, 1.0, count)[:, None]
    way = np.array(start) + share * np.subtract(end, start)
    wander = 9.0 * np.sin(share * np.pi) * np.c_[np.sin(40 * share), np.cos(31 * share)]
    return [(float(x), float(y)) for x, y in way + wander]


def test_500_moves_of_a_slider(at: Desk) -> None:
    at.visitor.do(do="select", part="left_forearm")
    at.agreed("view")
    slider = at.page.get_by_role("region", name="Rotation").get_by_role("slider").first
    box = until(slider.bounding_box, "the slider")
    middle, left = box["y"] + box["height"] / 2, box["x"] + box["width"] * 0.3
    at.page.mouse.move(box["x"] + box["width"] * 0.5, middle)
    at.page.mouse.down()
    at.page.mouse.move(box["x"] + box["width"] * 0.9, middle, steps=20)
    slider.evaluate(MOVES, [zigzag((box["x"] + box["width"], middle), (left, middle), MANY), BURST])
    at.page.mouse.move(left, middle)
    at.page.mouse.up()
    pose = all_agree(at)
    assert shown_deg(at.page) == pytest.approx(pose["angles"]["left_forearm"][0], abs=0.051)
    low, high = (float(slider.get_attribute(f"aria-value{end}") or 0) for end in ("min", "max"))
    assert low - 1e-3 <= pose["angles"]["left_forearm"][0] <= high + 1e-3
    assert undone(at) == ["turn left forearm"]


def test_500_moves_of_a_drag(at: Desk) -> None:
    start = spot(at.page, "left_hand")
    end = (start[0] + 18, start[1] - 22)
    at.page.mouse.move(*start)
    at.page.mouse.down()
    at.page.mouse.move(start[0] + 4, start[1] - 4)
    over = at.page.locator("#main svg.over")
    over.evaluate(MOVES, [zigzag(start, end, MANY), BURST])
    at.page.mouse.move(*end)
    at.page.mouse.up()
    all_agree(at)
    np.testing.assert_allclose(spot(at.page, "left_hand"), end, atol=UNDER_PX)
    assert undone(at) == ["move left hand"]


def test_a_drag_that_never_rests_ends_where_it_was_let_go(at: Desk) -> None:
    """Pressed, moved and let go without a pause, again and again."""
    start = spot(at.page, "waist")
    here = start
    for turn in range(TURNS):
        there = (start[0] + 40 * np.sin(turn), start[1] + 25 * np.cos(3 * turn))
        at.page.mouse.move(*here)
        at.page.mouse.down()
        at.page.mouse.move(*there, steps=5)
        at.page.mouse.up()
        until_state(at.page, "ack", bool)
        here = _where(at.page, there)
    all_agree(at)
    np.testing.assert_allclose(spot(at.page, "waist"), here, atol=UNDER_PX)
    assert undone(at) == ["move the body"] * TURNS


def _where(page: Page, wanted: Spot) -> Spot:
    """Wait until the diamond has come under the pointer: one grabs what one sees."""
    until(lambda: np.abs(np.subtract(spot(page, "waist"), wanted)).max() < 4, "the diamond")
    return wanted


def test_drags_and_steps_from_frame_to_frame_stay_in_order(at: Desk) -> None:
    at.visitor.do(do="go", frame=FIRST)
    for step in range(FIRST, LAST):
        until_state(at.page, "view.frame", lambda frame, step=step: frame == step)
        x, y = spot(at.page, "waist")
        at.page.mouse.move(x, y)
        at.page.mouse.down()
        at.page.mouse.move(x + 12, y + 5, steps=3)
        at.page.mouse.up()
        at.page.keyboard.press("ArrowRight")
    until_state(at.page, "view.frame", lambda frame: frame == LAST)
    all_agree(at)
    keys = at.served["keys"]
    assert keys["frames"] == [0, 24, 48, 72]
    assert keys["drafts"] == [frame for frame in range(FIRST, LAST) if frame != 24]
    assert undone(at) == ["move the body"] * (LAST - FIRST)
    assert at.served["keys"]["drafts"] == []


def test_steps_by_key_are_all_made(at: Desk) -> None:
    for _ in range(60):
        at.page.keyboard.press("ArrowRight")
    for _ in range(25):
        at.page.keyboard.press("ArrowLeft")
    until(lambda: at.agreed("view")["frame"] == 35, "the last step")
    at.page.wait_for_selector("#main canvas.vid[data-frame='35']")


def test_nudges_by_the_wheel_all_count(at: Desk) -> None:
    at.visitor.do(do="select", part="right_upper_arm")
    at.visitor.do(do="limits", on=False)
    at.agreed("view")
    before = at.agreed("pose")["angles"]["right_upper_arm"][0]
    angle_field(at.page).click()
    for notch in range(100):
        at.page.mouse.wheel(0, -100 if notch % 4 else 100)
    pose = all_agree(at)
    assert pose["angles"]["right_upper_arm"][0] == pytest.approx(before + 50, abs=1e-3)
    assert shown_deg(at.page) == pytest.approx(before + 50, abs=0.051)
    at.page.keyboard.press("Escape")
    assert set(undone(at)) == {"turn right upper arm"}


def test_what_another_tab_does_meanwhile_is_not_lost(at: Desk) -> None:
    """It changes how the body is drawn all the while a hand is dragged here, then an arm."""
    start = spot(at.page, "left_hand")
    end = (start[0] + 16, start[1] - 20)
    at.page.mouse.move(*start)
    at.page.mouse.down()
    for number, place in enumerate(zigzag(start, end, 40)):
        at.page.mouse.move(*place)
        at.visitor.send(do="display", opacity=number / 100)
    at.page.mouse.move(*end)
    at.page.mouse.up()
    until(lambda: at.agreed("pose")["stroke"] is None, "the end of the drag")
    at.visitor.do(do="angles", part="right_forearm", x=-40.0)
    pose = all_agree(at)
    np.testing.assert_allclose(spot(at.page, "left_hand"), end, atol=UNDER_PX)
    assert pose["angles"]["right_forearm"][0] == pytest.approx(-40, abs=1e-3)
    assert at.agreed("view")["opacity"] == pytest.approx(0.39)
    assert undone(at) == ["turn right forearm", "move left hand"]
