"""A dense motion becomes the fewest keyframes between which interpolation gives it back."""

from __future__ import annotations

import math
from itertools import combinations, pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate
from keypose.tracker.errors import ReductionError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.reduction.compare import _compared_body
from keypose.tracker.reduction.reduce import reduce_motion
from keypose.tracker.reduction.result import Every, Reduction, Tolerance, require_range
from tests.rendering import mocap
from tests.rendering.mocap import needs_mocap
from tests.tracker.tracking_cases import CAMERA, CAMERAS, deep_chain, random_body

Floats = NDArray[np.float64]


def wandering(skeleton: Skeleton, frames: int, seed: int, turn: float = 0.25) -> Trajectory:
    """Every part turns, and the root moves, by random steps: nothing like a smooth motion."""
    rng = np.random.default_rng(seed)
    Rs = np.tile(np.eye(3), (frames, skeleton.part_count, 1, 1))
    for n in range(1, frames):
        Rs[n] = Rs[n - 1] @ exp_rotation(rng.normal(0, turn, (skeleton.part_count, 3)))
    ps = np.cumsum(rng.normal(0, 0.05, (frames, 3)), axis=0) + np.array([0.0, 0.0, 3.0])
    return Trajectory(4, Rs, ps)


def misses(
    skeleton: Skeleton, camera: Camera, motion: Trajectory, tolerance: Tolerance, a: int, b: int
) -> Floats:
    """The misses of the frames between a and b, in plain numpy: the loops' twin."""
    body = _compared_body(skeleton, None)
    of = np.repeat(np.arange(skeleton.part_count), np.diff(body.starts))

    def points(shown: Trajectory) -> Floats:
        T = shown.transforms(skeleton)[:, of]
        return np.asarray((T[..., :3, :3] @ body.points[..., None])[..., 0] + T[..., :3, 3])

    between = interpolate(motion.pose(a), motion.pose(b), a, b)
    ours = points(between)[1:-1]
    theirs = points(motion)[a + 1 - motion.first_frame : b - motion.first_frame]
    away = np.linalg.norm(ours - theirs, axis=-1) / tolerance.metres
    if math.isfinite(tolerance.pixels):
        uv = camera.project(ours) - camera.project(theirs)
        away = np.maximum(away, np.linalg.norm(uv, axis=-1) / tolerance.pixels)
    return np.asarray(away.max(axis=-1)) if len(away) else np.zeros(0)


def brute_force(
    skeleton: Skeleton, camera: Camera, motion: Trajectory, tolerance: Tolerance
) -> tuple[int, ...]:
    """The best of all sets of frames."""
    first, last = motion.first_frame, motion.last_frame
    cost = {
        (a, b): misses(skeleton, camera, motion, tolerance, a, b)
        for a, b in combinations(range(first, last + 1), 2)
    }
    for count in range(last - first):
        sets = []
        for inner in combinations(range(first + 1, last), count):
            found = [cost[pair] for pair in pairwise((first, *inner, last))]
            if all((one <= 1).all() for one in found):
                sets.append((sum(float((one**2).sum()) for one in found), (first, *inner, last)))
        if sets:
            return min(sets)[1]
    raise AssertionError


