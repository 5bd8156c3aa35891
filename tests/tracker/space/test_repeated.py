"""Repeated frames are no evidence that a body stood still."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.session.references import Repeats
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.repeated import Moments, evened
from tests.rendering.mocap import needs_mocap
from tests.rendering.scenes import scene
from tests.tracker.space.space_cases import UP, Floats

PERIOD = 6
EVEN = pytest.mark.parametrize("even", [True, False], ids=["put between", "instead of a frame"])


def repeated(motion: Trajectory, even: bool) -> tuple[Trajectory, Repeats, Floats]:
    """The motion as a film shows it that repeats every sixth frame; the copies, and of each row of
    the motion the row of the film."""
    count = len(motion)
    if even:
        rows = np.repeat(np.arange(count), 1 + (np.arange(count) % (PERIOD - 1) == PERIOD - 2))
    else:
        rows = np.arange(count) - (np.arange(count) % PERIOD == PERIOD - 1)
    copies = tuple((np.flatnonzero(np.diff(rows) == 0) + 1 + motion.first_frame).tolist())
    shown = Trajectory(motion.first_frame, motion.Rs_parent_part[rows], motion.ps_camera_root[rows])
    return shown, Repeats(frames=copies, even=even), rows.astype(np.float64)


def acceleration(motion: Trajectory, rate: float) -> float:
    """Root mean square of the root's, m/s²."""
    a = np.diff(motion.ps_camera_root, 2, axis=0) * rate**2
    return float(np.sqrt((a**2).sum(axis=-1).mean()))


@needs_mocap
@EVEN
def test_accelerations_are_as_without_the_copies(even: bool) -> None:
    walk = scene("walk")
    shown, repeats, _ = repeated(walk.truth, even)
    rate = 30.0 * (PERIOD / (PERIOD - 1) if even else 1.0)  # as many seconds
    true = acceleration(walk.truth, 30.0)
    assert acceleration(shown, rate) > 3 * true
    assert acceleration(evened(shown, repeats), rate) < 1.15 * true


@needs_mocap
@EVEN
def test_proposed_pins_are_as_without_the_copies(even: bool) -> None:
    walk = scene("walk")
    shown, repeats, rows = repeated(walk.truth, even)
    rate = 30.0 * (PERIOD / (PERIOD - 1) if even else 1.0)
    true = proposed_pins(walk.skeleton, walk.truth, 30.0, UP)
    found = proposed_pins(walk.skeleton, evened(shown, repeats), rate, UP)
    assert [(pin.part, pin.landmarks) for pin in found] == [
        (pin.part, pin.landmarks) for pin in true
    ]
    ends = np.array([pin.span for pin in found]) - shown.first_frame
    assert np.abs(rows[ends] - [pin.span for pin in true]).max() <= 2


@EVEN
def test_frame_by_frame_the_poses_stay_and_those_at_copies_lie_between(even: bool) -> None:
    shown, repeats, _ = repeated(scene("tumbling_box").truth, even)
    moments = Moments.of(repeats, shown.first_frame, shown.last_frame)
    assert moments is not None
    again = moments.shown(moments.evened(shown))
    steps = np.linalg.norm(np.diff(shown.ps_camera_root, axis=0), axis=-1)
    off = np.linalg.norm(again.ps_camera_root - shown.ps_camera_root, axis=-1)
    assert off[moments.distinct].max() < 0.02 * steps.max()
    steps = np.linalg.norm(np.diff(again.ps_camera_root, axis=0), axis=-1)
    assert steps[1:-1].min() > 0.2 * np.median(steps)


@EVEN
def test_a_keyframe_stays_where_it_is_shown(even: bool) -> None:
    shown, repeats, _ = repeated(scene("tumbling_box").truth, even)
    first, last = shown.first_frame, shown.last_frame
    exact = [first, repeats.frames[1], first + 14, last]
    moments = Moments.of(repeats, first, last, exact)
    assert moments is not None
    for motion in (moments.evened(shown), moments.shown(moments.evened(shown))):
        for frame in exact:
            kept, given = motion.pose(frame), shown.pose(frame)
            assert kept.p_camera_root == pytest.approx(given.p_camera_root, abs=1e-9)
            assert kept.Rs_parent_part == pytest.approx(given.Rs_parent_part, abs=1e-9)


def test_unknown_poses_stay_unknown() -> None:
    shown, repeats, _ = repeated(scene("tumbling_box").truth, even=True)
    Rs, ps = shown.writable()
    ps[10:13], Rs[10:13] = np.nan, np.nan
    motion = evened(Trajectory(shown.first_frame, Rs, ps), repeats)
    assert (np.isnan(motion.ps_camera_root[:, 0]) == np.isnan(ps[:, 0])).all()


def test_a_motion_without_copies_is_itself() -> None:
    motion = scene("tumbling_box").truth
    assert evened(motion, Repeats()) is motion
    assert Moments.of(None, 0, 40) is None
