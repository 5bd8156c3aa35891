"""With Live on the motion follows the hand at every move, and stays where the hand lets go."""

from __future__ import annotations

from typing import Any

import numpy as np
from playwright.sync_api import Page

from tests.browser.interaction import screen, section, spot, until_state
from tests.browser.shared import Desk

_DOTS = """
() => [...document.querySelectorAll('#main g.trail circle')].map((dot) => (
  [Number(dot.getAttribute('cx')), Number(dot.getAttribute('cy'))]
))
"""


def dots(page: Page) -> np.ndarray:
    """(N, 2) where the page has the trail's dots in the large view."""
    return np.array(page.evaluate(_DOTS))


def at_36(trail: dict[str, Any]) -> np.ndarray:
    """Where the trail is between the keyframes 24 and 48, which nobody has tracked."""
    return np.array(next(p for frame, *p in trail["points"] if frame == 36))


DONE = ("good", "check", "lost")


def test_the_trail_follows_a_dragged_hand_at_each_of_its_moves(at: Desk) -> None:
    page = at.page
    at.visitor.do(do="go", frame=12)
    page.keyboard.press("Shift+T")
    until_state(page, "job.state", lambda state: state == "done", 120)
    at.visitor.do(do="go", frame=24)
    at.visitor.do(do="select", part="left_hand")
    at.visitor.do(do="display", trail=True)
    at.visitor.do(do="live", on=True)
    at.agreed("view")
    until_state(page, "trail", lambda trail: bool(trail) and trail["part"] == "left_hand")
    before, (x, y) = dots(page), spot(page, "left_hand")
    page.mouse.move(x, y)
    page.mouse.down()
    trails: list[Any] = [section(page, "trail")["points"]]
    for step in range(1, 4):
        page.mouse.move(x + 8 * step, y - 8 * step)
        until_state(page, "trail", lambda trail: trail["points"] != trails[-1])
        trails.append(section(page, "trail")["points"])
    assert section(page, "pose.stroke") is not None
    apart = np.linalg.norm(dots(page) - before, axis=1)
    assert apart[[0, -1]].max() < 3.0, "both other keyframes stay, a frame beside these dots"
    assert apart.max() > 10.0
    guessed = at_36(section(page, "trail"))

    def is_found(trail: dict[str, Any]) -> bool:
        return float(np.linalg.norm(at_36(trail) - guessed)) > 0.05

    until_state(page, "trail", is_found, 120)
    assert section(page, "job.state") != "running", "nobody asked for a job"
    screen(page, "live-drag")
    page.mouse.up()
    until_state(page, "pose.stroke", lambda stroke: stroke is None)
    assert is_found(section(page, "trail")), "until that is tracked for the pose it ended with"
    until_state(page, "segments", lambda found: all(s["state"] in DONE for s in found[:2]), 120)
    assert is_found(section(page, "trail"))
    at.visitor.do(do="live", on=False)
