"""Menus where the hand is, the command search, the history as a list, notes at frames."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field

from playwright.sync_api import Locator, Page, WebSocketRoute

from tests.browser.interaction import (
    Spot,
    copied_to_clipboard,
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


def _menu(page: Page) -> Locator:
    menu = page.locator("#tmenu .menu")
    menu.wait_for()
    settled(page)
    return menu


def _corner(page: Page) -> Spot:
    """A place of the picture where no part is, near its lower right end."""
    box = page.locator("#main").bounding_box()
    assert box is not None
    return box["x"] + box["width"] - 20, box["y"] + box["height"] - 70


def _focused(page: Page) -> str:
    words: str = page.evaluate("() => document.activeElement.querySelector('.ml')?.textContent")
    return words


def _gone(page: Page, selector: str) -> None:
    until_counted(page, selector, 0)


def _search(page: Page, words: str) -> Locator:
    """Open the search, type, and the first that was found."""
    page.keyboard.press("Control+k")
    page.locator("#search[open] input").wait_for()
    page.keyboard.type(words)
    page.wait_for_function("(w) => document.querySelector('#search input').value === w", arg=words)
    settled(page)
    return page.locator("#search .hit").first


def _on_ruler(page: Page, frame: int) -> Spot:
    """Where a note at this frame stands."""
    box = page.locator("#tsvg").bounding_box()
    assert box is not None
    first, last = 138.0, box["width"] - 26.0
    at = first + (last - first) * frame / (section(page, "file.frames") - 1)
    return box["x"] + at, box["y"] + 17


def _noted(page: Page, frame: int, words: str) -> None:
    _search(page, str(frame))
    page.keyboard.press("Enter")
    until_state(page, "view.frame", lambda now: now == frame)
    page.keyboard.press("Shift+M")
    page.locator(".notecard textarea").wait_for()
    page.keyboard.type(words)
    page.keyboard.press("Enter")
    until_state(page, "notes", lambda notes: {"frame": frame, "text": words} in notes)


@dataclass
class Held:
    """What the server replies to a tab's questions, until it is let through."""

    asked: set[int] = field(default_factory=set)
    replies: dict[int, Callable[[], None]] = field(default_factory=dict)

    def hold(self, line: WebSocketRoute) -> None:
        server = line.connect_to_server()

        def from_page(sent: str | bytes) -> None:
            if "ask" in (message := json.loads(sent)):
                self.asked.add(message["id"])
            server.send(sent)

        def from_server(received: str | bytes) -> None:
            message = json.loads(received)
            if message["t"] == "reply":
                self.replies[message["id"]] = lambda: line.send(received)
            else:
                line.send(received)

        line.on_message(from_page)
        server.on_message(from_server)

    def let_through(self, page: Page) -> None:
        """All replies to what was asked until now, which is something."""
        settled(page)
        until(lambda: settled(page) or self._is_answered, "the replies")
        for number in sorted(self.asked):
            self.replies.pop(number)()
        self.asked.clear()

    @property
    def _is_answered(self) -> bool:
        return bool(self.asked) and self.asked == self.replies.keys()


def test_a_menu_whose_place_is_known_late_does_not_open_over_what_is_done_meanwhile(
    at: Desk,
) -> None:
    page, held = at.page.context.new_page(), Held()
    page.route_web_socket("**/events", held.hold)
    page.goto(at.keypose.address)
    page.wait_for_selector("#main canvas.vid[data-frame]")
    for acts_meanwhile in (True, False):
        page.mouse.click(*_corner(page), button="right")
        if acts_meanwhile:
            page.keyboard.press("ArrowRight")
        held.let_through(page)
        if acts_meanwhile:  # what answers this comes after the replies
            page.keyboard.press("ArrowRight")
            until_state(page, "view.frame", lambda frame: frame == 2)
        until_counted(page, "#tmenu .menu", 0 if acts_meanwhile else 1)
    page.close()


def test_the_picture_has_a_menu_at_the_pointer_that_keys_alone_can_use(at: Desk) -> None:
    page = at.page
    page.mouse.click(*_corner(page), button="right")
    box = _menu(page).bounding_box()
    assert box is not None
    assert box["x"] >= 8
    assert box["y"] >= 8
    assert box["x"] + box["width"] <= SIZE[0]
    assert box["y"] + box["height"] <= SIZE[1]
    screens(page, "menu-picture")
    page.keyboard.press("Escape")
    _gone(page, "#tmenu .menu")
    page.mouse.click(*_corner(page), button="right")
    _menu(page)
    page.keyboard.press("ArrowDown")
    page.keyboard.press("u")
    assert _focused(page) == "Use tracked pose"
    reason = page.locator("#tmenu .mi:focus")
    assert reason.get_attribute("aria-disabled") == "true"
    assert "not tracked yet" in (reason.text_content() or "")
    page.keyboard.press("Enter")
    assert page.locator("#tmenu .menu").count() == 1, "what cannot be done does nothing"
    page.keyboard.press("Home")
    page.keyboard.press("c")
    assert _focused(page) == "Copy pose"
    copied_to_clipboard(page, lambda: page.keyboard.press("Enter"))
    _gone(page, "#tmenu .menu")


def test_the_menu_of_a_part_is_about_that_part_by_mouse_and_by_key(at: Desk) -> None:
    page = at.page
    page.mouse.click(*spot(page, "left_foot"), button="right")
    words = _menu(page).text_content() or ""
    assert "Pin here from this frame" in words
    assert page.locator("#tmenu .mi", has_text="Other side").get_attribute("aria-disabled") is None
    page.keyboard.press("Escape")
    until_state(page, "view.selected", lambda part: part == "left_foot")
    page.keyboard.press("Shift+F10")
    _menu(page)
    assert _focused(page) == "Pin here from this frame"
    page.keyboard.press("o")
    assert _focused(page) == "Other side of the body"
    page.keyboard.press("Enter")
    until_state(page, "view.selected", lambda part: part == "right_foot")


