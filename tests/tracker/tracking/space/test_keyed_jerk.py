"""A limb is granted the jerk that the frames ask for at which it was keyed, and nothing else is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.tracking.parts.keyed import KeyedParts
from keypose.tracker.tracking.space.jerk_sigmas import jerk_points
from keypose.tracker.tracking.space.keyed_jerk import with_jerk_of_keyed
from tests.rendering.scenes import Scene
from tests.tracker.tracking.space.space_cases import Floats, fps_of, standing

FRAMES, ARM = 61, "right_upper_arm"


@pytest.fixture(scope="module")
def person() -> Scene:
    return standing(FRAMES)


def raised(shown: Scene, frame: int, deg: float) -> Trajectory:
    """The truth with the right arm elsewhere at one frame."""
    R, p = shown.truth.writable()
    R[frame, shown.skeleton.body.index(ARM)] @= exp_rotation(np.radians([0.0, 0.0, deg]))
    return Trajectory(0, R, p)


def granted(
    shown: Scene, motion: Trajectory, keyed: Sequence[int], keyframes: Sequence[int]
) -> tuple[BodyPoints, Floats, Floats]:
    """The points, what they have in life, and what they are granted, at every third difference."""
    points, sigma = jerk_points(shown.skeleton, motion, fps_of(shown))
    limbs = [KeyedParts.of(shown.skeleton, f, (ARM,), motion.pose(f)) for f in keyed]
    found = with_jerk_of_keyed(sigma, points, motion, keyframes, limbs, fps_of(shown))
    return points, sigma, found


@pytest.mark.parametrize("keyed", [(), (20, 30, 40)], ids=["no limb", "on its way"])
def test_where_no_limb_is_keyed_off_its_way_nothing_is_granted(
    person: Scene, keyed: tuple[int, ...]
) -> None:
    _, sigma, found = granted(person, person.truth, keyed, (0, FRAMES - 1))
    assert found is sigma


def test_a_limb_keyed_to_and_fro_is_granted_what_that_takes_and_the_rest_of_the_body_nothing(
    person: Scene,
) -> None:
    motion = raised(person, 31, 75.0)
    points, sigma, found = granted(person, motion, (29, 31, 33), (0, FRAMES - 1))
    parts = np.array([part for ((part, _),) in points.points])
    names = person.skeleton.body.names
    more = (found > sigma).any(axis=0)
    assert {names[i] for i in parts[more]} == {"right_forearm", "right_hand"}
    rows = np.flatnonzero((found > sigma).any(axis=1))
    assert (rows[0], rows[-1]) == pytest.approx((29, 30), abs=9), "near these frames alone"


def test_through_three_exact_frames_goes_a_steady_push(person: Scene) -> None:
    _, sigma, found = granted(person, raised(person, 31, 60.0), (31,), (0, FRAMES - 1))
    assert found is sigma
