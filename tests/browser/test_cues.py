"""What tracking compares the body with, as a person chooses it in the Track tab."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page

from tests.app.serving import ROOT, Keypose
from tests.browser.interaction import screen, screens, section, until, until_state
from tests.browser.shared import Desk, admit, opened

SIZE = (1440, 900)


@pytest.fixture
def at(shared: Desk) -> Desk:
    """The Track tab as it is when the page has just been opened."""
    shared.fresh()
    shared.visitor.do(do="settings", cues=["brightness", "keypoints"])
    shared.agreed("settings")
    shared.page.get_by_role("tab", name="Track").click()
    return shared


def cue(page: Page, name: str) -> Locator:
    return page.get_by_role("region", name="Cues").get_by_role("switch", name=name)


def test_a_cue_is_switched_off_by_mouse_or_keyboard_and_undone(at: Desk) -> None:
    page = at.page
    screen(page, "cues-1-both")
    cue(page, "Keypoints").click()
    until_state(page, "settings.cues", lambda cues: cues == ["brightness"])
    page.keyboard.press("Control+z")
    until_state(page, "settings.cues", lambda cues: cues == ["brightness", "keypoints"])
    other = cue(page, "Brightness")
    until(lambda: other.get_attribute("aria-disabled") != "true", "the switch of the other cue")
    other.focus()
    page.keyboard.press("Enter")
    until_state(page, "settings.cues", lambda cues: cues == ["keypoints"])
    at.agreed("undo")
    at.visitor.do(do="undo")
    at.agreed("settings")


def test_a_network_that_is_not_here_is_named_with_the_command_that_adds_it(at: Desk) -> None:
    page = at.page
    at.visitor.do(do="settings", network="my-rtmw")
    cues = page.get_by_role("region", name="Cues")
    cues.get_by_text(
        "my-rtmw is not installed: run keypose models add my-rtmw --from FILE --sha256 DIGEST"
    ).wait_for()
    screen(page, "cues-3-missing-network")
    cues.get_by_role("button", name="Network").click()
    page.get_by_role("option", name="MoveNet Thunder + BlazePose").click()
    cues.get_by_text("is not installed").wait_for(state="detached")
    assert [each["id"] for each in at.agreed("networks") if each["chosen"]] == ["thunder"]


def test_the_last_cue_stays_on_and_says_why(at: Desk) -> None:
    page = at.page
    cue(page, "Keypoints").click()
    until_state(page, "settings.cues", lambda cues: cues == ["brightness"])
    last = cue(page, "Brightness")
    until(lambda: last.get_attribute("aria-disabled") == "true", "the last cue")
    assert last.get_attribute("title") == "At least one cue stays on"
    last.click(force=True)
    page.locator(".refusal", has_text="At least one cue stays on.").wait_for()
    screen(page, "cues-2-last")
    assert at.agreed("settings")["cues"] == ["brightness"]


def test_the_published_method_uses_no_keypoints(at: Desk) -> None:
    page = at.page
    at.visitor.do(do="settings", method="paper")
    page.get_by_text("Not in the published method").first.wait_for()
    assert cue(page, "Keypoints").get_attribute("aria-checked") == "false"
    cue(page, "Keypoints").click(force=True)
    cue(page, "Brightness").click(force=True)
    screens(page, "cues-3-paper")
    assert at.agreed("settings")["cues"] == ["brightness", "keypoints"]


def test_of_a_box_there_are_no_keypoints(browser: Browser, tmp_path: Path) -> None:
    place = tmp_path / "box"
    shutil.copytree(ROOT / "sample_videos" / "box", place)
    given = (str(place / "session.json"), "--workspace", str(tmp_path / "workspace"))
    with Keypose(*given) as keypose, admit(browser, drawn=False) as context:
        page = opened(context, keypose)
        page.get_by_role("tab", name="Track").click()
        off = cue(page, "Keypoints")
        assert off.get_attribute("title") == "Needs a person’s body"
        assert off.get_attribute("aria-checked") == "false"
        silhouette = cue(page, "Silhouette").get_attribute("title")
        assert silhouette == "Needs a person’s body, or a camera that stands still or turns"
        assert cue(page, "Brightness").get_attribute("aria-checked") == "true"
        screen(page, "cues-4-box")
        assert section(page, "settings.cues") == ["brightness"]
