"""The angle of a joint by its clinical name: found, charted, said at the joint, saved."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from keypose.tracker.body.joint_angles import joint_angles
from keypose.tracker.storage.files import load_session
from tests.browser.dense import PERSON, change_session, true_poses
from tests.browser.interaction import screen, section, settled, until, until_counted, until_state
from tests.browser.shared import desk


@pytest.fixture(scope="module")
def page(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """The page of the sample with its true motion as drafts."""

    def begin(path: Path) -> None:
        change_session(path, keyframes=(), drafts=tuple(true_poses()), results=None)

    folder = tmp_path_factory.mktemp("angles")
    with desk(browser, folder, size=(1440, 900), begin=begin) as made:
        yield made.page


def knees() -> dict[str, list[float]]:
    """The true flexion, degrees, by side."""
    session = load_session(PERSON / "session.json")
    with np.load(PERSON / "truth.npz") as truth:
        Rs = truth["Rs_parent_part"]
    found = {one.joint.name: one for one in joint_angles(session.subject.body, Rs, np.eye(3))}
    return {side: found[f"{side}_knee"]["flexion"].tolist() for side in ("left", "right")}


def test_a_knee_angle_is_found_by_its_name_charted_and_saved(page: Page, tmp_path: Path) -> None:
    page.keyboard.press("Control+k")
    page.locator("#search[open] input").fill("knee angle")
    page.locator("#search [role=option]").first.wait_for()
    page.keyboard.press("Enter")
    until_state(page, "joint_angle", lambda shown: shown is not None)
    true = knees()
    until_counted(page, ".anglechart path.curve", 2)
    frame = section(page, "view.frame")
    here = [f"{round(true[side][frame])}°" for side in ("left", "right")]
    assert page.locator(".anglecard .side b").all_inner_texts() == here
    assert page.locator(".hud .jointangle").all_inner_texts() == here
    screen(page, "joint-angle")
    box = page.locator(".anglechart").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 40)
    until(lambda: section(page, "view.frame") > frame, "another frame")
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save CSV").click()
    saved.value.save_as(tmp_path / "knee.csv")
    rows = list(csv.DictReader((tmp_path / "knee.csv").read_text().splitlines()))
    assert len(rows) == len(true["left"])
    for side in ("left", "right"):
        written = [float(row[f"{side}_knee_flexion_deg"]) for row in rows]
        assert written == pytest.approx(true[side], abs=0.06)
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save picture").click()
    saved.value.save_as(tmp_path / "knee.png")
    assert (tmp_path / "knee.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "knee.png").stat().st_size > 10_000
    page.locator(".anglecard").get_by_role("button", name="Close").click()
    until_counted(page, ".anglecard", 0)


@pytest.mark.parametrize("size", [(1366, 768), (1440, 900), (1024, 600)])
def test_the_chart_is_whole_and_the_keyframes_above_it_stay_in_sight(
    page: Page, size: tuple[int, int]
) -> None:
    page.set_viewport_size({"width": size[0], "height": size[1]})
    settled(page)
    before = page.locator("#main").bounding_box()
    page.evaluate(_CHART)
    until_counted(page, ".anglechart path.curve", 2)
    settled(page)
    card, status, row = (
        page.locator(name).bounding_box() for name in (".anglecard", "#status", "#tsvg")
    )
    assert card is not None
    assert status is not None
    assert row is not None
    assert before is not None
    assert card["y"] + card["height"] <= status["y"] + 0.5
    assert card["y"] >= row["y"] + KEYFRAMES_END_PX
    chart = page.locator(".anglechart").bounding_box()
    assert chart is not None
    for text in page.locator(".anglechart text").all():
        box = text.bounding_box()
        assert box is not None
        assert chart["y"] - 1 <= box["y"]
        assert box["y"] + box["height"] <= chart["y"] + chart["height"] + 1
    page.locator(".anglecard").get_by_role("button", name="Close").click()
    until(lambda: page.locator("#main").bounding_box() == before, "the room given back")


KEYFRAMES_END_PX = 55
_CHART = """async () => (await window.keypose.module('store/link.js'))
  .send({ do: 'joint_angle', joint: 'knee', angle: 'flexion' })"""
