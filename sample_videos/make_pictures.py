"""Make the README's pictures anew from the walk:  python -m keypose.sample_videos.make_pictures

The walk is tracked, shown in a real browser, and filmed. Needs the Chromium of the tests.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Page, sync_playwright

from keypose.app.cli.main import main as keypose
from keypose.app.document.library.samples import own_copy
from keypose.tracker.video import Video
from tests.app.serving import Keypose
from tests.browser.chromium import ARGUMENTS, find

HERE = Path(__file__).parent
FOLDER = HERE / "walk"
SIZE = {"width": 1440, "height": 900}
SHOWN_FRAME = 100
SIDE = "camera:70,6,6.5"
FILMED = (20, 132)
FILM_HEIGHT, EVERY, QUALITY = 300, 2, 55


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        session = own_copy(HERE, "walk", Path(folder))
        _run("track", session)
        picture(session, Path(folder) / "workspace", FOLDER / "page.jpg")
        film(session, Path(folder), FOLDER / "film.webp")


def picture(session: Path, workspace: Path, path: Path) -> None:
    """The page at one frame, as a person sees it."""
    running = Keypose(str(session), "--workspace", str(workspace))
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=find(), args=list(ARGUMENTS))
            page = browser.new_page(viewport=SIZE)  # type: ignore[arg-type]
            page.goto(running.address)
            page.wait_for_selector("html[data-ready]", state="attached")
            _show(page)
            page.screenshot(path=path, quality=88)
            browser.close()
    finally:
        running.end()


def film(session: Path, folder: Path, path: Path) -> None:
    """Over the video, and beside it from the side, as one moving picture."""
    frames = f"{FILMED[0]}-{FILMED[1]}"
    _run("film", session, "--frames", frames, "--out", folder / "main.mp4")
    _run("film", session, "--frames", frames, "--view", SIDE, "--size", "540x720",
         "--out", folder / "side.mp4")  # fmt: skip
    views = zip(_pictures(folder / "main.mp4"), _pictures(folder / "side.mp4"), strict=True)
    joined = [np.hstack(pair) for pair in views][::EVERY]
    animation = cv2.Animation()
    animation.frames = joined
    animation.durations = [EVERY * 1000 // 30] * len(joined)
    if not cv2.imwriteanimation(str(path), animation, [cv2.IMWRITE_WEBP_QUALITY, QUALITY]):
        raise SystemExit(f"{path} cannot be written")


def _show(page: Page) -> None:
    """At the frame, with nothing under the pointer."""
    page.get_by_role("textbox", name="Frame").fill(str(SHOWN_FRAME))
    page.keyboard.press("Enter")
    page.wait_for_selector(f"#main canvas.vid[data-frame='{SHOWN_FRAME}']")
    page.mouse.move(5, 5)
    page.wait_for_timeout(3000)  # viser's pictures are drawn by software here


def _pictures(path: Path) -> Iterator[NDArray[np.uint8]]:
    """Every picture of a film at the height of the animation, BGR."""
    with Video.open(path) as video:
        for number in range(video.info.frame_count):
            whole = video.frame(number)[..., ::-1]
            width = round(whole.shape[1] * FILM_HEIGHT / whole.shape[0])
            small = cv2.resize(whole, (width, FILM_HEIGHT), interpolation=cv2.INTER_AREA)
            yield np.asarray(small, dtype=np.uint8)


def _run(*words: object) -> None:
    if keypose([*map(str, words), "--overwrite"]) not in (0, 1):
        raise SystemExit(f"keypose {words[0]} failed")


if __name__ == "__main__":
    main()
