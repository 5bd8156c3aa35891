"""Review of a draft that is known to be wrong: it cannot be accepted as it is."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from keypose.tracker.session.annotations import Drafted, DraftPlace, FlippedDrafts
from keypose.tracker.storage.files import load_session, save_session
from tests.browser.interaction import answered, screens, section, until, until_state
from tests.browser.shared import Desk, desk
from tests.browser.test_review import current, done, pressed

ARM = ("left_upper_arm",)


def begin(path: Path) -> None:
    """The sample's keyframes as drafts, the left upper arm wrong in the second."""
    doc = load_session(path)
    drafts = tuple(k.model_copy(update={"drafted": True}) for k in doc.subject.keyframes)
    places = (
        DraftPlace(frame=24, reason="wrong", parts=ARM),
        DraftPlace(frame=48, reason="pose", parts=()),
    )
    drafted = Drafted(
        first_frame=0,
        last_frame=72,
        places=places,
        flipped=(FlippedDrafts(first_frame=24, last_frame=24, parts=ARM),),
    )
    save_session(
        doc.changed({"keyframes": (), "drafts": drafts, "drafted": drafted, "results": None}), path
    )


@pytest.fixture(scope="module")
def shared(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    folder = tmp_path_factory.mktemp("wrong_drafts")
    with desk(browser, folder, size=(1440, 900), begin=begin) as made:
        yield made


def test_a_draft_that_is_refused_stays_open_and_says_that_it_is_not_accepted(at: Desk) -> None:
    page = at.page
    page.keyboard.press("Shift+R")
    until_state(page, "view.frame", lambda frame: frame == 24)
    pressed(page)
    note = page.locator(".rv-place.on .note")
    until(lambda: note.inner_text().startswith("Not accepted. This draft is wrong"), "the refusal")
    answered(page)
    assert (current(page), done(page)) == ("Left upper arm", [])
    assert (section(page, "view.frame"), section(page, "keys.frames")) == (24, [])
    screens(page, "review-refused")
    page.keyboard.press("n")
    until_state(page, "view.frame", lambda frame: frame == 48)
    pressed(page)
    until_state(page, "keys.frames", lambda frames: frames == [48])
    until(lambda: [each["answer"] for each in done(page)] == ["accepted"], "what is accepted")
