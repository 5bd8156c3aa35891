"""The box around a person, drawn over the picture by hand, and the draft made from it."""

from __future__ import annotations

import json
from typing import Any

import pytest
from playwright.sync_api import Locator, Page

from tests.browser.interaction import (
    Spot,
    drag,
    screens,
    section,
    settled,
    spot,
    until,
    until_counted,
    until_state,
)
from tests.browser.shared import Desk

SIZE = (1440, 900)
SECONDS_TO_DRAFT = 400


@pytest.fixture
def page(shared: Desk) -> Page:
    """The Track tab of a film without keyframes, the box tool not in hand yet."""
    shared.fresh()
    for frame in (0, 24, 48, 72):
        shared.visitor.do(do="delete_key", frame=frame)
    shared.agreed("keys")
    shared.page.get_by_role("tab", name="Track").click()
    return shared.page


def box(page: Page) -> Any:
    """Left, top, right and bottom, pixels of the video; None where there is none."""
    return page.evaluate("() => window.keypose.ui.box")


def on_screen(page: Page, x: float, y: float) -> Spot:
    """Where a pixel of the video is seen."""
    settled(page)
    left, top = page.evaluate(
        """([x, y]) => {
          const view = window.keypose.view('main');
          const [a, b] = view.fromView([x, y]);
          const frame = view.el.getBoundingClientRect();
          return [frame.left + a, frame.top + b];
        }""",
        [x, y],
    )
    return left, top


def draw(page: Page, *sides: float) -> None:
    """Take the tool and draw a box with these sides."""
    page.get_by_role("button", name="Draw a box").click()
    drag(page, on_screen(page, *sides[:2]), on_screen(page, *sides[2:]))


def rounded(found: Any) -> list[int]:
    return [round(side) for side in found]


def test_a_box_is_drawn_pulled_at_a_corner_and_moved(page: Page) -> None:
    draw(page, 330, 20, 480, 320)
    assert rounded(box(page)) == [330, 20, 480, 320]
    until_counted(page, "#main .box .pull", 8)
    assert page.locator("#main .hud .flt", has_text="Person").inner_text() == "Person 150 × 300"
    screens(page, "box-1-drawn")
    drag(page, on_screen(page, 480, 320), on_screen(page, 500, 340))
    assert rounded(box(page)) == [330, 20, 500, 340]
    drag(page, on_screen(page, 330, 180), on_screen(page, 300, 200))
    assert rounded(box(page)) == [300, 20, 500, 340]
    drag(page, on_screen(page, 400, 100), on_screen(page, 390, 110))
    assert rounded(box(page)) == [290, 30, 490, 350]


def test_a_press_elsewhere_begins_another_box_and_a_click_does_not(page: Page) -> None:
    draw(page, 330, 20, 480, 320)
    page.mouse.click(*on_screen(page, 100, 100))
    assert rounded(box(page)) == [330, 20, 480, 320]
    drag(page, on_screen(page, 100, 100), on_screen(page, 200, 300))
    assert rounded(box(page)) == [100, 100, 200, 300]


def test_esc_ends_the_gesture_first_and_then_leaves(page: Page) -> None:
    draw(page, 330, 20, 480, 320)
    drag(page, on_screen(page, 400, 100), on_screen(page, 300, 100), drop=False)
    page.keyboard.press("Escape")
    page.mouse.up()
    assert rounded(box(page)) == [330, 20, 480, 320]
    page.keyboard.press("Escape")
    until(lambda: page.evaluate("() => window.keypose.ui.tool") == "select", "the tool before")
    until(lambda: box(page) is None, "no box")


def edges(found: list[float]) -> list[int]:
    return [round(edge) for edge in found]


def looked(page: Page) -> list[list[float]]:
    """Take the tool, and wait for who is found in the picture; those outlines are drawn."""
    page.get_by_role("button", name="Draw a box").click()
    people = until_state(page, "people", bool, SECONDS_TO_DRAFT)
    until_counted(page, "#main .people .found", len(people["boxes"]))
    return list(people["boxes"])


def test_the_person_is_proposed_and_enter_takes_the_box_as_if_it_was_drawn(page: Page) -> None:
    (person,) = looked(page)
    page.locator("#mhint", has_text="One person found.").wait_for()
    screens(page, "box-3-proposed")
    page.keyboard.press("Enter")
    until(lambda: box(page) is not None, "the box")
    assert edges(box(page)) == edges(person)
    until_counted(page, "#main .box .pull", 8)
    until_counted(page, "#main .people .found", 0)
    assert section(page, "job.state") != "running", "the box may be corrected first"


def test_the_pointer_shows_a_person_and_a_click_takes_them(page: Page) -> None:
    (person,) = looked(page)
    middle = on_screen(page, (person[0] + person[2]) / 2, (person[1] + person[3]) / 2)
    page.mouse.move(2, 2)
    page.mouse.move(*middle)
    until_counted(page, "#main .people .found.hot", 1)
    page.mouse.click(*middle)
    assert edges(box(page)) == edges(person)


def test_a_box_drawn_by_hand_goes_before_whoever_was_found(page: Page) -> None:
    (person,) = looked(page)
    start = (person[0] + 20, person[1] + 20)
    drag(page, on_screen(page, *start), on_screen(page, person[2] - 20, person[3] - 20))
    assert rounded(box(page)) == [*map(round, start), round(person[2] - 20), round(person[3] - 20)]


def test_a_small_person_is_warned_of_in_amber_and_may_be_drafted(page: Page) -> None:
    draw(page, 330, 20, 360, 62)
    words = "The person is small here (42 px). Choose a nearer frame if there is one."
    page.locator("#mhint.warned", has_text=words).wait_for()
    page.locator("#insp .note.warned", has_text=words).wait_for()
    assert page.get_by_role("button", name="Draft 73 frames").get_attribute("aria-disabled") is None
    screens(page, "box-2-small")