def test_the_right_button_in_a_drag_cancels_it_and_opens_nothing(at: Desk) -> None:
    page = at.page
    before = section(page, "pose.points.left_hand")
    x, y = spot(page, "left_hand")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y - 40, steps=6)
    until_state(page, "pose.points.left_hand", lambda there: there != before)
    page.mouse.down(button="right")
    page.mouse.up()  # the left one first: some systems ask for the menu only after that
    page.mouse.up(button="right")
    until_state(page, "pose.points.left_hand", lambda there: there == before)
    settled(page)
    assert page.locator("#tmenu .menu").count() == 0
    assert at.agreed("undo")["undo"] is None


def test_commands_parts_and_frames_are_found_and_done(at: Desk) -> None:
    page = at.page
    hit = _search(page, "blender")
    assert "Export" in (hit.text_content() or "")
    assert "there is no motion yet" in (hit.text_content() or "")
    page.keyboard.press("Enter")
    assert page.locator("#search[open]").count() == 1, "what cannot be done leaves it open"
    field = page.locator("#search input")
    assert field.get_attribute("aria-activedescendant") == "search-0"
    screens(page, "search-blender")
    page.keyboard.press("Escape")
    _gone(page, "#search[open]")
    assert (_search(page, "left forearm").text_content() or "").strip().startswith("Left forearm")
    page.keyboard.press("Enter")
    until_state(page, "view.selected", lambda part: part == "left_forearm")
    _search(page, "go to frame 37")
    page.keyboard.press("Enter")
    until_state(page, "view.frame", lambda frame: frame == 37)
    _search(page, "focal length")
    page.keyboard.press("Enter")
    until(lambda: page.evaluate("() => window.keypose.ui.tab") == "camera", "the lens")
    page.keyboard.press("Control+k")
    page.locator("#search[open]").wait_for()
    settled(page)
    assert "Recent" in (page.locator("#search .mh").first.text_content() or "")
    screens(page, "search-recent")
    page.keyboard.press("Control+k")
    _gone(page, "#search[open]")


def test_one_goes_to_any_step_of_the_history(at: Desk) -> None:
    page, visitor = at.page, at.visitor
    visitor.do(do="set_note", frame=3, text="one")
    visitor.do(do="set_note", frame=7, text="two")
    visitor.do(do="delete_key", frame=24)
    until_state(page, "history", lambda reported: reported["done"] == 3)
    page.locator("#top [aria-label^='Undo']").click(button="right")
    rows = page.locator("#top .menu.history .mi")
    until_counted(page, "#top .menu.history .mi", 4)
    assert rows.nth(0).get_attribute("aria-checked") == "true"
    assert "Delete keyframe 24" in (rows.nth(0).text_content() or "")
    screens(page, "history")
    rows.nth(2).click()
    until_state(page, "notes", lambda notes: [note["frame"] for note in notes] == [3])
    assert 24 in at.agreed("keys")["frames"]
    page.locator("#top [aria-label='History']").click()
    until_counted(page, "#top .menu.history .mi.undone", 2)
    screens(page, "history-back")
    rows.nth(0).click()
    until_state(page, "keys.frames", lambda frames: 24 not in frames)
    assert at.agreed("history")["done"] == 3


def test_a_note_is_written_moved_gone_to_and_deleted(at: Desk) -> None:
    page = at.page
    _noted(page, 40, "The hand is hidden")
    _noted(page, 60, "")
    page.locator("#mnote", has_text="Flag").wait_for()
    page.keyboard.press("Shift+H")
    until_state(page, "view.frame", lambda frame: frame == 40)
    page.locator("#mnote", has_text="The hand is hidden").wait_for()
    page.keyboard.press("Home")
    until_state(page, "view.frame", lambda frame: frame == 0)
    screens(page, "notes")
    page.mouse.move(*_on_ruler(page, 40))
    page.mouse.down()
    page.mouse.move(*_on_ruler(page, 50), steps=5)
    page.mouse.up()
    until_state(page, "notes", lambda notes: [note["frame"] for note in notes] == [50, 60])
    page.mouse.dblclick(*_on_ruler(page, 50))
    page.locator(".notecard textarea").wait_for()
    page.keyboard.type(" here")
    assert page.locator(".notecard textarea").input_value() == "The hand is hidden here"
    screens(page, "note-card")
    page.mouse.click(200, 150)  # elsewhere: what was written is kept
    until_state(page, "notes[0].text", lambda text: text == "The hand is hidden here")
    page.keyboard.press("Shift+M")
    page.locator(".notecard textarea").wait_for()
    page.keyboard.type(" or not")
    page.keyboard.press("Escape")
    _gone(page, ".notecard")
    page.locator("#tr .count.noted").click()
    until_counted(page, "#search[open] .hit", 2)
    screens(page, "notes-list")
    page.keyboard.press("Escape")
    page.mouse.click(*_on_ruler(page, 60), button="right")
    _menu(page)
    page.locator("#tmenu .mi", has_text="Delete note").click()
    until_state(page, "notes", lambda notes: [note["frame"] for note in notes] == [50])
    assert section(page, "notes[0].text") == "The hand is hidden here"
    page.keyboard.press("Control+z")
    until_state(page, "notes", lambda notes: len(notes) == 2)
