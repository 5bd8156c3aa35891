"""Observed surfaces on the page: the body is fitted to them, and they are seen in every view."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from keypose.app.cli.main import main
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.storage.evidence import surfaces_of
from keypose.tracker.storage.files import load_session, open_video_of
from tests.app.serving import ROOT, Keypose, Visitor
from tests.browser.interaction import (
    answered,
    drag,
    faded,
    screen,
    section,
    settled,
    until,
    until_state,
)
from tests.browser.shared import Desk, admit, opened

SAMPLE = ROOT / "sample_videos" / "arms"
SIZE = (1120, 640)
SMALL = ("top", "side", "front")
SMALL_SIZE = (800, 480)

_SKINS = """
(name) => {
  const frame = document.querySelector(`.view[data-view="${name}"] iframe`);
  const nodes = frame?.contentWindow?.__viserMutable?.nodeRefFromName ?? {};
  const found = [];
  for (const key of ['/camera/surface/0', '/camera/surface/1']) {
    nodes[key]?.traverse((object) => {
      if (object.material?.name !== 'sheet') return;
      object.geometry.computeBoundingBox();
      const { min, max } = object.geometry.boundingBox;
      found.push([[min.x, min.y, min.z], [max.x, max.y, max.z]]);
    });
  }
  return found;
}
"""
"""The boxes of the surfaces that a view draws, camera frame."""

_PIXELS = """
() => {
  const { canvas } = document.querySelector('#main canvas.vid').getContext('2d');
  return canvas.toDataURL();
}
"""


@contextmanager
def arms(browser: Browser, folder: Path, *, drawn: bool) -> Iterator[Desk]:
    """The page of a copy of the arms."""
    place = folder / "arms"
    if not place.exists():
        shutil.copytree(SAMPLE, place)
    session = place / "session.json"
    keypose = Keypose(str(session), "--workspace", str(folder / "workspace"))
    try:
        with admit(browser, drawn=drawn, size=SIZE) as context:
            visitor = Visitor(keypose)
            yield Desk(opened(context, keypose), visitor, keypose, session)
            visitor.leave()
    finally:
        code, words = keypose.end()
    assert code == 0, words
    assert "Traceback" not in words, words


@pytest.fixture(scope="module")
def shared(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    with arms(browser, tmp_path_factory.mktemp("surface"), drawn=False) as made:
        yield made


@pytest.fixture(scope="module")
def fitted(shared: Desk) -> Desk:
    """The arms once their one segment has been fitted, by the key."""
    shared.page.keyboard.press("t")
    until_state(shared.page, "segments", lambda all: all[0]["state"] in DONE)
    return shared


DONE = ("good", "check", "lost")


@pytest.fixture
def at(fitted: Desk) -> Desk:
    """Fitted, with nothing else done, at the frame of the keyframe."""
    while fitted.served["undo"]["undo"] is not None:
        fitted.visitor.do(do="undo")
    fitted.visitor.do(do="go", frame=0)
    fitted.visitor.do(do="display", tint="clay", mode="both", opacity=0.5)
    for name in ("view", "surface", "segments", "undo"):
        fitted.agreed(name)
    return fitted


def press(page: Page, words: str) -> None:
    """A choice of the inspector's last tab."""
    page.locator("#insp [role=tab]").last.click()
    page.locator("#insp").get_by_role("button", name=words, exact=True).click()


def test_one_keyframe_is_enough_to_fit(fitted: Desk) -> None:
    page = fitted.page
    (segment,) = section(page, "segments")
    assert (segment["first"], segment["last"], segment["state"]) == (0, 18, "good")
    until(lambda: page.locator("#mhead").inner_text().endswith("Good"), "the verdict")
    page.locator(".sug", has_text="All good").wait_for()
    assert "All fitted" in page.locator("#top .btn.pri").first.inner_text()
    page.locator("#insp [role=tab]").last.click()
    settled(page)
    reported = page.locator("#insp").inner_text()
    for words in ("Fit while posing", "Surface of", "Centimetres"):
        assert words in reported
    assert "Static camera" not in reported
    screen(page, "surface-fitted")


def test_the_fitted_motion_is_the_true_one(at: Desk) -> None:
    with np.load(SAMPLE / "truth.npz") as truth:
        roots = truth["ps_camera_root"]
    for frame in (5, 9, 14, 18):
        at.visitor.do(do="go", frame=frame)
        assert np.linalg.norm(np.subtract(at.served["pose"]["root"], roots[frame])) < 0.04


@pytest.mark.parametrize(
    ("tint", "high"),
    [("contact", "hidden by contact"), ("photo", "cameras disagree"), ("distance", "5 cm")],
)
def test_a_colouring_changes_the_picture_and_has_its_legend(at: Desk, tint: str, high: str) -> None:
    page = at.page
    at.visitor.do(do="go", frame=9)
    page.wait_for_selector("#main canvas.vid[data-frame='9']")
    before = page.evaluate(_PIXELS)
    page.locator(f"#mtint [data-tint={tint}]").click()
    until_state(page, "view.tint", lambda now: now == tint)
    until(lambda: page.evaluate(_PIXELS) != before, "another picture")
    page.locator("#mtint .ramp", has_text=high).wait_for()
    screen(page, f"surface-{tint}")


