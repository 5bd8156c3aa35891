"""The dialog of imports: a file is dropped, told what it is, and imported as a step to undo."""

from __future__ import annotations

import base64
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Locator

from keypose.tracker.body.skeleton import Skeleton
from tests.app.server.test_imports import sleap
from tests.browser.interaction import until
from tests.browser.shared import Desk, desk
from tests.tracker.formats import recordings

DROP = """([name, content]) => {
  const bytes = Uint8Array.from(atob(content), (c) => c.charCodeAt(0));
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([bytes], name));
  dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
}"""


@pytest.fixture(scope="module")
def work(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    with desk(browser, tmp_path_factory.mktemp("imports")) as made:
        yield made


def drop(at: Desk, name: str, content: bytes) -> None:
    at.page.evaluate(DROP, [name, base64.b64encode(content).decode()])


def shown(sheet: Locator, words: str) -> None:
    """Wait until the dialog says something: the file is read in a process that has to begin."""
    try:
        until(lambda: sheet.get_by_text(words).is_visible(), words)
    except AssertionError as late:
        seen = sheet.inner_text() if sheet.is_visible() else "is closed"
        raise AssertionError(f"{late}; the dialog: {seen}") from None


def test_a_dropped_motion_is_recognised_imported_and_undone(work: Desk) -> None:
    motion, body = recordings.trajectory("person"), recordings.session("person").subject.body
    drop(work, "walk.bvh", recordings.bvh_of(Skeleton.of(body), motion, 1 / 30).encode())
    sheet = work.page.locator("#importing")
    shown(sheet, "Recorded motion")
    shown(sheet, f"{len(motion)} frames")
    start = sheet.get_by_label("Start frame")
    start.fill("first")
    start.blur()
    shown(sheet, "Start frame is a whole number")
    button = sheet.get_by_role("button", name="Import", exact=True)
    assert button.is_disabled()
    start.fill("")
    start.blur()
    until(button.is_enabled, "an order that can be given")
    button.click()
    until(lambda: not sheet.is_visible(), "the end of the dialog")
    until(lambda: work.served["undo"]["undo"] == "import", "a step to undo")
    work.visitor.do(do="undo")
    until(lambda: work.served["undo"]["undo"] is None, "the session as it was")


def test_a_name_that_is_not_known_is_given_its_place_on_the_body(work: Desk) -> None:
    page, body = work.page, recordings.session("person").subject.body
    text = recordings.bvh_of(Skeleton.of(body), recordings.trajectory("person"), 1 / 30)
    assert "JOINT left_foot\n" in text
    drop(work, "odd.bvh", text.replace("JOINT left_foot\n", "JOINT Paw_1\n").encode())
    sheet = page.locator("#importing")
    shown(sheet, "Other names")
    chosen = sheet.get_by_role("button", name="What Paw_1 is")
    assert chosen.inner_text() == "Not used"
    chosen.click()
    page.keyboard.type("left foot")
    page.keyboard.press("Enter")
    until(lambda: chosen.inner_text() == "Left foot", "the choice")
    listen = page.expect_request(lambda sent: sent.method == "POST" and "/imports/" in sent.url)
    with listen as sent:
        sheet.get_by_role("button", name="Import", exact=True).click()
    assert sent.value.post_data_json["places"] == ["Paw_1=left_foot"]
    until(lambda: not sheet.is_visible(), "the end of the dialog")
    until(lambda: work.served["undo"]["undo"] == "import", "a step to undo")
    work.visitor.do(do="undo")
    until(lambda: work.served["undo"]["undo"] is None, "the session as it was")


def test_of_several_individuals_one_is_chosen(work: Desk) -> None:
    drop(work, "mice.csv", sleap("anna", "bert"))
    sheet = work.page.locator("#importing")
    shown(sheet, "Choose: Individual.")
    sheet.get_by_label("Individual:").click()
    work.page.get_by_role("option", name="bert").click()
    until(sheet.get_by_role("button", name="Import", exact=True).is_enabled, "an order")
    work.page.keyboard.press("Escape")
    until(lambda: not sheet.is_visible(), "the end of the dialog")


def test_what_cannot_be_imported_is_said_in_the_dialog_which_asks_for_another(work: Desk) -> None:
    drop(work, "walk.trc", b"nothing")
    sheet = work.page.locator("#importing")
    until(lambda: "walk.trc" in " ".join(sheet.get_by_role("alert").all_inner_texts()), "why not")
    shown(sheet, "Choose another…")
    work.page.keyboard.press("Escape")
    until(lambda: not sheet.is_visible(), "the end of the dialog")
