"""A second film of the motion: its picture with the body over it, and its clock."""

from __future__ import annotations

import base64
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Locator

from keypose.tracker.session.views import Clock
from keypose.tracker.storage.files import load_session, save_session
from tests.app.film_beside_cases import ID, with_film
from tests.browser.interaction import answered, drag, screen, screens, section, settled, spot, until
from tests.browser.shared import Desk, desk

BEGINS = 3.4
CLOCK = Clock(begins=BEGINS, sigma=0.1, also=(31.5,))

DROP = """
([name, content, words]) => {
  const bytes = Uint8Array.from(atob(content), (c) => c.charCodeAt(0));
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([bytes], name));
  const zones = [...document.querySelectorAll('#drop .veil div')];
  const zone = zones.find(({ textContent }) => textContent.includes(words));
  const { left = 0, top = 0, width = 2, height = 2 } = zone?.getBoundingClientRect() ?? {};
  const [clientX, clientY] = [left + width / 2, top + height / 2];
  const at = { clientX, clientY, bubbles: true, cancelable: true };
  dispatchEvent(new DragEvent('dragover', { dataTransfer, ...at }));
  if (zone) dispatchEvent(new DragEvent('drop', { dataTransfer, ...at }));
}
"""
"""Drag a file over the page and, once there is a zone with these words, drop it there."""

PAINTED = """
() => {
  const canvas = document.querySelector('.filmcard .figure');
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let sum = 0;
  for (let i = 3; i < data.length; i += 4) sum += data[i] ? i % 9973 : 0;
  return sum;
}
"""
"""Another number for another outline of the body, 0 where there is none."""

BODY = """
(ID) => {
  const film = window.keypose.server.films.find(({ id }) => id === ID);
  const canvas = document.querySelector('.filmcard .figure');
  const { width, height } = canvas;
  const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
  const box = [Infinity, Infinity, -1, -1];
  for (let i = 3; i < data.length; i += 4) {
    if (!data[i]) continue;
    const [x, y] = [((i - 3) / 4) % width, Math.floor(i / 4 / width)];
    [x, y].forEach((at, k) => {
      box[k] = Math.min(box[k], at);
      box[k + 2] = Math.max(box[k + 2], at);
    });
  }
  return box.map((px) => (px * film.camera.width) / width);
}
"""
"""Left, top, right and bottom of the painted body, pixels of the film."""


