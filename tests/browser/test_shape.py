"""The shape of a part, chosen in the inspector and seen in the views."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page

from keypose.app.scene.figure import part_mesh
from keypose.tracker.body.body import Body
from keypose.tracker.body.shapes import KINDS, Capsule, Solid
from tests.browser.interaction import drag, screen, section, until, until_state

PART = "left_thigh"
SIZE = (1120, 640)
"""Software draws all that is seen, four times."""

_VERTICES = """
([view, part]) => {
  const frame = document.querySelector(`.view[data-view="${view}"] iframe`);
  const node = frame?.contentWindow?.__viserMutable?.nodeRefFromName[`/camera/body/${part}`];
  let found = null;
  node?.traverse((object) => {
    const points = object.isMesh && object.geometry.attributes.position;
    if (points && !found) found = Array.from(points.array);
  });
  return found;
}
"""
"""The corners of a part as a view draws it, in the part's frame."""


@pytest.fixture
def drawn() -> bool:
    return True


def part_of(page: Page, name: str) -> dict[str, Any]:
    """A part as the server has told the page of it."""
    return next(part for part in section(page, "body")["parts"] if part["name"] == name)


def is_drawn(page: Page, view: str, index: int, shape: Solid) -> bool:
    """Whether a view draws the part of this index so."""
    found, (expected, _) = page.evaluate(_VERTICES, [view, index]), part_mesh(shape)
    if found is None or len(found) != expected.size:
        return False
    return bool(np.allclose(np.reshape(found, (-1, 3)), expected, atol=1e-4))


def radius_cm(page: Page) -> float:
    (found,) = (size["cm"] for size in part_of(page, PART)["sizes"] if size["key"] == "radius")
    return float(found)


def test_a_capsule_is_chosen_in_the_inspector_drawn_in_every_view_and_sized(
    page: Page, sample: Path
) -> None:
    until(lambda: page.locator(".view.drawn").count() == 4, "the four views")
    page.evaluate(
        """async (part) => {
          const { send } = await window.keypose.module('store/link.js');
          send({ do: 'select', part });
          send({ do: 'display', mode: 'both', opacity: 0.9 });
        }""",
        PART,
    )
    # The part selected at first is a frustum too.
    until_state(page, "view.selected", lambda selected: selected == PART)
    page.get_by_role("button", name="Shape: Frustum").click()
    offered = page.get_by_role("option").all_inner_texts()
    assert [text.strip() for text in offered] == [kind.capitalize() for kind in KINDS]
    before = section(page, "body")
    page.get_by_role("option", name="Capsule").click()
    until(lambda: part_of(page, PART)["shape"] == "capsule", "the capsule")
    assert part_of(page, "right_thigh")["shape"] == "capsule"
    body = Body.model_validate(json.loads(sample.read_text("utf-8"))["bodies"][0]["body"])
    index = body.index(PART)
    capsule = Capsule.like(body.parts[index].shape)
    for view in ("main", "top", "side", "front"):
        until(lambda view=view: is_drawn(page, view, index, capsule), f"the capsule in {view}")
    page.keyboard.press("s")
    rim = f'#main [data-grip="size:{PART}:radius"]'
    screen(page, "capsule")
    box = until(page.locator(rim).bounding_box, "the handle of the radius")
    start = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    thin = radius_cm(page)
    drag(page, start, (start[0] + 12, start[1]))
    until(lambda: abs(radius_cm(page) - thin) > 1, "another radius")
    for _ in range(2):
        page.keyboard.press("Control+z")
    until_state(page, "body", lambda reported: reported == before)
