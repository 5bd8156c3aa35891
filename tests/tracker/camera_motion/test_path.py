"""One path of what was measured: keyframes are met, drift is spread, gaps are bridged."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.path import (
    UNKNOWN_DOUBT,
    Turns,
    poses_bridged,
    poses_through,
    turns_through,
)
from keypose.tracker.camera_motion.turn import Turn
from keypose.tracker.geometry.camera_path import rigid_inverse
from keypose.tracker.geometry.rotations import Array, exp_rotation, transform
from tests.tracker.camera_cases import off_deg, turned

SURE = 1e-4
"""Radians: the doubt of a frame that was measured well."""


def turns_of(count: int, known: list[int] | None = None, step_deg: float = 2.0) -> Turns:
    """A pan of 2° a frame, with a zoom of 1 % a frame."""
    mask = np.ones(count, bool) if known is None else np.isin(np.arange(count), known)
    R = np.stack([turned(step_deg * k) for k in range(count)])
    doubt = np.full(count, SURE)
    return Turns(R, 0.01 * np.arange(count), mask, doubt, doubt)


# --- turns


def test_gaps_are_bridged_and_ends_held() -> None:
    turns = turns_of(12, known=[3, 4, 9])
    bridged = turns.bridged()
    assert (bridged.R[:3] == turns.R[3]).all()
    assert (bridged.R[10:] == turns.R[9]).all()
    assert off_deg(bridged.R[4:10], list(turns.R[4:10])).max() < 1e-6
    np.testing.assert_allclose(bridged.log_zoom[4:10], turns.log_zoom[4:10])
    assert (bridged.log_zoom[10:] == turns.log_zoom[9]).all()


@pytest.mark.parametrize("known", [[], [*range(6)]], ids=["none known", "all known"])
def test_with_nothing_to_bridge_turns_stay_as_they_are(known: list[int]) -> None:
    turns = turns_of(6, known)
    assert turns.bridged() is turns


def test_a_path_of_turns_stays_in_one_place() -> None:
    path = turns_of(5).path()
    assert not path.moves
    np.testing.assert_allclose(path.zoom, np.exp(0.01 * np.arange(5)))
    np.testing.assert_allclose(path.Ts_camera_world[3, :3, :3], turned(6.0))


FRAMES = [0, 5, 10]
"""In which keyframes are set; each frame is measured from the last one before it."""
KEYFRAME = np.array([0, *[0] * 5, *[1] * 5])
TRUE = [turned(2.0 * k) for k in range(11)]


def measured(doubt: Array | None = None, known: Array | None = None) -> Turns:
    """The turn of each frame since its keyframe, without error."""
    relative = [TRUE[k] @ TRUE[FRAMES[KEYFRAME[k]]].T for k in range(11)]
    since = 0.01 * (np.arange(11) - np.array(FRAMES)[KEYFRAME])
    doubts = np.full(11, SURE) if doubt is None else doubt
    mask = np.ones(11, bool) if known is None else known
    return Turns(np.stack(relative), since, mask, doubts, doubts)


def keyframes(off_deg_last: float = 0.0) -> list[Turn]:
    """Turns of the keyframes, of which the last is off from what was measured."""
    true = [Turn(TRUE[frame], float(np.exp(0.01 * frame))) for frame in FRAMES]
    true[2] = Turn(turned(20.0 + off_deg_last), true[2].zoom)
    return true


def test_frames_follow_from_their_keyframes() -> None:
    turns = turns_through(measured(), KEYFRAME, keyframes(), FRAMES)
    assert off_deg(turns.R, TRUE).max() < 1e-6
    np.testing.assert_allclose(turns.log_zoom, 0.01 * np.arange(11), atol=1e-12)


def test_what_a_keyframe_is_off_by_is_spread_over_the_frames_before_it() -> None:
    turns = turns_through(measured(), KEYFRAME, keyframes(off_deg_last=1.0), FRAMES)
    off = off_deg(turns.R, TRUE)
    assert off[:6].max() < 1e-6  # before the keyframe that these are measured from
    np.testing.assert_allclose(off[6:], [0.2, 0.4, 0.6, 0.8, 1.0], atol=0.15)
    assert off[-1] == pytest.approx(1.0, abs=1e-3)
    assert (np.diff(off[5:]) > 0).all()


def test_an_unsure_step_takes_most_of_the_drift() -> None:
    doubt = np.full(11, SURE)
    doubt[8] = 100 * SURE
    turns = turns_through(measured(doubt), KEYFRAME, keyframes(off_deg_last=1.0), FRAMES)
    off = off_deg(turns.R, TRUE)
    assert off[7] < 0.01
    assert off[9] > 0.99  # the step to frame 8 and the one from it are as unsure


def test_so_does_a_step_over_which_nothing_is_known() -> None:
    known = np.arange(11) != 7
    turns = turns_through(measured(known=known), KEYFRAME, keyframes(off_deg_last=1.0), FRAMES)
    off = off_deg(turns.R, TRUE)
    assert off[6] < 0.01
    assert off[8] > 0.99


def test_a_keyframe_that_nothing_ties_shares_nothing_out() -> None:
    keyframe = np.array([0, *[0] * 4, *[1] * 6])  # frame 5 is measured from itself
    relative = [TRUE[k] @ TRUE[FRAMES[keyframe[k]]].T for k in range(11)]
    doubt = np.full(11, SURE)
    doubt[5] = UNKNOWN_DOUBT
    turns = Turns(np.stack(relative), np.zeros(11), np.ones(11, bool), doubt, doubt)
    jumped = [Turn(TRUE[0], 1.0), Turn(turned(50.0), 1.0)]
    path = turns_through(turns, keyframe, jumped, [0, 5])
    assert off_deg(path.R[:5], TRUE[:5]).max() < 1e-6
    after = [turned(2.0 * (k - 5)) @ turned(50.0) for k in range(5, 11)]
    assert off_deg(path.R[5:], after).max() < 1e-6


def test_drift_after_a_jump_is_not_taken_for_part_of_the_jump() -> None:
    """The first frame after it is as sure of those that follow as they of it."""
    keyframe = np.array([0, *[0] * 4, *[1] * 6])
    relative = [TRUE[k] @ TRUE[FRAMES[keyframe[k]]].T for k in range(11)]
    doubt = np.full(11, SURE)
    doubt[5] = UNKNOWN_DOUBT
    turns = Turns(np.stack(relative), np.zeros(11), np.ones(11, bool), doubt, doubt)
    path = turns_through(turns, keyframe, keyframes(off_deg_last=1.0), FRAMES)
    off = off_deg(path.R, TRUE)
    np.testing.assert_allclose(off[6:], [0.1, 0.33, 0.55, 0.78, 1.0], atol=0.05)


# --- poses


def arc(count: int = 21) -> Array:
    """(N, 4, 4) camera from world: a metre aside, turning by 20°."""
    share = np.linspace(0, 1, count)
    R = exp_rotation(np.radians(20) * share[:, None] * (0.0, -1.0, 0.1))
    p = np.stack([share, 0.1 * share**2, 0.3 * share], axis=1)
    return rigid_inverse(transform(R, p))


def places(Ts: Array) -> Array:
    return np.asarray(rigid_inverse(Ts)[:, :3, 3])


def test_poses_meet_the_keyframes_and_share_out_what_they_are_off_by() -> None:
    true = arc()
    frames = [0, 8, 20]
    drifted = true.copy()
    ends = rigid_inverse(true)
    ends[:, :3, 3] += 0.05 * np.linspace(0, 1, 21)[:, None] * (1.0, 0.0, -1.0)
    drifted = rigid_inverse(ends)
    pulled = poses_through(drifted, frames, true[frames])
    np.testing.assert_array_equal(pulled[frames], true[frames])
    assert np.linalg.norm(places(drifted) - places(true), axis=1).max() > 0.05
    np.testing.assert_allclose(places(pulled), places(true), atol=1e-9)  # a drift that grows evenly


def test_beyond_the_keyframes_poses_are_off_by_as_much_as_at_the_next() -> None:
    true = arc()
    wanted = true[[5, 10]].copy()
    wanted[:, 0, 3] += 0.2
    pulled = poses_through(true, [5, 10], wanted)
    shift = places(pulled) - places(true)
    np.testing.assert_allclose(shift[:5], np.broadcast_to(shift[5], (5, 3)), atol=1e-12)
    np.testing.assert_allclose(shift[11:], np.broadcast_to(shift[10], (10, 3)), atol=1e-12)
    np.testing.assert_allclose(pulled[:, :3, :3], true[:, :3, :3], atol=1e-12)


def test_one_keyframe_moves_all_poses_alike() -> None:
    true = arc()
    wanted = true[[7]].copy()
    wanted[0, :3, 3] += (0.1, 0.2, 0.3)
    shift = places(poses_through(true, [7], wanted)) - places(true)
    np.testing.assert_allclose(shift, np.broadcast_to(shift[7], shift.shape), atol=1e-12)
    assert np.linalg.norm(shift[7]) == pytest.approx(np.sqrt(0.14))


def test_poses_that_are_met_already_stay() -> None:
    true = arc()
    np.testing.assert_allclose(poses_through(true, [0, 9, 20], true[[0, 9, 20]]), true, atol=1e-12)


def test_poses_that_are_not_known_lie_on_the_straight_way() -> None:
    Ts = arc()
    known = np.ones(21, bool)
    known[4:9] = known[:2] = known[18:] = False
    Ts[~known] = np.nan
    bridged = poses_bridged(Ts, known)
    np.testing.assert_array_equal(bridged[known], Ts[known])
    np.testing.assert_array_equal(bridged[:2], np.stack([Ts[2]] * 2))
    np.testing.assert_array_equal(bridged[18:], np.stack([Ts[17]] * 3))
    before, after = places(bridged)[[3, 9]]
    expected = before + np.arange(1, 6)[:, None] / 6 * (after - before)
    np.testing.assert_allclose(places(bridged)[4:9], expected, atol=1e-12)
    assert off_deg(bridged[4:9], list(arc()[4:9, :3, :3])).max() < 1e-6  # it turned evenly


@pytest.mark.parametrize("known", [False, True])
def test_with_nothing_to_bridge_poses_stay_as_they_are(known: bool) -> None:
    Ts = arc()
    assert poses_bridged(Ts, np.full(21, known)) is Ts
