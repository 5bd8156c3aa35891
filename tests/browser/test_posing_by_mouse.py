"""Posing as a person does it: with the mouse on the picture, and with the keys beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page

from keypose.tracker.geometry.rotations import Array
from tests.browser.interaction import (
    Spot,
    between,
    copied_to_clipboard,
    drag,
    section,
    settled,
    spot,
    until,
    until_counted,
    until_state,
)
from tests.browser.shared import Desk

UNDER_PX = 1.5


def points(desk: Desk) -> dict[str, Array]:
    """Where the joints and landmarks are, as the server has it: camera frame, metres."""
    return {name: np.array(p) for name, p in desk.served["pose"]["points"].items()}


def bones(desk: Desk) -> Array:
    """The distance of every joint from the joint it hangs on."""
    places = points(desk)
    parts = desk.served["body"]["parts"]
    pairs = [(part["name"], part["parent"]) for part in parts if part["parent"]]
    return np.array([np.linalg.norm(places[one] - places[other]) for one, other in pairs])


def released(desk: Desk) -> None:
    """Let go, and wait until the step is done."""
    desk.page.mouse.up()
    until(lambda: desk.agreed("pose")["stroke"] is None, "the end of the drag")


def pulled(desk: Desk, start: Spot, by: Spot) -> Spot:
    """Drag from a spot by so many pixels; where the pointer was let go."""
    end = (start[0] + by[0], start[1] + by[1])
    drag(desk.page, start, end, steps=4, drop=False)
    until_state(desk.page, "pose.gesture", bool)
    released(desk)
    return end


def undo_steps(desk: Desk) -> int:
    """How many steps can be taken back; they are taken back."""
    steps = 0
    while desk.served["undo"]["undo"] is not None:
        desk.visitor.do(do="undo")
        steps += 1
    return steps


@contextmanager
def held(page: Page, key: str) -> Iterator[None]:
    page.keyboard.down(key)
    yield
    page.keyboard.up(key)


def selected(desk: Desk, part: str) -> None:
    """Select a part by its name, as the list of parts does."""
    desk.visitor.do(do="select", part=part)
    desk.agreed("view")
    settled(desk.page)


# --- handles


def test_a_handle_ends_under_the_pointer_and_no_bone_changes(at: Desk) -> None:
    before, root = bones(at), points(at)["waist"]
    end = pulled(at, spot(at.page, "left_hand"), (34, -22))
    np.testing.assert_allclose(spot(at.page, "left_hand"), end, atol=UNDER_PX)
    np.testing.assert_allclose(bones(at), before, atol=2e-5)
    np.testing.assert_allclose(points(at)["waist"], root, atol=1e-9)
    assert undo_steps(at) == 1


def test_beyond_its_reach_a_hand_stays_on_the_circle_and_says_so(at: Desk) -> None:
    start = spot(at.page, "left_hand")
    drag(at.page, start, (start[0] + 250, start[1] - 200), steps=4, drop=False)
    gesture = until_state(at.page, "pose.gesture", lambda g: bool(g) and g["out_of_reach"])
    reach = gesture["reach"]
    until_counted(at.page, "#main circle.reach", 1)
    until_counted(at.page, "#main .grip.far", 1)
    released(at)
    away = np.linalg.norm(points(at)["left_hand"] - np.array(reach["centre"]))
    assert away == pytest.approx(reach["radius_m"], abs=2e-3)


def test_a_knee_ends_under_the_pointer_and_its_foot_stays_where_it_is_seen(at: Desk) -> None:
    lengths = bones(at)
    start, seen = spot(at.page, "left_shin"), spot(at.page, "left_foot")
    pointer = pulled(at, start, (12, -6))
    np.testing.assert_allclose(spot(at.page, "left_shin"), pointer, atol=UNDER_PX)
    np.testing.assert_allclose(spot(at.page, "left_foot"), seen, atol=UNDER_PX)
    np.testing.assert_allclose(bones(at), lengths, atol=2e-5)
    assert undo_steps(at) == 1
    at.agreed("pose")


ENDS = ("left_hand", "right_hand", "left_foot", "right_foot")


def test_a_foot_that_cannot_stay_is_named_and_alt_takes_it_along(at: Desk) -> None:
    start, foot = spot(at.page, "waist"), points(at)["left_foot"]
    drag(at.page, start, (start[0], start[1] - 90), steps=4, drop=False)
    gesture = until_state(at.page, "pose.gesture", lambda g: bool(g) and len(g["unreached"]) == 4)
    assert set(gesture["unreached"]) == set(ENDS)
    until_counted(at.page, "#main .grip.far", 4)
    assert "cannot reach" in at.page.locator(".hud .flt .unreached").inner_text()
    with held(at.page, "Alt"):
        until_state(at.page, "pose.gesture", lambda g: bool(g) and g["unreached"] == [])
        until_counted(at.page, ".hud .flt .unreached", 0)
        up = points(at)["left_foot"] - foot
        assert up[1] < -0.05
    until_state(at.page, "pose.gesture", lambda g: bool(g) and len(g["unreached"]) == 4)
    released(at)
    straight = points(at)["left_shin"] - points(at)["left_thigh"]
    lower = points(at)["left_foot"] - points(at)["left_shin"]
    cosine = straight @ lower / np.linalg.norm(straight) / np.linalg.norm(lower)
    assert cosine > np.cos(np.radians(2))


def test_the_whole_body_is_carried_by_its_tool(at: Desk) -> None:
    before = points(at)
    at.page.keyboard.press("g")
    end = pulled(at, spot(at.page, "waist"), (40, -18))
    np.testing.assert_allclose(spot(at.page, "waist"), end, atol=UNDER_PX)
    ways = np.array([p - before[name] for name, p in points(at).items()])
    assert np.abs(ways[:, 2]).max() < 1e-5
    np.testing.assert_allclose(ways, np.broadcast_to(ways[0], ways.shape), atol=2e-5)
    assert undo_steps(at) == 1


def test_the_body_is_set_in_depth_in_the_side_view(at: Desk) -> None:
    before = points(at)["waist"]
    scale = at.page.evaluate("() => window.keypose.view('side').window.scale")
    pulled(at, spot(at.page, "waist", "side"), (20, 0))
    away = np.array(section(at.page, "views.side"))[0]  # where the pointer went, in space
    np.testing.assert_allclose(points(at)["waist"] - before, away * 20 / scale, atol=2e-3)
    assert abs(away[2]) > 0.9


def test_with_d_held_a_hand_goes_along_its_own_ray(at: Desk) -> None:
    start, depth = spot(at.page, "left_hand"), points(at)["left_hand"][2]
    with held(at.page, "d"):
        pulled(at, start, (0, 14))
    assert points(at)["left_hand"][2] < depth - 0.03
    np.testing.assert_allclose(spot(at.page, "left_hand"), start, atol=UNDER_PX)


# --- rings


def knob(page: Page, axis: str) -> Spot:
    box = until(page.locator(f'#main [data-ring="{axis}"] .knob').bounding_box, "the ring")
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_a_ring_with_ctrl_turns_by_steps_of_5_degrees(at: Desk) -> None:
    at.visitor.do(do="limits", on=False)
    selected(at, "right_shin")
    before = at.served["pose"]["T"]["right_shin"]
    x, y = knob(at.page, "x")
    with held(at.page, "Control"):
        drag(at.page, (x, y), (x + 9, y + 31), steps=5, drop=False)
        gesture = until_state(at.page, "pose.gesture", bool)
        released(at)
    assert gesture["axis"] == "x"
    turned = _angle_deg(before, at.served["pose"]["T"]["right_shin"])
    assert turned == pytest.approx(5 * round(turned / 5), abs=0.01)
    assert turned > 4


def _angle_deg(one: list[float], other: list[float]) -> float:
    """The turn between two poses of a part, rows of 3×4 matrices."""
    R, Q = (np.array(rows).reshape(3, 4)[:, :3] for rows in (one, other))
    return float(np.degrees(np.arccos(np.clip((np.trace(R.T @ Q) - 1) / 2, -1, 1))))


def test_a_limb_is_turned_by_its_surface(at: Desk) -> None:
    before = at.served["pose"]["angles"]["right_thigh"]
    start = between(at.page, "right_thigh", "right_shin")
    pulled(at, start, (18, 2))
    assert at.agreed("view")["selected"] == "right_thigh"
    assert np.abs(np.subtract(at.served["pose"]["angles"]["right_thigh"], before)).max() > 2


# --- what the keys do to a drag


def test_escape_takes_a_drag_back(at: Desk) -> None:
    before = at.served["pose"]
    start = spot(at.page, "left_hand")
    drag(at.page, start, (start[0] + 30, start[1]), steps=4, drop=False)
    until_state(at.page, "pose.gesture", bool)
    at.page.keyboard.press("Escape")
    assert at.agreed("pose") == before
    at.page.mouse.move(start[0] + 60, start[1], steps=3)
    released(at)
    assert at.agreed("pose") == before
    assert at.served["undo"]["undo"] is None


def test_the_right_button_takes_a_drag_back(at: Desk) -> None:
    before = at.served["pose"]
    start = spot(at.page, "right_foot")
    drag(at.page, start, (start[0] + 30, start[1]), steps=4, drop=False)
    until_state(at.page, "pose.gesture", bool)
    at.page.mouse.down(button="right")
    at.page.mouse.move(start[0] + 40, start[1])
    until_state(at.page, "pose.stroke", lambda stroke: stroke is None)
    at.page.mouse.up(button="right")
    released(at)
    assert at.agreed("pose") == before


def test_with_shift_a_handle_goes_a_tenth_of_the_way(at: Desk) -> None:
    start = spot(at.page, "waist")
    with held(at.page, "Shift"):
        pulled(at, start, (100, 40))
    np.testing.assert_allclose(np.subtract(spot(at.page, "waist"), start), (10, 4), atol=0.5)


# --- clicks


def test_a_click_on_the_body_selects_what_lies_there(at: Desk) -> None:
    for one, other in (("right_shin", "right_foot"), ("left_thigh", "left_shin")):
        at.page.mouse.click(*between(at.page, one, other))
        until_state(at.page, "view.selected", lambda part, one=one: part == one)
        label = one.replace("_", " ").capitalize()
        until_counted(at.page, f".fig [aria-label='{label}'][aria-pressed=true]", 1)
    at.page.mouse.click(*_beside_the_body(at.page))
    until_state(at.page, "view.selected", lambda part: part is None)


def _beside_the_body(page: Page) -> Spot:
    box = page.locator("#main canvas.vid").bounding_box()
    assert box is not None
    return box["x"] + box["width"] * 0.93, box["y"] + box["height"] * 0.5


def test_a_double_click_selects_the_limb(at: Desk) -> None:
    at.page.mouse.dblclick(*between(at.page, "right_thigh", "right_shin"))
    until(lambda: at.page.evaluate("() => window.keypose.ui.limb"), "the limb")
    assert at.page.evaluate("() => window.keypose.ui.limb") == [
        "right_thigh", "right_shin", "right_foot",
    ]  # fmt: skip


# --- numbers and whole poses


def field(page: Page, block: str, number: int) -> Any:
    """A number field of a section of the inspector."""
    return page.get_by_role("region", name=block).get_by_role("spinbutton").nth(number)


def typed(page: Page, there: Any, text: str) -> None:
    there.click()
    page.keyboard.press("Control+a")
    page.keyboard.type(text)
    page.keyboard.press("Enter")


def test_a_number_typed_with_a_sign_is_added(at: Desk) -> None:
    selected(at, "left_forearm")
    before = at.served["pose"]["angles"]["left_forearm"][0]
    typed(at.page, field(at.page, "Rotation", 0), "+5")
    until(lambda: at.served["pose"]["angles"]["left_forearm"][0] != before)
    assert at.served["pose"]["angles"]["left_forearm"][0] == pytest.approx(before + 5, abs=1e-3)
    typed(at.page, field(at.page, "Rotation", 0), "-=30/2")
    until(lambda: at.agreed("pose")["angles"]["left_forearm"][0] < before)
    assert at.served["pose"]["angles"]["left_forearm"][0] == pytest.approx(before - 10, abs=1e-3)
    assert undo_steps(at) == 2


def test_a_number_beyond_a_limit_is_held_until_the_limit_is_lifted(at: Desk) -> None:
    selected(at, "left_shin")
    part = next(p for p in at.served["body"]["parts"] if p["name"] == "left_shin")
    low, high = part["limits"]["x"]
    wild = high + 10 if abs(high) < abs(low) else low - 10
    typed(at.page, field(at.page, "Rotation", 0), str(wild))
    at.agreed("undo")
    assert low - 1e-3 <= at.agreed("pose")["angles"]["left_shin"][0] <= high + 1e-3
    at.page.get_by_role("checkbox", name="Joint limits").click()
    until(lambda: at.agreed("view")["limits"] is False)
    typed(at.page, field(at.page, "Rotation", 0), str(wild))
    until(lambda: at.served["pose"]["angles"]["left_shin"][0] == pytest.approx(wild, abs=1e-3))


def test_backspace_resets_the_part_and_with_shift_the_pose(at: Desk) -> None:
    selected(at, "left_forearm")
    others = {**at.served["pose"]["angles"]}
    at.page.keyboard.press("Backspace")
    until(lambda: at.served["pose"]["angles"]["left_forearm"] == [0, 0, 0])
    after = at.served["pose"]["angles"]
    assert {k: v for k, v in after.items() if k != "left_forearm"} == {
        k: v for k, v in others.items() if k != "left_forearm"
    }
    at.page.keyboard.press("Shift+Backspace")
    until(lambda: not np.any(list(at.served["pose"]["angles"].values())))
    assert undo_steps(at) == 2


def moved_to(desk: Desk, frame: int) -> None:
    desk.visitor.do(do="go", frame=frame)
    desk.agreed("view")
    desk.agreed("pose")


def test_a_pose_is_copied_and_pasted(at: Desk) -> None:
    copied = at.served["pose"]
    copied_to_clipboard(at.page, lambda: at.page.keyboard.press("Control+c"))
    moved_to(at, 30)
    at.page.keyboard.press("Control+v")
    until(lambda: at.agreed("pose")["source"] == "draft")
    assert _same_angles(at.served["pose"], copied)
    np.testing.assert_allclose(at.served["pose"]["root"], copied["root"], atol=1e-5)
    assert at.agreed("keys")["drafts"] == [30]


def _same_angles(one: dict[str, Any], other: dict[str, Any]) -> bool:
    names = one["angles"]
    return all(np.allclose(names[n], other["angles"][n], atol=0.01) for n in names)


def tab(page: Page, name: str) -> None:
    page.get_by_role("tab", name=name).click()
    settled(page)


@pytest.fixture
def tabs(at: Desk) -> Iterator[Callable[[str], None]]:
    """Turn to a tab of the inspector; afterwards the usual one stands there again."""
    yield lambda name: tab(at.page, name)
    tab(at.page, "Part")


def test_a_preset_changes_the_body_and_keeps_the_keyframes(
    at: Desk, tabs: Callable[[str], None]
) -> None:
    tabs("Body")
    before = at.served["body"]["height_cm"]
    keys = at.served["keys"]
    at.page.get_by_role("button", name="Preset:").click()
    at.page.get_by_role("option", name="Elderly female").click()
    until(lambda: at.agreed("body")["height_cm"] != before)
    assert at.served["body"]["preset"] == "elderly_female"
    assert at.agreed("keys") == keys
    assert undo_steps(at) == 1


def on_picture(page: Page, uv: Spot) -> Spot:
    """Where a pixel of the picture is seen."""
    box = page.locator("#main canvas.vid").bounding_box()
    assert box is not None
    width, height = (section(page, f"camera.{side}") for side in ("width", "height"))
    across, down = (uv[0] + 0.5) / width, (uv[1] + 0.5) / height
    return box["x"] + box["width"] * across, box["y"] + box["height"] * down


def test_a_mask_is_drawn_on_the_picture_moved_and_deleted(
    at: Desk, tabs: Callable[[str], None]
) -> None:
    tabs("Camera")
    corners = [(400, 120), (520, 130), (500, 260), (410, 240)]
    at.page.get_by_role("button", name="Draw a mask in the image").click()
    for corner in corners:
        at.page.mouse.click(*on_picture(at.page, corner))
    at.page.keyboard.press("Enter")
    (mask,) = until(lambda: at.agreed("masks"), "the mask")
    np.testing.assert_allclose(mask["polygon"], corners, atol=0.6)
    assert (mask["first"], mask["last"]) == (0, 72)  # the whole film
    until(lambda: at.page.locator("#main path.mask.chosen").count() == 1, "the chosen mask")
    start = on_picture(at.page, corners[2])
    drag(at.page, start, (start[0] + 12, start[1] + 12), steps=3)
    until(lambda: at.agreed("masks")[0]["polygon"][2][0] > corners[2][0] + 3)
    np.testing.assert_allclose(at.served["masks"][0]["polygon"][0], corners[0], atol=0.6)
    at.page.keyboard.press("Delete")
    until(lambda: at.agreed("masks") == [], "no mask")
    assert undo_steps(at) == 3


def test_a_drawn_vertical_sets_what_is_up(at: Desk, tabs: Callable[[str], None]) -> None:
    tabs("Camera")
    at.page.get_by_role("button", name="Draw verticals in the image").click()
    one, other = on_picture(at.page, (320, 60)), on_picture(at.page, (350, 300))
    drag(at.page, one, other, steps=4)
    until(lambda: at.agreed("camera")["up_origin"] == "drawn", "the vertical")
    leaning = np.degrees(np.arctan2(30, 240))
    assert abs(at.served["camera"]["roll_deg"]) == pytest.approx(leaning, abs=1.0)
    R = np.array(at.agreed("views")["front"])
    np.testing.assert_allclose(R[1], -np.array(at.served["camera"]["up"]), atol=0.3)
    assert abs(R[0][1]) > 0.05  # the front view stands upright, the camera does not
    # with a second one both tilt and roll are known
    assert at.served["camera"]["tilt_deg"] == pytest.approx(0, abs=1.0)
    drag(at.page, on_picture(at.page, (240, 150)), on_picture(at.page, (245, 300)), steps=4)
    until(lambda: abs(at.agreed("camera")["tilt_deg"]) > 2, "both verticals")
    until(lambda: at.page.evaluate("() => window.keypose.ui.tool") != "vertical", "the tool")
    assert undo_steps(at) == 2


def test_the_horizon_is_drawn_and_pulled_at_its_handles_and_lays_the_floor(
    at: Desk, tabs: Callable[[str], None]
) -> None:
    tabs("Camera")
    at.page.get_by_role("button", name="Draw the horizon").click()
    one, other = on_picture(at.page, (120, 90)), on_picture(at.page, (520, 60))
    drag(at.page, one, other, steps=4)
    until(lambda: at.agreed("camera")["up_origin"] == "drawn", "the horizon")
    camera = at.served["camera"]
    leaning = np.degrees(np.arctan2(30, 400))
    assert abs(camera["roll_deg"]) == pytest.approx(leaning, abs=1.0)
    assert camera["tilt_deg"] < -3  # the horizon lies above the middle: the camera looks down
    floor = until(lambda: at.agreed("floor")["height_m"], "the floor")
    (left, high), right = camera["horizon"]
    start = on_picture(at.page, (left, high))
    drag(at.page, start, on_picture(at.page, (left, right[1])), steps=4)
    until(lambda: abs(at.agreed("camera")["roll_deg"]) < 0.5, "the pulled end")
    assert at.agreed("floor")["height_m"] != floor
    assert undo_steps(at) == 2
    at.page.keyboard.press("Escape")
    until(lambda: at.page.locator("#main .horizon").count() == 0, "the tool put away")
    at.page.keyboard.press("Control+z")
    at.page.keyboard.press("Control+z")
    until(lambda: at.agreed("camera")["up_origin"] == "camera", "up as it was")


# --- sizes


def lengths(desk: Desk, *parts: str) -> list[float]:
    known = {part["name"]: part["sizes"] for part in desk.served["body"]["parts"]}
    return [size["cm"] for part in parts for size in known[part] if size["key"] == "length"]


def cap(page: Page, part: str) -> Spot:
    box = until(page.locator(f'#main [data-grip="size:{part}:length"]').bounding_box, "the cap")
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_a_length_dragged_on_the_picture_changes_left_and_right(at: Desk) -> None:
    selected(at, "left_shin")
    at.page.keyboard.press("s")
    before = lengths(at, "left_shin", "right_shin")
    assert before[0] == pytest.approx(before[1])
    pulled(at, cap(at.page, "left_shin"), (0, 24))
    after = lengths(at, "left_shin", "right_shin")
    assert after[0] > before[0] + 2
    assert after[0] == pytest.approx(after[1])
    assert undo_steps(at) == 1


# --- views


def test_a_number_key_enlarges_a_view_and_brings_it_back(at: Desk) -> None:
    key, name = "3", "side"
    small = at.page.locator(f"[data-view={name}]").bounding_box()
    large = at.page.locator("#main").bounding_box()
    at.page.keyboard.press(key)
    until(lambda: at.page.locator(f"[data-view={name}]").bounding_box() == large, name)
    assert at.page.locator("#main").bounding_box() == small
    end = pulled(at, spot(at.page, "left_hand", name), (3, -9))
    np.testing.assert_allclose(spot(at.page, "left_hand", name), end, atol=UNDER_PX)
    at.page.keyboard.press(key)
    until(lambda: at.page.locator("#main").bounding_box() == large, "the camera's view")


def test_key_5_shows_four_equal_views(at: Desk) -> None:
    at.page.keyboard.press("5")
    views = at.page.locator(".view")

    def sizes() -> set[tuple[int, int]]:
        boxes = [views.nth(i).bounding_box() for i in range(4)]
        return {(round(box["width"]), round(box["height"])) for box in boxes if box}

    until(lambda: len({width for width, _ in sizes()}) <= 2 and min(sizes())[0] > 300, "four")
    at.page.keyboard.press("1")
    until(lambda: max(sizes())[0] > 600, "the camera's view")


def test_picture_and_handles_stay_together_when_zoomed_and_pushed(at: Desk) -> None:
    page = at.page
    uv = _pixel_of(page, "left_hand")
    here = spot(page, "left_hand")
    np.testing.assert_allclose(on_picture(page, uv), here, atol=0.5)
    page.mouse.move(*here)
    page.mouse.wheel(0, -400)
    until(lambda: page.evaluate("() => window.keypose.view('main').window.chosen"), "the zoom")
    np.testing.assert_allclose(spot(page, "left_hand"), here, atol=0.5)
    np.testing.assert_allclose(on_picture(page, uv), here, atol=0.5)
    empty = (here[0] + 60, here[1] - 60)
    page.mouse.move(*empty)
    page.mouse.down(button="middle")
    page.mouse.move(empty[0] + 50, empty[1] + 30, steps=3)
    page.mouse.up(button="middle")
    moved = (here[0] + 50, here[1] + 30)
    np.testing.assert_allclose(spot(page, "left_hand"), moved, atol=0.5)
    np.testing.assert_allclose(on_picture(page, uv), moved, atol=0.5)
    end = pulled(at, spot(page, "left_hand"), (20, -24))
    np.testing.assert_allclose(spot(page, "left_hand"), end, atol=UNDER_PX)
    page.keyboard.press("0")
    until(lambda: not page.evaluate("() => window.keypose.view('main').window.chosen"), "the fit")


def _pixel_of(page: Page, point: str) -> Spot:
    x, y, z = section(page, f"pose.points.{point}")
    camera = section(page, "camera")
    return camera["fx"] * x / z + camera["cx"], camera["fy"] * y / z + camera["cy"]