def test_with_four_views_the_colours_are_chosen_and_read_in_the_camera_s(at: Desk) -> None:
    page = at.page
    page.keyboard.press("5")
    page.locator("[data-view=main] #mtint [data-tint=distance]").click()
    until_state(page, "view.tint", lambda now: now == "distance")
    page.locator("[data-view=main] #mtint .ramp").wait_for()
    screen(page, "surface-four-views")
    page.keyboard.press("1")


@pytest.mark.parametrize(("view", "tint"), [("all", "clay"), ("top", "contact"), ("main", "photo")])
def test_the_picture_is_that_of_the_command_line_in_the_colours_that_are_chosen(
    at: Desk, tmp_path: Path, view: str, tint: str
) -> None:
    page = at.page
    at.visitor.do(do="go", frame=9)
    at.visitor.do(do="display", tint=tint)
    until_state(page, "view.tint", lambda now: now == tint)
    until(lambda: at.agreed("saved")["state"] == "saved", "the file")
    keys = {"top": "2"}
    if view in keys:
        page.keyboard.press(keys[view])
    page.get_by_role("button", name="Export").click()
    name = "All four views" if view == "all" else "This view, PNG"
    with page.expect_download() as waiting:
        page.get_by_role("menuitem", name=name).click()
    saved = Path(waiting.value.path()).read_bytes()
    if view in keys:
        page.keyboard.press(keys[view])
    out = tmp_path / "shot.png"
    wanted = ["--frame", "9", "--view", view, "--tint", tint, "--out", str(out)]
    assert main(["shot", str(at.session), *wanted]) == 0
    assert saved == out.read_bytes()


def test_how_to_fit_is_an_edit_like_any_other(at: Desk) -> None:
    page = at.page
    press(page, "To points")
    until_state(page, "surface.distance", lambda now: now == "point")
    assert at.agreed("segments")[0]["state"] == "outdated"
    page.keyboard.press("Control+z")
    until_state(page, "surface.distance", lambda now: now == "plane")
    assert at.agreed("segments")[0]["state"] == "good"


def test_another_keyframe_s_surface_can_be_the_one_that_moves(at: Desk) -> None:
    page = at.page
    at.visitor.do(do="go", frame=3)
    at.agreed("view")
    page.keyboard.press("k")
    until_state(page, "keys.frames", lambda frames: frames == [0, 3])
    press(page, "Use frame 3")
    until_state(page, "surface.model_frame", lambda frame: frame == 3)
    assert [s["state"] for s in at.agreed("segments")] == ["outdated", "outdated"]


def test_the_camera_tab_says_that_nobody_filmed(at: Desk) -> None:
    page = at.page
    page.get_by_role("tab", name="Camera").click()
    settled(page)
    reported = page.locator("#insp-body").inner_text()
    assert "A virtual camera in front of the first surface" in reported
    assert "Distortion" not in reported
    screen(page, "surface-camera")
    page.get_by_role("tab", name="Part").click()


def test_a_hand_drag_moves_the_body_in_the_surface(at: Desk) -> None:
    page = at.page
    before = section(page, "pose.root")
    page.keyboard.press("g")
    answered(page)
    x, y = page.evaluate(
        """() => {
          const view = window.keypose.view('main');
          const [x, y] = view.project(window.keypose.server.pose.root);
          const box = view.el.getBoundingClientRect();
          return [box.left + x, box.top + y];
        }"""
    )
    drag(page, (x, y), (x + 40, y + 10))
    answered(page)
    assert section(page, "pose.root")[0] > before[0] + 0.01
    page.keyboard.press("v")


def test_the_page_is_as_clear_on_a_small_screen_and_by_day(at: Desk) -> None:
    page = at.page
    at.visitor.do(do="go", frame=7)
    at.visitor.do(do="display", tint="distance")
    at.agreed("view")
    page.set_viewport_size({"width": 1280, "height": 720})
    page.evaluate("() => { document.documentElement.dataset.theme = 'light'; }")
    faded(page)
    screen(page, "surface-light-1280x720")
    head, tints = (page.locator(name).bounding_box() for name in ("#mhead", "#mtint"))
    assert head is not None
    assert tints is not None
    assert tints["y"] >= head["y"] + head["height"]
    page.evaluate("() => { document.documentElement.dataset.theme = 'dark'; }")
    page.set_viewport_size({"width": SIZE[0], "height": SIZE[1]})


# --- in viser's small views


@pytest.fixture(scope="module")
def drawn(browser: Browser, shared: Desk) -> Iterator[Desk]:
    """One more tab, with viser's pictures."""
    with admit(browser, drawn=True, size=SMALL_SIZE) as context:
        yield replace(shared, page=opened(context, shared.keypose))


