"""The guide for a new film: its lens, the person in it, then a draft or a pose by hand."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import av
import pytest
from playwright.sync_api import Browser, Locator, Page

from tests.app.serving import ROOT, Keypose
from tests.browser.interaction import (
    drag,
    screens,
    section,
    settled,
    until,
    until_counted,
    until_state,
)
from tests.browser.shared import Desk, admit, office, opened

FILM = ROOT / "sample_videos" / "person" / "person.mp4"
TAGS = {
    "com.apple.quicktime.camera.focal_length.35mm_equivalent": "26",
    "com.apple.quicktime.make": "Google",
    "com.apple.quicktime.model": "Pixel 7",
}


@contextmanager
def new_film(browser: Browser, folder: Path, tags: dict[str, str] | None = None) -> Iterator[Page]:
    """The page of a film that nobody has opened before."""
    film = copied_film(folder, tags)
    keypose = Keypose(str(film), "--workspace", str(folder / "workspace"))
    try:
        with admit(browser, drawn=False, size=(1440, 900)) as context:
            page = opened(context, keypose)
            until(lambda: title(page) == "Which lens?", "the guide")
            yield page
    finally:
        code, words = keypose.end()
    assert code == 0, words


def copied_film(folder: Path, tags: dict[str, str] | None = None) -> Path:
    film = folder / ("film.mov" if tags else "film.mp4")
    if tags:
        with_tags(film, tags)
    else:
        shutil.copy(FILM, film)
    return film


def with_tags(film: Path, tags: dict[str, str]) -> None:
    """The sample's film with these tags, as a phone writes them."""
    options = {"movflags": "use_metadata_tags"}
    with av.open(str(FILM)) as source, av.open(str(film), "w", options=options) as target:
        target.metadata.update(tags)
        stream = target.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(source.streams.video[0]):
            if packet.dts is not None:
                packet.stream = stream
                target.mux(packet)


@pytest.fixture
def page(browser: Browser, tmp_path: Path) -> Iterator[Page]:
    with another_film(browser, tmp_path) as made:
        yield made


@contextmanager
def another_film(
    browser: Browser, folder: Path, tags: dict[str, str] | None = None
) -> Iterator[Page]:
    """The same at a server that other films were opened with."""
    place = office(browser, folder)
    inside = place.folder / folder.name
    inside.mkdir()
    with place.desk(copied_film(inside, tags), size=(1440, 900)) as made:
        until(lambda: title(made.page) == "Which lens?", "the guide")
        yield made.page


def title(page: Page) -> str:
    heading = page.locator("#guide h3")
    return heading.inner_text() if heading.count() else ""


def kinds(page: Page) -> Locator:
    return page.locator("#guide").get_by_role("radio")


def chosen(page: Page) -> str:
    return page.locator("#guide .lens.on b").inner_text()


def test_a_film_that_says_nothing_begins_with_a_guess_that_a_key_replaces(page: Page) -> None:
    assert chosen(page) == "Don’t know"
    assert section(page, "camera.lens_is_guess")
    before = section(page, "camera.fx")
    page.keyboard.press("1")
    camera = until_state(page, "camera", lambda camera: camera["fx"] < before)
    assert camera["lens_source"] == "person"
    assert not camera["lens_is_guess"]
    assert camera["focal_mm"] == pytest.approx(26)
    until(lambda: chosen(page) == "Phone, main", "the card")
    assert page.evaluate("() => window.keypose.ui.layout") == "main"  # 1 did not choose a view
    until_counted(page, ".fan text.here", 1)
    until(lambda: "26 mm · 69°" in page.locator(".fan").inner_text(), "the angle of view")
    screens(page, "lens-1")


def test_an_action_camera_bends_edges_and_another_one_does_not(page: Page) -> None:
    page.keyboard.press("5")
    until_state(page, "camera.distortion", lambda values: values[0] < -0.1)
    page.keyboard.press("2")
    until_state(page, "camera.distortion", lambda values: not any(values))
    assert section(page, "camera.focal_mm") == pytest.approx(77)


def test_the_wheel_on_the_slider_is_one_millimetre(page: Page) -> None:
    page.keyboard.press("1")
    until_state(page, "camera.focal_mm", lambda mm: abs(mm - 26) < 1e-6)
    page.locator("#guide slide-bar").hover()
    page.mouse.wheel(0, -100)
    until_state(page, "camera.focal_mm", lambda mm: abs(mm - 27) < 1e-6)