def require_reproduced(
    skeleton: Skeleton, camera: Camera, motion: Trajectory, found: Reduction
) -> None:
    for a, b in pairwise(found.frames):
        expected = misses(skeleton, camera, motion, found.tolerance, a, b)
        assert (expected <= 1 + 1e-9).all()
        rows = slice(a + 1 - motion.first_frame, b - motion.first_frame)
        np.testing.assert_allclose(found.misses[rows], expected, atol=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_no_other_frames_are_fewer_or_as_few_and_nearer(seed: int) -> None:
    skeleton, motion = random_body(seed), wandering(random_body(seed), 10, seed)
    camera = CAMERAS["telephoto" if seed % 2 else "perspective"]
    for tolerance in (
        Tolerance(0.15),
        Tolerance(0.4),
        Tolerance(math.inf, 12.0),
        Tolerance(0.5, 20),
    ):
        found = reduce_motion(skeleton, camera, motion, tolerance)
        assert found.frames == brute_force(skeleton, camera, motion, tolerance)
        require_reproduced(skeleton, camera, motion, found)


@pytest.mark.parametrize("seed", range(4))
def test_one_frame_in_so_many_leaves_the_least_to_be_missed(seed: int) -> None:
    skeleton, motion = random_body(seed), wandering(random_body(seed), 11, seed)
    for every, required in ((2, ()), (3, ()), (3, (6, 13)), (9, ()), (20, ())):
        found = reduce_motion(skeleton, CAMERA, motion, Every(every), required)
        assert found.frames == best_spread(skeleton, motion, every, required)
        assert found.worst == pytest.approx(1)
        require_reproduced(skeleton, CAMERA, motion, found)


def best_spread(
    skeleton: Skeleton, motion: Trajectory, every: int, required: tuple[int, ...]
) -> tuple[int, ...]:
    """The best of all sets of frames none of which is too far from the next one."""
    first, last = motion.first_frame, motion.last_frame
    cost = {
        (a, b): float((misses(skeleton, CAMERA, motion, Tolerance(1.0), a, b) ** 2).sum())
        for a, b in combinations(range(first, last + 1), 2)
    }
    for count in range(max((last - first) // every, 1) - 1, last - first):
        paths = [(first, *inner, last) for inner in combinations(range(first + 1, last), count)]
        sets = [
            (sum(cost[pair] for pair in pairwise(path)), path)
            for path in paths
            if set(required) <= set(path)
            and max(b - a for a, b in pairwise(path)) <= math.ceil(1.3 * every)
        ]
        if sets:
            return min(sets)[1]
    raise AssertionError


def test_frames_without_a_pose_are_led_over_however_many_they_are() -> None:
    skeleton, motion = random_body(4), wandering(random_body(4), 30, 4, turn=0.05)
    Rs, ps = motion.writable()
    ps[5:25] = np.nan
    found = reduce_motion(skeleton, CAMERA, Trajectory(4, Rs, ps), Every(4))
    assert {8, 29} <= set(found.frames)
    assert not set(range(9, 29)) & set(found.frames)
    assert found.known_count == 10


def test_a_still_body_and_an_even_motion_need_two_keyframes() -> None:
    skeleton = deep_chain()
    start = wandering(skeleton, 2, 1)
    even = interpolate(start.pose(4), start.pose(5), 10, 300)
    still = interpolate(start.pose(4), start.pose(4), 10, 300)
    for motion in (even, still):
        assert reduce_motion(skeleton, CAMERA, motion, Tolerance(1e-4)).frames == (10, 300)


def test_a_full_turn_has_keyframes_less_than_half_a_turn_apart() -> None:
    skeleton, frames = random_body(3, parts=1), 73
    turns = exp_rotation(np.linspace(0, 2 * np.pi, frames)[:, None, None] * np.array([0, 1.0, 0]))
    motion = Trajectory(0, turns, np.tile((0.0, 0.0, 3.0), (frames, 1)))
    found = reduce_motion(skeleton, CAMERA, motion, Tolerance(1e-4))
    assert len(found.frames) in (3, 4)  # a half turn may be led through either way
    assert max(b - a for a, b in pairwise(found.frames)) <= 36
    require_reproduced(skeleton, CAMERA, motion, found)


def test_required_frames_are_keyframes_and_the_rest_is_as_good_as_can_be() -> None:
    skeleton, motion = random_body(2), wandering(random_body(2), 12, 2)
    free = reduce_motion(skeleton, CAMERA, motion, Tolerance(0.3))
    bound = reduce_motion(skeleton, CAMERA, motion, Tolerance(0.3), required=[7, 9])
    assert {7, 9} <= set(bound.frames)
    assert len(free.frames) <= len(bound.frames)
    require_reproduced(skeleton, CAMERA, motion, bound)


def test_frames_without_a_pose_are_no_keyframes_and_are_bridged() -> None:
    skeleton, motion = random_body(4), wandering(random_body(4), 12, 4, turn=0.05)
    Rs, ps = motion.writable()
    Rs[0], ps[0], ps[5:8] = np.nan, np.nan, np.nan
    gappy = Trajectory(4, Rs, ps)
    found = reduce_motion(skeleton, CAMERA, gappy, Tolerance(0.02))
    assert found.frames[0] == 5
    assert not {4, 9, 10, 11} & set(found.frames)
    assert np.isnan(found.misses[[0, 5, 6, 7]]).all()
    assert found.worst <= 1
    assert found.known_count == 8
    with pytest.raises(ReductionError, match="Frame 10 is a keyframe, but the motion has no pose"):
        reduce_motion(skeleton, CAMERA, gappy, Tolerance(0.02), required=[10])


def test_parts_by_themselves_need_no_more_keyframes_than_the_body() -> None:
    skeleton, motion = deep_chain(), wandering(deep_chain(), 20, 5, turn=0.1)
    whole = reduce_motion(skeleton, CAMERA, motion, Tolerance(0.1))
    tip = reduce_motion(skeleton, CAMERA, motion, Tolerance(0.1), parts=[6, 7])
    assert len(tip.frames) < len(whole.frames)


@pytest.mark.parametrize(
    ("metres", "pixels", "words"),
    [
        (0.0, math.inf, "at least 0.1 mm"),
        (-1.0, 3.0, "at least 0.1 mm"),
        (0.02, 0.0, "0.01 pixels"),
        (math.nan, math.inf, "at least"),
        (math.inf, math.inf, "in space or in the picture"),
    ],
)
def test_a_tolerance_that_is_none_is_refused(metres: float, pixels: float, words: str) -> None:
    with pytest.raises(ReductionError, match=words):
        Tolerance(metres, pixels)


def test_less_than_one_frame_for_a_keyframe_is_refused() -> None:
    with pytest.raises(ReductionError, match="at least 1"):
        Every(0)


def test_a_motion_needs_two_poses_and_a_range_lies_within_it() -> None:
    skeleton, motion = random_body(1), wandering(random_body(1), 5, 1)
    one = Trajectory(0, motion.Rs_parent_part[:1], motion.ps_camera_root[:1])
    with pytest.raises(ReductionError, match="this one has one"):
        reduce_motion(skeleton, CAMERA, one, Tolerance())
    for first, last in ((3, 6), (5, 9), (7, 5)):
        with pytest.raises(ReductionError, match="The motion has frames 4 to 8"):
            require_range(motion, first, last)
    assert len(require_range(motion, 5, 7)) == 3


def test_work_can_be_cancelled_from_its_progress() -> None:
    skeleton, motion = random_body(1), wandering(random_body(1), 30, 1)
    reported = []

    def stop(done: int, expected: int) -> None:
        reported.append((done, expected))
        raise KeyboardInterrupt

    for goal in (Tolerance(0.02), Every(5)):
        with pytest.raises(KeyboardInterrupt):
            reduce_motion(skeleton, CAMERA, motion, goal, progress=stop)
    assert [expected for _, expected in reported] == [30, 30]
    assert reported[0][0] <= 30


@needs_mocap
@pytest.mark.parametrize(
    ("name", "in_space", "in_picture"),
    [("walk", 46, 34), ("jump", 32, 20), ("wash", 32, 26), ("pirouette", 58, 40),
     ("jumping_jacks", 60, 41)],
)  # fmt: skip
def test_recorded_motions_come_back_within_2_cm_or_5_px(
    name: str, in_space: int, in_picture: int
) -> None:
    skeleton = Skeleton.of(preset("adult_male"))
    motion = getattr(mocap, name)(skeleton, constrained=False)
    camera = Camera(width=640, height=360, fx=700, fy=700, cx=319.5, cy=179.5)
    for tolerance, most in ((Tolerance(0.02), in_space), (Tolerance(math.inf, 5.0), in_picture)):
        found = reduce_motion(skeleton, camera, motion, tolerance)
        assert len(found.frames) <= most
        require_reproduced(skeleton, camera, motion, found)


def test_a_body_that_goes_evenly_through_the_world_needs_no_keyframes_for_a_shake() -> None:
    skeleton = Skeleton.of(preset("box"))
    start = Pose.rest(skeleton, (0.0, 0.0, 3.0))
    end = Pose(start.Rs_parent_part @ exp_rotation((0.0, 0.3, 0.1)), np.array([0.5, 0.1, 3.4]))
    even = interpolate(start, end, 4, 40)
    rng = np.random.default_rng(2)
    turns = exp_rotation(np.cumsum(rng.normal(0, 0.01, (45, 3)), axis=0))
    path = CameraPath.of(turns, rng.normal(0, 0.02, (45, 3)), 1 + np.arange(45) / 30)
    seen = even.carried(path.between(4, 40).Ts_camera_world)
    for tolerance in (Tolerance(1e-4), Tolerance(1.0, 0.05)):
        found = reduce_motion(skeleton, CAMERA, seen, tolerance, path=path)
        assert found.frames == (4, 40)
        assert len(reduce_motion(skeleton, CAMERA, seen, tolerance).frames) > 10


def test_misses_in_the_picture_are_as_large_as_the_camera_shows_them_at_each_frame() -> None:
    skeleton = Skeleton.of(preset("box"))
    motion = wandering(skeleton, 9, 5, 0.02)
    path = CameraPath.of(
        exp_rotation(np.linspace(0, 0.2, 13)[:, None] * np.array([0.2, -1.0, 0.3])),
        np.linspace(0, 0.1, 13)[:, None] * np.array([1.0, 0.0, 0.5]), np.linspace(1, 2, 13),
    )  # fmt: skip
    seen = motion.carried(path.between(4, 12).Ts_camera_world)
    found = reduce_motion(skeleton, CAMERA, seen, Tolerance(1e6, 1e3), path=path)
    between = interpolate(motion.pose(4), motion.pose(12), 4, 12)
    body = _compared_body(skeleton, None)
    assert found.frames == (4, 12)
    for frame in range(5, 12):
        T, camera = path.Ts_camera_world[frame], path.camera_at(CAMERA, frame)
        uv = []
        for shown in (between, motion):
            Ts = T @ pose_transforms(skeleton, shown.pose(frame))
            uv.append(camera.project(body.points @ Ts[0, :3, :3].T + Ts[0, :3, 3]))
        px = np.linalg.norm(uv[0] - uv[1], axis=-1).max()
        assert found.misses[frame - 4] * 1e3 == pytest.approx(px, rel=1e-6)
