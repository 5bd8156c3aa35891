"""BVH as animators get it: the pose by another program's reader, and curves that run smoothly."""

from __future__ import annotations

import warnings
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.rotation_curves import smooth_euler
from keypose.tracker.geometry.rotations import Array, exp_rotation, rotation_from_euler
from tests.tracker.formats import recordings
from tests.tracker.formats.recordings import bvh_of

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # it imports its own library by an old name
    import bvhio


def turned_back(angles: Array) -> Array:
    """The rotations of triples (..., 3)."""
    flat = [rotation_from_euler(*triple) for triple in angles.reshape(-1, 3)]
    return np.array(flat).reshape(*angles.shape, 3)


@pytest.mark.parametrize("name", recordings.NAMES)
def test_another_programs_reader_finds_the_joints_where_they_are(name: str, tmp_path: Path) -> None:
    made = recordings.recording(name)
    place = tmp_path / "motion.bvh"
    place.write_text(bvh_of(made.skeleton, made.trajectory, 1 / made.frames_per_second))
    file, root = bvhio.readAsBvh(str(place)), bvhio.readAsHierarchy(str(place))
    assert file.FrameCount == len(made)
    assert pytest.approx((len(made) - 1) * file.FrameTime) == made.times_s[-1] - made.times_s[0]
    expected = recordings.joints_in_file(made)
    for i in range(len(made)):
        root.loadPose(i)
        places = {joint.Name: np.array(joint.PositionWorld) for joint, _, _ in root.layout()}
        found = [places[part] for part in made.skeleton.body.names]
        np.testing.assert_allclose(found, expected[i, : len(found)], atol=1e-5)


@pytest.mark.parametrize("name", recordings.NAMES)
def test_curves_never_jump_by_half_a_turn(name: str) -> None:
    made = recordings.recording(name)
    lines = bvh_of(made.skeleton, made.trajectory, 0.04).split("Frame Time:")[1].splitlines()[1:]
    angles = np.array([line.split() for line in lines], dtype=float)[:, 3:]
    assert np.abs(np.diff(angles, axis=0)).max() < 90


def test_a_part_that_goes_on_turning_has_angles_that_go_on() -> None:
    turn = np.linspace(0, 6 * np.pi, 120)
    for axis in range(3):
        angles = smooth_euler(exp_rotation(np.outer(turn, np.eye(3)[axis])))
        np.testing.assert_allclose(angles[:, 2 - axis], turn, atol=1e-9)
        np.testing.assert_allclose(np.delete(angles, 2 - axis, axis=1), 0, atol=1e-9)


def test_curves_stay_smooth_through_the_pose_where_two_axes_are_one() -> None:
    y = np.deg2rad(np.arange(60, 121, 5.0))  # over the pole, and on it at 90
    for sign in (1, -1):
        Rs = np.stack([rotation_from_euler(0.4, sign * a, -0.7) for a in y])
        angles = smooth_euler(Rs)
        np.testing.assert_allclose(turned_back(angles), Rs, atol=1e-12)
        expected = np.column_stack([np.full(len(y), 0.4), sign * y, np.full(len(y), -0.7)])
        np.testing.assert_allclose(angles, expected, atol=1e-7)


def test_where_two_axes_are_one_their_common_turn_is_shared() -> None:
    turn = np.linspace(0, 3, 31)
    Rs = np.stack([rotation_from_euler(0.2, np.pi / 2, 0.2 + a) for a in turn])
    angles = smooth_euler(Rs)
    np.testing.assert_allclose(turned_back(angles), Rs, atol=1e-7)
    assert np.abs(np.diff(angles, axis=0)).max() == pytest.approx(0.05, abs=1e-6)


@given(st.integers(0, 2**32 - 1), st.floats(0.01, 3.0))
def test_whatever_the_motion_the_rotations_stay_and_no_triple_was_nearer(
    seed: int, pace: float
) -> None:
    rng = np.random.default_rng(seed)
    steps = exp_rotation(rng.normal(size=(12, 2, 3)) * pace)
    Rs = np.stack(
        [np.linalg.multi_dot([np.eye(3), *steps[: i + 1, k]]) for i in range(12) for k in (0, 1)]
    )
    Rs = Rs.reshape(12, 2, 3, 3)
    angles = smooth_euler(Rs)
    np.testing.assert_allclose(turned_back(angles), Rs, atol=1e-7)
    for before, now in pairwise(angles):
        nearest = np.square(now - before).sum(axis=-1)
        for half in (now, now * [1, -1, 1] + [np.pi, np.pi, np.pi]):
            for turns in np.ndindex(3, 3, 3):
                other = half + 2 * np.pi * (np.array(turns) - 1)
                assert (np.square(other - before).sum(axis=-1) >= nearest - 1e-9).all()


def test_a_gap_is_refused_by_its_frames() -> None:
    made = recordings.recording("person", without=(1,))
    with pytest.raises(FormatError, match="Frames 25 to 47 are not tracked, and BVH holds no gaps"):
        made.whole("BVH")
