"""What the finding of a camera's motion is made of: each part keeps its promise alone."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.matches import rotation_from_matches
from keypose.tracker.camera_motion.measurements import Measured, Measurements
from keypose.tracker.camera_motion.patches import MOST_KEPT, Patches
from keypose.tracker.camera_motion.path import Turns
from keypose.tracker.camera_motion.points import PointFollower
from keypose.tracker.camera_motion.pose_graph import Edge, optimised
from keypose.tracker.camera_motion.turn import SeenDirections, Turn, linearised, solve_turn
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation
from tests.tracker.camera_cases import SMALL, off_deg, rendered, texture, turned

LENS = Lens.of(SMALL)


def directions(count: int, seed: int = 0) -> Array:
    uv = np.random.default_rng(seed).uniform((0, 0), (319, 179), (count, 2))
    return LENS.directions(uv, 1.0)


def test_a_large_minority_that_moves_by_itself_is_refused() -> None:
    rng = np.random.default_rng(1)
    true, d = Turn(turned(4, -2, 3), 1.1), directions(100)
    seen = true.flat(d) + rng.normal(0, 0.1 / SMALL.fx, (100, 2))
    seen[:42] += np.array([30.0, 5.0]) / SMALL.fx
    solved = solve_turn(SeenDirections.trusted(d, seen, SMALL.fx), [Turn.none()])
    assert solved is not None
    assert off_deg(solved.turn.R[None], [true.R]).max() < 0.02
    assert abs(solved.turn.zoom / 1.1 - 1) < 1e-3
    assert not solved.agrees[:42].any()
    assert solved.agrees[42:].all()


def test_trust_outweighs_number() -> None:
    """Points that have proved themselves win over more that have not."""
    d = directions(100)
    seen = Turn(turned(1.0), 1.0).flat(d)
    seen[:60] = Turn(turned(-2.0), 1.0).flat(d[:60])
    trust = np.where(np.arange(100) < 60, 0.2, 1.0)
    solved = solve_turn(SeenDirections(d, seen, SMALL.fx, trust), [Turn.none()])
    assert solved is not None
    assert off_deg(solved.turn.R[None], [turned(1.0)]).max() < 0.02


def test_the_covariance_is_that_of_the_errors() -> None:
    rng, d, misses = np.random.default_rng(2), directions(60), []
    for _ in range(60):
        seen = Turn.none().flat(d) + rng.normal(0, 0.2 / SMALL.fx, (60, 2))
        solved = solve_turn(SeenDirections.trusted(d, seen, SMALL.fx), [Turn.none()])
        assert solved is not None
        miss = np.append(log_rotation(solved.turn.R), np.log(solved.turn.zoom))
        misses.append(miss @ solved.information @ miss)
    assert 2.5 < np.mean(misses) < 8.0  # 4 for perfect weights


def test_the_slope_is_the_derivative() -> None:
    turn = Turn(turned(3, 2, 1), 1.2)
    seen = SeenDirections.trusted(directions(5), np.zeros((5, 2)), SMALL.fx)
    before, J = linearised(turn, seen)
    for axis in range(4):
        step = 1e-6 * np.eye(4)[axis]
        after, _ = linearised(turn.moved(step), seen)
        assert np.allclose((before - after) / 1e-6, J[..., axis], rtol=1e-3, atol=1e-2)


def chain(count: int, drift: Array) -> tuple[list[Turn], list[Edge]]:
    """Keyframes that turn by 5° each, with edges that are each off by a drift (3,)."""
    turns, edges = [Turn.none()], []
    for k in range(count - 1):
        step = Turn(exp_rotation(drift) @ turned(5.0), 1.0)
        edges.append(Edge(k, k + 1, step, np.eye(4) * 1e6))
        turns.append(turns[-1].then(step))
    return turns, edges


def test_a_camera_that_comes_back_spreads_its_drift() -> None:
    turns, edges = chain(7, np.radians([0.0, 0.1, 0.05]))
    edges.append(Edge(0, 6, Turn(turned(30.0), 1.0), np.eye(4) * 1e10, closes_loop=True))
    off = off_deg(
        np.stack([turn.R for turn in optimised(turns, edges)]), [turned(5.0 * k) for k in range(7)]
    )
    assert off.max() < 0.02
    assert off_deg(np.stack([t.R for t in turns]), [turned(5.0 * k) for k in range(7)])[-1] > 0.6


def test_a_false_return_loses_its_weight() -> None:
    turns, edges = chain(7, np.zeros(3))
    edges.append(Edge(0, 6, Turn(turned(10.0), 1.0), np.eye(4) * 1e6, closes_loop=True))
    off = off_deg(
        np.stack([turn.R for turn in optimised(turns, edges)]), [turned(5.0 * k) for k in range(7)]
    )
    assert off.max() < 0.05


def still_turns(count: int, known: list[int] | None = None) -> Turns:
    mask = np.ones(count, bool)
    if known is not None:
        mask = np.isin(np.arange(count), known)
    R = np.stack([turned(2.0 * k) for k in range(count)])
    return Turns(R, np.zeros(count), mask, np.full(count, 1e-4), np.full(count, 1e-4))


def test_gaps_are_bridged_and_ends_held() -> None:
    turns = still_turns(12, known=[3, 4, 9])
    path = turns.bridged()
    assert (path.R[:3] == turns.R[3]).all()
    assert (path.R[10:] == turns.R[9]).all()
    assert off_deg(path.R[4:10], list(turns.R[4:10])).max() < 1e-6


DISTORTED = SMALL.model_copy(update={"distortion": (-0.2, 0.05, 0.001, -0.001, 0.0)})


@pytest.mark.parametrize("camera", [SMALL, DISTORTED], ids=["ideal", "distorted"])
@pytest.mark.parametrize("count", [2, 3, 12])
def test_matched_points_tell_the_turn_and_the_zoom(camera: Camera, count: int) -> None:
    lens, R = Lens.of(camera), turned(7, -3, 4)
    one = np.random.default_rng(count).uniform((60, 40), (220, 140), (count, 2))
    other = lens.pixels(lens.directions(one, 1.2) @ R.T, 1.4)
    found = rotation_from_matches(one, other, camera, zoom=1.2)
    assert np.allclose(found.R_other_one, R, atol=1e-7)
    assert found.zoom == pytest.approx(1.4, abs=1e-6)
    assert found.error_px.max() < 1e-3


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ([[10.0, 10.0]], [[20.0, 10.0]]),
        ([[10.0, 10.0], [50.0, 60.0]], [[20.0, 10.0]]),
        ([[10.0, 10.0], [11.0, 10.0]], [[20.0, 10.0], [21.0, 10.0]]),
        ([], []),
    ],
)
def test_too_few_matches_are_refused(one: list[list[float]], other: list[list[float]]) -> None:
    with pytest.raises(CameraError):
        rotation_from_matches(np.array(one), np.array(other), SMALL)


def test_landmarks_are_found_in_a_turned_and_zoomed_picture() -> None:
    R, zoom = turned(3, 1, 12), 1.2
    one, other = rendered(SMALL, np.eye(3)), rendered(SMALL, R, zoom)
    follower = PointFollower(320, 180)
    follower.look(one)
    keyframe = follower.pick(None, np.zeros(0, np.int64), np.zeros((0, 2)))
    marks = Patches()
    marks.keep(one, 0, keyframe.ids, keyframe.uv, keyframe.uv)
    rays = LENS.directions(keyframe.uv, 1.0)
    true = LENS.pixels(rays @ R.T, zoom)
    inside = ((true > 24) & (true < (295, 155))).all(axis=1)
    warps = np.broadcast_to(zoom * R[:2, :2], (inside.sum(), 2, 2))
    there, found = marks.register(np.flatnonzero(inside), other, true[inside] + (2.0, -3.0), warps)
    off = np.linalg.norm(there - true[inside], axis=1)
    assert found.mean() > 0.8
    assert np.median(off[found]) < 0.15


def test_no_more_landmarks_are_kept_than_memory_has_room_for() -> None:
    marks, picture = Patches(), texture(0, 100, 100)
    for anchor in range(6):
        ids = np.arange(anchor * 4000, (anchor + 1) * 4000)
        uv = np.full((4000, 2), 50.0)
        marks.keep(picture, anchor, ids, uv, uv)
        assert len(marks) <= MOST_KEPT
    assert set(marks.anchor.tolist()) == set(range(6))


def test_of_many_frames_each_keeps_its_own_points() -> None:
    measurements, rng = Measurements(), np.random.default_rng(0)
    given = [rng.normal(size=(int(rng.integers(0, 5)), 2)).astype(np.float32) for _ in range(900)]
    for frame, uv in enumerate(given):
        good = np.full(len(uv), frame % 2 == 0)
        measurements.add(Measured(frame // 9, Turn.none(), True, "", np.eye(4), frame, uv, good))
    points = measurements.points()
    for frame, uv in enumerate(given):
        there, good = points.of(frame)
        assert (there == uv).all()
        assert (good == (frame % 2 == 0)).all()
    assert (measurements.error_px == np.arange(900)).all()
    assert (measurements.keyframe == np.arange(900) // 9).all()
