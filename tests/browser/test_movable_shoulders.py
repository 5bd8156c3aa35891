"""Shoulders that move, switched on in the Body tab; and the filter in the Export menu."""

from __future__ import annotations

import pytest

from tests.browser.interaction import drag, screens, spot, until
from tests.browser.shared import Desk

SIZE = (1440, 900)


def test_shoulders_move_once_they_are_asked_to_and_arms_keep_theirs(shared: Desk) -> None:
    shared.fresh()
    page = shared.page
    page.get_by_role("tab", name="Body").click()
    box = page.get_by_role("checkbox", name="Movable shoulders")
    until(lambda: box.get_attribute("aria-checked") == "false", "the switch")
    box.click()
    until(lambda: box.get_attribute("aria-checked") == "true", "the switch")
    before = shared.agreed("pose")["angles"]
    assert before["left_clavicle"] == pytest.approx([0, 0, 0], abs=1e-6)
    screens(page, "shoulders-1-body-tab")
    shared.visitor.do(do="select", part="left_clavicle")
    page.get_by_role("tab", name="Part").click()
    screens(page, "shoulders-2-part-tab")
    shoulder = spot(page, "left_upper_arm")
    page.keyboard.down("Alt")  # or the hand would stay where it is
    drag(page, shoulder, (shoulder[0], shoulder[1] - 20))
    page.keyboard.up("Alt")
    screens(page, "shoulders-3-raised")
    raised = shared.agreed("pose")["angles"]
    assert abs(raised["left_clavicle"][2]) > 3
    for part in ("chest", "left_upper_arm", "left_forearm"):
        assert raised[part] == pytest.approx(before[part], abs=1e-6), part
    hand = spot(page, "left_hand")
    drag(page, hand, (hand[0] + 15, hand[1] - 15))
    reached = shared.agreed("pose")["angles"]
    assert reached["left_clavicle"] == pytest.approx(raised["left_clavicle"], abs=1e-6)
    assert reached["left_forearm"] != pytest.approx(raised["left_forearm"], abs=1e-3)


def test_the_export_menu_says_that_motion_is_filtered(shared: Desk) -> None:
    shared.fresh()
    page = shared.page
    page.get_by_role("button", name="Export").click()
    box = page.get_by_role("menuitemcheckbox", name="Low-pass filter, 6 Hz")
    until(lambda: box.get_attribute("aria-checked") == "false", "the switch")
    box.click()
    until(lambda: box.get_attribute("aria-checked") == "true", "the switch")
    screens(page, "export-filter")
    page.keyboard.press("Escape")
