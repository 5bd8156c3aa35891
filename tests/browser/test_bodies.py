"""Several bodies in one film: each is added, posed and tracked, one of them posed at a time."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Locator

from tests.browser.interaction import answered, screen, screens, section, settled, until
from tests.browser.shared import Desk, desk

SHORT = {"do": "settings", "quality": "preview"}


@pytest.fixture(scope="module")
def work(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    with desk(browser, tmp_path_factory.mktemp("bodies"), size=(1366, 768)) as made:
        made.page.keyboard.press("Escape")
        yield made


@pytest.fixture
def at(work: Desk) -> Desk:
    work.fresh()
    return work


def chips(at: Desk) -> Locator:
    return at.page.locator("#insp .onebody")


def posed(at: Desk) -> str:
    return next(body["id"] for body in at.agreed("bodies") if body["posed"])


def add(at: Desk) -> None:
    at.page.get_by_role("tab", name="Body").click()
    at.page.get_by_role("button", name="Add a body", exact=True).click()
    chips(at).nth(1).wait_for()


def test_a_body_is_added_posed_and_named_beside_the_first_which_is_drawn_in_its_colour(
    at: Desk,
) -> None:
    add(at)
    assert posed(at) == "adult_male"
    at.page.keyboard.press("k")
    until(lambda: [len(body["keys"]) for body in at.agreed("bodies")] == [4, 1], "its keyframe")
    assert set(at.agreed("poses_beside")) == {"body"}
    chips(at).nth(1).dblclick()
    at.page.get_by_label("Name of the body").fill("Anna")
    at.page.keyboard.press("Enter")
    until(lambda: at.agreed("bodies")[1]["called"] == "Anna", "its name")
    screens(at.page, "bodies-1")


def test_what_adds_a_body_stands_beside_the_names_and_its_list_shows_that_it_goes_on(
    at: Desk,
) -> None:
    add(at)
    plus = at.page.locator("#insp .bodies button[aria-haspopup]")
    tops = [box.bounding_box() for box in (chips(at).nth(0), chips(at).nth(1), plus)]
    middles = [top["y"] + top["height"] / 2 for top in tops if top is not None]
    assert max(middles) - min(middles) < 4
    plus.click()
    shelf = at.page.locator(".drop-list:popover-open")
    end = shelf.locator(".opts").evaluate("(list) => list.getBoundingClientRect().bottom")
    rows = [row.bounding_box() for row in shelf.locator(".mi").all()]
    cut = [row for row in rows if row is not None and row["y"] < end < row["y"] + row["height"]]
    assert [abs(row["y"] + row["height"] / 2 - end) < 2 for row in cut] == [True]
    screen(at.page, "bodies-shelf")
    at.page.keyboard.press("Escape")


def test_a_click_on_a_body_in_the_picture_or_tab_poses_it(at: Desk) -> None:
    add(at)
    points = at.agreed("poses_beside")["body"]["head"]
    at.page.mouse.move(5, 300)
    x, y = at.page.evaluate(
        """(T) => {
          const view = window.keypose.view('main');
          const [u, v] = view.project([T[3], T[7] - 0.05, T[11]]);
          const { left, top } = view.over.getBoundingClientRect();
          return [left + u, top + v];
        }""",
        points,
    )
    at.page.mouse.click(x, y)
    until(lambda: posed(at) == "body", "the body that was clicked on")
    at.page.keyboard.press("Tab")
    until(lambda: posed(at) == "adult_male", "the next body")
    assert at.agreed("keys")["frames"] == []


def test_every_other_body_has_a_row_in_the_timeline_whose_keyframes_pose_it(at: Desk) -> None:
    add(at)
    row = at.page.locator("#tsvg .bodyrow")
    until(lambda: row.locator(".bodykey").count() == 4, "the keyframes of the first")
    screen(at.page, "bodies-3")
    box = row.locator(".bodykey").nth(1).bounding_box()
    assert box is not None
    at.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    until(lambda: posed(at) == "body", "the body of that row")
    frames = at.agreed("keys")["frames"]
    until(lambda: section(at.page, "view.frame") == frames[1], "its keyframe")
    until(lambda: row.locator(".bodykey").count() == 0, "the row of the other one")


def test_all_bodies_are_tracked_at_once(at: Desk) -> None:
    at.visitor.do(**SHORT)
    add(at)
    for frame in (0, 12):
        at.visitor.do(do="go", frame=frame)
        at.visitor.do(do="add_key", frame=frame)
    answered(at.page)
    settled(at.page)
    at.page.keyboard.press("t")
    until(lambda: all(body["open"] == 0 for body in at.agreed("bodies")), "both motions", 120)
    assert all(body["worst"] is not None for body in at.agreed("bodies"))
    screens(at.page, "bodies-2")


def test_a_body_that_is_removed_comes_back_with_undo(at: Desk) -> None:
    add(at)
    chips(at).nth(1).click(button="right")
    at.page.get_by_role("menuitem", name="Remove body").click()
    until(lambda: len(at.agreed("bodies")) == 1, "one body")
    at.page.keyboard.press("Control+z")
    until(lambda: len(at.agreed("bodies")) == 2, "both")
