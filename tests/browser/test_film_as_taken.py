"""How a film was taken, said in the page: by the command search, in the Camera tab, undoable."""

from __future__ import annotations

import pytest

from tests.browser.interaction import answered, until, until_state
from tests.browser.shared import Desk
from tests.browser.test_everyone import focus, typed


def test_slow_motion_is_said_where_the_command_search_leads(shared: Desk) -> None:
    shared.fresh()
    page = shared.page
    page.keyboard.press("Control+k")
    page.locator("#search[open] input").fill("slow motion")
    first = page.locator("#search [role=option]").first
    until(lambda: "Recording rate" in (first.text_content() or ""), "the setting found first")
    page.keyboard.press("Enter")
    page.get_by_role("region", name="Video").wait_for()
    focus(page, "Recorded at")
    typed(page, "240", "file.fps", lambda fps: fps == 240)
    page.get_by_text("The file shows it at 30 fps, 8 times slower.").wait_for()
    page.get_by_text("240 fps").wait_for()
    answered(page)
    assert shared.agreed("file")["duration_s"] == pytest.approx(73 / 240)
    page.keyboard.press("Escape")
    page.keyboard.press("Control+z")
    until_state(page, "file.fps", lambda fps: fps == 30)
