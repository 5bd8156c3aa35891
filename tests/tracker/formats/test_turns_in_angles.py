"""Angles in tables run on where a part turns, and gain no turns where it only passes the pole."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.heading import CAMERA_UP, heading_first
from keypose.tracker.formats.rotation_curves import known_smooth_euler, smooth_euler
from keypose.tracker.geometry.rotations import Array, exp_rotation, rotation_from_euler

FRAMES = 600
TURNS = 6


def turning(sway_deg: float, seed: int) -> Array:
    """(N, 1, 3, 3) somebody who turns round and round and sways in every direction."""
    t = np.linspace(0, 1, FRAMES)
    noise = np.random.default_rng(seed)
    sways = [
        sum(np.sin(2 * np.pi * (k * t + noise.random())) / 3 for k in (4, 7, 11)) for _ in "xz"
    ]
    tilts = np.stack([sways[0], 0 * t, sways[1]], axis=1) * np.radians(sway_deg)
    turns = exp_rotation(np.outer(2 * np.pi * TURNS * t, [0.0, 1.0, 0.0]))
    return np.asarray(exp_rotation(tilts) @ turns)[:, None]


@pytest.mark.parametrize("sway_deg", [2.0, 8.0, 20.0])
@pytest.mark.parametrize("seed", range(6))
def test_somebody_who_turns_round_and_sways_gains_no_turns_of_roll_and_pitch(
    sway_deg: float, seed: int
) -> None:
    Rs = turning(sway_deg, seed)
    z, y, x = np.degrees(known_smooth_euler(Rs)[:, 0].T)
    away = np.abs(np.sin(np.radians(y))) < 0.7
    for angle in (z, x):
        assert np.abs(angle[away]).max() < 180 + 1.2 * sway_deg
        assert np.abs(angle).max() < 320
    again = np.stack(
        [rotation_from_euler(*np.radians(angles)) for angles in zip(z, y, x, strict=True)]
    )
    np.testing.assert_allclose(again, Rs[:, 0], atol=1e-9)


def test_the_motion_of_this_module_gains_turns_where_nothing_takes_them_back() -> None:
    most = [np.abs(smooth_euler(turning(20.0, seed))[..., [0, 2]]).max() for seed in range(6)]
    assert np.degrees(max(most)) > 600


@pytest.mark.parametrize("axis", [0, 2])
def test_a_part_that_tumbles_has_angles_that_run_on(axis: int) -> None:
    turn = np.linspace(0, 2 * np.pi * TURNS, FRAMES)
    Rs = exp_rotation(np.outer(turn, np.eye(3)[axis]))[:, None]
    found = known_smooth_euler(Rs)[:, 0, 2 - axis]
    np.testing.assert_allclose(np.abs(found), turn, atol=1e-9)


def test_away_from_the_pole_nothing_jumps() -> None:
    angles = known_smooth_euler(turning(8.0, 1))[:, 0]
    away = np.abs(np.sin(angles[:, 1])) < np.sin(np.radians(45.0))
    steps = np.degrees(np.abs(np.diff(angles, axis=0)))[away[1:] & away[:-1]]
    assert steps.max() < 15


@pytest.mark.parametrize("seed", range(6))
def test_against_what_is_up_the_heading_runs_on_and_roll_and_pitch_stay(seed: int) -> None:
    level = heading_first(turning(8.0, seed), CAMERA_UP)
    heading, roll, pitch = np.degrees(known_smooth_euler(level)[:, 0].T)
    assert abs(abs(np.ptp(heading)) - 360 * TURNS) < 30
    assert max(np.abs(roll).max(), np.abs(pitch).max()) < 30
