"""The page drafts a dog from a box, once a network of animals was added."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from keypose.app.document.new import new_session
from keypose.tracker.body.body import preset
from keypose.tracker.keypoints.model_files import cache_folder
from keypose.tracker.storage.files import save_session
from keypose.tracker.storage.networks import add_own
from keypose.tracker.video import Video
from tests.animals.dot_network import dot_network
from tests.animals.walking import CAMERA, Walk
from tests.app.serving import Keypose
from tests.browser.interaction import drag, screens, section, until_state
from tests.browser.shared import admit
from tests.browser.test_box import on_screen

WALK = Walk("dog", frames=8)
NO_NETWORK = "Needs a network of animals, added by “keypose models add NAME"


@pytest.fixture
def session(tmp_path: Path) -> Path:
    """A session of a dog that nobody has posed."""
    film = WALK.film(tmp_path / "film")
    with Video.open(film) as video:
        made = new_session(video, tmp_path / "session.json")
    path = tmp_path / "session.json"
    save_session(made.changed({"body": preset("dog"), "camera": CAMERA}), path)
    return path


@pytest.fixture
def page(
    browser: Browser, session: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Page]:
    """The page of it, on the Track tab, in a user's account without added networks."""
    own = tmp_path / "cache" / "keypose"
    own.mkdir(parents=True)
    (own / "kernels").symlink_to(cache_folder() / "kernels")  # the compiled loops
    monkeypatch.setenv("XDG_CACHE_HOME", str(own.parent))
    running = Keypose(str(session), "--workspace", str(tmp_path / "workspace"))
    try:
        with admit(browser, drawn=False, size=(1440, 900)) as context:
            tab = context.new_page()
            tab.goto(running.address)
            tab.wait_for_selector("html[data-ready]", state="attached")
            tab.get_by_role("tab", name="Track").click()
            yield tab
    finally:
        running.end()


def test_a_dog_is_drafted_from_a_box_once_a_network_was_added(page: Page, tmp_path: Path) -> None:
    page.get_by_text(NO_NETWORK).wait_for()
    assert page.get_by_role("button", name="Draw a box").count() == 0
    path, content = tmp_path / "ap10k.onnx", dot_network()
    path.write_bytes(content)
    add_own("paws", path, hashlib.sha256(content).hexdigest())
    page.reload()
    page.wait_for_selector("html[data-ready]", state="attached")
    page.get_by_role("tab", name="Track").click()
    page.get_by_role("button", name="Draw a box").click()
    left, top, right, bottom = WALK.box()
    drag(page, on_screen(page, left, top), on_screen(page, right, bottom))
    screens(page, "draft-animals-1-box")
    page.get_by_role("button", name="Draft 8 frames").click()
    until_state(page, "draft", lambda draft: bool(draft) and draft["drafted"] == WALK.frames)
    assert section(page, "body")["is_animals"]
    screens(page, "draft-animals-2-drafted")
