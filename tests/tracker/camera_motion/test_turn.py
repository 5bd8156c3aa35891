"""A turn and a zoom are found from directions and where they are seen, whatever a minority says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.turn import (
    FEWEST,
    SeenDirections,
    Shear,
    Solved,
    Turn,
    linearised,
    solve_turn,
)
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation
from tests.tracker.camera_cases import SMALL, off_deg, turned

LENS = Lens.of(SMALL)
NOISE_PX = 0.1


def directions(count: int, seed: int = 0) -> Array:
    uv = np.random.default_rng(seed).uniform((0, 0), (319, 179), (count, 2))
    return LENS.directions(uv, 1.0)


def seen_by(turn: Turn, count: int = 100, noise_px: float = NOISE_PX) -> SeenDirections:
    """Directions where a camera turned so shows them."""
    d, rng = directions(count), np.random.default_rng(1)
    xy = turn.flat(d) + rng.normal(0, noise_px / SMALL.fx, (count, 2))
    return SeenDirections.trusted(d, xy, SMALL.fx)


def solved_of(points: SeenDirections, start: Turn | None = None) -> Solved:
    solved = solve_turn(points, [start or Turn.none()])
    assert solved is not None
    return solved


def assert_close(turn: Turn, true: Turn, deg: float = 0.02, zoom: float = 1e-3) -> None:
    assert off_deg(turn.R[None], [true.R]).max() < deg
    assert turn.zoom == pytest.approx(true.zoom, abs=zoom)


# --- turns

TURNS = [Turn(turned(4, -2, 3), 1.1), Turn(turned(-20, 8, -30), 0.7), Turn.none()]


@pytest.mark.parametrize("turn", TURNS)
def test_a_turn_and_its_inverse_lead_back(turn: Turn) -> None:
    for both in (turn.then(turn.inverse()), turn.inverse().then(turn)):
        np.testing.assert_allclose(both.R, np.eye(3), atol=1e-12)
        assert both.zoom == pytest.approx(1.0)


def test_one_turn_after_another_shows_what_both_do() -> None:
    first, second = TURNS[:2]
    d = directions(20)
    both = first.then(second)
    np.testing.assert_allclose(both.rotated(d), second.rotated(first.rotated(d)), atol=1e-12)
    assert both.zoom == pytest.approx(first.zoom * second.zoom)


def test_a_step_turns_on_in_the_cameras_own_axes() -> None:
    turn, step = TURNS[0], np.array([0.02, -0.01, 0.03, 0.1])
    moved = turn.moved(step)
    np.testing.assert_allclose(moved.R, exp_rotation(step[:3]) @ turn.R, atol=1e-12)
    assert moved.zoom == pytest.approx(turn.zoom * np.exp(0.1))
    np.testing.assert_allclose(Turn.none().moved(step).rotation, step[:3], atol=1e-12)


def test_ten_thousand_steps_leave_it_a_rotation() -> None:
    turn = Turn.none()
    for _ in range(10_000):
        turn = turn.moved(np.array([1e-3, 2e-3, -5e-4, 0.0]))
    np.testing.assert_allclose(turn.R @ turn.R.T, np.eye(3), atol=1e-12)


def test_a_turn_that_is_predicted_from_the_two_before_stays_a_rotation() -> None:
    before, turn = Turn(turned(1.0), 1.0), Turn(turned(1.5, 0.2), 1.0)
    for _ in range(60):
        on = before.inverse().then(turn)
        before, turn = turn, turn.then(on).moved(np.full(4, 1e-9))
    np.testing.assert_allclose(turn.R @ turn.R.T, np.eye(3), atol=1e-12)


def test_what_is_behind_the_camera_is_seen_nowhere() -> None:
    back = Turn(turned(180.0), 1.0)
    assert np.isnan(back.flat(directions(5))).all()


# --- solving

TRUE = {
    "a pan": Turn(turned(3.0), 1.0),
    "a tilt": Turn(turned(0.0, -4.0), 1.0),
    "a roll": Turn(turned(0.0, 0.0, 12.0), 1.0),
    "a zoom": Turn(np.eye(3), 1.4),
    "all of them": Turn(turned(4, -2, 3), 1.1),
    "nothing": Turn.none(),
}


@pytest.mark.parametrize("name", TRUE)
def test_a_turn_is_found_from_none(name: str) -> None:
    solved = solved_of(seen_by(TRUE[name]))
    assert_close(solved.turn, TRUE[name])
    assert solved.agreeing == 100
    assert solved.noise_px == pytest.approx(NOISE_PX, rel=0.2)


def test_to_rounding_without_noise() -> None:
    true = TRUE["all of them"]
    assert_close(solved_of(seen_by(true, noise_px=0.0)).turn, true, deg=1e-9, zoom=1e-9)


def test_a_large_minority_that_moves_by_itself_is_refused() -> None:
    true = Turn(turned(4, -2, 3), 1.1)
    points = seen_by(true)
    points.xy[:42] += np.array([30.0, 5.0]) / SMALL.fx
    solved = solved_of(points)
    assert_close(solved.turn, true)
    assert not solved.agrees[:42].any()
    assert solved.agrees[42:].all()


def test_from_afar_pairs_of_points_find_it_where_a_third_is_wrong() -> None:
    true = Turn(turned(9, 4, 14), 1.15)
    points = seen_by(true)
    rng = np.random.default_rng(3)
    points.xy[:33] = rng.uniform(-0.35, 0.35, (33, 2))
    assert_close(solved_of(points).turn, true, deg=0.05)


def test_the_likeliest_start_is_enough_where_it_is_right() -> None:
    true = Turn(turned(25.0, 5.0), 0.8)
    wrong = Turn(turned(-25.0), 1.0)
    solved = solve_turn(seen_by(true), [wrong, true])
    assert solved is not None
    assert_close(solved.turn, true)


def test_trust_outweighs_number() -> None:
    """Points that have proved themselves win over more that have not."""
    points = seen_by(Turn(turned(1.0), 1.0), noise_px=0.0)
    points.xy[:60] = Turn(turned(-2.0), 1.0).flat(points.directions[:60])
    points = replace(points, trust=np.where(np.arange(100) < 60, 0.2, 1.0))
    assert_close(solved_of(points).turn, Turn(turned(1.0), 1.0))


def test_the_covariance_is_that_of_the_errors() -> None:
    rng, d, misses = np.random.default_rng(2), directions(60), []
    for _ in range(60):
        xy = Turn.none().flat(d) + rng.normal(0, 0.2 / SMALL.fx, (60, 2))
        solved = solved_of(SeenDirections.trusted(d, xy, SMALL.fx))
        miss = np.append(log_rotation(solved.turn.R), np.log(solved.turn.zoom))
        misses.append(miss @ solved.information @ miss)
    assert 2.5 < np.mean(misses) < 8.0  # 4 for perfect weights


def test_what_points_have_in_common_makes_the_turn_less_sure() -> None:
    solved = solved_of(seen_by(Turn.none()))
    plain, wider = (np.diag(solved.covariance(systematic)) for systematic in (0.0, 1e-3))
    np.testing.assert_allclose(plain, np.diag(np.linalg.inv(solved.information)), rtol=1e-3)
    np.testing.assert_allclose(wider - plain, 1e-6, rtol=1e-3)


@pytest.mark.parametrize("count", [0, 1, FEWEST - 1])
def test_too_few_points_tell_no_turn(count: int) -> None:
    assert solve_turn(seen_by(Turn.none(), count), [Turn.none()]) is None


def test_points_in_one_place_tell_no_roll_and_are_not_sure_of_it() -> None:
    d = np.repeat(LENS.directions(np.array([[160.0, 90.0]]), 1.0), 30, axis=0)
    rng = np.random.default_rng(4)
    xy = Turn.none().flat(d) + rng.normal(0, NOISE_PX / SMALL.fx, (30, 2))
    solved = solve_turn(SeenDirections.trusted(d, xy, SMALL.fx), [Turn.none()])
    assert solved is not None
    roll_doubt = np.sqrt(np.diag(solved.covariance(0.0)))[2]
    assert roll_doubt > np.radians(10)


def test_points_behind_the_camera_do_not_agree_and_do_no_harm() -> None:
    true = TRUE["a pan"]
    points = seen_by(true)
    points.directions[:10] *= -1
    solved = solved_of(points)
    assert not solved.agrees[:10].any()
    assert_close(solved.turn, true)


def test_a_step_of_the_camera_leaves_near_points_aside() -> None:
    """No turn explains both what is near and what is far."""
    d = directions(120)
    depth = np.where(np.arange(120) < 80, 50.0, 2.0)
    p = d * depth[:, None] - np.array([0.1, 0.0, 0.0])
    points = SeenDirections.trusted(d, p[:, :2] / p[:, 2:], SMALL.fx)
    solved = solved_of(points)
    assert solved.agrees[:80].mean() > 0.95
    assert solved.agrees[80:].mean() < 0.05


def test_the_slope_is_the_derivative() -> None:
    turn = Turn(turned(3, 2, 1), 1.2)
    points = SeenDirections.trusted(directions(5), np.zeros((5, 2)), SMALL.fx)
    before, J = linearised(turn, points)
    for axis in range(4):
        step = 1e-6 * np.eye(4)[axis]
        after, _ = linearised(turn.moved(step), points)
        np.testing.assert_allclose((before - after) / 1e-6, J[..., axis], rtol=1e-3, atol=1e-2)


# --- shear


def sheared(share: float, count: int = 150) -> tuple[SeenDirections, Shear]:
    """Points of a picture that is sheared along u by their height, of which nothing is known."""
    points = seen_by(TRUE["a pan"], count, noise_px=0.02)
    shifts = np.zeros((count, 2, 1))
    shifts[:, 0, 0] = points.xy[:, 1]
    sheared_points = replace(points, xy=points.xy + share * shifts[..., 0])
    return sheared_points, Shear(shifts, np.zeros(1))


def test_points_say_by_how_much_the_picture_is_sheared() -> None:
    points, shear = sheared(0.03)
    solved = solve_turn(points, [Turn.none()], shear=shear)
    assert solved is not None
    change = np.linalg.solve(solved.pull_information, solved.pull)
    assert change[0] == pytest.approx(0.03, rel=0.05)


def test_a_shear_that_is_known_is_taken_out() -> None:
    points, shear = sheared(0.03)
    solved = solve_turn(points, [Turn.none()], shear=replace(shear, share=np.array([0.03])))
    assert solved is not None
    assert_close(solved.turn, TRUE["a pan"], deg=0.005)
    plain = solve_turn(points, [Turn.none()])
    assert plain is not None
    assert off_deg(plain.turn.R[None], [TRUE["a pan"].R]).max() > 0.1  # taken for roll


def test_the_lever_says_where_another_shear_would_have_led() -> None:
    points, shear = sheared(0.01)
    blind, told = (
        solve_turn(points, [Turn.none()], shear=replace(shear, share=np.array([share])))
        for share in (0.0, 0.01)
    )
    assert blind is not None
    assert told is not None
    moved = blind.turn.moved(blind.lever @ np.array([0.01]))
    assert_close(moved, told.turn, deg=0.01)
