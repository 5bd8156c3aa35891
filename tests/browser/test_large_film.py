"""A film of more pixels than the screen has room for."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Browser, Page

from tests.app.serving import Keypose
from tests.browser.interaction import until
from tests.browser.shared import SIZE, admit, opened
from tests.tracker.video_cases import numbered_picture, write_clip

WIDTH = 2560
HEIGHT = 1440


def shown(page: Page) -> tuple[int, str]:
    """Pixels across of the picture that is shown, and its frame."""
    across, frame = page.evaluate(
        "() => { const film = document.querySelector('#main canvas.vid');"
        " return [film.width, film.dataset.frame]; }"
    )
    return across, frame


def zoom(page: Page, factor: float) -> None:
    page.evaluate("(by) => window.keypose.view('main').zoomAt(300, 200, by)", factor)


def test_it_comes_as_small_as_it_is_shown_and_whole_where_one_looks_closer(
    browser: Browser, tmp_path: Path
) -> None:
    film = tmp_path / "large.mp4"
    write_clip(film, [numbered_picture(number, WIDTH, HEIGHT) for number in range(4)])
    keypose = Keypose(str(film), "--workspace", str(tmp_path / "workspace"))
    try:
        with admit(browser, drawn=False, size=SIZE) as context:
            page = opened(context, keypose)
            until(lambda: shown(page) == (WIDTH // 2, "0"), "the half picture")
            page.keyboard.press("ArrowRight")
            until(lambda: shown(page) == (WIDTH // 2, "1"), "the next half picture")
            zoom(page, 4)
            until(lambda: shown(page) == (WIDTH, "1"), "the whole picture")
            page.keyboard.press("ArrowRight")
            until(lambda: shown(page) == (WIDTH, "2"), "the next whole picture")
            page.evaluate("() => window.keypose.view('main').fit()")
            until(lambda: shown(page) == (WIDTH // 2, "2"), "the half picture again")
    finally:
        keypose.end()
