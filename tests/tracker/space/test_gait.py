"""Heel strikes, toe offs and strides of walks that are known."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.gait import FootPath, Gait, gait_of, gait_of_paths
from keypose.tracker.storage.files import load_session
from tests.rendering import motions
from tests.rendering.mocap import needs_mocap, walk
from tests.tracker.formats.recordings import SAMPLES, recorded
from tests.tracker.space.space_cases import UP

FPS = 50.0
STRIDE = 60
STANCE = 36
"""Of the constructed walk: frames of a stride, and of those that a foot is on the ground."""
LENGTH_M = 1.4
WIDTH_M = 0.16
FOOT_M = 0.25
SKELETON = Skeleton.of(preset("adult_male"))


def foot(part: str, first: int, heading_deg: float, frames: int = 260) -> FootPath:
    """A foot that strikes at `first` and every STRIDE frames, stands, and swings in a straight
    line."""
    side = WIDTH_M / 2 if part.startswith("right") else -WIDTH_M / 2
    k, phase = np.divmod(np.arange(frames) - first, STRIDE)
    swing = np.clip((phase - STANCE) / (STRIDE - STANCE), 0.0, 1.0)
    x = LENGTH_M * (k + swing + first / STRIDE)
    heel = np.column_stack([x, 0.1 * np.sin(np.pi * swing), np.full(frames, side)])
    turned = _turn(heading_deg)
    return FootPath(part, heel @ turned.T, (heel + np.array([FOOT_M, 0.0, 0.0])) @ turned.T)


def _turn(degrees: float) -> Array:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def constructed(heading_deg: float = 0.0) -> Gait:
    """Both feet, pinned from a little after they strike to a little before they leave."""
    frames = 260
    x = LENGTH_M * (np.arange(frames) / STRIDE - 0.5 * STANCE / STRIDE) + 0.3
    root = np.column_stack([x, np.full(frames, 0.9), np.zeros(frames)]) @ _turn(heading_deg).T
    feet = []
    for part, first in (("left_foot", 20), ("right_foot", 50)):
        still = [(a + 5, a + STANCE - 9) for a in range(first, frames - STANCE, STRIDE)]
        feet.append((foot(part, first, heading_deg), still))
    return gait_of_paths(root, feet, np.arange(frames) / FPS)


@pytest.mark.parametrize("heading_deg", [0.0, 90.0, 217.0])
def test_events_of_a_walk_are_found_to_the_frame_whichever_way_it_goes(heading_deg: float) -> None:
    for stance in constructed(heading_deg).stances:
        first = stance.still[0] - 5
        assert stance.heel_strike == pytest.approx(first, abs=1)
        assert stance.toe_off == pytest.approx(first + STANCE, abs=1)


@pytest.mark.parametrize("heading_deg", [0.0, 90.0, 217.0])
def test_strides_of_a_walk_are_measured_whichever_way_it_goes(heading_deg: float) -> None:
    strides = constructed(heading_deg).strides
    assert [one.part for one in strides] == [f"{side}_foot" for side in ("left", "right") * 3][:5]
    for one in strides:
        assert one.time_s == pytest.approx(STRIDE / FPS, abs=1.01 / FPS)
        assert one.length_m == pytest.approx(LENGTH_M, abs=1e-6)
        assert one.step_length_m == pytest.approx(LENGTH_M / 2, abs=1e-6)
        assert one.step_width_m == pytest.approx(WIDTH_M, abs=1e-6)
        assert one.speed_m_s == pytest.approx(LENGTH_M * FPS / STRIDE, rel=0.02)
        assert one.cadence == pytest.approx(120 * FPS / STRIDE, rel=0.02)
        assert one.stance_share == pytest.approx(STANCE / STRIDE, abs=0.035)


def found(motion: Trajectory, fps: float) -> Gait:
    made = recorded(SKELETON, motion, fps)
    pins = proposed_pins(SKELETON, motion, fps, UP)
    return gait_of(SKELETON, motion, made.times_s, made.ground, pins)


@pytest.mark.parametrize(("name", "period"), [("stride", 44), ("crossing", 51)])
def test_written_walks_have_strides_of_their_period(name: str, period: int) -> None:
    strides = found(getattr(motions, name)(SKELETON), 30.0).strides
    assert len(strides) >= 3
    assert {one.last_frame - one.first_frame for one in strides} <= {period - 1, period, period + 1}
    for one in strides:
        assert one.stance_share is not None
        assert 0.55 < one.stance_share < 0.72


@needs_mocap
def test_toes_of_a_recorded_walk_leave_when_the_markers_begin_to_move() -> None:
    """The recording's toe markers pass 0.5 m/s at its frames 43, 108 (left) and 75, 143 (right),
    of which the walk has every second one."""
    gait = found(walk(SKELETON, constrained=False), 30.0)
    offs = {(s.part, s.toe_off) for s in gait.stances if s.toe_off is not None}
    for part, at in (
        ("left_foot", 21.5),
        ("left_foot", 54),
        ("right_foot", 38),
        ("right_foot", 71),
    ):
        assert min(abs(frame - at) for foot, frame in offs if foot == part) <= 2
    for one in gait.strides:  # 67 frames at 60 a second
        assert one.time_s == pytest.approx(67 / 60, abs=1 / 30)


def test_somebody_who_stands_makes_no_stride() -> None:
    Rs = np.tile(np.eye(3), (60, SKELETON.part_count, 1, 1))
    gait = found(Trajectory(0, Rs, np.tile([0.0, 0.0, 4.0], (60, 1))), 30.0)
    assert len(gait.stances) == 2
    assert gait.strides == ()
    assert {(s.heel_strike, s.toe_off) for s in gait.stances} == {(None, None)}


def test_a_body_without_feet_has_no_gait() -> None:
    body = preset("adult_male")
    kept = tuple(part for part in body.parts if "foot" not in part.name)
    footless = Skeleton.of(body.model_copy(update={"parts": kept, "mirror_pairs": ()}))
    Rs = np.tile(np.eye(3), (5, footless.part_count, 1, 1))
    motion = Trajectory(0, Rs, np.tile([0.0, 0.0, 4.0], (5, 1)))
    made = recorded(footless, motion, 30.0)
    gait = gait_of(footless, motion, made.times_s, made.ground, ())
    assert (gait.stances, gait.strides) == ((), ())


def test_a_pin_of_the_toes_after_that_of_the_foot_is_the_same_stance() -> None:
    motion = motions.crossing(SKELETON)
    made = recorded(SKELETON, motion, 30.0)
    sole = ("left_heel", "left_toe")
    pins = (
        Pin(part="left_foot", landmarks=sole, first_frame=43, last_frame=60),
        Pin(part="left_foot", landmarks=sole[1:], first_frame=61, last_frame=71),
    )
    gait = gait_of(SKELETON, motion, made.times_s, made.ground, pins)
    assert [stance.still for stance in gait.stances] == [(43, 71)]


def test_strides_of_the_filmed_walk_last_as_long_as_its_pins_are_apart() -> None:
    """`walk_feet.json` is the sample as it was tracked; its pins are what a person accepted."""
    paths = json.loads(Path(__file__).with_name("walk_feet.json").read_text("utf-8"))
    first, root = paths["first_frame"], np.array(paths["root"])
    pins = load_session(SAMPLES / "walk" / "session.json").subject.pins
    feet, starts = [], {}
    for side in ("left", "right"):
        heel, toe = (np.array(paths[f"{side}_{end}"]) for end in ("heel", "toe"))
        spans = [pin.span for pin in pins if pin.part == f"{side}_foot"]
        starts[f"{side}_foot"] = [a for a, _ in spans]
        feet.append(
            (FootPath(f"{side}_foot", heel, toe), [(a - first, b - first) for a, b in spans])
        )
    gait = gait_of_paths(root, feet, (first + np.arange(len(root))) / 30, first)
    assert len(gait.strides) == 5
    for one in gait.strides:
        pinned = [a for a in starts[one.part] if one.first_frame <= a <= one.last_frame + 6]
        assert pinned[0] - one.first_frame in range(1, 6)  # the heel first, then all of the foot
        assert one.last_frame - one.first_frame == pytest.approx(pinned[1] - pinned[0], abs=2)
        assert one.stance_share == pytest.approx(0.62, abs=0.06)  # as in healthy walking
        assert one.step_length_m == pytest.approx(one.length_m / 2, abs=0.05)
        moved = root[one.last_frame - first] - root[one.first_frame - first]
        assert one.length_m == pytest.approx(np.hypot(moved[0], moved[2]), abs=0.06)


def test_where_the_motion_has_a_gap_there_is_no_stride() -> None:
    motion = motions.crossing(SKELETON)
    pins = proposed_pins(SKELETON, motion, 30.0, UP)
    made = recorded(SKELETON, motion, 30.0)
    whole = gait_of(SKELETON, motion, made.times_s, made.ground, pins)
    Rs, ps = motion.Rs_parent_part.copy(), motion.ps_camera_root.copy()
    Rs[60:80], ps[60:80] = np.nan, np.nan
    holed = Trajectory(0, Rs, ps)
    gait = gait_of(SKELETON, holed, made.times_s, made.ground, pins)
    left = [one for one in whole.strides if one.last_frame < 55 or one.first_frame > 85]
    assert [one for one in gait.strides if one in left] == left
    assert len(gait.strides) < len(whole.strides)
