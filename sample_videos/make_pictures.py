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
from keypose.app.document.new import new_session
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.storage.files import save_session
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

FLOOR = """async (floor) =>
  (await window.keypose.module('store/link.js')).send({ do: 'display', floor })"""
FOOT = """() => {
  const view = window.keypose.view('main');
  const { left, top } = view.el.getBoundingClientRect();
  const [x, y] = view.project(window.keypose.server.pose.points.left_foot);
  return [left + x, top + y];
}"""

PANNED_SIZE, PANNED_FX = (640, 480), 1100.0
PANNED_RAD = 0.2
"""The camera of the film that pans looks so far to both sides."""
PANNED_SHOWN = (5, 55, 105)
SQUARE_PX = 24

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


def stand(page: Page, session: Path, folder: Path) -> Picture:
    """Feet on the floor that was found, where they are pinned."""
    page.evaluate(FLOOR, True)
    foot = page.evaluate(FOOT)
    page.mouse.move(*foot)
    _zoom(page, 4)
    _settle(page)
    picture = _seen(page, "#main")
    page.evaluate(FLOOR, False)
    page.keyboard.press("0")
    return picture


def camera(page: Page, session: Path, folder: Path) -> Picture:
    """What a camera that pans has swept, found again from a film that was made with it."""
    film, turned = folder / "pan.mp4", folder / "pan" / "session.json"
    _pan(FOLDER / "walk.mp4", film)
    with Video.open(film) as video:
        turned.parent.mkdir()
        save_session(new_session(video, turned), turned)
    _run("camera", turned, "--kind", "turns")
    _run("camera", turned, "--background", folder / "swept.png")
    swept = _read(folder / "swept.png")
    frames = [_read_frame(film, number) for number in PANNED_SHOWN]
    width = swept.shape[1]
    height = round(frames[0].shape[0] * width / (len(frames) * frames[0].shape[1]))
    row = np.hstack(frames)
    return np.vstack([np.asarray(cv2.resize(row, (width, height)), np.uint8), swept])


def matte(page: Page, session: Path, folder: Path) -> Picture:
    """The person cut out, before squares that show through."""
    frames = f"{SHOWN_FRAME}-{SHOWN_FRAME}"
    _run("matte", session, "--frames", frames, "--out", folder / "matte")
    (file,) = (folder / "matte").glob("*.png")
    cut = cv2.imdecode(np.frombuffer(file.read_bytes(), np.uint8), cv2.IMREAD_UNCHANGED)
    assert cut is not None
    alpha = cut[..., 3:] / 255.0
    rows, columns = np.indices(cut.shape[:2]) // SQUARE_PX
    squares = np.where((rows + columns) % 2, 205.0, 235.0)[..., None]
    filmed = _read_frame(FOLDER / "walk.mp4", SHOWN_FRAME)
    shown = (alpha * cut[..., :3] + (1 - alpha) * squares).astype(np.uint8)
    seen = np.flatnonzero(alpha[..., 0].max(axis=0) > 0.5)
    left = int(np.clip(seen.mean() - filmed.shape[1] / 4, 0, filmed.shape[1] / 2))
    half = slice(left, left + filmed.shape[1] // 2)
    return np.hstack([filmed[:, half], shown[:, half]])


def _pan(source: Path, film: Path) -> None:
    """A film as a camera had made it that pans over the pictures of another."""
    width, height = PANNED_SIZE
    K_film = np.array([[PANNED_FX, 0, width / 2], [0, PANNED_FX, height / 2], [0, 0, 1]])
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"mp4v"), 30, PANNED_SIZE)
    first, last = FILMED
    with Video.open(source) as video:
        for number in range(first, last):
            picture = video.frame(number)[..., ::-1]
            middle = np.array([picture.shape[1] / 2, picture.shape[0] / 2])
            K_source = np.array([[PANNED_FX, 0, middle[0]], [0, PANNED_FX, middle[1]], [0, 0, 1]])
            angle = PANNED_RAD * (2 * (number - first) / (last - first) - 1)
            H = K_film @ exp_rotation([0.0, -angle, 0.0]) @ np.linalg.inv(K_source)
            writer.write(cv2.warpPerspective(picture, H, PANNED_SIZE))
    writer.release()


def _read_frame(film: Path, number: int) -> Picture:
    with Video.open(film) as video:
        return np.ascontiguousarray(video.frame(number)[..., ::-1])


GALLERY: Final[dict[str, Callable[[Page, Path, Path], Picture]]] = {
    draw.__name__: draw
    for draw in (posing, timeline, space, review, views, report, stand, camera, matte)
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
