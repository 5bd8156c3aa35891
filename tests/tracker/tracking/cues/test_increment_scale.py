"""How far brightness leads astray is read off where chains from a keyframe miss the other one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.solver.robust import Cauchy
from keypose.tracker.solver.smoothness import Increments, increments
from keypose.tracker.tracking.cues.reweighting import MOST, USUAL, increment_scale
from keypose.tracker.tracking.cues.soft_correction import (
    Correction,
    measured_increments,
    with_drift,
)
from keypose.tracker.tracking.drift import Doubt, Motions
from tests.tracker.tracking.cues.people import SKELETON, Filmed, joints_apart_m, moving

COUNT = 25


def _measured(film: Filmed) -> Increments:
    """The true steps, each with the doubt of what is not seen at all."""
    truth = film.truth
    motions = Motions(
        truth.Rs_parent_part[1:], truth.ps_camera_root[1:],
        Doubt.equal(len(truth) - 1, SKELETON.part_count),
    )  # fmt: skip
    return measured_increments(film.free, truth, motions)


def _astray(film: Filmed, sigmas: float, parts: set[str] | None = None) -> Trajectory:
    """The truth, every tracked turn of some parts off by so many standard deviations of all steps
    together, and where the root is, too, unless parts are named."""
    measured = _measured(film)
    expected = sigmas * np.sqrt((1 / measured.precision).sum(axis=0))
    off, shift = np.zeros((SKELETON.part_count, 3)), np.zeros(3)
    free = film.free.skeleton
    for d in range(free.dof_count):
        part, axis = free.dof_part[d], free.dof_axis[d]
        if parts is not None and SKELETON.body.names[part] not in parts:
            continue
        if free.dof_turns[d] == 1:
            off[part, axis] = expected[d]
        elif parts is None:
            shift[axis] = expected[d]
    truth = film.truth
    R = truth.Rs_parent_part
    inside = np.einsum("nab,b->na", R[:, 0], shift)
    return Trajectory(truth.first_frame, R @ exp_rotation(off), truth.ps_camera_root + inside)


@pytest.mark.parametrize(
    ("sigmas", "scale"),
    [(0.0, 1.0), (0.5 * USUAL, 1.0), (4.0, 3.0), (14.0, MOST)],
    ids=["met", "usual", "far", "lost"],
)
def test_a_body_that_misses_the_keyframes_so_many_times_as_far_says_so(
    sigmas: float, scale: float
) -> None:
    film = Filmed(moving(COUNT))
    chain = _astray(film, sigmas)
    found = increment_scale(film.segment, (chain, chain), _measured(film))
    assert found == pytest.approx(scale, rel=0.02)


def test_one_limb_that_was_lost_says_nothing_of_the_others() -> None:
    film = Filmed(moving(COUNT))
    chain = _astray(film, 30.0, {"left_upper_arm", "left_forearm"})
    assert increment_scale(film.segment, (chain, chain), _measured(film)) == 1.0


def test_where_nothing_was_measured_nothing_is_known_to_drift() -> None:
    film = Filmed(moving(COUNT))
    chain, measured = _astray(film, 10.0), _measured(film)
    nothing = replace(measured, precision=0 * measured.precision)
    assert increment_scale(film.segment, (chain, chain), nothing) == 1.0


def test_steps_that_do_not_lead_astray_stay_the_only_link() -> None:
    measured = _measured(Filmed(moving(COUNT)))
    assert with_drift(measured, 1.0) == (measured,)


def test_a_slow_drift_counts_less_and_shaking_as_much_as_before() -> None:
    film = Filmed(moving(COUNT))
    measured = _measured(film)
    truth = increments(film.free.skeleton, film.truth)
    slow, shaking = np.full_like(truth, 0.01), np.zeros_like(truth)
    shaking[::2], shaking[1::2] = 0.01, -0.01

    def cost(off: np.ndarray, scale: float) -> float:
        moved = replace(measured, wanted=truth + off)
        return sum(link.cost(film.truth) for link in with_drift(moved, scale))

    assert cost(slow, 3.0) == pytest.approx(cost(slow, 1.0) / 9, rel=0.01)
    assert cost(shaking, 3.0) > 0.9 * cost(shaking, 1.0)


def test_keypoints_take_out_more_of_a_drift_that_is_known_to_be_large() -> None:
    film = Filmed(moving(COUNT))
    measured, rng = _measured(film), np.random.default_rng(6)
    away_and_back = np.cos(np.linspace(0, 2 * np.pi, COUNT - 1))[:, None]  # both ends are met
    off = away_and_back * rng.normal(0, 0.01, measured.wanted.shape[1])
    sure = 30 * measured.precision  # as where the pictures show all of the body
    astray = replace(measured, wanted=measured.wanted + off, precision=sure)
    plain = Correction(film.free, film.segment, film.anchors()[0])

    def missed(scale: float) -> float:
        correction = replace(plain, drift_scale=scale)
        found = correction.solve(film.truth, (astray,), Cauchy())
        return float(joints_apart_m(found, film.truth).mean())

    assert missed(4.0) < 0.75 * missed(1.0)