def test_what_the_file_says_is_chosen_already_and_comes_back(
    browser: Browser, tmp_path: Path
) -> None:
    with another_film(browser, tmp_path, TAGS) as page:
        assert chosen(page) == "Phone, main"
        assert "26 mm, Google Pixel 7" in page.locator("#guide .filesays.good").inner_text()
        assert section(page, "camera.lens_source") == "file"
        kinds(page).nth(1).click()
        until_state(page, "camera.lens_source", lambda source: source == "person")
        page.locator("#guide").get_by_text("File says 26 mm").wait_for()
        page.locator("#guide").get_by_role("button", name="Use").click()
        until_state(page, "camera.lens_source", lambda source: source == "file")
        assert section(page, "camera.focal_mm") == pytest.approx(26)
        page.get_by_role("tab", name="Camera").click()
        page.locator("#insp").get_by_text("From the file: 26 mm, Google Pixel 7").wait_for()


def to_the_person(page: Page) -> None:
    """Past the lens, as it is, and how the camera is tilted, which is not known."""
    page.keyboard.press("Enter")
    until(lambda: title(page) == "How is the camera tilted?", "the next step")
    page.locator("#guide").get_by_role("button", name="Don’t know").click()
    until(lambda: title(page) == "Choose the person", "the person")


def test_enter_leads_from_the_lens_to_the_person_and_every_step_can_be_skipped(page: Page) -> None:
    to_the_person(page)
    until_state(page, "camera.lens_source", lambda source: source == "guess")  # asked, and kept
    until(lambda: page.evaluate("() => window.keypose.ui.tool") == "box", "the tool")
    for step, wanted in (("Draft", "Pose every frame"), ("Review", "Confirm the draft")):
        page.locator("#guide .steps").get_by_role("button", name=step).click()
        until(lambda wanted=wanted: title(page) == wanted, wanted)
    page.locator("#guide").get_by_role("button", name="Close guide").click()
    until_counted(page, "#guide .coach", 0)


def test_the_guide_asks_how_the_camera_is_tilted_and_a_level_one_leads_on(page: Page) -> None:
    page.keyboard.press("Enter")
    until(lambda: title(page) == "How is the camera tilted?", "the next step")
    page.locator("#main .horizon").wait_for()
    page.locator("#guide .foot .pri", has_text="Find it").wait_for()
    page.locator("#guide").get_by_role("button", name="Level camera").click()
    until_state(page, "camera.up_origin", lambda origin: origin == "drawn")
    until(lambda: title(page) == "Choose the person", "the person")
    assert section(page, "camera.tilt_deg") == pytest.approx(0)


def test_a_box_is_drawn_beside_the_card_which_then_offers_the_draft(page: Page) -> None:
    to_the_person(page)
    view = page.locator("#main").bounding_box()
    assert view is not None
    x, y = view["x"] + 0.6 * view["width"], view["y"] + 0.2 * view["height"]
    drag(page, (x, y), (x + 90, y + 300))
    settled(page)
    page.locator("#guide .filesays.good").wait_for()
    until_counted(page, "#guide .coach.behind", 0)
    page.locator("#guide .foot .pri", has_text="Draft 73 frames").wait_for()


def test_enter_waits_for_what_a_step_has_begun(page: Page) -> None:
    page.keyboard.press("Enter")
    until(lambda: title(page) == "How is the camera tilted?", "the next step")
    settled(page)
    page.evaluate(_AT_WORK)
    waiting = page.locator("#guide .foot .btn[aria-disabled=true]")
    until_counted(page, "#guide .foot .btn[aria-disabled=true]", 1)
    assert "under way" in str(waiting.get_attribute("title"))
    for _ in range(3):
        page.keyboard.press("Enter")
    settled(page)
    assert title(page) == "How is the camera tilted?"
    page.evaluate(_AT_REST)
    until_counted(page, "#guide .foot .btn[aria-disabled=true]", 0)
    page.locator("#guide").get_by_role("button", name="Level camera").click()
    until(lambda: title(page) == "Choose the person", "the person")


_JOB = """async () => {
  const { applySections } = await window.keypose.module('store/state.js');
  applySections({ job: { state: '%s', title: 'Looking for what is up', kind: 'fit' } });
}"""
_AT_WORK = _JOB % "running"
_AT_REST = _JOB % "idle"


