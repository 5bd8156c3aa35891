"""A server of our own and a real Chromium, for tests that use the page as a person would."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from tests.app.serving import ROOT, Keypose
from tests.browser.chromium import ARGUMENTS, find
from tests.browser.shared import SIZE, Desk, admit, close_office, desk


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    """A real Chromium; without one the test is skipped, but never where all must be tested.

    It goes with the last of these tests: while it is there no other event loop can run.
    """
    path = find()
    if path is None and os.environ.get("CI"):
        pytest.fail("There is no Chromium, and a build machine must test the page.")
    if path is None:
        pytest.skip("There is no Chromium on this computer.")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=list(ARGUMENTS))
        yield chromium
        close_office(chromium)
        chromium.close()


@pytest.fixture
def sample(tmp_path: Path) -> Path:
    """A session of one's own: the sample's, with its video beside it."""
    folder = tmp_path / "person"
    folder.mkdir()
    for name in ("person.mp4", "session.json"):
        shutil.copy(ROOT / "sample_videos" / "person" / name, folder)
    return folder / "session.json"


@pytest.fixture
def keypose(sample: Path, tmp_path: Path) -> Iterator[Keypose]:
    """The page of that session."""
    running = Keypose(str(sample), "--workspace", str(tmp_path / "workspace"))
    yield running
    running.end()


@pytest.fixture
def drawn() -> bool:
    """Whether a test looks at viser's pictures: a module that does says so."""
    return False


@pytest.fixture
def page(
    browser: Browser, keypose: Keypose, drawn: bool, request: pytest.FixtureRequest
) -> Iterator[Page]:
    """The page, opened and ready; anything the browser complains about fails the test. A module may
    say its SIZE."""
    size = getattr(request.module, "SIZE", (1440, 900))
    with admit(browser, drawn=drawn, size=size) as context:
        tab = context.new_page()
        tab.goto(keypose.address)
        tab.wait_for_selector("html[data-ready]", state="attached")
        yield tab


@pytest.fixture(scope="module")
def shared(
    browser: Browser, tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest
) -> Iterator[Desk]:
    """A page for a module's tests; a module may say its SIZE, and that its server is its OWN."""
    asks, folder = request.module, tmp_path_factory.mktemp(request.module.__name__.split("_")[-1])
    size, own = getattr(asks, "SIZE", SIZE), getattr(asks, "OWN", False)
    with desk(browser, folder, size=size, own=own) as made:
        yield made


@pytest.fixture
def at(shared: Desk) -> Desk:
    """The page of a module's own `shared` desk, as if it had just been opened."""
    shared.fresh()
    return shared