def test_a_box_is_made_with_the_keyboard_alone(page: Page) -> None:
    page.get_by_role("button", name="Draw a box").focus()
    page.keyboard.press("Enter")
    until(lambda: page.evaluate("() => window.keypose.ui.tool") == "box", "the tool")
    page.keyboard.press("Alt+ArrowRight")
    left, top, right, bottom = box(page)
    page.keyboard.press("Alt+Shift+ArrowDown")
    assert box(page)[:3] == [left, top, right]
    assert box(page)[3] > bottom
    page.keyboard.press("ArrowRight")
    until(lambda: section(page, "view.frame") == 1, "the next frame")
    assert box(page)[0] == left


_LISTEN = """
() => {
  const send = WebSocket.prototype.send;
  window.sent = [];
  WebSocket.prototype.send = function (text) {
    window.sent.push(text);
    send.call(this, text);
  };
}
"""


def test_enter_sends_the_box_with_the_frame_it_lies_on(page: Page) -> None:
    page.evaluate(_LISTEN)
    draw(page, 330, 20, 480, 320)
    page.keyboard.press("Enter")
    sent = until(lambda: [text for text in page.evaluate("() => window.sent") if '"draft"' in text])
    message = json.loads(sent[0])
    assert message["frame"] == section(page, "view.frame")
    assert rounded(message["box"]) == [330, 20, 480, 320]
    assert page.evaluate("() => window.keypose.ui.tool") == "select"


_ESC_AT_ONCE = """async () => {
  const { watch } = await window.keypose.module('store/state.js');
  window.escaped = false;
  watch(['job'], () => {
    const { kind, state } = window.keypose.server.job ?? {};
    if (window.escaped || kind !== 'draft' || state !== 'running') return;
    window.escaped = true;
    document.activeElement?.blur(); // which Esc leaves first
    dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape' }));
  });
}"""


def test_esc_ends_a_draft_and_leaves_the_guide_open(page: Page) -> None:
    page.evaluate("async () => (await window.keypose.module('guide/guide.js')).openGuide()")
    page.locator(".coach").wait_for()
    page.evaluate(_ESC_AT_ONCE)
    draw(page, 322, 14, 508, 344)
    page.keyboard.press("Enter")
    until(lambda: page.evaluate("() => window.escaped"), "the draft to begin")
    until_state(page, "job.state", lambda state: state != "running")
    assert section(page, "draft") is None
    assert page.locator(".coach").is_visible()
    page.evaluate("async () => (await window.keypose.module('guide/guide.js')).closeGuide()")


def banner(page: Page) -> Locator:
    return page.locator("#mdraft")


def test_a_draft_is_reported_of_shown_on_the_timeline_and_undone(page: Page) -> None:
    page.evaluate("async () => (await window.keypose.module('guide/guide.js')).openGuide()")
    page.locator(".coach").wait_for()
    draw(page, 310, 10, 520, 350)
    page.keyboard.press("Enter")
    until(lambda: section(page, "draft"), "the draft", SECONDS_TO_DRAFT)
    until_counted(page, ".coach", 0)  # what to confirm leads on
    banner(page).wait_for()
    assert "Drafted 73 frames." in banner(page).inner_text()
    page.mouse.move(*spot(page, "head_top"))
    settled(page)
    assert "faded" not in str(banner(page).get_attribute("class")), "it is read beside the body"
    frames = [place["frame"] for place in section(page, "draft.proposals")]
    until_counted(page, "#tsvg .place", len(frames))
    until_counted(page, "#tsvg .drafted", 1)
    screens(page, "draft-1-result")

    ring = page.locator("#tsvg .place circle").nth(1).bounding_box()
    assert ring is not None
    page.mouse.move(ring["x"] + 4, ring["y"] + 4)
    page.locator("#tsvg .plate", has_text=f"Go to {frames[1]}").wait_for()
    page.mouse.down()
    page.mouse.up()
    until_state(page, "view.frame", lambda frame: frame == frames[1])
    banner(page).get_by_role("button", name="to confirm").click()
    review = page.get_by_role("region", name="Review")
    review.wait_for()
    page.keyboard.press("Delete")
    until_state(page, "keys.drafts", lambda drafts: frames[0] not in drafts)
    page.keyboard.press("Enter")
    page.get_by_text(f"Nothing is left to review at frame {frames[0]}.").wait_for()
    assert not review.get_by_text("Accepted").count()
    assert section(page, "keys.frames") == []
    page.keyboard.press("Control+z")
    until_state(page, "keys.drafts", lambda drafts: frames[0] in drafts)
    banner(page).wait_for()
    screens(page, "draft-3-in-review")
    page.keyboard.press("Escape")
    listed = page.get_by_role("group", name="Places to confirm").get_by_role("button")
    until(lambda: listed.count() == len(frames), "the places, back in the panel the review covered")
    listed.nth(0).click()
    until_state(page, "view.frame", lambda frame: frame == frames[0])
    page.keyboard.press("n")
    until_state(page, "view.frame", lambda frame: frame == frames[1])

    page.keyboard.press("k")
    until_counted(page, "#tsvg .place", len(frames) - 1)
    until(lambda: banner(page).count() == 0, "the banner to go with the first edit")
    screens(page, "draft-2-confirmed")
    page.keyboard.press("Control+z")
    banner(page).get_by_role("button", name="Undo draft").click()
    until_state(page, "draft", lambda draft: draft is None)
    until_counted(page, "#tsvg .drafted", 0)
    until(lambda: banner(page).count() == 0, "the banner to go")
