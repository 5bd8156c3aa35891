"""What the page is told of pins, proposals and the floor."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.app.editor.state import EditorState
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import Sections
from keypose.tracker.body.pose import joint_names, joint_positions, pose_transforms
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.session.camera_motion import CameraMotion
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.results import PinResult
from keypose.tracker.space.result import SpaceResult
from keypose.tracker.storage.results import Results
from keypose.tracker.storage.stretches import stretches
from tests.app.editor.desk import after, desk
from tests.app.editor.test_pins import stepping

FOOT = {"do": "set_pin", "part": "left_foot", "frame": 24, "first": 20, "last": 28}


def reported(edit: EditorState) -> dict[str, Any]:
    return Sections().changed(AppState(edit=edit))


def test_a_pinned_foot_is_reported_with_its_frames_and_the_print_of_its_sole() -> None:
    edit = after(desk(), FOOT)
    (pin,) = reported(edit)["pins"]
    assert (pin["label"], pin["side"], pin["first"], pin["last"]) == ("Left foot", "L", 20, 28)
    keyframe = next(k for k in edit.doc.subject.keyframes if k.frame == 24)
    Ts = pose_transforms(edit.skeleton, keyframe.pose(edit.skeleton))
    joints = joint_positions(edit.skeleton, Ts)
    toe = joints[joint_names(edit.skeleton).index("left_toe")]
    sole = np.array(pin["sole"])
    assert len(sole) == 4
    assert np.linalg.norm(sole - toe, axis=1).min() < 0.06
    sides = np.linalg.norm(sole - np.roll(sole, 1, axis=0), axis=1)
    assert sides.max() < 0.3, "it goes round the sole, not across"
    foot = edit.doc.subject.body.index("left_foot")
    vertices = np.asarray(edit.doc.subject.body.parts[foot].shape.mesh().vertices)
    standing = vertices @ Ts[foot, :3, :3].T + Ts[foot, :3, 3]
    off = np.linalg.norm(standing[:, None] - sole, axis=2).min(axis=0)
    assert off.max() < 1e-4, "it lies in the foot's surface"


@pytest.mark.parametrize(
    ("more", "label"),
    [
        ({"landmarks": ["left_heel"]}, "Left heel"),
        ({"part": "left_shin", "landmarks": []}, "Left knee"),
        ({"part": "left_hand", "landmarks": []}, "Left hand"),
        ({"part": "waist", "landmarks": []}, "Waist"),
    ],
)
def test_a_pin_is_called_by_what_it_holds(more: dict[str, Any], label: str) -> None:
    (pin,) = reported(after(desk(), {**FOOT, **more}))["pins"]
    assert pin["label"] == label
    assert (pin["sole"] != []) == (pin["part"] == "left_foot")


def solved(edit: EditorState, found: PinResult, proposed: tuple[Pin, ...] = ()) -> EditorState:
    """With what the solve over the tracked motion said of its pins."""
    (stretch,) = stretches(edit.doc, edit.results.fitting(edit.doc))
    motion = next(iter(edit.results.by_key.values())).trajectory
    space = SpaceResult(stretch.key, motion, (found,), proposed)
    return edit.with_results(Results(edit.results.by_key, {stretch.key: space}))


def pinned(off_m: float, keyframe: int | None) -> EditorState:
    pin = {"part": "left_foot", "landmarks": ("left_heel", "left_toe")}
    span = {"first_frame": 10, "last_frame": 24}
    found = PinResult(**pin, **span, off_m=off_m, usual_off_m=off_m, frame=12, keyframe=keyframe)  # type: ignore[arg-type]
    edit = after(stepping((8, 14)), {**FOOT, "first": 10, "last": 24})
    return solved(edit, found, (Pin(part="right_foot", first_frame=2, last_frame=9),))


def test_what_the_solve_found_of_a_pin_is_reported_until_the_pin_is_changed() -> None:
    known = pinned(0.031, 24)
    (pin,) = reported(known)["pins"]
    assert pin["problem"] == "Keyframe 24 is 3 cm off the pin."
    assert (pin["keyframe"], pin["slides_cm"]) == (24, 3.1)
    (trimmed,) = reported(after(known, {"do": "change_pin", "index": 0, "last": 22}))["pins"]
    assert (trimmed["problem"], trimmed["keyframe"], trimmed["slides_cm"]) == ("", None, None)


def test_a_foot_that_slides_a_little_is_no_problem() -> None:
    (pin,) = reported(pinned(0.004, None))["pins"]
    assert (pin["problem"], pin["keyframe"], pin["slides_cm"]) == ("", None, 0.4)


def test_what_the_solve_proposed_stays_while_another_pin_waits_to_be_solved_for() -> None:
    known = pinned(0.004, None)
    assert [pin["part"] for pin in reported(known)["proposed_pins"]] == ["right_foot"]
    trimmed = after(known, {"do": "change_pin", "index": 0, "last": 22})
    assert [pin["part"] for pin in reported(trimmed)["proposed_pins"]] == ["right_foot"]


def test_proposals_are_reported_until_they_are_answered() -> None:
    proposed = Pin(part="right_hand", first_frame=3, last_frame=9)
    edit = replace(desk(), proposed_pins=(proposed,))
    (pin,) = reported(edit)["proposed_pins"]
    assert (pin["label"], pin["side"], pin["first"], pin["last"]) == ("Right hand", "R", 3, 9)
    for answer in ("accept_pins", "dismiss_pins"):
        assert reported(after(edit, {"do": answer}))["proposed_pins"] == []


def test_the_floor_is_reported_with_whether_pinned_feet_could_say_where_it_is() -> None:
    assert reported(desk())["floor"] == {
        "height_m": None,
        "has_feet": False,
        "soles": "",
        "soles_off_cm": None,
    }
    edit = after(desk(), FOOT, {"do": "floor", "height_m": -1.25})
    assert reported(edit)["floor"] == {
        "height_m": -1.25,
        "has_feet": True,
        "soles": "",
        "soles_off_cm": None,
    }


def test_soft_keyframes_and_smoothness_are_reported() -> None:
    soft = {"do": "soften_key", "frame": 24}
    values = reported(after(desk(), soft, {"do": "settings", "smooth": True}))
    assert values["keys"]["soft"] == [24]
    assert values["settings"]["smooth"] is True
    assert reported(desk())["settings"]["smooth"] is False


def test_the_print_of_a_sole_lies_in_the_world_that_stands_still_while_the_camera_turns() -> None:
    still = after(desk(), FOOT)
    count = still.frame_count
    turns = exp_rotation(np.linspace(0, 0.4, count)[:, None] * np.array([0.1, -1.0, 0.0]))
    path = CameraPath.of(turns, np.zeros((count, 3)), np.ones(count))
    video = still.doc.view.video.model_copy(update={"stands_still": False})
    doc = still.doc.changed({"camera_motion": CameraMotion.of("turns", path), "video": video})
    (here,), (turned,) = (reported(edit)["pins"] for edit in (still, still.with_doc(doc)))
    np.testing.assert_allclose(turned["sole"], np.array(here["sole"]) @ turns[24], atol=2e-4)