def test_the_card_stands_beside_the_picture_and_no_body_before_the_person(
    browser: Browser, tmp_path: Path
) -> None:
    with another_film(browser, tmp_path) as page:
        page.set_viewport_size({"width": 1366, "height": 768})
        for step in range(4):
            page.locator("#guide .steps button").nth(step).click()
            settled(page)
            card, view = (page.locator(of).bounding_box() for of in ("#guide .coach", "#main"))
            assert card is not None
            assert view is not None
            assert card["x"] >= view["x"] + view["width"], step
            until_counted(page, "#main.unposed", 1)
            assert page.locator("#main .hands .grip:visible").count() == 0
        page.locator("#guide .steps button").nth(2).click()
        page.locator("#guide").get_by_role("button", name="Pose by hand instead").click()
        until_counted(page, "#main.unposed", 0)


def test_the_person_may_be_a_child_or_an_animal_and_as_tall_as_is_said(page: Page) -> None:
    to_the_person(page)
    card = page.locator("#guide")
    card.get_by_role("button", name="Child", exact=True).click()
    until_state(page, "body.preset", lambda preset: preset == "child")
    assert title(page) == "Choose the person"
    field = card.get_by_role("spinbutton", name="Height of the person")
    field.click()
    page.keyboard.press("Control+a")
    page.keyboard.type("117")
    page.keyboard.press("Enter")
    until_state(page, "body.height_cm", lambda cm: abs(cm - 117) < 1e-6)
    assert title(page) == "Choose the person", "Enter was the field's"
    card.get_by_role("button", name="Dog", exact=True).click()
    until_state(page, "body.preset", lambda preset: preset == "dog")
    until(lambda: "Step 1 of" in page.locator("#guide .foot").inner_text(), "posing by hand")


def test_posing_by_hand_is_one_press_away(page: Page) -> None:
    to_the_person(page)
    page.locator("#guide").get_by_role("button", name="Pose by hand instead").click()
    until(lambda: title(page) == "Drag the waist onto the hips", "the first step by hand")
    until(lambda: page.evaluate("() => window.keypose.ui.tool") == "move", "the tool")


def test_the_camera_tab_knows_the_lens_in_three_ways_and_fits_a_guess(page: Page) -> None:
    page.keyboard.press("Escape")
    until_counted(page, "#guide .coach", 0)
    page.get_by_role("tab", name="Camera").click()
    tab = page.locator("#insp")
    tab.get_by_text("A guess. Distances rest on it: ± 28 %.").wait_for()
    tab.get_by_role("button", name="Field", exact=True).click()
    tab.get_by_text("Angle").wait_for()
    tab.get_by_role("button", name="Pixels", exact=True).click()
    tab.get_by_text("Focal x").wait_for()
    tab.get_by_role("button", name="Lens", exact=True).click()
    tab.get_by_text("35 mm eq.").wait_for()
    page.get_by_role("tab", name="Body").click()
    until(
        tab.get_by_role("checkbox", name="With focal length").is_checked, "the guess to be fitted"
    )


def test_of_a_thing_the_guide_leads_to_its_sizes_and_its_corners(page: Page) -> None:
    to_the_person(page)
    page.locator("#guide").get_by_role("button", name="Box", exact=True).click()
    until_state(page, "body.name", lambda name: name == "box")
    until_state(page, "view.selected", lambda part: part == "box")
    page.get_by_role("tab", name="Part", selected=True).wait_for()
    until(lambda: title(page) == "Move it onto the thing", "the first step of a thing")
    until(lambda: page.evaluate("() => window.keypose.ui.tool") == "move", "its tool")
    page.keyboard.press("v")
    until_counted(page, "#main .box-corner", 4)


_FOUND = """async () => {
  const { applySections } = await window.keypose.module('store/state.js');
  applySections({ up: { frame: null, words: 'Upright lines say 3°, how the person stands says 12°.',
    lines: [[[40, 20], [42, 90]], [[90, 20], [91, 80]]], choices: [
    { label: 'Take upright lines', source: 'lines', up: [0, -0.99863, -0.05234], sigma_deg: 1 },
    { label: 'Take how the person stands', source: 'person', sigma_deg: 1.5,
      up: [0, -0.97815, -0.20791] },
  ] } });
}"""


def test_lines_lie_on_the_picture_and_where_ways_disagree_either_is_taken(at: Desk) -> None:
    page = at.page
    page.evaluate(_FOUND)
    until_counted(page, "#main .uprights path", 2)
    drawn = str(page.locator("#main .uprights path").last.get_attribute("d"))
    assert drawn.count("M") == 2
    page.locator(".fitcard").get_by_role("button", name="Take how the person stands").click()
    until_state(page, "camera.up_origin", lambda origin: origin == "drawn")
    assert section(page, "camera.tilt_deg") == pytest.approx(-12, abs=0.01)
    assert section(page, "camera.up_off_deg") == 3
    assert not section(page, "camera.up_is_sure")