@pytest.fixture
def at_views(at: Desk, drawn: Desk) -> Desk:
    return drawn


def boxes(page: Page, view: str) -> list[Array]:
    return [np.array(box) for box in page.evaluate(_SKINS, view)]


def box_of(session: Path, frame: int) -> Array:
    """Least and greatest coordinates of a step's surface, camera frame, metres."""
    with open_video_of(load_session(session), session) as video:
        vertices = surfaces_of(video).steps.shape(frame).vertices
    return np.array([vertices.min(axis=0), vertices.max(axis=0)])


def until_seen(page: Page, wanted: Array) -> None:
    """Wait until every small view draws this surface, and nothing but it."""
    for view in SMALL:

        def is_drawn(view: str = view) -> bool:
            drawn = boxes(page, view)
            return len(drawn) == 1 and np.allclose(drawn[0], wanted, atol=1e-3)

        until(is_drawn, f"the surface in {view}")


def test_the_surface_of_the_present_frame_is_seen_in_the_small_views(at_views: Desk) -> None:
    page = at_views.page
    until_seen(page, box_of(at_views.session, 0))
    assert boxes(page, "main") == []  # there it is in the picture
    screen(page, "surface-opened")


def test_after_quick_scrubbing_the_surface_of_the_last_frame_stands_alone(at_views: Desk) -> None:
    page = at_views.page
    for frame in (*range(19), *range(18, 4, -1)):
        at_views.visitor.send(do="go", frame=frame)
    until_state(page, "view.frame", lambda frame: frame == 5)
    page.wait_for_selector("#main canvas.vid[data-frame='5']")
    until_seen(page, box_of(at_views.session, 5))


def test_playing_through_ends_at_the_last_surface(at_views: Desk) -> None:
    page = at_views.page
    page.keyboard.press("Space")
    until_state(page, "view.frame", lambda frame: frame == 18)
    until_seen(page, box_of(at_views.session, 18))


def test_other_units_keep_the_picture_and_move_the_surface(at_views: Desk) -> None:
    page = at_views.page
    near = box_of(at_views.session, 0)
    at_views.visitor.do(do="observe", units="dm")
    until(lambda: _is_at(page, 10 * near), "the larger surface")
    at_views.visitor.do(do="undo")
    until_seen(page, near)


def _is_at(page: Page, box: Array) -> bool:
    drawn = boxes(page, "front")
    return len(drawn) == 1 and bool(np.allclose(drawn[0], box, rtol=1e-3))


# --- steps that cannot be used


@pytest.fixture(scope="module")
def torn(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    """The arms, of which two steps cannot be read."""
    folder = tmp_path_factory.mktemp("torn")
    shutil.copytree(SAMPLE, folder / "arms")
    for step in (7, 12):
        (folder / "arms" / "meshes" / f"step_{step:04}.ply").write_bytes(b"")
    with arms(browser, folder, drawn=False) as made:
        yield made


def test_steps_that_cannot_be_used_are_reported_before_they_are_met(torn: Desk) -> None:
    page = torn.page
    page.locator("#insp [role=tab]").last.click()
    reported = page.locator("#insp .note.warned")
    reported.wait_for()
    assert reported.inner_text().startswith(
        "Steps 7 and 12 cannot be used. The first of them: Step 7"
    )
    assert section(page, "view.frame") == 0
    reported.scroll_into_view_if_needed()
    screen(page, "surface-unusable")


def test_a_step_that_cannot_be_used_is_reported_at_its_frame(torn: Desk) -> None:
    page = torn.page
    torn.visitor.do(do="go", frame=6)
    page.wait_for_selector("#main canvas.vid[data-frame='6']")
    problem = page.locator("#mproblem")
    assert problem.count() == 0
    torn.visitor.do(do="go", frame=7)
    problem.wait_for()
    assert "step_0007.ply" in problem.inner_text()
    page.wait_for_selector("#main canvas.vid[data-frame='7']")
    screen(page, "surface-problem")
    torn.visitor.do(do="go", frame=8)
    until(lambda: problem.count() == 0, "no problem any more")


def test_surfaces_are_a_sample_of_the_start_screen(browser: Browser, tmp_path: Path) -> None:
    keypose = Keypose("--workspace", str(tmp_path / "workspace"))
    try:
        with admit(browser, drawn=False, size=(1280, 720)) as context:
            page = context.new_page()
            page.goto(keypose.address)
            page.get_by_text("Try surfaces").wait_for()
            screen(page, "surface-start-1280x720")
            page.get_by_text("Try surfaces").click()
            until(lambda: _surface_of(page), "the arms")
            assert section(page, "file.frames") == 19
    finally:
        keypose.end()


def _surface_of(page: Page) -> Any:
    return page.evaluate("() => window.keypose?.server.surface")
