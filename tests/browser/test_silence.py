"""While the server does not answer a drag goes on, and a click waits: both count once it does."""

from __future__ import annotations

import os
import signal
import subprocess
from math import dist

from tests.browser.interaction import between, section, spot, until, until_state
from tests.browser.shared import Desk

OWN = True
"""Its server is its own."""
REACH_PX = 3.0


def silenced(process: subprocess.Popen[bytes]) -> None:
    """Stop a server, and wait until all its threads stand: the signal itself does not wait."""
    process.send_signal(signal.SIGSTOP)
    os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WNOWAIT)


def test_a_hand_that_is_dragged_in_silence_shows_where_it_goes_and_goes_there(at: Desk) -> None:
    page, process = at.page, at.keypose.process
    start = spot(page, "left_hand")
    goal = (start[0] + 40, start[1] - 50)
    silenced(process)
    try:
        page.mouse.move(*start)
        page.mouse.down()
        page.mouse.move(start[0] + 20, start[1] - 20, steps=4)
        page.get_by_text("Connection lost.").wait_for()
        page.mouse.move(*goal, steps=4)
        preview = page.locator("#main .offline")
        preview.get_by_text("Preview").wait_for()

        def middle() -> tuple[float, float]:
            box = preview.locator("circle.spot").bounding_box()
            assert box is not None
            return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

        until(lambda: dist(middle(), goal) < REACH_PX, "the preview below the pointer")
        page.mouse.up()
        assert preview.get_by_text("Preview").is_visible()  # it waits to be sent
        assert dist(spot(page, "left_hand"), start) < REACH_PX  # the body is as it was last seen
    finally:
        process.send_signal(signal.SIGCONT)
    until(lambda: dist(spot(page, "left_hand"), goal) < REACH_PX, "the hand at its place")
    until(lambda: page.locator("#main .offline circle").count() == 0, "the end of the preview")
    until(lambda: section(page, "undo.undo") is not None, "one step")
    page.keyboard.press("Control+z")
    until(lambda: dist(spot(page, "left_hand"), start) < REACH_PX, "the hand where it was")
    until_state(page, "undo.undo", lambda step: step is None)


def test_a_click_in_silence_selects_the_part_once_the_server_has_said_which(at: Desk) -> None:
    page, process = at.page, at.keypose.process
    at.visitor.do(do="select", part="head")
    at.agreed("view")
    place = between(page, "right_shin", "right_foot")
    silenced(process)
    try:
        page.mouse.click(*place)
        page.get_by_text("Connection lost.").wait_for()
        assert section(page, "view.selected") == "head"
    finally:
        process.send_signal(signal.SIGCONT)
    until_state(page, "view.selected", lambda part: part == "right_shin")


def test_a_click_on_a_handle_is_not_undone_by_the_late_answer_to_the_one_before(at: Desk) -> None:
    page, process = at.page, at.keypose.process
    body, handle = between(page, "right_shin", "right_foot"), spot(page, "left_hand")
    silenced(process)
    try:
        page.mouse.click(*body)
        page.mouse.click(*handle)
    finally:
        process.send_signal(signal.SIGCONT)
    until_state(page, "view.selected", lambda part: part == "left_hand")
    assert at.agreed("view")["selected"] == "left_hand"
