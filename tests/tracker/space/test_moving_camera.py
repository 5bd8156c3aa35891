"""Before a camera that turns and moves, what stands still in the world does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.findings import MotionInSpace, space_findings
from keypose.tracker.space.solve import solve_space
from tests.rendering.scenes import Scene
from tests.tracker.space.space_cases import (
    UP,
    farther,
    fps_of,
    pinned_foot,
    places,
    problem,
    standing,
)

FRAMES = 61


def path_of(shake: float = 0.005, metres: float = 0.5) -> CameraPath:
    """A pan of 20° by a shaking hand that walks along."""
    t = np.linspace(0, 1, FRAMES)
    k = np.arange(FRAMES)
    turn = np.stack(
        [shake * np.sin(1.7 * k), np.radians(20) * t + shake * np.sin(1.1 * k), shake * np.cos(k)],
        axis=1,
    )
    turn -= turn[0]
    p = metres * t[:, None] * (1.0, 0.05, 0.1)
    return CameraPath.of(exp_rotation(turn), p, np.ones(FRAMES))


@pytest.fixture(scope="module")
def person() -> Scene:
    return standing(FRAMES)


def slide_m(shown: Scene, motion_in_world: object) -> float:
    p = places(shown, motion_in_world)  # type: ignore[arg-type]
    return float(np.linalg.norm(p - np.median(p, axis=0), axis=-1).max())


def test_a_pinned_foot_stands_in_the_world_and_the_body_where_it_is_seen(person: Scene) -> None:
    path = path_of()
    wander = farther(person.truth, 0.05 * np.sin(np.linspace(0, 3 * np.pi, FRAMES)))
    tracked = wander.carried(path.Ts_camera_world)
    given = problem(person, tracked, pins=pinned_foot(person, 0, FRAMES - 1), soft=(0, FRAMES - 1))
    found = solve_space(replace(given, path=path))
    world = found.motion.carried(path.Ts_world_camera)
    assert slide_m(person, tracked.carried(path.Ts_world_camera)) > 0.03
    assert slide_m(person, world) < 0.003
    seen = [
        person.camera.project(motion.transforms(person.skeleton)[..., :3, 3])
        for motion in (found.motion, tracked)
    ]
    assert np.linalg.norm(seen[0] - seen[1], axis=-1).mean() < 0.8
    np.testing.assert_allclose(
        found.places.mean(axis=0), places(person, world).mean((0, 1)), atol=0.01
    )


def test_what_is_solved_for_before_a_moving_camera_is_what_a_still_one_gives(
    person: Scene,
) -> None:
    wander = farther(person.truth, 0.05 * np.sin(np.linspace(0, 3 * np.pi, FRAMES)))
    pins = pinned_foot(person, 0, FRAMES - 1)
    still = solve_space(problem(person, wander, pins=pins))
    path = path_of()
    given = problem(person, wander.carried(path.Ts_camera_world), pins=pins)
    found = solve_space(replace(given, path=path)).motion.carried(path.Ts_world_camera)
    apart = found.joints(person.skeleton) - still.motion.joints(person.skeleton)
    assert np.linalg.norm(apart, axis=-1).max() < 0.012


def test_a_camera_that_stands_still_by_its_path_changes_no_digit(person: Scene) -> None:
    pins = pinned_foot(person, 0, FRAMES - 1)
    plain = problem(person, pins=pins)
    one = solve_space(plain).motion
    other = solve_space(replace(plain, path=CameraPath.standing_still(FRAMES))).motion
    np.testing.assert_allclose(other.ps_camera_root, one.ps_camera_root, atol=1e-9)


def test_feet_are_found_standing_in_the_world_and_not_in_the_picture(person: Scene) -> None:
    path = path_of()
    rate = fps_of(person)
    eyes = path.Ts_world_camera[:, :3, 3]
    expected = proposed_pins(person.skeleton, person.truth, rate, UP)
    found = proposed_pins(person.skeleton, person.truth, rate, UP, eyes)
    assert [(pin.part, pin.landmarks) for pin in found] == [
        (pin.part, pin.landmarks) for pin in expected
    ]
    in_picture = proposed_pins(
        person.skeleton, person.truth.carried(path.Ts_camera_world), rate, UP
    )
    frames = [sum(pin.last_frame - pin.first_frame for pin in pins) for pins in (found, in_picture)]
    assert frames[1] < 0.5 * frames[0]


def test_findings_are_about_the_world(person: Scene) -> None:
    path = path_of()
    pins = proposed_pins(person.skeleton, person.truth, 30.0, UP)
    judged = MotionInSpace(
        person.skeleton, person.camera, person.truth, person.truth, 30.0,
        stances=pins, pinned=[False] * len(pins), keyframes=[0, 30, 60], up_world=UP,
        floor_m=None, path=path,
    )  # fmt: skip
    kinds = {one.kind for one in space_findings(judged)}
    assert not kinds & {"slides", "keyframe_depth"}
