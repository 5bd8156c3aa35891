"""Keypoints on the picture: rings that are dragged and ignored, and what is tracked by them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import Drafted
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.sidecars import save_keypoints
from tests.app.serving import ROOT
from tests.browser.interaction import (
    Spot,
    answered,
    drag,
    screens,
    section,
    settled,
    until,
    until_counted,
    until_state,
)
from tests.browser.shared import desk

UNSURE = JOINTS.index("right_elbow")
PROJECTED = """
(point) => window.keypose.view('main').project(window.keypose.server.pose.points[point])
"""


def seen(session: Session) -> Keypoints:
    """Where the film shows the joints of the first segment, one of them unsure."""
    skeleton = Skeleton.of(session.subject.body)
    _, parts, points = points_on_body(session.subject.body, JOINTS)
    where = BodyPoints.single(skeleton, parts, points)
    truth = np.load(ROOT / "sample_videos" / "person" / "truth.npz")
    rows = slice(session.subject.keyframes[1].frame + 1)
    path = Trajectory(0, truth["Rs_parent_part"][rows], truth["ps_camera_root"][rows])
    p = where.at(path.transforms(skeleton))
    sure = np.full(p.shape[:2], 0.9)
    sure[:, UNSURE] = 0.5
    return Keypoints(0, JOINTS, session.view.camera.project(p), sure)


@pytest.fixture(scope="module")
def page(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    def begin(path: Path) -> None:
        session = load_session(path)
        chosen = {"cues": ("brightness", "keypoints"), "quality": "preview"}
        settings = session.settings.model_copy(update=chosen)
        session = session.changed({"settings": settings})
        save_session(save_keypoints(session, path, seen(session), "points.json"), path)

    folder = tmp_path_factory.mktemp("keypoints")
    with desk(browser, folder, size=(1440, 900), begin=begin) as made:
        page = made.page
        page.keyboard.press("Escape")
        page.get_by_role("tab", name="Track").click()
        for _ in range(12):
            page.keyboard.press("ArrowRight")
        until_state(page, "keypoints", lambda known: known is not None and known["frame"] == 12)
        yield page


def keypoint(page: Page, joint: str = "left_wrist") -> Any:
    found = section(page, "keypoints.points")
    return next(point for point in found if point["joint"] == joint)


def ring(page: Page, joint: str = "left_wrist") -> Spot:
    """The middle of a ring on the screen."""
    settled(page)
    box = page.locator(f"[data-keypoint={joint}] .rest").bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_rings_are_there_while_the_track_tab_is_open_or_they_are_asked_for(page: Page) -> None:
    until_counted(page, "#main .keypoint", len(JOINTS))
    until_counted(page, "#main .keypoint.unsure", 1)
    page.locator("#main .hud .kp", has_text="Right elbow 50 %").wait_for()
    screens(page, "keypoints-1-rings")
    page.get_by_role("tab", name="Body").click()
    until_counted(page, "#main .keypoint", 0)
    page.locator("#mdisp").get_by_role("button", name="Show rings").click()
    until_counted(page, "#main .keypoint", len(JOINTS))
    page.get_by_role("tab", name="Track").click()
    listed = page.get_by_role("region", name="Keypoints here")
    until_counted(page, "#insp .kp", 5)
    listed.get_by_role("button", name="All 12").click()
    until_counted(page, "#insp .kp", 12)
    listed.get_by_role("button", name="Fewer").click()


def test_a_dragged_ring_corrects_the_keypoint_and_not_the_pose(page: Page) -> None:
    pose = section(page, "pose.T")
    before, (x, y) = keypoint(page), ring(page)
    drag(page, (x + 2, y + 1), (x + 42, y + 31))
    answered(page)
    assert section(page, "undo.undo") == "correct the keypoint left wrist"
    after = keypoint(page)
    assert (after["state"], after["sure"]) == ("corrected", 1)
    until(
        lambda: np.allclose(ring(page), (x + 40, y + 30), atol=1.5), "the ring where it was let go"
    )
    assert section(page, "pose.T") == pose
    page.keyboard.press("Control+z")
    until(lambda: keypoint(page) == before, "the keypoint as it was found")


def test_a_ring_is_ignored_and_put_back_by_its_menu(page: Page) -> None:
    before = keypoint(page)
    page.mouse.click(*ring(page), button="right")
    page.get_by_role("menuitem", name="Ignore here").click()
    until(lambda: keypoint(page)["state"] == "ignored", "the ring to be ignored")
    until_counted(page, "#main .keypoint.ignored", 1)
    screens(page, "keypoints-2-ignored")
    row = page.get_by_role("region", name="Keypoints here").get_by_role("button", name="Left wrist")
    row.focus()
    page.keyboard.press("Enter")
    page.get_by_role("menuitem", name="Put back").click()
    until(lambda: keypoint(page) == before, "the keypoint as it was found")


def test_a_corrected_keypoint_outdates_its_segment_and_the_motion_goes_there(page: Page) -> None:
    def segment() -> Any:
        return section(page, "segments")[0]

    def hand() -> Any:
        return page.evaluate(PROJECTED, "left_hand")[:2]

    page.keyboard.press("t")
    until(lambda: segment()["state"] in ("good", "check"), "the segment")
    x, y = ring(page)
    drag(page, (x, y), (x + 24, y + 12))
    answered(page)  # the ring lies where it was let go
    until(lambda: segment()["state"] == "outdated", "the segment to be outdated")
    assert [each["state"] for each in section(page, "segments")[1:]].count("outdated") == 0
    at = keypoint(page)["at"]
    page.keyboard.press("t")
    until(lambda: segment()["state"] in ("good", "check", "lost"), "the segment")
    wanted = page.evaluate("(at) => window.keypose.view('main').fromView(at)", at)
    # One frame against the film and all its neighbours: these keep some of the way.
    assert np.linalg.norm(np.subtract(hand(), wanted)) < np.linalg.norm((24, 12)) / 2
    screens(page, "keypoints-3-tracked")


def test_where_nobody_was_found_it_is_said_with_what_to_do(
    browser: Browser, tmp_path: Path
) -> None:
    def begin(path: Path) -> None:
        session = load_session(path)
        first = session.subject.keyframes[1]
        frames = range(31, 73)
        drafts = tuple(first.model_copy(update={"frame": n, "time_s": n / 30}) for n in frames)
        missing = [{"first_frame": 0, "last_frame": 30}]
        places = [{"frame": 40, "reason": "hidden", "parts": ["left_forearm"]}]
        found = {"first_frame": 0, "last_frame": 72, "missing": missing, "places": places}
        drafted = Drafted.model_validate(found)
        update = {"keyframes": (), "drafts": drafts, "results": None, "drafted": drafted}
        save_session(session.changed(update), path)

    with desk(browser, tmp_path, size=(1440, 900), own=True, begin=begin) as made:
        page = made.page
        page.keyboard.press("Escape")
        page.get_by_role("tab", name="Track").click()
        part = page.get_by_role("region", name="Draft")
        part.get_by_text("No person found in frames 0–30.").wait_for()
        until_counted(page, "#insp .place", 1)  # what was to be confirmed is there after a restart
        screens(page, "keypoints-4-nobody")
        part.get_by_role("button", name="Draw a box at 30").click()
        until_state(page, "view.frame", lambda frame: frame == 30)
        assert page.evaluate("() => window.keypose.ui.draftRange") == [0, 30]
        part.get_by_role("button", name="Draft 31 frames").wait_for()
        screens(page, "keypoints-5-box-there")
        last = part.get_by_label("Last frame to draft")
        last.fill("20")
        last.press("Enter")
        part.get_by_role("button", name="Draft 21 frames").wait_for()
