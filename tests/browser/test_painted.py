"""The body over the film where 3D is software: the page paints it, as viser would draw it."""

from __future__ import annotations

import base64
from collections.abc import Iterator

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Browser, Page

from keypose.app.render.palette import SIDE_COLOURS, part_sides
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.storage.files import load_session
from tests.app.serving import Keypose
from tests.browser.interaction import answered, section, settled, until, until_state
from tests.browser.shared import Desk, admit, desk, opened

PIXELS = """
() => {
  const { window: seen } = window.keypose.view('main');
  const png = document.querySelector('#main canvas.figure').toDataURL();
  return { png: png.split(',')[1], corner: seen.fromPlane([0, 0]), scale: seen.scale };
}
"""
"""The painted body as a PNG, which comes in a hundredth of the time of a list of numbers, and
where the picture's first pixel lies on it."""

SMALL = (800, 480)
"""Where software draws viser's pictures."""

VISER_IN = "() => document.querySelectorAll('.view[data-view=main] iframe.viser').length"
FRAMES_SHOWN = """
() => [...document.querySelectorAll('#main canvas[data-frame]')].map((each) => each.dataset.frame)
"""


@pytest.fixture(scope="module")
def shared(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    with desk(browser, tmp_path_factory.mktemp("painted")) as made:
        yield made


@pytest.fixture
def at(shared: Desk) -> Desk:
    shared.fresh()
    return shared


def _painted(page: Page) -> NDArray[np.float64]:
    """(H, W, 4) RGBA, 0 to 255, of the body at the film's pixels."""
    answered(page)
    settled(page)
    seen = page.evaluate(PIXELS)
    png = np.frombuffer(base64.b64decode(seen["png"]), np.uint8)
    bgra = cv2.imdecode(png, cv2.IMREAD_UNCHANGED)
    assert bgra is not None
    rgba = bgra[..., [2, 1, 0, 3]]
    camera = section(page, "camera")
    columns, rows = np.arange(camera["width"]), np.arange(camera["height"])
    x = np.rint(seen["corner"][0] + columns * seen["scale"] - 0.5).astype(int)
    y = np.rint(seen["corner"][1] + rows * seen["scale"] - 0.5).astype(int)
    return rgba[np.ix_(y.clip(0, len(rgba) - 1), x.clip(0, rgba.shape[1] - 1))].astype(float)


def _parts(desk: Desk) -> NDArray[np.int32]:
    """(H, W) the part that a camera sees at each pixel of the film, −1 where none."""
    page, body = desk.page, load_session(desk.session).subject.body
    T = section(page, "pose.T")
    Ts = np.tile(np.eye(4), (len(body.parts), 1, 1))
    Ts[:, :3] = [np.reshape(T[name], (3, 4)) for name in body.names]
    known = section(page, "camera")
    camera = Camera(**{name: known[name] for name in ("width", "height", "fx", "fy", "cx", "cy")})
    return raster(BodyMesh.of(Skeleton.of(body)), Ts, ViewCamera.of(camera)).part


@pytest.mark.parametrize("frame", [0, 24, 40, 72])
def test_every_part_is_painted_where_the_camera_sees_it_before_what_it_covers(
    at: Desk, frame: int
) -> None:
    at.visitor.do(do="go", frame=frame)
    at.visitor.do(do="display", mode="solid", opacity=1.0, ghosts=False, trail=False)
    at.visitor.do(do="select", part=None)
    until_state(at.page, "view.frame", lambda now: now == frame)
    rgba, parts = _painted(at.page), _parts(at)
    is_there, is_seen = rgba[..., 3] > 128, parts >= 0
    assert is_there[is_seen].mean() > 0.995
    around = cv2.dilate(is_seen.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    assert not (is_there & ~around).any(), "no line lies farther off than it is wide"
    body = load_session(at.session).subject.body
    colours = np.array([SIDE_COLOURS[side] for side in part_sides(body)], dtype=float)
    wanted = colours[parts[is_seen]]
    # By the balance of red and blue, which shade and the lines of a part leave as it is.
    balance = rgba[is_seen][:, 0] - rgba[is_seen][:, 2]
    right = np.sign(wanted[:, 0] - wanted[:, 2]) * balance > 0
    assert right[np.abs(wanted[:, 0] - wanted[:, 2]) > 50].mean() > 0.95


def _alpha(desk: Desk, **display: object) -> float:
    """How much the body covers in the middle of its chest, 0 to 1, painted so."""
    desk.visitor.do(do="display", **display)
    answered(desk.page)
    parts = _parts(desk)
    chest = list(load_session(desk.session).subject.body.names).index("chest")
    return float(np.median(_painted(desk.page)[..., 3][parts == chest]) / 255)


def test_it_is_as_dense_as_chosen_and_wires_let_the_film_through(at: Desk) -> None:
    at.visitor.do(do="select", part="left_hand")
    at.visitor.do(do="display", ghosts=False, trail=False)
    for opacity in (0.25, 0.5, 1.0):
        assert _alpha(at, mode="solid", opacity=opacity) == pytest.approx(opacity, abs=0.02)
    assert _alpha(at, mode="wire") < 0.02
    assert _alpha(at, mode="both", opacity=0.5) >= 0.48
    at.visitor.do(do="select", part="chest")
    assert _alpha(at, mode="wire") == pytest.approx(0.12, abs=0.03)
    assert _alpha(at, mode="solid", opacity=0.5) == pytest.approx(0.62, abs=0.03)


def test_ghosts_and_the_trail_are_painted_beside_it(at: Desk) -> None:
    at.visitor.do(do="go", frame=36)
    at.visitor.do(do="select", part="left_hand")
    at.visitor.do(do="display", mode="both", ghosts=False, trail=False)
    covered = (_painted(at.page)[..., 3] > 0).sum()
    at.visitor.do(do="display", trail=True)
    with_trail = (_painted(at.page)[..., 3] > 0).sum()
    at.visitor.do(do="display", ghosts=True)
    assert covered < with_trail < (_painted(at.page)[..., 3] > 0).sum()


def test_the_body_stands_in_the_frame_that_is_shown_also_when_the_film_has_played(at: Desk) -> None:
    page = at.page
    for frame in (0, 7, 36):
        at.visitor.do(do="go", frame=frame)
        for canvas in ("vid", "figure"):
            page.wait_for_selector(f"#main canvas.{canvas}[data-frame='{frame}']")
    page.keyboard.press("Space")
    until(lambda: not page.evaluate("() => window.keypose.ui.playing"), "the end")
    until(lambda: len(set(page.evaluate(FRAMES_SHOWN))) == 1, "film and body in one frame")


def test_the_choice_between_both_is_found_by_search_and_kept_by_a_reload_that_brings_all_views_back(
    browser: Browser, keypose: Keypose
) -> None:
    with admit(browser, drawn=True, painted=True, size=SMALL) as context:
        page = opened(context, keypose)
        page.wait_for_selector("#main.painted canvas.figure[data-frame]")
        until(lambda: page.locator(".view.drawn").count() == 4, "the four views")
        assert page.evaluate(VISER_IN) == 0, "viser's page is not fetched for what it does not draw"
        _toggle(page)
        until(lambda: page.evaluate(VISER_IN) == 1, "viser's picture")
        assert not page.locator("#main.painted").count()
        page.reload()
        page.wait_for_selector("html[data-ready]", state="attached")
        until(lambda: page.evaluate(VISER_IN) == 1, "viser's picture")
        until(lambda: page.locator(".view.drawn").count() == 4, "the four views")
        _toggle(page)
        page.wait_for_selector("#main.painted canvas.figure[data-frame]")


def _toggle(page: Page) -> None:
    page.keyboard.press("Control+k")
    page.keyboard.type("draw the body without 3d")
    page.keyboard.press("Enter")
