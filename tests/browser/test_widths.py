"""The page in half a window, and in a small one at 200 %: nothing overlaps, all can be pressed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from tests.browser.interaction import faded, section
from tests.browser.shared import desk
from tests.browser.test_everyone import SET_UP

TARGET_PX = 24
"""The least width and height of what is pressed.  WCAG 2.2, 2.5.8"""

SUGGESTION = {
    "frame": 83, "title": "Add a keyframe at 83", "detail": "Right forearm may be wrong, 71–96",
    "kind": "key", "ahead": "forward",
}  # fmt: skip

BARS = "#top, #stage > :not(#insp), .insp-tag, #tr, #status"
"""Where no list scrolls, so that all that is there is seen at once."""

CONTROLS = """
(region) => {
  // Where a handle lies under a bar, the bar has a hole, wherever the body is.
  document.querySelectorAll('.glass').forEach((bar) => { bar.style.clipPath = 'none'; });
  const all = [...document.querySelectorAll(region)].flatMap((one) =>
    [...one.querySelectorAll('button, label.fbox, [role=slider], .tx b, .count')]);
  const controls = all.filter((one) => one.checkVisibility({visibilityProperty: true}))
    .map((one) => [one, one.getBoundingClientRect()]).filter(([, box]) => box.width > 0);
  const said = (one) => one.ariaLabel || one.textContent.trim() || one.className;
  const pressed = (one) => one.matches('button, label, [role=slider]');
  const found = [];
  for (const [one, {left, top, width, height}] of controls) {
    const hit = document.elementFromPoint(left + width / 2, top + height / 2);
    if (!one.contains(hit) && !one.disabled) found.push(`${said(one)} cannot be reached`);
    if (pressed(one) && Math.min(width, height) < LEAST)
      found.push(`${said(one)} is ${width} by ${height}`);
    if (one.matches('.tx b') && one.offsetWidth > one.parentElement.clientWidth)
      found.push(`${said(one)} is cut`);
  }
  controls.forEach(([one, a], i) => controls.slice(i + 1).forEach(([other, b]) => {
    const apart = a.right <= b.left + 0.5 || b.right <= a.left + 0.5
      || a.bottom <= b.top + 0.5 || b.bottom <= a.top + 0.5;
    if (!apart && !one.contains(other)) found.push(`${said(one)} overlaps ${said(other)}`);
  }));
  return [controls.length, found];
}
""".replace("LEAST", str(TARGET_PX))


@pytest.fixture(scope="module")
def page(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    with desk(browser, tmp_path_factory.mktemp("widths")) as made:
        made.page.evaluate(SET_UP)
        yield made.page


def feed(page: Page, sections: dict[str, Any], ui: dict[str, Any]) -> None:
    news = {"sections": sections, "ui": ui, "toasts": [], "theme": "dark"}
    page.evaluate("(news) => window.steady.feed(news)", news)


def busy(page: Page) -> dict[str, Any]:
    """What fills the bar most: a suggestion with two buttons, a segment of each verdict."""
    states = ("good", "check", "lost")
    segments = [
        segment | {"state": states[i % 3], "words": "", "short": ""}
        for i, segment in enumerate(section(page, "segments"))
    ]
    return {"suggest": SUGGESTION, "segments": segments}


def complaints(page: Page, size: tuple[int, int], region: str) -> list[str]:
    page.set_viewport_size({"width": size[0], "height": size[1]})
    faded(page)
    count, found = page.evaluate(CONTROLS, region)
    assert count > 5
    return [f"{size[0]} × {size[1]}: {words}" for words in found]


def test_at_every_width_nothing_in_the_bars_overlaps_or_is_cut(page: Page) -> None:
    feed(page, busy(page), {"layout": "main"})
    sizes = [(width, 800) for width in (*range(700, 1260, 20), 911, 1366)] + [(683, 313)]
    found = [complaint for size in sizes for complaint in complaints(page, size, BARS)]
    assert found == [], "\n".join(found)


def proposed() -> dict[str, Any]:
    """Pins that wait to be accepted, or the feet to be stood: three buttons."""
    pin = {"part": "left_foot", "label": "Left foot", "landmarks": ["left_heel", "left_toe"],
           "first": 4, "last": 20}  # fmt: skip
    return {"proposed_pins": [pin | {"first": n, "last": n + 1} for n in range(0, 24, 2)]}


def contradicted() -> dict[str, Any]:
    """Pins against which keyframes stand."""
    found = {
        "kind": "pin",
        "part": "left_foot",
        "first": 4,
        "last": 20,
        "go": 8,
        "cm": 20.0,
        "keyframes": [8, 20],
        "words": "Left foot is pinned 20 cm from where keyframe 8 is",
    }
    return {"proposed_pins": [], "space": [found]}


@pytest.mark.parametrize("waiting", [proposed, contradicted])
def test_what_stands_beside_standing_on_the_floor_is_not_cut(page: Page, waiting: Any) -> None:
    feed(page, {**busy(page), **waiting()}, {"layout": "main"})
    assert page.locator("#tr .sug").get_by_role("button", name="Stand on the floor").count() == 1
    sizes = [(width, 800) for width in (*range(700, 1260, 20), 911, 1366)] + [(683, 313)]
    found = [complaint for size in sizes for complaint in complaints(page, size, BARS)]
    feed(page, {"proposed_pins": [], "space": []}, {})
    assert found == [], "\n".join(found)


@pytest.mark.parametrize("layout", ["main", "quad"])
@pytest.mark.parametrize("height", [313, 360, 420, 480, 560, 640, 768])
def test_in_a_low_window_all_tools_can_be_pressed(page: Page, layout: str, height: int) -> None:
    feed(page, {}, {"layout": layout})
    assert complaints(page, (683, height), "#tools") == []
    assert page.locator("#tools button").count() == 6
