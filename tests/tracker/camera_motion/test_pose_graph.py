"""Turns between keyframes that were measured twice are met as well as can be."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.pose_graph import Edge, optimised
from keypose.tracker.camera_motion.turn import Turn
from keypose.tracker.geometry.rotations import Array, exp_rotation
from tests.tracker.camera_cases import off_deg, turned

SURE = np.eye(4) * 1e6
"""Information of 0.06° and 0.1 % of zoom."""
SURER = np.eye(4) * 1e10
COUNT = 7
STEP_DEG = 5.0
TRUE = [turned(STEP_DEG * k) for k in range(COUNT)]


def chain(drift: Array, zoom: float = 1.0) -> tuple[list[Turn], list[Edge]]:
    """Keyframes that turn by 5° each, with edges that are each off by a drift (3,) and a zoom."""
    turns, edges = [Turn.none()], []
    for k in range(COUNT - 1):
        step = Turn(exp_rotation(drift) @ turned(STEP_DEG), zoom)
        edges.append(Edge(k, k + 1, step, SURE))
        turns.append(turns[-1].then(step))
    return turns, edges


def closing(source: int, target: int, turn: Turn, information: Array = SURER) -> Edge:
    return Edge(source, target, turn, information, closes_loop=True)


def errors_deg(turns: list[Turn]) -> Array:
    return off_deg(np.stack([turn.R for turn in turns]), TRUE)


DRIFT = np.radians([0.0, 0.1, 0.05])


def test_a_camera_that_comes_back_spreads_its_drift() -> None:
    turns, edges = chain(DRIFT)
    assert errors_deg(turns)[-1] > 0.6
    edges.append(closing(0, 6, Turn(turned(30.0), 1.0)))
    assert errors_deg(optimised(turns, edges)).max() < 0.02


def test_without_a_closed_loop_nothing_changes() -> None:
    turns, edges = chain(DRIFT)
    for before, after in zip(turns, optimised(turns, edges), strict=True):
        np.testing.assert_allclose(after.R, before.R, atol=1e-9)
        assert after.zoom == pytest.approx(before.zoom)


def test_the_first_keyframe_stays_where_it_is() -> None:
    turns, edges = chain(DRIFT)
    begin = Turn(turned(40.0, 10.0), 1.3)
    turned_all = [begin.then(turn) for turn in turns]
    edges.append(closing(0, 6, Turn(turned(30.0), 1.0)))
    first, *_, last = optimised(turned_all, edges)
    np.testing.assert_allclose(first.R, begin.R, atol=1e-12)
    assert first.zoom == pytest.approx(1.3)
    assert off_deg((last.R @ begin.R.T)[None], [TRUE[-1]]).max() < 0.02


def test_a_zoom_that_drifted_is_spread_too() -> None:
    turns, edges = chain(np.zeros(3), zoom=1.01)
    edges.append(closing(0, 6, Turn(turned(30.0), 1.0)))
    zooms = [turn.zoom for turn in optimised(turns, edges)]
    assert np.abs(np.log(zooms)).max() < 0.002
    assert turns[-1].zoom > 1.06


def test_an_unsure_step_takes_the_drift() -> None:
    turns, edges = chain(np.zeros(3))
    edges[2] = Edge(2, 3, edges[2].turn, SURE / 1e4)
    edges.append(closing(0, 6, Turn(turned(31.0), 1.0), SURE))
    off = errors_deg(optimised(turns, edges))
    assert off[:3].max() < 0.02
    assert off[3:].min() > 0.9


def test_a_false_closure_loses_its_weight() -> None:
    turns, edges = chain(np.zeros(3))
    edges.append(closing(0, 6, Turn(turned(10.0), 1.0), SURE))
    assert errors_deg(optimised(turns, edges)).max() < 0.05


def test_a_false_closure_does_not_spoil_right_ones() -> None:
    turns, edges = chain(DRIFT)
    edges += [closing(0, 6, Turn(turned(30.0), 1.0)), closing(1, 5, Turn(turned(20.0), 1.0))]
    edges.append(closing(2, 6, Turn(turned(-10.0), 1.0), SURE))
    assert errors_deg(optimised(turns, edges)).max() < 0.03


@pytest.mark.parametrize("count", [0, 1])
def test_fewer_than_two_keyframes_are_left_as_they_are(count: int) -> None:
    turns = [Turn(turned(3.0), 1.1)] * count
    assert optimised(turns, []) == turns
