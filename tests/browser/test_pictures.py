"""What leaves the page as a file is, byte for byte, what the command line writes."""

from __future__ import annotations

import base64
import zipfile
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page

from keypose.app.cli.main import main
from keypose.app.export.motion_formats import FORMATS, MotionFormat
from tests.browser.interaction import section, until
from tests.browser.shared import Desk, desk

COPIED = """
async () => {
  const [item] = await navigator.clipboard.read();
  const bytes = new Uint8Array(await (await item.getType('image/png')).arrayBuffer());
  return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));
}
"""
"""The picture on the clipboard; the browser writes it anew, so its pixels count, not its bytes."""

MOTION = """
async () => {
  const { fetchOwn } = await window.keypose.module('store/storage.js');
  return (await fetchOwn('/motion?format=bvh')).text();
}
"""


@pytest.fixture(scope="module")
def tracked(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    """The page of a session that is tracked, quickly."""
    with desk(browser, tmp_path_factory.mktemp("pictures")) as made:
        made.visitor.do(do="settings", quality="preview")
        made.visitor.do(do="track", what="all")
        until(lambda: made.served["job"]["state"] == "done", "the track")
        yield made


@pytest.fixture
def at(tracked: Desk) -> Desk:
    """At a tracked frame, all saved."""
    show(tracked, frame=12, mode="both", opacity=0.5)
    return tracked


def show(desk: Desk, *, frame: int, mode: str, opacity: float) -> None:
    desk.visitor.do(do="go", frame=frame)
    desk.visitor.do(do="display", mode=mode, opacity=opacity)
    desk.agreed("view")
    until(lambda: desk.agreed("saved")["state"] == "saved", "the file")
    desk.page.wait_for_selector(f"#main canvas.vid[data-frame='{frame}']")


def shot(desk: Desk, folder: Path, *more: str) -> bytes:
    """The picture of the present frame from the command line."""
    out = folder / "shot.png"
    view = section(desk.page, "view")
    style = ["--style", view["mode"], "--opacity", f"{100 * view['opacity']:.0f}"]
    frame = ["--frame", str(view["frame"])]
    place = ["--out", str(out), "--overwrite"]
    assert main(["shot", str(desk.session), *frame, *style, *place, *more]) == 0
    return out.read_bytes()


def downloaded(page: Page, folder: Path, by: str | Locator) -> Path:
    """The file that a key, or a click, gives; under the name that the page proposes."""
    with page.expect_download() as waiting:
        if isinstance(by, str):
            page.keyboard.press(by)
        else:
            by.click()
    place = folder / waiting.value.suggested_filename
    waiting.value.save_as(place)
    return place


def item(page: Page, name: str) -> Locator:
    """An item of the Export menu."""
    page.get_by_role("button", name="Export").click()
    return page.get_by_role("menuitem", name=name)


@pytest.mark.parametrize(
    ("frame", "mode", "opacity"),
    [(12, "both", 0.5), (24, "wire", 0.5), (50, "solid", 0.83), (30, "both", 0.07)],
)
def test_the_picture_is_that_of_the_command_line(
    at: Desk, tmp_path: Path, frame: int, mode: str, opacity: float
) -> None:
    show(at, frame=frame, mode=mode, opacity=opacity)
    saved = downloaded(at.page, tmp_path, "Shift+E")
    assert f"{frame}" in saved.name
    assert saved.suffix == ".png"
    assert saved.read_bytes() == shot(at, tmp_path)


def test_all_four_views_are_those_of_the_command_line(at: Desk, tmp_path: Path) -> None:
    saved = downloaded(at.page, tmp_path, item(at.page, "All four views"))
    assert saved.read_bytes() == shot(at, tmp_path, "--view", "all")


@pytest.mark.parametrize(("key", "view"), [("2", "top"), ("3", "side"), ("4", "front")])
def test_the_enlarged_view_is_that_of_the_command_line(
    at: Desk, tmp_path: Path, key: str, view: str
) -> None:
    at.page.keyboard.press(key)
    saved = downloaded(at.page, tmp_path, item(at.page, "This view, PNG"))
    at.page.keyboard.press(key)
    assert saved.read_bytes() == shot(at, tmp_path, "--view", view)


def test_at_a_changed_keyframe_the_picture_shows_the_change(at: Desk, tmp_path: Path) -> None:
    show(at, frame=48, mode="both", opacity=0.5)
    before = shot(at, tmp_path)
    at.visitor.do(do="root", x=0.1)
    at.agreed("pose")
    until(lambda: at.agreed("saved")["state"] == "saved", "the file")
    changed = downloaded(at.page, tmp_path, "Shift+E").read_bytes()
    assert changed == shot(at, tmp_path)
    assert changed != before
    at.visitor.do(do="undo")
    until(lambda: at.agreed("saved")["state"] == "saved", "the file")


def test_the_copied_picture_is_on_the_clipboard(at: Desk, tmp_path: Path) -> None:
    at.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    at.page.keyboard.press("Shift+C")
    at.page.get_by_text("Image of frame 12 copied.").wait_for()
    content = base64.b64decode(at.page.evaluate(COPIED))
    np.testing.assert_array_equal(_pixels(content), _pixels(shot(at, tmp_path)))


def _pixels(content: bytes) -> np.ndarray:  # type: ignore[type-arg]
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)


@pytest.mark.parametrize("kind", ["bvh", "glb", "usd", "trc", "c3d", "npz", "amass"])
def test_the_motion_is_that_of_the_command_line(
    at: Desk, tmp_path: Path, kind: MotionFormat
) -> None:
    saved = downloaded(at.page, tmp_path, item(at.page, kind.upper()))
    (name,) = FORMATS[kind].names
    assert saved.name == name.replace("motion", "person")
    out = tmp_path / "out"
    assert main(["export", str(at.session), "--format", kind, "--out", str(out)]) == 0
    assert saved.read_bytes() == (out / name).read_bytes()


def test_the_tables_are_those_of_the_command_line(at: Desk, tmp_path: Path) -> None:
    saved = downloaded(at.page, tmp_path, item(at.page, "CSV"))
    out = tmp_path / "out"
    assert main(["export", str(at.session), "--format", "csv", "--out", str(out)]) == 0
    with zipfile.ZipFile(saved) as archive:
        packed = {name: archive.read(name) for name in archive.namelist()}
    assert packed == {path.name: path.read_bytes() for path in out.iterdir()}


def test_the_report_is_that_of_the_command_line(at: Desk, tmp_path: Path) -> None:
    saved = downloaded(at.page, tmp_path, item(at.page, "Report"))
    until(
        lambda: at.page.get_by_text("Saved as person-report.html").count(),
        "the word on it, which goes again",
    )
    assert saved.name == "person-report.html"
    out = tmp_path / "report.html"
    assert main(["report", str(at.session), "--out", str(out)]) == 0
    assert saved.read_bytes() == out.read_bytes()


def test_without_a_motion_the_menu_says_why(at: Desk) -> None:
    for frame in (24, 48, 72):
        at.visitor.do(do="delete_key", frame=frame)
    until(lambda: at.agreed("segments") == [], "no segment")
    motion = item(at.page, "BVH")
    assert motion.get_attribute("aria-disabled") == "true"
    assert "Track first" in (motion.get_attribute("title") or "")
    at.page.keyboard.press("Escape")
    reported = at.page.evaluate(MOTION)
    assert reported == "There is no motion yet: pose two keyframes and track.\n"
    for _ in range(3):
        at.visitor.do(do="undo")
    at.agreed("segments")
