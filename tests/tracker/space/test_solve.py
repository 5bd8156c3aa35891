"""The last solve: feet that are pinned stand, bodies move smoothly, keyframes stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import savgol_filter

from keypose.tracker.body.pose import Pose, joint_names, pose_transforms
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation, log_rotation, transpose
from keypose.tracker.space.pinned import PinnedPoint
from keypose.tracker.space.solve import SpaceSolution, solve_space
from keypose.tracker.tracking.parts.limb_keyframes import KeyedParts
from tests.rendering.mocap import needs_mocap
from tests.rendering.scenes import Scene, scene
from tests.tracker.space.space_cases import (
    UP,
    Floats,
    acceleration,
    errors_m,
    farther,
    fps_of,
    pinned_foot,
    pixels,
    places,
    problem,
    reach_far,
    shaken,
    speeds,
    standing,
)

FRAMES = 61


@pytest.fixture(scope="module")
def person() -> Scene:
    return reach_far(standing(FRAMES))


def bow(size_m: float, frames: int = FRAMES) -> Floats:
    return np.asarray(size_m * np.sin(np.pi * np.linspace(0, 1, frames)))


def slide_m(shown: Scene, motion: Trajectory) -> float:
    """How far a foot strays from where it mostly stands."""
    p = places(shown, motion)
    return float(np.linalg.norm(p - np.median(p, axis=0), axis=-1).max())


def require_sound(found: SpaceSolution) -> None:
    R = found.motion.Rs_parent_part
    assert np.isfinite(found.motion.ps_camera_root).all()
    np.testing.assert_allclose(R @ transpose(R), np.broadcast_to(np.eye(3), R.shape), atol=1e-9)
    assert np.isfinite(found.places).all()
    assert all(np.isfinite(off).all() for off in found.off_m)


# --- limbs keyed alone


@pytest.mark.parametrize("drift_m", [0.0, 0.08])
def test_a_limb_keyed_alone_is_seen_where_it_was_set_and_as_far_from_the_body(
    person: Scene, drift_m: float
) -> None:
    """Though the body it hangs on drifted in depth, and comes back."""
    frame, names = FRAMES // 2, person.skeleton.body.names
    tracked = farther(person.truth, bow(drift_m))
    key = KeyedParts.of(person.skeleton, frame, ("right_upper_arm",), tracked.pose(frame))
    pins = pinned_foot(person, 0, FRAMES - 1)
    found = solve_space(problem(person, tracked, pins=pins, keyed_parts=(key,))).motion
    wrist = names.index("right_hand")
    there, set_there = (
        m.transforms(person.skeleton)[frame, wrist, :3, 3] for m in (found, tracked)
    )
    seen = person.camera.project(there) - person.camera.project(set_there)
    assert np.linalg.norm(seen) < 0.1
    assert there[2] - found.ps_camera_root[frame, 2] == pytest.approx(
        set_there[2] - tracked.ps_camera_root[frame, 2], abs=1e-3
    )
    beside = found.transforms(person.skeleton)[frame - 1 : frame + 2, wrist, :3, 3]
    assert np.linalg.norm(np.diff(beside, 2, axis=0)) < 0.01, "it comes there smoothly"


@pytest.mark.parametrize("turn_deg", [10.0, 25.0])
def test_an_elbow_does_not_leap_where_its_hand_was_keyed_on_a_body_that_stands_otherwise(
    person: Scene, turn_deg: float
) -> None:
    """The hand has to come there and go back; the elbow gives way, and takes its time."""
    frame, names = FRAMES // 2, person.skeleton.body.names
    R, t = person.truth.pose(frame).writable()
    R[names.index("chest")] @= exp_rotation(np.radians([turn_deg, 0.0, turn_deg]))
    key = KeyedParts.of(person.skeleton, frame, ("right_upper_arm",), Pose(R, t))
    found = solve_space(problem(person, keyed_parts=(key,))).motion
    elbow, hand = (names.index(f"right_{part}") for part in ("forearm", "hand"))
    p = found.transforms(person.skeleton)[frame - 2 : frame + 3, ..., :3, 3][:, [elbow, hand]]
    leaps = np.linalg.norm(np.diff(p, 2, axis=0), axis=-1).max(axis=0)
    assert leaps[0] < 0.4 * leaps[1]
    there = pose_transforms(person.skeleton, key.pose)[hand, :3, 3]
    assert np.linalg.norm(person.camera.project(p[2, 1]) - person.camera.project(there)) < 0.1


# --- pins


@pytest.mark.parametrize("known", [0.9, np.nan], ids=["seen well", "of unknown observability"])
@pytest.mark.parametrize("away", [bow(0.1), np.linspace(0, 0.1, FRAMES)], ids=["bow", "ramp"])
def test_a_pinned_foot_that_drifted_in_depth_comes_to_rest_and_is_seen_where_it_was(
    person: Scene, away: Floats, known: float
) -> None:
    tracked = farther(person.truth, away)
    assert slide_m(person, tracked) > 0.04
    keyframes = (0,) if away[-1] else (0, FRAMES - 1)
    seen = np.full((FRAMES - 1, person.skeleton.part_count), known)
    pins = pinned_foot(person, 0, FRAMES - 1)
    found = solve_space(
        problem(person, tracked, keyframes=keyframes, pins=pins, observability=seen)
    )
    assert slide_m(person, found.motion) < 0.005
    assert max(off.max() for off in found.off_m) < 0.005
    away_px = np.linalg.norm(pixels(person, found.motion) - pixels(person, tracked), axis=-1)
    assert away_px.max() < 1


def test_without_pins_a_foot_stays_where_it_was_tracked(person: Scene) -> None:
    tracked = farther(person.truth, bow(0.1))
    found = solve_space(problem(person, tracked))
    assert slide_m(person, found.motion) == pytest.approx(slide_m(person, tracked), rel=0.05)
    assert (found.places.shape, found.off_m, found.floor_m) == ((0, 3), (), None)


def test_feet_on_the_floor_come_to_one_height_which_is_reported(person: Scene) -> None:
    """A camera that looks down: what is wrong in depth is wrong in height."""
    up = np.array([0.0, -np.cos(0.5), -np.sin(0.5)])
    ramp = np.clip(np.arange(FRAMES) - 26, 0, 8) / 8
    tracked = farther(person.truth, 0.1 * ramp)
    pins = [
        *pinned_foot(person, 0, 25, floor=True),
        *pinned_foot(person, 35, FRAMES - 1, floor=True),
    ]
    found = solve_space(problem(person, tracked, soft=(0, FRAMES - 1), pins=pins, up_world=up))
    assert found.floor_m is not None
    high, before = (
        (places(person, motion)[[10, 50]] @ up).mean(axis=1) for motion in (found.motion, tracked)
    )
    assert np.ptp(before) > 0.04
    assert np.ptp(high) < 0.5 * np.ptp(before)
    assert high == pytest.approx(found.floor_m, abs=0.02)


def test_a_floor_that_is_known_stays_where_it_is(person: Scene) -> None:
    height = float((places(person, person.truth) @ UP).min()) + 0.004
    pins = pinned_foot(person, 0, FRAMES - 1, floor=True)
    found = solve_space(
        problem(person, pins=pins, soft=(0, FRAMES - 1), up_world=UP, floor_m=height)
    )
    assert found.floor_m == pytest.approx(height, abs=1e-4)


def test_a_floor_that_is_tilted_by_mistake_gives_way_before_knees_bend() -> None:
    """What is up is wrong by 8°, while feet stand at several distances."""
    shown = scene("stride").cut(0, FRAMES - 1)
    wrong = exp_rotation(np.radians([8.0, 0.0, 0.0])) @ UP
    pins = [*pinned_foot(shown, 4, 14, floor=True), *pinned_foot(shown, 46, 56, floor=True)]
    pins += pinned_foot(shown, 25, 35, "right_foot", floor=True)
    given = problem(shown, pins=pins, soft=(0, FRAMES - 1), up_world=wrong)
    held, yielding = (solve_space(replace(given, tilt_rad=tilt)) for tilt in (0.0, 0.1))
    assert held.up_world == pytest.approx(wrong)
    assert yielding.up_world @ UP > np.cos(np.radians(4.0))
    assert errors_m(shown, yielding.motion).mean() < 0.7 * errors_m(shown, held.motion).mean()
    for found in (held, yielding):
        heights = found.places @ found.up_world
        assert found.floor_m == pytest.approx(float(heights.mean()), abs=2e-3)


def test_straight_legs_stay_straight_where_the_body_is_at_a_wrong_distance() -> None:
    """It comes nearer and goes away by 6 % while its feet stand."""
    shown = standing(FRAMES)
    tracked = farther(shown.truth, 0.3 * np.sin(np.linspace(0, 3 * np.pi, FRAMES)))
    pins = [
        p for foot in ("left_foot", "right_foot") for p in pinned_foot(shown, 0, 60, foot, True)
    ]
    found = solve_space(problem(shown, tracked, pins=pins, soft=(0, 60))).motion
    shins = [shown.skeleton.body.index(f"{side}_shin") for side in ("left", "right")]
    turned = transpose(tracked.Rs_parent_part[:, shins]) @ found.Rs_parent_part[:, shins]
    assert np.degrees(np.linalg.norm(log_rotation(turned), axis=-1)).max() < 4.0
    assert slide_m(shown, found) < 0.01


def test_a_foot_comes_to_where_it_is_pinned_and_leaves_evenly(person: Scene) -> None:
    """It was tracked some centimetres beside, and tipped by 25°, for the whole time."""
    R, t = person.truth.writable()
    foot = person.skeleton.body.index("left_foot")
    R[:, foot] @= exp_rotation(np.radians([25.0, 0.0, 0.0]))
    tracked = farther(Trajectory(0, R, t), np.linspace(-0.15, 0.15, FRAMES))
    pins = pinned_foot(person, 20, 40, floor=True)
    found = solve_space(problem(person, tracked, pins=pins, soft=(0, 60))).motion
    steps = transpose(found.Rs_parent_part[:-1, foot]) @ found.Rs_parent_part[1:, foot]
    assert np.degrees(np.linalg.norm(log_rotation(steps), axis=-1)).max() < 6.0
    pushed = np.linalg.norm(np.diff(places(person, found), 2, axis=0), axis=-1).max()
    assert pushed * fps_of(person) ** 2 < 12.0


# --- keyframes


@pytest.mark.parametrize("smooth", [True, False])
def test_exact_keyframes_stay_exact(person: Scene, smooth: bool) -> None:
    tracked = farther(shaken(person), bow(0.1))
    keyframes = (0, 20, 41, FRAMES - 1)
    found = solve_space(
        problem(person, tracked, keyframes=keyframes, smooth=smooth,
                pins=pinned_foot(person, 5, FRAMES - 1))
    ).motion  # fmt: skip
    rows = list(keyframes)
    for name in ("Rs_parent_part", "ps_camera_root"):
        away = getattr(found, name)[rows] - getattr(tracked, name)[rows]
        assert np.abs(away).max() < 1e-9
    between = found.ps_camera_root - tracked.ps_camera_root
    assert np.abs(between[21:41]).max() > 1e-4


def test_the_motion_meets_exact_keyframes_without_a_jump(person: Scene) -> None:
    """They are part of the solve, not put in afterwards."""
    tracked = farther(person.truth, bow(0.1))
    found = solve_space(
        problem(person, tracked, keyframes=(0, 30, 60), pins=pinned_foot(person, 0, 60))
    ).motion
    steps = np.abs(np.diff(found.ps_camera_root, axis=0)).max(axis=1)
    assert steps[[29, 30]].max() < 3 * np.abs(np.diff(tracked.ps_camera_root, axis=0)).max()


def test_soft_keyframes_give_way_in_depth_by_more_than_across(person: Scene) -> None:
    R, p = person.truth.writable()
    p[30] = p[30] * (1 + 0.1 / np.linalg.norm(p[30]))
    tracked = Trajectory(0, R, p)
    given = problem(person, tracked, keyframes=(0, 30, 60), pins=pinned_foot(person, 0, 60))
    soft = solve_space(replace(given, soft=(30,))).motion
    hard = solve_space(given).motion
    away = np.abs(soft.ps_camera_root[30] - tracked.ps_camera_root[30])
    assert away[2] > 0.05
    assert away[2] > 10 * away[:2].max()
    np.testing.assert_array_equal(hard.ps_camera_root[30], tracked.ps_camera_root[30])


# --- smoothness


@pytest.mark.parametrize("name", ["speech", "throw", "stride"])
def test_a_shaken_motion_is_less_shaken_and_nearer_to_the_truth(name: str) -> None:
    shown = scene(name)
    tracked = shaken(shown)
    smooth, as_tracked = (
        solve_space(problem(shown, tracked, smooth=wanted)).motion for wanted in (True, False)
    )
    real = acceleration(shown, shown.truth)
    assert abs(acceleration(shown, smooth) - real) < 0.15 * abs(acceleration(shown, tracked) - real)
    assert acceleration(shown, smooth) < acceleration(shown, as_tracked)
    assert errors_m(shown, smooth).mean() < 0.7 * errors_m(shown, tracked).mean()


@pytest.mark.parametrize("rate", [30.0, 60.0])
def test_a_foot_that_stands_keeps_little_of_the_shaking_of_a_tracked_body(
    person: Scene, rate: float
) -> None:
    tracked = shaken(person)
    found = solve_space(problem(person, tracked, frames_per_second=rate)).motion

    def shaking(motion: Trajectory) -> float:
        bends = np.diff(places(person, motion), 2, axis=0) * rate**2
        return float(np.sqrt((bends**2).sum(axis=-1).mean()))

    assert shaking(tracked) > 40
    assert shaking(found) < 2.5


def test_a_hand_that_is_interpolated_between_keyframes_turns_without_a_corner_there(
    person: Scene,
) -> None:
    """It turns by 6 degrees a frame up to a keyframe, and no more after it."""
    hand = person.skeleton.body.index("left_hand")
    turn = np.zeros((FRAMES, 3))
    turn[:, 0] = np.radians(6.0) * np.clip(np.arange(FRAMES) - 15, 0, 15)
    R, p = person.truth.writable()
    R[:, hand] = exp_rotation(turn)
    tracked = Trajectory(0, R, p)
    seen = np.full((FRAMES - 1, person.skeleton.part_count), 0.9)
    seen[:, hand] = np.nan  # nothing tracks it
    given = problem(
        person, tracked, keyframes=(0, 30, 60), observability=seen, frames_per_second=60.0
    )
    found = solve_space(given).motion

    def corner(motion: Trajectory) -> float:
        """Degrees by which the turn of a frame differs from that of the next, about keyframe 30."""
        own = motion.Rs_parent_part[:, hand]
        turns = log_rotation(transpose(own[:-1]) @ own[1:])
        return float(np.degrees(np.linalg.norm(np.diff(turns, axis=0), axis=-1))[24:36].max())

    assert corner(tracked) == pytest.approx(6.0)
    assert corner(found) < 3.0
    np.testing.assert_array_equal(found.Rs_parent_part[30], tracked.Rs_parent_part[30])


@needs_mocap
def test_feet_that_whirl_keep_their_peak_speeds() -> None:
    shown = scene("pirouette")
    feet = [i for i, name in enumerate(joint_names(shown.skeleton)) if "foot" in name]
    joints = savgol_filter(shown.truth.joints(shown.skeleton), 7, 3, axis=0)
    truth = np.linalg.norm(np.diff(joints, axis=0), axis=-1) * fps_of(shown)
    found = speeds(shown, solve_space(problem(shown)).motion)
    fastest = truth[:, feet].max(axis=0)
    assert fastest.min() > 4
    assert found[:, feet].max() == pytest.approx(fastest.max(), rel=0.03)
    np.testing.assert_allclose(found[:, feet].max(axis=0), fastest, rtol=0.07)


@pytest.mark.parametrize("name", ["throw", "stride", pytest.param("jump", marks=needs_mocap)])
def test_a_throw_a_stride_and_a_jump_keep_their_peak_speeds(name: str) -> None:
    """Of the fastest point and of the waist, where they move at all. Records of joints shake by
    several per cent from frame to frame, which is no speed: it is taken out of the jump's before
    comparing, over a tenth of a second."""
    shown = scene(name)
    found = speeds(shown, solve_space(problem(shown)).motion)
    joints = shown.truth.joints(shown.skeleton)
    if name == "jump":
        joints = savgol_filter(joints, 7, 3, axis=0)
    truth = np.linalg.norm(np.diff(joints, axis=0), axis=-1) * fps_of(shown)
    assert found.max() == pytest.approx(truth.max(), rel=0.03)
    assert found[:, 0].max() == pytest.approx(truth[:, 0].max(), rel=0.03)


# --- whatever comes


def test_pins_that_the_pictures_contradict_leave_a_sound_motion_and_are_reported(
    person: Scene,
) -> None:
    """Both feet are said to stand at one place, though the whole body goes aside by 40 cm."""
    R, p = person.truth.writable()
    p[30:] += [0.4, 0.0, 0.0]
    tracked = Trajectory(0, R, p)
    pins = [
        *pinned_foot(person, 0, FRAMES - 1, "left_foot"),
        *pinned_foot(person, 0, FRAMES - 1, "right_foot"),
    ]
    found = solve_space(problem(person, tracked, pins=pins))
    require_sound(found)
    assert min(off.max() for off in found.off_m) > 0.05


def test_a_pin_that_contradicts_exact_keyframes_says_how_far(person: Scene) -> None:
    R, p = person.truth.writable()
    p[:] = p[0]
    p[30] += [0.1, 0.0, 0.0]
    pins = pinned_foot(person, 0, FRAMES - 1)
    found = solve_space(problem(person, Trajectory(0, R, p), keyframes=(0, 30, 60), pins=pins))
    require_sound(found)
    for off in found.off_m:
        assert int(np.argmax(off)) == 30
        assert off[30] > 0.05


def test_a_thing_that_is_no_person_stands_on_its_corner() -> None:
    box = reach_far(scene("tumbling_box").cut(0, 20))
    R, p = box.truth.writable()
    corner = (0.32, 0.20, 0.24)
    at = R[:, 0] @ np.array(corner)
    p[:] = p[0] + at[0] - at  # it turns about its corner
    truth = Trajectory(0, R, p)
    tracked = Trajectory(0, R, p + bow(0.05, 21)[:, None] * [0.0, 0.0, 1.0])
    found = solve_space(problem(box, tracked, pins=[PinnedPoint(0, corner, 0, 20)]))
    require_sound(found)
    assert np.median(found.off_m[0]) < 0.006
    assert found.off_m[0].max() < 0.02
    shown = replace(box, truth=truth)
    assert errors_m(shown, found.motion).max() < 0.6 * errors_m(shown, tracked).max()


@pytest.mark.parametrize("frames", [2, 3, 4])
def test_a_stretch_may_be_of_a_few_frames(person: Scene, frames: int) -> None:
    few = person.cut(0, frames - 1)
    found = solve_space(problem(few, pins=pinned_foot(few, 0, frames - 1)))
    require_sound(found)
    assert len(found.motion) == frames
    assert errors_m(few, found.motion).max() < 1e-3


def test_cancelled_at_once_the_motion_is_as_it_was_tracked(person: Scene) -> None:
    tracked = farther(person.truth, bow(0.1))
    given = problem(person, tracked, pins=pinned_foot(person, 0, FRAMES - 1))
    found = solve_space(given, lambda: True)
    np.testing.assert_array_equal(found.motion.Rs_parent_part, tracked.Rs_parent_part)
    np.testing.assert_array_equal(found.motion.ps_camera_root, tracked.ps_camera_root)
    require_sound(found)


def test_a_stretch_that_begins_later_is_solved_in_the_same_way(person: Scene) -> None:
    tracked = farther(person.truth, bow(0.1))
    later = Trajectory(100, tracked.Rs_parent_part, tracked.ps_camera_root)
    here, there = (
        solve_space(problem(person, motion, pins=pinned_foot(person, first, first + 60))).motion
        for motion, first in ((tracked, 0), (later, 100))
    )
    assert there.first_frame == 100
    np.testing.assert_array_equal(there.ps_camera_root, here.ps_camera_root)
