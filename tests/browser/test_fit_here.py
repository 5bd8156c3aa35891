"""Fits to the picture as a person asks for them: a key, a card that tells what it did, and undo."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import Page

from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.storage.files import load_session
from tests.app.serving import ROOT
from tests.browser.interaction import (
    answered,
    drag,
    screen,
    section,
    spot,
    themed,
    until,
    until_counted,
    until_state,
)
from tests.browser.shared import Desk

FRAME = 24
SIZE = (1440, 900)
TURNS = {"right_forearm": -7.0, "left_upper_arm": 5.0, "right_thigh": 4.0, "left_shin": 6.0}
"""Degrees about x, as a hand that was in a hurry would leave them."""


@pytest.fixture
def at(shared: Desk) -> Desk:
    """The page as if it had just been opened, at a frame with a keyframe."""
    shared.fresh()
    shared.visitor.do(do="go", frame=FRAME)
    until_state(shared.page, "view.frame", lambda frame: frame == FRAME)
    return shared


def disturbed(desk: Desk) -> None:
    """The keyframe posed less well than it is, in one step."""
    angles = desk.served["pose"]["angles"]
    for part, by in TURNS.items():
        x = angles[part][0] + by
        desk.visitor.do(do="angles", part=part, x=x, free=True)
    desk.agreed("pose")


def error_px(desk: Desk) -> float:
    """Mean distance in the picture of all joints from where they truly are."""
    session = load_session(ROOT / "sample_videos" / "person" / "session.json")
    skeleton = Skeleton.of(session.subject.body)
    with np.load(ROOT / "sample_videos" / "person" / "truth.npz") as truth:
        pose = Pose(truth["Rs_parent_part"][FRAME], truth["ps_camera_root"][FRAME])
    true = joint_positions(skeleton, pose_transforms(skeleton, pose))
    reported = desk.served["pose"]["points"]
    here = np.array([reported[name] for name in joint_names(skeleton)])
    uv = (session.view.camera.project(points) for points in (here, true))
    return float(np.linalg.norm(np.subtract(*uv), axis=-1).mean())


def shin_cm(desk: Desk) -> float:
    """How long the left shin is."""
    (shin,) = (part for part in desk.served["body"]["parts"] if part["name"] == "left_shin")
    (length,) = (size["cm"] for size in shin["sizes"] if size["key"] == "length")
    return float(length)


def fitted(page: Page) -> None:
    """Wait for the card that tells what a fit did."""
    until_state(page, "fit", bool)
    until_counted(page, ".fitcard", 1)


def held_before(page: Page, name: str) -> None:
    """Hold the card's button, look, and let go."""
    page.locator(".fitcard .before").hover()
    page.mouse.down()
    until_state(page, "fit.looking_back", bool)
    page.get_by_text("Before the fit").wait_for()
    screen(page, name)


def test_f_lays_a_keyframe_onto_what_the_picture_shows(at: Desk) -> None:
    page = at.page
    disturbed(at)
    before, root = error_px(at), at.served["pose"]
    page.keyboard.press("f")
    fitted(page)
    after = at.agreed("pose")
    assert after["source"] == "keyframe"
    assert error_px(at) < 0.8 * before
    assert section(page, "undo.undo") == "fit the pose"
    screen(page, "fit-1-card")
    held_before(page, "fit-2-before")
    until_state(page, "pose.points", lambda points: points == root["points"])
    page.mouse.up()
    until(lambda: section(page, "pose.points") == after["points"], "what was fitted")
    page.keyboard.press("Control+z")
    until(lambda: section(page, "pose.points") == root["points"], "what was before")
    until_counted(page, ".fitcard", 0)


def test_a_look_back_ends_where_the_card_has_gone_meanwhile(at: Desk) -> None:
    page = at.page
    disturbed(at)
    page.keyboard.press("f")
    fitted(page)
    after = at.agreed("pose")
    held_before(page, "fit-2-before")
    page.keyboard.press("ArrowRight")  # another frame: the card is of the one before
    until_counted(page, ".fitcard", 0)
    page.mouse.up()
    page.keyboard.press("ArrowLeft")
    until(lambda: section(page, "pose.points") == after["points"], "what was fitted")


