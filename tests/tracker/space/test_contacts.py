"""Feet that stand still are found, and proposed as pins."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.space.contacts import proposed_pins
from tests.rendering.mocap import needs_mocap
from tests.rendering.scenes import Scene, scene
from tests.tracker.space.space_cases import UP, fps_of, places, standing

Bools = NDArray[np.bool_]

NAMES = ("walk", "stride", "crossing", "jump", "jumping_jacks")
FEET = ("left_foot", "right_foot")
STANDS_M_S = 0.30
LOW_M = 0.06
AIR_M = 0.10
"""A foot stands where its ankle, heel or toe moves slower, over a tenth of a second, and its sole
is not higher above where it mostly stands; feet of people and of written walks slide that much."""

known = lru_cache(maxsize=None)(scene)


def _sole(shown: Scene, name: str) -> tuple[Bools, Bools]:
    """(N,) where a foot truly stands, and where it is in the air."""
    part = shown.skeleton.body.index(name)
    ankle = shown.truth.transforms(shown.skeleton)[:, part, None, :3, 3]
    p = np.concatenate([ankle, places(shown, shown.truth, name)], axis=1)
    width = int(0.1 * fps_of(shown)) | 1
    even = uniform_filter1d(p, width, axis=0, mode="nearest")
    slowest = np.linalg.norm(np.gradient(even, axis=0), axis=-1).min(axis=1) * fps_of(shown)
    high = (p[:, 1:] @ UP).min(axis=1)
    above = high - np.median(high[slowest < 0.2])
    return (slowest < STANDS_M_S) & (above < LOW_M), above > AIR_M


def found(shown: Scene, motion: Trajectory) -> dict[str, Bools]:
    """(N,) of each foot: where it is proposed to be pinned."""
    there = {name: np.zeros(len(motion), dtype=np.bool_) for name in FEET}
    for pin in proposed_pins(shown.skeleton, motion, fps_of(shown), UP):
        there[pin.part][pin.first_frame : pin.last_frame + 1] = True
    return there


def score(shown: Scene, motion: Trajectory) -> float:
    """F1 of frames, over both feet."""
    there = found(shown, motion)
    message = np.concatenate([there[name] for name in FEET])
    true = np.concatenate([_sole(shown, name)[0] for name in FEET])
    return 2 * float((message & true).sum()) / float(message.sum() + true.sum())


def noisy(shown: Scene, seed: int = 0) -> Trajectory:
    """As tracking may find it: 3 mm across the view, 15 mm along it."""
    p = shown.truth.ps_camera_root
    noise = np.random.default_rng(seed).normal(0, 1, p.shape) * (0.003, 0.003, 0.015)
    return Trajectory(0, shown.truth.Rs_parent_part, p + noise)


@needs_mocap
def test_where_feet_truly_stand_pins_are_proposed() -> None:
    scores = [score(known(name), known(name).truth) for name in NAMES]
    assert np.mean(scores) >= 0.9
    assert min(scores) > 0.8


@needs_mocap
def test_noise_along_the_view_hardly_matters() -> None:
    scores = [score(known(name), noisy(known(name))) for name in NAMES]
    assert np.mean(scores) >= 0.85
    assert min(scores) > 0.75


@needs_mocap
@pytest.mark.parametrize("name", ["jump", "jumping_jacks"])
@pytest.mark.parametrize("motion", [lambda shown: shown.truth, noisy], ids=["true", "noisy"])
def test_nobody_is_pinned_in_the_air(name: str, motion: object) -> None:
    assert callable(motion)
    shown = known(name)
    there = found(shown, motion(shown))
    flying = np.all([_sole(shown, foot)[1] for foot in FEET], axis=0)
    assert flying.any()
    for foot in FEET:
        assert not (there[foot] & flying).any()


def test_whoever_stands_all_the_time_gets_one_pin_a_foot() -> None:
    shown = standing()
    pins = proposed_pins(shown.skeleton, shown.truth, 30.0, UP)
    assert [(pin.part, pin.span, pin.floor) for pin in pins] == [
        ("left_foot", (0, 60), False),
        ("right_foot", (0, 60), False),
    ]
    assert {name for pin in pins for name in pin.landmarks} == {
        "left_heel", "left_toe", "right_heel", "right_toe"
    }  # fmt: skip


def test_pins_have_the_frames_of_the_film() -> None:
    shown = standing()
    later = Trajectory(200, shown.truth.Rs_parent_part, shown.truth.ps_camera_root)
    pins = proposed_pins(shown.skeleton, later, 30.0, UP)
    assert {pin.span for pin in pins} == {(200, 260)}


def test_a_foot_held_still_in_the_air_is_not_pinned() -> None:
    shown = standing()
    R, p = shown.truth.writable()
    knee = shown.skeleton.body.index("right_shin")
    thigh = shown.skeleton.body.index("right_thigh")
    R[:, thigh], R[:, knee] = R[0, thigh], R[0, knee]
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    R[:, thigh], R[:, knee] = turn, turn.T
    raised = Trajectory(0, R, p)
    assert {pin.part for pin in proposed_pins(shown.skeleton, raised, 30.0, UP)} == {"left_foot"}
    assert {pin.part for pin in proposed_pins(shown.skeleton, raised, 30.0, None)} == {"left_foot"}


@pytest.mark.parametrize(("frames", "metres", "stances"), [
    (8, 0.15, 2),
    (15, 0.15, 2),
    (30, 0.15, 2),
    (8, 0.05, 1),
])  # fmt: skip
def test_a_foot_that_moves_on_ends_its_stance_however_slowly_and_shortly(
    frames: int, metres: float, stances: int
) -> None:
    shown = standing()
    R, p = shown.truth.writable()
    share = np.clip((np.arange(len(p)) - 22) / frames, 0, 1)
    p[:, 0] += metres * share**2 * (3 - 2 * share)
    moved = Trajectory(0, R, p)
    pins = proposed_pins(shown.skeleton, moved, 30.0, UP)
    assert len(pins) == 2 * stances
    for pin in pins:
        ends = p[pin.first_frame, 0] - p[pin.last_frame, 0]
        assert abs(ends) < 0.055


def test_a_foot_that_moves_on_twice_has_three_stances() -> None:
    shown = standing(91)
    R, p = shown.truth.writable()
    for start in (24, 56):
        share = np.clip((np.arange(len(p)) - start) / 12, 0, 1)
        p[:, 0] += 0.12 * share**2 * (3 - 2 * share)
    pins = proposed_pins(shown.skeleton, Trajectory(0, R, p), 30.0, UP)
    left = [pin.span for pin in pins if pin.part == "left_foot"]
    assert len(left) == 3
    assert left[0][0] == 0
    assert left[1][0] < 40 < 54 < left[1][1] < 64
    assert left[2][1] == 90


def test_feet_that_stay_are_pinned_though_an_error_in_depth_puts_them_into_the_air() -> None:
    """As after a jump that is tracked too near; a foot that does not stay is none."""
    shown = standing()
    R, p = shown.truth.writable()
    p[25:45] += 0.4 * UP
    p[22:25] += np.array([[0.1], [0.2], [0.3]]) * UP
    p[45:48] += np.array([[0.3], [0.2], [0.1]]) * UP
    pins = proposed_pins(shown.skeleton, Trajectory(0, R, p), 30.0, UP)
    held = [pin for pin in pins if pin.first_frame > 22 and pin.last_frame < 48]
    assert {pin.part for pin in held} == {"left_foot", "right_foot"}
    p[28:45] = shown.truth.ps_camera_root[28:45]
    short = proposed_pins(shown.skeleton, Trajectory(0, R, p), 30.0, UP)
    assert not any(22 < pin.first_frame < 27 for pin in short)


def test_feet_of_somebody_who_stands_on_the_head_are_not_pinned() -> None:
    shown = standing()
    R, p = shown.truth.writable()
    R[:, 0] = np.diag([1.0, -1.0, -1.0]) @ R[:, 0]
    assert proposed_pins(shown.skeleton, Trajectory(0, R, p), 30.0, UP) == ()


def test_both_feet_are_pinned_in_a_camera_that_nobody_knows_to_be_tilted() -> None:
    shown = standing()
    angle = np.radians(25)
    tilt = np.array([
        [1.0, 0.0, 0.0], [0.0, np.cos(angle), -np.sin(angle)], [0.0, np.sin(angle), np.cos(angle)],
    ])  # fmt: skip
    R, p = shown.truth.writable()
    middle = p.mean(axis=0)
    R[:, 0] = tilt @ R[:, 0]
    tilted = Trajectory(0, R, (p - middle) @ tilt.T + middle)
    unknown = proposed_pins(shown.skeleton, tilted, 30.0, None)
    assert {pin.part for pin in unknown} == {"left_foot", "right_foot"}


def test_a_body_without_feet_is_not_pinned() -> None:
    box = scene("tumbling_box")
    still = Trajectory(0, np.repeat(box.truth.Rs_parent_part[:1], 30, axis=0),
                       np.repeat(box.truth.ps_camera_root[:1], 30, axis=0))  # fmt: skip
    assert proposed_pins(box.skeleton, still, 30.0, UP) == ()


@pytest.mark.parametrize("frames", [1, 2, 3, 5])
def test_in_a_few_frames_nothing_is_said_or_something_sound(frames: int) -> None:
    shown = standing().cut(0, frames - 1)
    for pin in proposed_pins(shown.skeleton, shown.truth, 30.0, UP):
        assert 0 <= pin.first_frame <= pin.last_frame < frames
