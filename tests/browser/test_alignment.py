"""The body lies on the picture, and the three other views are true: to half a pixel, any size."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from keypose.tracker.geometry.rotations import Array
from tests.browser.interaction import section, until, until_state
from tests.browser.shared import Desk, desk

LIMIT_PX = 0.5
SIZES = ((1100, 640), (900, 520), (760, 660))
ZOOMS = (1.0, 2.7, 8.0)

_SEEN = """
(name) => {
  const view = window.keypose.view(name);
  const frame = view.el.querySelector('iframe');
  const inner = frame.contentWindow.__viserMutable;
  if (!inner?.camera || !inner.canvas) return null;
  const { camera, canvas } = inner;
  const outer = frame.getBoundingClientRect();
  const box = canvas.getBoundingClientRect();
  const film = view.el.querySelector('canvas.vid')?.getBoundingClientRect();
  const own = view.el.getBoundingClientRect();
  const points = Object.values(window.keypose.server.pose.points);
  return {
    matrix: camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).elements.slice(),
    canvas: [outer.left + box.left, outer.top + box.top, box.width, box.height],
    film: film && [film.left, film.top, film.width, film.height],
    points,
    handles: points.map((p) => view.project(p).slice(0, 2)),
    window: view.window && [view.window.x, view.window.y, view.window.scale],
    own: [own.left, own.top, own.width, own.height],
  };
}
"""


def drawn(seen: dict[str, Any]) -> Array:
    """Where viser's renderer puts the points, pixels of the window: (N, 2)."""
    matrix = np.array(seen["matrix"]).reshape(4, 4).T
    p_world = np.array(seen["points"]) * (1, -1, -1)  # three.js: y up, z toward the viewer
    clip = np.c_[p_world, np.ones(len(p_world))] @ matrix.T
    x, y = (clip[:, :2] / clip[:, 3:]).T
    left, top, width, height = seen["canvas"]
    return np.c_[left + (x + 1) / 2 * width, top + (1 - y) / 2 * height]


def filmed(seen: dict[str, Any], camera: dict[str, Any]) -> Array:
    """Where they lie on the picture as it is shown, by OpenCV's projection: (N, 2)."""
    K = np.array([[camera["fx"], 0, camera["cx"]], [0, camera["fy"], camera["cy"]], [0, 0, 1.0]])
    none = np.zeros(3)
    uv = cv2.projectPoints(np.array(seen["points"]), none, none, K, None)[0].reshape(-1, 2)
    left, top, width, height = seen["film"]
    scale = width / camera["width"], height / camera["height"]
    return np.c_[left + (uv[:, 0] + 0.5) * scale[0], top + (uv[:, 1] + 0.5) * scale[1]]


def flat(seen: dict[str, Any], R_view_camera: Array) -> Array:
    """Where a true orthographic view shows them: (N, 2)."""
    at = (np.array(seen["points"]) @ R_view_camera.T)[:, :2]
    x, y, scale = seen["window"]
    left, top, width, height = seen["own"]
    return (at - (x, y)) * scale + (left + width / 2, top + height / 2)


def rms(one: Array, other: Array) -> float:
    return float(np.sqrt(((one - other) ** 2).sum(axis=1).mean()))


def look(page: Page, name: str) -> dict[str, Any]:
    return dict(until(lambda: page.evaluate(_SEEN, name), f"the {name} view"))


def zoomed(page: Page, name: str, factor: float) -> None:
    page.evaluate(
        """([name, factor]) => {
          const view = window.keypose.view(name);
          view.fit();
          if (factor !== 1) view.zoomAt(90, 70, factor);
        }""",
        [name, factor],
    )


@pytest.fixture(scope="module")
def shared(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    with desk(browser, tmp_path_factory.mktemp("alignment"), drawn=True, size=SIZES[0]) as made:
        yield made


@pytest.fixture
def page(shared: Desk) -> Page:
    """The page as if it had just been opened."""
    _resize(shared.page, SIZES[0])
    shared.fresh()
    return shared.page


def _resize(page: Page, size: tuple[int, int]) -> None:
    page.set_viewport_size({"width": size[0], "height": size[1]})


@pytest.mark.parametrize("size", SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def test_body_and_handles_lie_where_the_calibrated_camera_sees_them(
    page: Page, size: tuple[int, int]
) -> None:
    _resize(page, size)
    camera = section(page, "camera")
    for zoom in ZOOMS:
        zoomed(page, "main", zoom)

        def lies_right() -> bool:
            seen = look(page, "main")
            wanted = filmed(seen, camera)
            handles = np.array(seen["handles"]) + seen["own"][:2]
            return max(rms(drawn(seen), wanted), rms(handles, wanted)) <= LIMIT_PX

        until(lies_right, f"the body on the picture at zoom {zoom}")


@pytest.mark.parametrize("name", ["top", "side", "front"])
def test_the_small_views_are_truly_orthographic(page: Page, name: str) -> None:
    R_view_camera = np.array(section(page, "views")[name])
    for zoom in (1.0, 3.0):
        zoomed(page, name, zoom)

        def is_true() -> bool:
            seen = look(page, name)
            wanted = flat(seen, R_view_camera)
            handles = np.array(seen["handles"]) + seen["own"][:2]
            return max(rms(drawn(seen), wanted), rms(handles, wanted)) <= LIMIT_PX

        until(is_true, f"a true {name} view at zoom {zoom}")


def test_a_lens_with_its_axis_off_the_middle_is_followed(page: Page) -> None:
    page.evaluate(
        """async () => {
          const { send } = await window.keypose.module('store/link.js');
          send({ do: 'camera', fx: 700, fy: 780, cx: 250, cy: 150 });
        }"""
    )
    until(lambda: section(page, "camera")["cx"] == 250, "the camera")

    def lies_right() -> bool:
        seen = look(page, "main")
        return rms(drawn(seen), filmed(seen, section(page, "camera"))) <= LIMIT_PX

    until(lies_right, "the body on the picture")


_LOOPS = """
() => [...document.querySelectorAll('iframe.viser')].map((frame) => (
  frame.contentWindow.__viserMutable.scene.__r3f.root.getState().frameloop
))
"""


def test_views_sleep_where_nothing_happens_and_draw_what_happens_then(page: Page) -> None:
    until(lambda: set(page.evaluate(_LOOPS)) == {"never"}, "sleep")
    camera, before = section(page, "camera"), drawn(look(page, "main"))
    page.keyboard.press("ArrowRight")
    until_state(page, "view.frame", lambda frame: frame == 1)

    def lies_right() -> bool:
        seen = look(page, "main")
        return rms(drawn(seen), filmed(seen, camera)) <= LIMIT_PX

    until(lies_right, "the body where it is now")
    assert rms(drawn(look(page, "main")), before) > LIMIT_PX
