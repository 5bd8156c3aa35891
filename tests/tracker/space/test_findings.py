"""What is not plausible in space is found where it is, and nothing in a sound motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.results import SpaceFinding
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.findings import MotionInSpace, space_findings
from tests.rendering.mocap import needs_mocap
from tests.rendering.scenes import Scene, scene
from tests.tracker.space.space_cases import UP, fps_of, places, standing

FRAMES = 61
FEET = ("left_foot", "right_foot")
LANDMARKS = {name: (name.replace("foot", "heel"), name.replace("foot", "toe")) for name in FEET}


@pytest.fixture(scope="module")
def person() -> Scene:
    return standing(FRAMES)


def stances(first: int = 0, last: int = FRAMES - 1, feet: Sequence[str] = FEET) -> list[Pin]:
    return [
        Pin(part=name, landmarks=LANDMARKS[name], first_frame=first, last_frame=last)
        for name in feet
    ]


def floor_of(shown: Scene) -> float:
    return float(np.median(places(shown, shown.truth) @ UP))


def findings(shown: Scene, motion: Trajectory, **changes: Any) -> tuple[SpaceFinding, ...]:
    given: dict[str, Any] = {
        "skeleton": shown.skeleton,
        "camera": shown.camera,
        "motion": motion,
        "tracked": motion,
        "frames_per_second": fps_of(shown),
        "stances": stances(motion.first_frame, motion.last_frame),
        "pinned": (False, False),
        "keyframes": (motion.first_frame, motion.last_frame),
        "up_world": UP,
        "floor_m": floor_of(shown),
    }
    return space_findings(MotionInSpace(**{**given, **changes}))


def moved(motion: Trajectory, by: Any) -> Trajectory:
    return Trajectory(motion.first_frame, motion.Rs_parent_part, motion.ps_camera_root + by)


def test_of_somebody_who_stands_nothing_is_found(person: Scene) -> None:
    assert findings(person, person.truth) == ()


@needs_mocap
def test_of_a_true_walk_nothing_is_found() -> None:
    shown = scene("walk")
    pins = proposed_pins(shown.skeleton, shown.truth, 30.0, UP)
    found = findings(shown, shown.truth, stances=pins, pinned=[False] * len(pins), floor_m=None)
    assert found == ()


def test_a_foot_that_its_pin_pushes_off_is_found_and_one_that_was_tracked_so_is_not(
    person: Scene,
) -> None:
    pushed = np.zeros((FRAMES, 3))
    pushed[41:, 0] = 0.04  # where the pins end
    motion, pins = moved(person.truth, pushed), stances(20, 40)
    given = {"stances": pins, "pinned": (True, True), "floor_m": None}
    found = findings(person, motion, **given, tracked=person.truth)
    assert [(one.kind, one.part) for one in found] == [("jumps", foot) for foot in FEET]
    assert all(abs(one.go - 40) <= 3 for one in found)
    assert findings(person, motion, **given) == ()  # tracked is the motion itself
    assert findings(person, motion, **given | {"pinned": (False, False)}) == ()


def test_a_foot_that_slides_is_found_unless_it_is_pinned(person: Scene) -> None:
    slides = np.zeros((FRAMES, 3))
    slides[:, 0] = 0.12 * np.clip((np.arange(FRAMES) - 40) / 20, 0, 1)
    motion = moved(person.truth, slides)
    one, other = findings(person, motion)
    assert (one.kind, other.kind) == ("slides", "slides")
    assert (one.part, other.part) == FEET
    assert (one.first_frame, one.last_frame, one.go) == (0, FRAMES - 1, FRAMES - 1)
    assert one.amount == pytest.approx(0.12, abs=0.01)
    assert [found.part for found in findings(person, motion, pinned=(True, False))] == [FEET[1]]


@pytest.mark.parametrize(("by_m", "kind"), [(0.07, "off_floor"), (-0.07, "below_floor")])
def test_feet_that_float_or_sink_are_found_where_the_floor_is_known(
    person: Scene, by_m: float, kind: str
) -> None:
    motion = moved(person.truth, by_m * UP)
    found = findings(person, motion)
    assert {one.kind for one in found} == {kind}
    assert {one.part for one in found} == set(FEET)
    assert found[0].amount == pytest.approx(0.07, abs=0.02)
    assert findings(person, motion, floor_m=None) == ()
    assert findings(person, motion, up_world=None) == ()


def test_a_keyframe_at_another_depth_is_found_and_says_by_how_much(person: Scene) -> None:
    aside = np.zeros((FRAMES, 3))
    aside[:, 2] = 0.1 * np.exp(-(((np.arange(FRAMES) - 30) / 8.0) ** 2))
    tracked = moved(person.truth, aside)
    found = findings(
        person, person.truth, tracked=tracked, pinned=(True, True), keyframes=(0, 15, 30, 45, 60)
    )
    assert {(one.kind, one.go) for one in found} == {("keyframe_depth", 30)}
    assert [one.part for one in found] == list(FEET)
    assert all(one.amount == pytest.approx(0.1, abs=0.02) for one in found)
    nearer = moved(person.truth, -aside)
    amounts = [one.amount for one in findings(
        person, person.truth, tracked=nearer, pinned=(True, True), keyframes=(0, 15, 30, 45, 60)
    )]  # fmt: skip
    assert all(amount < 0 for amount in amounts)


def test_a_body_that_leans_too_far_is_found_where_up_is_known(person: Scene) -> None:
    R, p = person.truth.writable()
    lean = exp_rotation([0.6, 0.0, 0.0])
    ankles = person.truth.transforms(person.skeleton)[0, person.skeleton.body.index("left_foot")]
    about = ankles[:3, 3]
    R[:, 0] = lean @ R[:, 0]
    p = about + (p - about) @ lean.T
    (found,) = findings(person, Trajectory(0, R, p), floor_m=None)
    assert (found.kind, found.part) == ("leans", "waist")
    assert (found.first_frame, found.last_frame) == (0, FRAMES - 1)
    assert found.amount > np.radians(20)
    assert findings(person, Trajectory(0, R, p), up_world=None) == ()
    assert findings(person, Trajectory(0, R, p), stances=(), pinned=()) == ()


def test_a_body_that_shakes_is_found(person: Scene) -> None:
    noise = np.random.default_rng(0).normal(0, 0.004, (FRAMES, 3))
    (found,) = findings(person, moved(person.truth, noise))
    assert (found.kind, found.part) == ("shakes", "waist")
    assert found.amount > 8
    assert 0 < found.go < FRAMES - 1


def test_frames_are_those_of_the_film(person: Scene) -> None:
    R, p = person.truth.writable()
    p[50:, 0] += 0.12
    later = Trajectory(300, R, p)
    found = findings(person, later)
    slides = [one for one in found if one.kind == "slides"]
    assert {(one.first_frame, one.last_frame) for one in slides} == {(300, 360)}
    assert all(350 <= one.go <= 360 for one in slides)


@pytest.mark.parametrize("frames", [2, 3])
def test_in_a_few_frames_nothing_is_found(person: Scene, frames: int) -> None:
    few = person.cut(0, frames - 1)
    assert findings(few, few.truth) == ()


@pytest.mark.parametrize(("degrees", "reported"), [(0.0, False), (135.0, False), (-170.0, True)])
def test_an_arm_turned_half_round_at_a_keyframe_is_told_and_where(
    person: Scene, degrees: float, reported: bool
) -> None:
    Rs, arm = person.truth.Rs_parent_part.copy(), person.skeleton.body.index("right_upper_arm")
    Rs[30, arm] = Rs[30, arm] @ exp_rotation(np.array([0.0, np.radians(degrees), 0.0]))
    motion = Trajectory(0, Rs, person.truth.ps_camera_root)
    found = findings(person, motion, keyframes=(0, 30, 60))
    twisted = [one for one in found if one.kind == "twisted"]
    assert [(one.part, one.go) for one in twisted] == [("right_upper_arm", 30)] * reported
    assert all(np.degrees(one.amount) == pytest.approx(-45.0, abs=8.0) for one in twisted)
    soft = findings(person, motion, keyframes=(0, 60), soft=(30,))
    assert [one for one in soft if one.kind == "twisted"] == twisted
    elsewhere = findings(person, motion, keyframes=(0, 29, 60))
    assert [one for one in elsewhere if one.kind == "twisted"] == []
