"""Playing the film: it goes forward only, and ends where it should, however late the server is."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from tests.app.serving import Keypose, Visitor
from tests.browser.interaction import answered, screen, section, until, until_state
from tests.browser.shared import admit, opened, served

LATE = """
const usual = Object.getOwnPropertyDescriptor(WebSocket.prototype, 'onmessage');
Object.defineProperty(WebSocket.prototype, 'onmessage', {
  ...usual,
  set(heard) {
    usual.set.call(this, (event) => setTimeout(() => heard(event), 300));
  },
});
"""
"""Whatever the server says is heard a third of a second later, in its order."""

RECORD = """
() => {
  const canvas = document.querySelector('#main canvas.vid');
  window.seen = [];
  new MutationObserver(() => window.seen.push(Number(canvas.dataset.frame)))
    .observe(canvas, { attributeFilter: ['data-frame'] });
}
"""


@pytest.fixture(scope="module")
def keypose(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Keypose]:
    with served(tmp_path_factory.mktemp("playing")) as (running, _):
        yield running


def _played(page: Page) -> list[int]:
    """The pictures that were seen from here to the end."""
    page.evaluate(RECORD)
    page.keyboard.press("Space")  # it plays by now: where few frames are left that is soon over
    until(lambda: not page.evaluate("() => window.keypose.ui.playing"), "the end")
    return list(page.evaluate("() => window.seen"))


def _go(keypose: Keypose, page: Page, frame: int) -> None:
    """Begin at a frame, with its picture."""
    visitor = Visitor(keypose)
    visitor.do(do="go", frame=frame)
    visitor.leave()
    until_state(page, "view.frame", lambda now: now == frame)
    page.wait_for_selector(f"#main canvas.vid[data-frame='{frame}']")


@pytest.mark.parametrize("late", [False, True])
def test_pictures_go_forward_only_and_end_with_the_last(
    browser: Browser, keypose: Keypose, late: bool
) -> None:
    with admit(browser, drawn=False) as context:
        if late:
            context.add_init_script(LATE)
        page = opened(context, keypose)
        last = section(page, "file.frames") - 1
        _go(keypose, page, last - 20)
        seen = _played(page)
        assert seen == sorted(seen)
        assert seen[-1] == last
        until_state(page, "view.frame", lambda frame: frame == last)
        answered(page)
        assert section(page, "view.frame") == last
        again = _played(page)  # from the end it begins anew
        assert again == sorted(again)
        assert again[-1] == last


def test_playing_ends_though_the_last_picture_cannot_be_had(
    browser: Browser, keypose: Keypose
) -> None:
    visitor = Visitor(keypose)
    last = visitor.seen["file"]["frames"] - 1
    visitor.do(do="go", frame=last - 10)  # else the page opens with the last one
    visitor.leave()
    with admit(browser, drawn=False) as context:
        context.route(f"**/frame/{last}.jpg*", lambda route: route.fulfill(status=404))
        page = opened(context, keypose)
        assert last not in _played(page)


def _ui(page: Page, name: str) -> Any:
    return page.evaluate(f"() => window.keypose.ui.{name}")


def test_a_loop_stays_between_in_and_out_point_until_it_is_stopped(
    browser: Browser, keypose: Keypose
) -> None:
    with admit(browser, drawn=False) as context:
        page = opened(context, keypose)
        _go(keypose, page, 10)
        page.keyboard.press("Shift+I")
        _go(keypose, page, 16)
        page.keyboard.press("Shift+O")
        page.keyboard.press("Shift+L")
        page.evaluate(RECORD)
        page.keyboard.press("Space")

        def has_turned() -> bool:
            seen: list[int] = page.evaluate("() => window.seen")
            return sum(a > b for a, b in pairwise(seen)) >= 2

        until(has_turned, "the third time round")
        screen(page, "timeline-loop")
        page.keyboard.press("k")  # while it plays: no keyframe is added
        until(lambda: not _ui(page, "playing"), "the end")
        answered(page)
        seen = page.evaluate("() => window.seen")
        assert set(seen) <= set(range(10, 17))
        assert 10 not in section(page, "keys.frames")
        page.reload()
        page.wait_for_selector("html[data-ready]", state="attached")
        until(lambda: _ui(page, "span.first") == 10, "the in point")
        assert _ui(page, "span.last") == 16
        assert _ui(page, "loop") is True
        page.keyboard.press("Shift+X")
        until(lambda: _ui(page, "span.first") is None, "nothing chosen")


def test_backward_pictures_go_backward_only_and_l_turns_them_round(
    browser: Browser, keypose: Keypose
) -> None:
    with admit(browser, drawn=False) as context:
        page = opened(context, keypose)
        live = section(page, "view.live")
        _go(keypose, page, 14)
        page.evaluate(RECORD)
        page.keyboard.press("Shift+Space")
        until(lambda: not _ui(page, "playing"), "the end")
        seen = page.evaluate("() => window.seen")
        assert seen == sorted(seen, reverse=True)
        assert seen[-1] == 0
        page.keyboard.press("Shift+L")  # round and round: it does not end before it is turned
        page.keyboard.press("Space")
        page.keyboard.press("j")
        until(lambda: _ui(page, "shuttle") == -1, "backward")
        page.keyboard.press("l")
        until(lambda: _ui(page, "shuttle") == 1, "forward")
        page.keyboard.press("k")
        until(lambda: not _ui(page, "playing"), "the end")
        answered(page)
        assert section(page, "view.live") == live, "while it plays L is no switch"


def test_the_out_point_is_dragged_on_the_ruler_and_snaps_to_keyframes(
    browser: Browser, keypose: Keypose
) -> None:
    with admit(browser, drawn=False, size=(1440, 900)) as context:
        page = opened(context, keypose)
        _go(keypose, page, 30)
        page.keyboard.press("Shift+O")
        until(lambda: _ui(page, "span.last") == 30, "the out point")
        box = page.locator("#tsvg").bounding_box()
        assert box is not None
        each = (box["width"] - 138 - 26) / (section(page, "file.frames") - 1)
        bracket = box["x"] + 138 + 30 * each + 4, box["y"] + 10
        page.mouse.move(*bracket)
        page.mouse.down()
        page.mouse.move(bracket[0] + 18 * each + 2, bracket[1], steps=5)
        page.mouse.up()
        until(lambda: _ui(page, "span.last") == 48, "the keyframe near it")
        assert section(page, "view.frame") == 30, "the ruler was not scrubbed"
        page.mouse.click(bracket[0] + 18 * each, bracket[1], button="right")
        page.get_by_role("menuitem", name="Clear the out point").click()
        until(lambda: _ui(page, "span.last") is None, "no out point")
