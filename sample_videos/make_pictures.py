"""Make the README's pictures anew from the walk:  python -m keypose.sample_videos.make_pictures

The walk is tracked, shown in a real browser, and filmed. Needs the Chromium of the tests.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, TypeAlias

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
GALLERY_WIDTH, GALLERY_QUALITY = 960, 80
REPORTED = ("Hip flexion", "Ankle internal rotation")
"""The first and the last chart of the report that are shown."""

CROPPED = """() => [...document.querySelectorAll('#insp .rv-place frame-crop')]
  .every((crop) => crop.querySelector('canvas'))"""
"""Whether every place of the review has its small picture."""

Picture: TypeAlias = NDArray[np.uint8]


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        session = own_copy(HERE, "walk", Path(folder))
        _run("track", session)
        with opened(session, Path(folder) / "workspace") as page:
            page.screenshot(path=FOLDER / "page.jpg", quality=88)
            for name, draw in GALLERY.items():
                picture = draw(page, session, Path(folder))
                _keep(picture, FOLDER / "gallery" / f"{name}.webp")
        film(session, Path(folder), FOLDER / "film.webp")


@contextmanager
def opened(session: Path, workspace: Path) -> Iterator[Page]:
    """The page at one frame, as a person sees it."""
    running = Keypose(str(session), "--workspace", str(workspace))
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=find(), args=list(ARGUMENTS))
            page = browser.new_context(viewport=SIZE).new_page()  # type: ignore[arg-type]
            page.goto(running.address)
            page.wait_for_selector("html[data-ready]", state="attached")
            _show(page)
            yield page
            browser.close()
    finally:
        running.end()


# --- the gallery: each draws one picture, BGR, of the page or by a command


def posing(page: Page, session: Path, folder: Path) -> Picture:
    """A pose over the film, near, with everything that can be pulled."""
    place = page.locator("#main").bounding_box()
    assert place is not None
    page.mouse.move(place["x"] + 0.34 * place["width"], place["y"] + 0.86 * place["height"])
    _zoom(page, 3)
    _settle(page)
    picture = _seen(page, "#main")
    page.keyboard.press("0")
    return picture


def timeline(page: Page, session: Path, folder: Path) -> Picture:
    """Keyframes, verdicts, what is hidden, pins, a joint angle and its error."""
    return _seen(page, "#time")


def space(page: Page, session: Path, folder: Path) -> Picture:
    """The motion in space, from a side where no camera stood."""
    page.keyboard.press("6")
    page.wait_for_selector("#free canvas")
    place = page.locator("#free").bounding_box()
    assert place is not None
    page.mouse.move(place["x"] + place["width"] / 2, place["y"] + place["height"] / 2)
    _zoom(page, 5)
    _settle(page)
    picture = _seen(page, "#free")
    page.keyboard.press("1")
    return picture


def review(page: Page, session: Path, folder: Path) -> Picture:
    """The places that are least sure, the worst first."""
    page.keyboard.press("Shift+R")
    page.wait_for_selector("#insp .review .rv-place")
    page.wait_for_function(CROPPED)
    _settle(page)
    picture = _seen(page, "#stage")
    page.keyboard.press("Escape")
    return picture


def views(page: Page, session: Path, folder: Path) -> Picture:
    """One pose from the camera, the top, the side and the front."""
    out = folder / "views.png"
    _run("shot", session, "--frame", SHOWN_FRAME, "--view", "all", "--out", out)
    return _read(out)


def report(page: Page, session: Path, folder: Path) -> Picture:
    """The legs' angles over time, as the report prints them."""
    out = folder / "report.html"
    _run("report", session, "--out", out)
    tab = page.context.new_page()
    tab.goto(out.as_uri())
    first, last = (tab.locator("figure", has_text=name).first.bounding_box() for name in REPORTED)
    assert first is not None
    assert last is not None
    edges = {"x": first["x"], "y": first["y"], "width": last["x"] + last["width"] - first["x"]}
    clip = {**edges, "height": last["y"] + last["height"] - first["y"]}
    picture = _decoded(tab.screenshot(full_page=True, clip=clip))  # type: ignore[arg-type]
    tab.close()
    return picture


GALLERY: Final[dict[str, Callable[[Page, Path, Path], Picture]]] = {
    draw.__name__: draw for draw in (posing, timeline, space, review, views, report)
}
"""What the README shows, by the names of the files."""


def _zoom(page: Page, notches: int) -> None:
    """Nearer, where the pointer is."""
    for _ in range(notches):
        page.mouse.wheel(0, -120)
        page.wait_for_timeout(200)


def _seen(page: Page, selector: str) -> Picture:
    return _decoded(page.locator(selector).screenshot())


def _read(path: Path) -> Picture:
    return _decoded(path.read_bytes())


def _decoded(content: bytes) -> Picture:
    return np.asarray(cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR), np.uint8)


def _keep(picture: Picture, path: Path) -> None:
    """No wider than a README shows it."""
    if picture.shape[1] > GALLERY_WIDTH:
        height = round(picture.shape[0] * GALLERY_WIDTH / picture.shape[1])
        size = (GALLERY_WIDTH, height)
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
    path.parent.mkdir(exist_ok=True)
    if not cv2.imwrite(str(path), picture, [cv2.IMWRITE_WEBP_QUALITY, GALLERY_QUALITY]):
        raise SystemExit(f"{path} cannot be written")


# --- the film


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
    """At the frame."""
    page.get_by_role("textbox", name="Frame").fill(str(SHOWN_FRAME))
    page.keyboard.press("Enter")
    page.wait_for_selector(f"#main canvas.vid[data-frame='{SHOWN_FRAME}']")
    _settle(page)


def _settle(page: Page) -> None:
    """With nothing under the pointer, once all is drawn."""
    page.mouse.move(5, 5)
    page.wait_for_timeout(3000)  # viser's pictures are drawn by software here


def _pictures(path: Path) -> Iterator[Picture]:
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
