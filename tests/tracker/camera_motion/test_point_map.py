"""The map of a camera that moves: where its landmarks are, and which are in view again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from keypose.tracker.camera_motion.point_map import Keyframe, PointMap
from keypose.tracker.camera_motion.points import PointFollower
from keypose.tracker.camera_motion.two_views import TwoViews
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation, transform
from tests.tracker.camera_cases import planes
from tests.tracker.camera_motion.place_cases import NOISE, Place, off_by

CAMERA = Camera(width=320, height=180, fx=250.0, fy=250.0, cx=159.5, cy=89.5)
PLACE = Place.of(views=8, points=150)
IDS = np.arange(150)


def seen_by(number: int, noise: float = NOISE) -> Array:
    """Where a camera of the place sees its points, as x/z and y/z."""
    rng = np.random.default_rng(number)
    return np.asarray(PLACE.seen[0][number] + rng.normal(0, noise, (150, 2)))


def mapped(count: int = 8, off: float = 0.0, depths_off: float = 0.0) -> PointMap:
    """A map of the place, its poses and depths off by so much, anchored in the first keyframe."""
    rng = np.random.default_rng(1)
    point_map = PointMap(CAMERA, PointFollower(320, 180), NOISE)
    for number in range(count):
        step = rng.normal(0, off, 6) if number else np.zeros(6)
        T = transform(exp_rotation(step[3:]), step[:3]) @ PLACE.Ts[number]
        point_map.add(Keyframe(number, T, IDS, seen_by(number)))
    point_map.has_depths = True
    true = 1 / PLACE.seen[1][0]
    point_map.depths = true * np.exp(rng.normal(0, depths_off, 150))
    point_map.mean = np.full(150, float(np.median(true)))
    point_map.spread = np.full(150, 0.02)
    return point_map


# --- keyframes and landmarks


def test_new_landmarks_follow_those_that_are_there() -> None:
    point_map = PointMap(CAMERA, PointFollower(320, 180), NOISE)
    point_map.add(Keyframe(0, np.eye(4), np.arange(5), np.zeros((5, 2))))
    point_map.add(Keyframe(9, np.eye(4), np.array([1, 3, 5, 6]), np.ones((4, 2))))
    assert point_map.anchor.tolist() == [0, 0, 0, 0, 0, 1, 1]
    assert point_map.rays[:, 0].tolist() == [0.0] * 5 + [1.0] * 2
    assert (point_map.depths == 0).all()  # infinitely far, until depths are known
    assert point_map.sound.all()


def test_a_new_landmark_is_as_far_as_others_usually_are() -> None:
    point_map = mapped()
    usual = float(np.median(1 / PLACE.seen[1][7]))
    xy = np.concatenate([seen_by(7), np.zeros((2, 2))])
    ids = np.concatenate([IDS, [150, 151]])
    point_map.add(Keyframe(20, PLACE.Ts[7], ids, xy))
    np.testing.assert_allclose(point_map.depths[150:], usual, rtol=0.02)
    np.testing.assert_allclose(point_map.spread[150:], usual, rtol=0.02)


def test_a_keyframe_that_is_put_between_others_leaves_landmarks_their_anchors() -> None:
    point_map = PointMap(CAMERA, PointFollower(320, 180), NOISE)
    for frame, ids in ((0, [0, 1]), (20, [1, 2, 3])):
        number = len(ids)
        point_map.add(Keyframe(frame, np.eye(4), np.array(ids), np.full((number, 2), float(frame))))
    point_map.insert(Keyframe(10, np.eye(4), np.array([0, 1]), np.zeros((2, 2))))
    assert [keyframe.frame for keyframe in point_map.keyframes] == [0, 10, 20]
    frames = [point_map.keyframes[anchor].frame for anchor in point_map.anchor]
    assert frames == [0, 0, 20, 20]


def test_landmarks_are_expected_where_they_are_seen() -> None:
    point_map = mapped()
    for number in (0, 3, 7):
        there = point_map.expected(PLACE.Ts[number], IDS)
        np.testing.assert_allclose(there, PLACE.seen[0][number], atol=2 * NOISE * 5)


def test_behind_the_camera_they_are_expected_nowhere() -> None:
    back = PLACE.Ts[0].copy()
    back[:3, :3] = np.diag([-1.0, 1.0, -1.0]) @ back[:3, :3]
    assert np.isnan(mapped().expected(back, IDS)).all()


def test_what_is_known_of_landmarks_is_where_they_are_in_the_world() -> None:
    observed = mapped().observed(IDS, seen_by(2))
    X = observed.world / observed.depths[:, None]
    np.testing.assert_allclose(X, PLACE.X, rtol=0.02, atol=0.02)
    np.testing.assert_allclose(observed.eyes, 0.0, atol=1e-12)  # all anchored in the first one
    assert point_count(observed.world) == 150
    empty = mapped().observed(IDS[:0], np.zeros((0, 2)))
    assert empty.world.shape == (0, 3)


def point_count(world: Array) -> int:
    return int(np.isfinite(world).all(axis=1).sum())


# --- adjustment


def test_an_adjustment_finds_poses_and_depths() -> None:
    point_map = mapped(off=0.01, depths_off=0.1)
    point_map.adjust_all()
    errors = [off_by(k.T, true) for k, true in zip(point_map.keyframes, PLACE.Ts, strict=True)]
    scale = np.median(point_map.depths * PLACE.seen[1][0])
    assert max(turn for turn, _ in errors) < 0.2
    assert scale == pytest.approx(1.0, rel=0.2)  # which nothing tells
    relative = point_map.depths * PLACE.seen[1][0] / scale
    assert np.median(np.abs(relative - 1)) < 0.01
    np.testing.assert_array_equal(point_map.keyframes[0].T, PLACE.Ts[0])


def test_an_adjustment_on_the_way_leaves_all_but_the_last_keyframes() -> None:
    point_map = mapped(count=8, off=0.005, depths_off=0.05)
    for frame in range(8, 30):  # it waits at the end of the way
        point_map.add(Keyframe(frame, PLACE.Ts[7].copy(), IDS, seen_by(7)))
    before = [keyframe.T.copy() for keyframe in point_map.keyframes]
    point_map.adjust_last()
    moved = [not np.array_equal(k.T, T) for k, T in zip(point_map.keyframes, before, strict=True)]
    assert moved == [False] * 18 + [True] * 12


def test_a_landmark_that_moves_by_itself_is_found_out() -> None:
    point_map = mapped(depths_off=0.05)
    for number, keyframe in enumerate(point_map.keyframes):
        keyframe.xy[:6] += 0.01 * number * np.array([1.0, -1.0])
    point_map.adjust_all()
    assert not point_map.sound[:6].any()
    assert point_map.sound[6:].mean() > 0.97


def test_a_landmark_that_would_lie_behind_its_anchor_is_found_out() -> None:
    point_map = mapped()
    true, point_map.depths[:5] = point_map.depths[:5].copy(), -0.3
    for keyframe in point_map.keyframes[1:]:  # as a reflection in a mirror ball is seen
        keyframe.xy[:5] = point_map.expected(keyframe.T, IDS[:5])
    point_map.depths[:5] = true
    point_map.adjust_all()
    assert not point_map.sound[:5].any()
    assert point_map.sound[5:].mean() > 0.97


def test_with_nothing_to_adjust_nothing_changes() -> None:
    point_map = mapped(count=1)
    point_map.adjust_all()
    np.testing.assert_array_equal(point_map.keyframes[0].T, PLACE.Ts[0])
    assert point_map.bundle(range(1), 1) is None


def test_two_views_begin_the_map() -> None:
    point_map = PointMap(CAMERA, PointFollower(320, 180), NOISE)
    for number in (0, 3, 6):
        point_map.add(Keyframe(number, np.eye(4), IDS, seen_by(number)))
    z = PLACE.seen[1][0]
    agree = IDS >= 10
    motion = TwoViews(PLACE.Ts[6], 1 / z, np.full(150, 0.01), agree)
    first, _, last = point_map.keyframes
    point_map.begin(first, last, IDS, motion)
    assert point_map.has_depths
    np.testing.assert_array_equal(last.T, PLACE.Ts[6])
    np.testing.assert_allclose(point_map.depths[10:], 1 / z[10:])
    np.testing.assert_allclose(point_map.spread[10:], 0.01)
    assert (point_map.depths[:10] == 1.0).all()  # of which nothing is known
    np.testing.assert_array_equal(point_map.sound, agree)


# --- landmarks that return


@dataclass(frozen=True, eq=False)
class Scene:
    """A map of a wall, a pillar and a floor, as a camera at the origin saw them."""

    point_map: PointMap
    follower: PointFollower
    ids: Array

    @classmethod
    def of(cls) -> Scene:
        follower = PointFollower(320, 180)
        follower.look(planes(CAMERA, np.eye(3), np.zeros(3)))
        picture = follower.pick(None, np.zeros(0, np.int64), np.zeros((0, 2)))
        point_map = PointMap(CAMERA, follower, 0.25 / 250)
        rays = CAMERA.back_project(picture.uv, 1.0)[:, :2]
        point_map.add(Keyframe(0, np.eye(4), picture.ids, rays))
        point_map.keep(picture.ids, picture.uv)
        point_map.has_depths = True
        point_map.depths = 1 / depths(rays)
        point_map.spread = 0.01 * point_map.depths
        return cls(point_map, follower, picture.ids)

    def looked_at(self, p: Array, R: Array | None = None) -> Array:
        """The latest picture is taken from p (3,); T (4, 4) there."""
        turn = np.eye(3) if R is None else R
        self.follower.look(planes(CAMERA, turn, p))
        return transform(turn, -turn @ p)


def depths(rays: Array) -> Array:
    """Of what `planes` shows along rays (K, 2)."""
    x, y = rays.T
    pillars = np.select(
        [(5 * x > -1) & (5 * x < 0), (8 * x > 0.7) & (8 * x < 1.6)], [5.0, 8.0], 12.0
    )
    floor = np.where(y > 1e-4, 1.4 / np.maximum(y, 1e-4), np.inf)
    return np.minimum(pillars, floor)


def test_landmarks_in_view_again_are_found_where_they_are() -> None:
    scene = Scene.of()
    p, R = np.array([0.4, -0.1, 0.3]), exp_rotation([0.02, -0.05, 0.03])
    T = scene.looked_at(p, R)
    ids, uv = scene.point_map.returned(T, scene.ids[:0], None)
    assert len(ids) > 30
    expected = CAMERA.project(
        np.concatenate([scene.point_map.expected(T, ids), np.ones((len(ids), 1))], axis=1)
    )
    assert np.median(np.linalg.norm(uv - expected, axis=1)) < 0.3


def test_of_those_that_are_there_already_and_where_something_hides_them_none_is_found() -> None:
    scene = Scene.of()
    T = scene.looked_at(np.zeros(3))
    half = scene.ids[: len(scene.ids) // 2]
    ids, _ = scene.point_map.returned(T, half, None)
    assert not np.isin(ids, half).any()
    hidden = np.zeros((180, 320), bool)
    assert len(scene.point_map.returned(T, half, hidden)[0]) == 0


def test_what_is_seen_from_another_side_is_not_looked_for() -> None:
    """From 5 m aside a pillar 5 m off shows another side, and the wall 12 m off does not."""
    scene = Scene.of()
    p = np.array([5.0, 0.0, 0.0])
    T = transform(np.eye(3), -p)
    chosen = scene.point_map._candidates(T, scene.ids[:0])
    far = 1 / scene.point_map.depths
    assert (far[chosen] > 10).any()
    assert not (far[chosen] < 6).any()
    assert (far < 6).any()


UNLIKE = {
    "depths that are hardly known": lambda m: m.spread.__imul__(100.0),
    "landmarks that are outliers": lambda m: m.sound.__iand__(False),
}


@pytest.mark.parametrize("name", UNLIKE)
def test_unsure_landmarks_are_not_looked_for(name: str) -> None:
    scene = Scene.of()
    T = scene.looked_at(np.zeros(3))
    assert len(scene.point_map.returned(T, scene.ids[:0], None)[0]) > 50
    UNLIKE[name](scene.point_map)
    assert len(scene.point_map.returned(T, scene.ids[:0], None)[0]) == 0


@pytest.mark.parametrize(
    ("p", "R"),
    [
        (np.array([0.0, 0.0, 5.5]), np.eye(3)),  # so near that patches are twice as large
        (np.array([0.0, 0.0, -14.0]), np.eye(3)),  # so far that they are half as large
        (np.zeros(3), exp_rotation([0.0, 2.8, 0.0])),  # facing away
    ],
    ids=["near", "far", "away"],
)
def test_where_landmarks_look_otherwise_or_are_not_in_view_hardly_one_is_found(
    p: Array, R: Array
) -> None:
    scene = Scene.of()
    T = scene.looked_at(p, R)
    assert len(scene.point_map.returned(T, scene.ids[:0], None)[0]) < 12