def test_a_frame_between_keyframes_becomes_a_draft_and_esc_closes_the_card(at: Desk) -> None:
    page = at.page
    at.visitor.do(do="go", frame=FRAME + 2)
    at.visitor.do(do="root", x=at.served["pose"]["root"][0] + 0.02)
    at.agreed("pose")
    page.get_by_role("tab", name="Part").click()
    page.get_by_role("button", name="Fit pose").click()
    until(
        lambda: section(page, "fit") or page.locator(".toast").count(),
        "the fit",
    )
    assert section(page, "keys.drafts") == [FRAME + 2]
    page.keyboard.press("Escape")
    until_counted(page, ".fitcard", 0)
    assert section(page, "keys.drafts") == [FRAME + 2]


def test_fit_here_without_any_pose_says_why_not(at: Desk) -> None:
    page = at.page
    for frame in (0, 24, 48, 72):
        at.visitor.do(do="delete_key", frame=frame)
    page.keyboard.press("f")
    page.get_by_text("Pose the body roughly first").wait_for()
    assert section(page, "job.state") == "idle"


def test_new_sizes_are_shown_compared_and_applied_in_one_step(at: Desk) -> None:
    page = at.page
    true_cm = shin_cm(at)
    at.visitor.do(do="size", part="left_shin", key="length", cm=1.06 * true_cm)
    before = at.agreed("body")
    page.get_by_role("tab", name="Body").click()
    page.get_by_role("button", name="Fit sizes").click()
    until_state(page, "sizes_preview", bool)
    page.get_by_text("Preview of new sizes").wait_for()
    page.get_by_text("New sizes fit better.").wait_for()
    screen(page, "fit-3-sizes")
    adjust = page.get_by_role("checkbox", name="Also adjust keyframe poses")
    assert section(page, "sizes_preview.turns")
    if section(page, "sizes_preview.choice"):
        adjust.click()
    until_state(page, "sizes_preview.poses", bool)
    assert abs(shin_cm(at) - true_cm) < 1.5
    after = at.agreed("body")
    page.get_by_role("button", name="Show", exact=True).click()
    screen(page, "fit-4-sizes-poses")
    page.keyboard.down("b")
    until(lambda: section(page, "body") == before, "the body as it is")
    screen(page, "fit-5-sizes-before")
    page.keyboard.up("b")
    until(lambda: section(page, "body") == after, "the new sizes")
    page.keyboard.press("Enter")
    until_state(page, "sizes_preview", lambda preview: preview is None)
    assert at.agreed("undo")["undo"] == "fit the sizes"
    assert at.agreed("body") == after
    page.keyboard.press("Control+z")
    until(lambda: at.agreed("body") == before, "the body as it was")


def test_new_sizes_that_are_discarded_with_esc_change_nothing(at: Desk) -> None:
    page = at.page
    at.visitor.do(do="size", part="left_shin", key="length", cm=1.06 * shin_cm(at))
    before = at.agreed("body")
    page.get_by_role("tab", name="Body").click()
    page.get_by_role("button", name="Fit sizes").click()
    until_state(page, "sizes_preview", bool)
    page.keyboard.press("Escape")
    until_state(page, "sizes_preview", lambda preview: preview is None)
    assert at.agreed("body") == before
    page.get_by_role("button", name="Fit sizes").wait_for()


def test_tracking_waits_for_a_fit_and_goes_on_after_it(at: Desk) -> None:
    page = at.page
    disturbed(at)
    page.keyboard.press("t")
    until_state(page, "segments", lambda all: any(s["state"] == "tracking" for s in all))
    with at.keypose.workers_stopped():  # else the fit may be done before it is seen
        page.keyboard.press("f")
        until_state(page, "job.kind", lambda kind: kind == "fit")
        screen(page, "fit-8-while-tracking")
    fitted(page)
    themed(page, "light")
    screen(page, "fit-9-after-light")
    themed(page, "dark")
    until_state(page, "job.state", lambda state: state == "done")
    assert {s["state"] for s in section(page, "segments")} <= {"good", "check", "lost"}


def test_a_drag_that_begins_at_once_wins_over_the_fit(at: Desk) -> None:
    page = at.page
    disturbed(at)
    start = spot(page, "left_hand")
    end = (start[0] + 30, start[1] - 20)
    with at.keypose.workers_stopped():  # else the fit may be done before the drag begins
        page.keyboard.press("f")
        until_state(page, "job.kind", lambda kind: kind == "fit")
        drag(page, start, end)
        answered(page)
    page.get_by_text("Fit cancelled because the pose changed").wait_for()
    assert section(page, "undo.undo") == "move left hand"
    until_state(page, "job.state", lambda state: state == "idle")
    np.testing.assert_allclose(spot(page, "left_hand"), end, atol=1.5)
    assert section(page, "fit") is None
