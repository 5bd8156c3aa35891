"""Keyframes and poses go over the clipboard: within a session, and wherever its text is taken."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page

from tests.browser.interaction import section, until, until_state
from tests.browser.shared import Desk, desk

KEYS = [0, 24, 48, 72]


@pytest.fixture(scope="module")
def shared(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    with desk(browser, tmp_path_factory.mktemp("copying")) as made:
        made.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        yield made


@pytest.fixture
def at(shared: Desk) -> Desk:
    """The page as if it had just been opened, with nothing selected."""
    shared.fresh()
    shared.page.keyboard.press("Escape")
    return shared


def _clipboard(page: Page) -> str:
    return str(page.evaluate("() => navigator.clipboard.readText()"))


def _copied(page: Page, keys: list[int]) -> str:
    page.evaluate("() => navigator.clipboard.writeText('')")
    page.evaluate("(keys) => { window.keypose.ui.timeKeys = keys; }", keys)
    page.keyboard.press("Control+c")
    until(lambda: _clipboard(page), "the text")
    return _clipboard(page)


def _go(desk: Desk, frame: int) -> None:
    desk.visitor.do(do="go", frame=frame)
    until_state(desk.page, "view.frame", lambda now: now == frame)


def test_keyframes_are_copied_as_text_and_pasted_from_the_playhead_on(at: Desk) -> None:
    page = at.page
    text = _copied(page, [0, 24])
    assert [key["after"] for key in json.loads(text)["keys"]] == [0, 24]
    _go(at, 30)
    page.keyboard.press("Control+v")
    until_state(page, "keys.frames", lambda now: now == [0, 24, 30, 48, 54, 72])
    until(lambda: page.evaluate("() => window.keypose.ui.timeKeys") == [30, 54], "the pasted ones")
    assert at.agreed("undo")["undo"] == "paste 2 keyframes"


def test_the_text_of_another_session_is_taken_and_any_other_text_is_not(at: Desk) -> None:
    page = at.page
    text = _copied(page, [])
    page.evaluate("() => navigator.clipboard.writeText('a poem')")
    _go(at, 30)
    page.keyboard.press("Control+v")
    page.get_by_text("The clipboard holds no pose or keyframes.").wait_for()
    page.evaluate("(text) => navigator.clipboard.writeText(text)", text)
    page.keyboard.press("Control+v")
    until_state(page, "keys.drafts", lambda now: now == [30])


def test_shift_v_pastes_onto_the_body_here(at: Desk) -> None:
    page = at.page
    _copied(page, [])
    _go(at, 48)
    root = at.agreed("pose")["root"]
    angles = section(page, "pose.angles.left_thigh")
    page.keyboard.press("Shift+V")
    until_state(page, "pose.angles.left_thigh", lambda now: now != angles)
    assert at.agreed("pose")["root"] == root


def test_what_is_in_the_way_is_replaced_only_with_its_button(at: Desk) -> None:
    page = at.page
    _copied(page, [0, 24])
    _go(at, 24)
    page.keyboard.press("Control+v")
    page.get_by_text("Frames 24 and 48 are already keyframes.").wait_for()
    assert at.agreed("undo")["undo"] is None
    page.get_by_role("button", name="Replace them").click()
    until_state(page, "undo.undo", lambda step: step == "paste 2 keyframes")
    assert at.agreed("keys")["frames"] == KEYS