@pytest.fixture(scope="module")
def work(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    def begin(path: Path) -> None:
        shutil.copy(path.parent / "person.mp4", path.parent / "side.mp4")
        doc = load_session(path)
        video = doc.view.video.model_copy(update={"path": "side.mp4"})
        settings = doc.settings.model_copy(update={"static_camera": True})
        save_session(with_film(doc.changed({"settings": settings}), CLOCK, video=video), path)

    with desk(browser, tmp_path_factory.mktemp("films"), size=(1366, 768), begin=begin) as made:
        made.page.keyboard.press("Escape")
        yield made


@pytest.fixture
def at(work: Desk) -> Iterator[Desk]:
    work.fresh()
    yield work
    if large(work).is_visible():
        work.page.keyboard.press("7")


def card(at: Desk) -> Locator:
    return at.page.locator(f'.filmcard[data-film="{ID}"]')


def large(at: Desk) -> Locator:
    """The film in the place beside the first."""
    return at.page.locator("#film")


def go(at: Desk, frame: int) -> None:
    at.visitor.do(do="go", frame=frame)
    until(lambda: section(at.page, "view.frame") == frame, "the moment")


def enlarged(at: Desk) -> None:
    """At the frame 24, whose picture is the film's 21st, with the film beside the first."""
    go(at, 24)
    at.page.keyboard.press("7")
    large(at).locator("canvas.vid[data-frame='21']").wait_for()
    large(at).locator("canvas.figure[data-frame='24']").wait_for()


def shown(at: Desk) -> Any:
    """The frame of the film whose picture is shown, and that of the body over it."""
    return tuple(
        card(at).locator(f"canvas.{name}").get_attribute("data-frame") for name in ("vid", "figure")
    )


def begins(at: Desk) -> float:
    return float(at.agreed("films")[0]["begins"])


def test_the_picture_of_the_moment_is_shown_with_the_body_where_its_camera_sees_it(
    at: Desk,
) -> None:
    card(at).get_by_text("This film does not show this moment.").wait_for()
    go(at, 24)
    until(lambda: shown(at) == ("21", "24"), "the frame of the moment")
    settled(at.page)
    box = at.page.evaluate(BODY, ID)
    film, points = at.agreed("films")[0], at.agreed("pose")["points"].values()
    (a, b, c, p), (d, e, f, q), (g, h, i, r) = (film["T"][row : row + 4] for row in (0, 4, 8))
    lens = film["camera"]
    for x, y, z in points:
        depth = g * x + h * y + i * z + r
        u = lens["fx"] * (a * x + b * y + c * z + p) / depth + lens["cx"]
        v = lens["fy"] * (d * x + e * y + f * z + q) / depth + lens["cy"]
        assert box[0] - 4 <= u <= box[2] + 4
        assert box[1] - 4 <= v <= box[3] + 4
    screens(at.page, "films-1")


def test_it_lies_over_no_bar_and_no_tool(at: Desk) -> None:
    go(at, 24)
    until(lambda: shown(at) == ("21", "24"), "the frame of the moment")
    for size in ((1366, 768), (1280, 720)):
        at.page.set_viewport_size({"width": size[0], "height": size[1]})
        for name in ("#tools", "#mfoot", "#mhead", "#mdisp", "#mzoom"):
            at.page.mouse.move(2, 2)
            settled(at.page)
            own, bar = card(at).bounding_box(), at.page.locator(name).bounding_box()
            assert own is not None
            assert bar is not None
            is_aside = own["x"] >= bar["x"] + bar["width"] or bar["x"] >= own["x"] + own["width"]
            is_off = own["y"] >= bar["y"] + bar["height"] or bar["y"] >= own["y"] + own["height"]
            assert is_aside or is_off, name
    at.page.set_viewport_size({"width": 1366, "height": 768})


def test_the_body_over_it_follows_a_drag_before_the_pose_is_let_go(at: Desk) -> None:
    go(at, 24)
    until(lambda: shown(at) == ("21", "24"), "the frame of the moment")
    before = at.page.evaluate(PAINTED)
    x, y = spot(at.page, "left_hand")
    drag(at.page, (x, y), (x + 30, y - 40), drop=False)
    until(lambda: at.page.evaluate(PAINTED) != before, "the dragged body")
    assert section(at.page, "pose.stroke")
    at.page.mouse.up()
    answered(at.page)


def test_its_clock_is_moved_by_buttons_keys_and_typing_and_each_is_undone(at: Desk) -> None:
    go(at, 24)
    later = card(at).get_by_role("button", name="Film begins one frame later")
    later.click()
    until(lambda: begins(at) == pytest.approx(BEGINS + 1), "a frame later")
    until(lambda: shown(at)[0] == "20", "the picture before")
    at.page.keyboard.down("Shift")
    card(at).get_by_role("button", name="Film begins one frame earlier").click()
    at.page.keyboard.up("Shift")
    until(lambda: begins(at) == pytest.approx(BEGINS + 0.9), "a tenth earlier")
    at.page.keyboard.press("Control+.")
    until(lambda: begins(at) == pytest.approx(BEGINS + 1.9), "another frame later")
    field = card(at).get_by_role("spinbutton")
    field.click()
    field.fill("7.25")
    field.press("Enter")
    until(lambda: begins(at) == 7.25, "what was typed")
    assert at.agreed("films")[0]["sigma"] is None
    for _ in range(4):
        at.page.keyboard.press("Escape")
        at.page.keyboard.press("Control+z")
    until(lambda: begins(at) == BEGINS, "the clock that was found")
    assert at.agreed("undo")["undo"] is None


def test_its_strip_is_dragged_along_the_timeline_as_one_step(at: Desk) -> None:
    strip = at.page.locator("#tsvg .filmstrip").nth(1).bounding_box()
    frames = at.page.locator("#tsvg .filmstrip").nth(0).bounding_box()
    assert strip is not None
    assert frames is not None
    px = frames["width"] / (at.agreed("file")["frames"] - 1)
    start = (strip["x"] + 200, strip["y"] + 5)
    drag(at.page, start, (start[0] + 6 * px, start[1]), drop=False)
    until(lambda: begins(at) == pytest.approx(BEGINS + 6, abs=0.6), "a later begin")
    screen(at.page, "films-6-strip")
    at.page.mouse.up()
    answered(at.page)
    at.page.keyboard.press("Control+z")
    until(lambda: begins(at) == BEGINS, "the clock that was found")
    assert at.agreed("undo")["undo"] is None


def test_a_picture_that_is_held_is_aligned_with_the_frame_that_shows_the_same(at: Desk) -> None:
    enlarged(at)
    bar = at.page.locator("#fclock")
    bar.get_by_role("button", name="Hold its picture").click()
    bar.get_by_role("button", name="Let go of its picture").wait_for()
    go(at, 30)
    large(at).locator("canvas.vid[data-frame='21']").wait_for()
    screen(at.page, "films-7-held")
    bar.get_by_role("button", name="Align here").click()
    until(lambda: begins(at) == 9.0, "frame 21 at frame 30")
    bar.get_by_role("button", name="Hold its picture").wait_for()


def test_where_it_may_begin_as_well_is_one_press_away_and_its_camera_is_found_for_it(
    at: Desk,
) -> None:
    card(at).get_by_role("button", name="+31.5?").click()
    at.page.get_by_text("Nothing is known of the person in side.mp4").wait_for()
    assert begins(at) == BEGINS


def test_a_click_lays_it_beside_the_first_film_and_a_key_back_into_its_corner(at: Desk) -> None:
    go(at, 24)
    card(at).locator(".filmpic").click()
    film = large(at)
    film.locator("canvas.vid[data-frame='21']").wait_for()
    film.locator("canvas.figure[data-frame='24']").wait_for()
    both = [at.page.locator(name).bounding_box() for name in ("#main", "#film")]
    assert both[0] is not None
    assert both[1] is not None
    assert both[0]["x"] + both[0]["width"] <= both[1]["x"]
    assert abs(both[0]["width"] - both[1]["width"]) <= 2
    at.page.locator("#views .view").first.wait_for(state="hidden")
    screens(at.page, "films-2-large")
    at.page.keyboard.press("7")
    card(at).wait_for()
    at.page.locator("#views .view").first.wait_for()
    film.wait_for(state="hidden")


def test_a_hand_is_dragged_there_and_the_first_film_shows_its_line_of_sight(at: Desk) -> None:
    enlarged(at)
    x, y = spot(at.page, "left_hand", "film")
    drag(at.page, (x, y), (x + 20, y - 25), drop=False)
    until(lambda: at.page.locator("#main .hands .depth").count() == 1, "the line of sight")
    there = pytest.approx((x + 20, y - 25), abs=3)
    until(lambda: spot(at.page, "left_hand", "film") == there, "the hand at the pointer")
    screen(at.page, "films-5-drag")
    at.page.mouse.up()
    answered(at.page)
    until(lambda: at.page.locator("#main .hands .depth").count() == 0, "no line of sight")
    assert section(at.page, "undo.undo") is not None


def test_a_film_is_removed_from_its_menu_and_back_after_undo(at: Desk) -> None:
    card(at).get_by_role("button", name="Menu of side.mp4").click()
    screen(at.page, "films-3-menu")
    at.page.get_by_role("menuitem", name="Remove film").click()
    until(lambda: card(at).count() == 0, "no card")
    at.page.keyboard.press("Control+z")
    until(lambda: card(at).count() == 1, "the card")


def test_a_film_that_is_dropped_where_the_page_says_so_is_added_and_not_opened(at: Desk) -> None:
    content = base64.b64encode((at.session.parent / "side.mp4").read_bytes()).decode()
    dropped = ["again.mp4", content, "to add it to"]
    at.page.evaluate(DROP, dropped)
    at.page.get_by_text("Drop a film of the same motion here").wait_for()
    screen(at.page, "films-4-drop")
    at.page.evaluate(DROP, dropped)
    at.page.get_by_text("This film is in the session already.").wait_for()
    assert section(at.page, "file.path") == str(at.session)


def test_a_film_is_chosen_from_the_file_menu(at: Desk) -> None:
    at.page.locator("#top").get_by_role("button", name="person").click()
    at.page.get_by_role("menuitem", name="Add a film").click()
    sheet = at.page.locator("#chooser")
    sheet.get_by_text("Add a film of the same motion").wait_for()
    sheet.get_by_role("searchbox").fill("side.mp4")
    sheet.get_by_role("button", name="side.mp4").first.click()
    at.page.get_by_text("This film is in the session already.").wait_for()
