"""A box is posed over the picture by dragging its corners, as a person would."""

from __future__ import annotations

from itertools import pairwise

import pytest
from playwright.sync_api import Page

from tests.browser.interaction import (
    Spot,
    answered,
    drag,
    screens,
    section,
    until,
    until_counted,
    until_state,
)
from tests.browser.shared import Desk


@pytest.fixture
def page(shared: Desk) -> Page:
    """A film with a person, nothing selected."""
    shared.fresh()
    return shared.page


def corner(index: int) -> str:
    return f'#main [data-grip="box-corner:box:{index}"]'


def where(page: Page, index: int) -> Spot:
    """The middle of a corner's handle."""
    box = page.locator(corner(index)).bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def is_at(page: Page, index: int, spot: Spot) -> bool:
    x, y = where(page, index)
    return abs(x - spot[0]) < 1 and abs(y - spot[1]) < 1


def placed(page: Page) -> list[int]:
    return [one["index"] for one in section(page, "pose.corners")]


def with_box(shared: Desk) -> None:
    """A box in the place of the person, at a frame where nothing was posed."""
    for frame in (0, 24, 48, 72):
        shared.visitor.do(do="delete_key", frame=frame)
    shared.visitor.do(do="preset", name="box")
    shared.visitor.do(do="angles", part="box", x=25.0, y=35.0, z=0.0)
    for name in ("pose", "body"):
        shared.agreed(name)
    until_counted(shared.page, "#main .box-corner", 7)


def test_corners_dragged_one_after_another_stay_where_they_were_put(
    page: Page, shared: Desk
) -> None:
    with_box(shared)
    seen = [i for i in range(8) if page.locator(corner(i)).count()]
    spots: dict[int, Spot] = {}
    for index, (dx, dy) in zip(seen[:3], ((12, 8), (-9, 14), (10, -7)), strict=True):
        x, y = where(page, index)
        spots[index] = x + dx, y + dy
        drag(page, (x, y), spots[index])
        until(lambda known=list(spots): placed(page) == known, "the corner is placed")
        for known, spot in spots.items():
            until(lambda i=known, at=spot: is_at(page, i, at), f"corner {known} where it was put")
        answered(page)
    until_counted(page, "#main .placed-at", 3)
    screens(page, "box-corners-1-three")
    page.keyboard.press("Control+z")
    until(lambda: placed(page) == seen[:2], "two corners")
    for known in seen[:2]:
        until(lambda i=known: is_at(page, i, spots[i]), f"corner {known} where it was put")
    until_state(page, "undo.undo", lambda label: label == "move a corner of box")


def test_alt_lets_go_of_the_other_corners(page: Page, shared: Desk) -> None:
    with_box(shared)
    seen = [i for i in range(8) if page.locator(corner(i)).count()]
    for index in seen[:2]:
        x, y = where(page, index)
        drag(page, (x, y), (x + 10, y + 5))
        until(lambda i=index: placed(page)[-1:] == [i], "the corner is placed")
        answered(page)
    before = [where(page, i) for i in seen]
    x, y = before[2]
    page.keyboard.down("Alt")
    drag(page, (x, y), (x + 20, y))
    page.keyboard.up("Alt")
    until(lambda: placed(page) == seen[2:3], "that corner alone")
    until(lambda: is_at(page, seen[2], (x + 20, y)), "the corner where it was put")
    moved = [where(page, i)[0] - old[0] for i, old in zip(seen, before, strict=True)]
    assert all(abs(one - other) < 8 for one, other in pairwise(moved)), moved


def test_a_person_s_hands_and_feet_are_pulled_whole(page: Page, shared: Desk) -> None:
    boxes = [part["name"] for part in section(page, "body.parts") if part["corners_cm"]]
    assert set(boxes) == {"left_hand", "right_hand", "left_foot", "right_foot"}
    for part in boxes:
        shared.visitor.do(do="select", part=part)
        until(lambda part=part: section(page, "view.selected") == part, "the part")  # type: ignore[misc]
        answered(page)
        assert page.locator("#main .box-corner").count() == 0
