"""Nothing moves under a pressed pointer, and nothing over a picture takes a handle's press."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from tests.browser.interaction import section
from tests.browser.random_states import RandomStates
from tests.browser.shared import Desk, desk

LAYOUTS = 25
STATES = 8

FEED = "(news) => window.steady.feed(news)"

SET_UP = (Path(__file__).parent / "steady.js").read_text()

FIXED = """() => {
  const fixed = '#top > .ib, #top > .holder, #top > .switch, #tr > .ib, #tr > .fbox, .sug .pri';
  const name = ({ dataset, className }) => dataset.action ?? dataset.menu ?? className;
  return [...document.querySelectorAll(fixed)].map((element) =>
    [name(element), element.getBoundingClientRect().right]);
}"""


@pytest.fixture(scope="module")
def shared(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    with desk(browser, tmp_path_factory.mktemp("steady"), late=False) as made:
        made.page.emulate_media(reduced_motion="reduce")  # what slides is where it will be
        # What is pressed here is not done.
        made.page.evaluate(SET_UP)
        made.page.evaluate(
            """() => addEventListener('click', (event) => {
              event.preventDefault();
              event.stopImmediatePropagation();
            }, true)"""
        )
        yield made


@pytest.mark.parametrize("seed", range(LAYOUTS))
def test_no_control_moves_under_a_pressed_pointer_and_no_handle_is_covered(
    shared: Desk, seed: int
) -> None:
    page, states = shared.page, RandomStates(shared.page, seed)
    page.set_viewport_size(states.size())
    cases = [states.case() for _ in range(STATES)]
    assert page.evaluate("(cases) => window.steady.run(cases)", cases) == [], page.viewport_size


@pytest.mark.parametrize("width", [320, 480, 600, 720, 1024, 1280, 1440, 1920])
def test_what_comes_by_itself_has_its_room_in_the_bars(shared: Desk, width: int) -> None:
    page, states = shared.page, RandomStates(shared.page, width)
    page.set_viewport_size({"width": width, "height": 800})
    page.evaluate(FEED, states.next() | {"ui": {"tab": "part", "layout": "main", "toasts": []}})
    before = dict(page.evaluate(FIXED))
    for _ in range(10):
        page.evaluate(FEED, states.next() | {"toasts": []})
        now = dict(page.evaluate(FIXED))
        moved = {n: (before[n], now[n]) for n in before.keys() & now.keys() if before[n] != now[n]}
        assert moved == {}


def test_what_waited_for_the_release_is_shown_after_it(shared: Desk) -> None:
    page, states = shared.page, RandomStates(shared.page, 1)
    page.set_viewport_size({"width": 1280, "height": 720})
    page.evaluate(FEED, states.next() | {"ui": {"toasts": [], "line": None, "tab": "part"}})
    page.get_by_role("tab", name="Body").hover()
    page.mouse.down()
    running = {"state": "running", "title": "Tracking 0–24", "words": "", "percent": 3}
    news = {"job": running | {"seconds_left": None, "kind": "track"}}
    page.evaluate(FEED, {"sections": news, "ui": {}, "toasts": [], "theme": "dark"})
    assert section(page, "job.title") != "Tracking 0–24" or section(page, "job.percent") != 3
    page.mouse.up()
    page.locator("#top .job", has_text="Tracking 0–24").wait_for()


# --- the top bar in narrow windows

IN_THE_BAR = """() => [
  ...document.querySelectorAll('#top button, #top .job, #top .chip, #top .saved'),
].flatMap((element) => {
  const { left, right } = element.getBoundingClientRect();
  const words = element.getAttribute('aria-label') ?? element.className;
  return left < right ? [[words, left, right, element.matches('button')]] : [];
}).sort((a, b) => a[1] - b[1])"""


@pytest.mark.parametrize("width", [320, 360, 414, 480, 540, 600, 720, 800, 900, 1100, 1366])
def test_the_top_bar_fits_into_any_window(shared: Desk, width: int) -> None:
    page, states = shared.page, RandomStates(shared.page, width)
    page.set_viewport_size({"width": width, "height": 700})
    for _ in range(10):
        page.evaluate(FEED, states.next() | {"toasts": []})
        found = page.evaluate(IN_THE_BAR)
        assert all(left >= 0 and right <= width for _, left, right, _ in found), found
        buttons = [item for item in found if item[3]]
        assert all(a[2] <= b[1] + 1 for a, b in pairwise(buttons)), buttons


STOOD = "12 pins on the floor, 10 of them new; 9 keyframes give way in depth. The camera is level."


@pytest.mark.parametrize(
    ("width", "words", "is_cut"),
    [(480, STOOD, True), (768, STOOD, True), (1280, STOOD, True), (1440, "3 good", False)],
)
def test_what_a_job_says_at_its_end_is_read_in_any_window(
    shared: Desk, width: int, words: str, is_cut: bool
) -> None:
    page, states = shared.page, RandomStates(shared.page, 4)
    page.set_viewport_size({"width": width, "height": 800})
    job = {"state": "running", "title": "Standing on the floor", "words": "", "kind": "space"}
    page.evaluate(FEED, states.next() | {"ui": {"toasts": [], "line": None}, "toasts": []})
    for news in ({}, {"state": "done", "words": words}):
        page.evaluate(FEED, {"sections": {"job": job | news}, "ui": {}, "toasts": []})
    page.locator("#top .job.end .mut", has_text=words).wait_for(state="attached")
    found = page.locator("#toasts .toast", has_text=words)
    if is_cut:
        found.wait_for()
    assert found.count() == is_cut


def test_the_button_says_what_is_left_to_track(shared: Desk) -> None:
    page, states = shared.page, RandomStates(shared.page, 5)
    page.set_viewport_size({"width": 1440, "height": 800})
    ended = {"state": "done", "title": "Tracked", "words": "", "kind": "track"}
    whole = {"ui": {"toasts": [], "span": {"first": None, "last": None}}, "toasts": []}
    page.evaluate(FEED, states.next() | whole)
    segments = section(page, "segments")
    for state, words in (("none", "Track"), ("outdated", "Track changed"), ("good", "All tracked")):
        now = [each | {"state": state, "percent": None, "unfinished": False} for each in segments]
        sections = {"segments": now, "job": ended, "surface": None}
        page.evaluate(FEED, whole | {"sections": sections})
        shown = page.locator("#top .split .either > .shown")
        shown.get_by_text(words, exact=True).wait_for()
        assert shown.count() == 1


def test_a_tip_says_what_the_control_under_the_resting_pointer_does_now(shared: Desk) -> None:
    page, states = shared.page, RandomStates(shared.page, 2)
    page.set_viewport_size({"width": 1280, "height": 720})
    news = states.next() | {"ui": {"toasts": [], "line": None, "connected": True}, "toasts": []}
    for undo, words in ((None, "Nothing to undo"), ("turn chest", "Undo turn chest")):
        page.evaluate(FEED, news | {"sections": {"undo": {"undo": undo, "redo": None}}})
        if undo is None:
            page.locator("#top [data-action=undo]").hover()
        page.locator(".tip", has_text=words).wait_for()
