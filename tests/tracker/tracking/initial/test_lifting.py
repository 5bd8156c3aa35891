"""Tracks in the picture become a motion in space: limbs on their tracks, bones and joints whole."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.tracking.initial.lifting import lift
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from tests.rendering.motions import stride
from tests.rendering.scenes import camera
from tests.tracker.tracking_cases import random_body, random_trajectory

Floats = NDArray[np.float64]

SKELETON = Skeleton.of(preset("adult_male"))
CAMERA = camera()
TELEPHOTO = CAMERA.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 5.0})
ENDS = ("hand", "foot", "forearm", "shin")
NOTHING: Any = None  # no pictures are looked at


@dataclass(frozen=True, eq=False)
class Tracks:
    """Followed points, as `keypose.tracker.tracking.initial.templates` gives them."""

    parts: NDArray[np.int64]
    points: Floats
    uv: Floats
    sigma_px: Floats
    notes: tuple[str, ...] = ()


@cache
def _truth(first: int = 30, last: int = 54) -> Trajectory:
    """A step and a half of a walk across the picture."""
    whole = stride(SKELETON)
    Rs, ps = whole.Rs_parent_part[first : last + 1], whole.ps_camera_root[first : last + 1]
    return Trajectory(first, Rs, ps)


def _points(skeleton: Skeleton) -> tuple[NDArray[np.int64], Floats]:
    """The parents' ends at wrists, ankles, elbows and knees, and the top of the head."""
    joints = [i for i, name in enumerate(skeleton.body.names) if name.endswith(ENDS)]
    parts = [*skeleton.parents[joints], skeleton.body.index("head")]
    top = skeleton.body.parts[parts[-1]].landmarks["head_top"]
    return np.array(parts), np.array([*skeleton.joints[joints], top])


def _tracks(lens: Camera, truth: Trajectory, skeleton: Skeleton = SKELETON) -> Any:
    parts, points = _points(skeleton)
    T = truth.transforms(skeleton)[:, parts]
    p = (T[..., :3, :3] @ points[..., None])[..., 0] + T[..., :3, 3]
    uv = np.swapaxes(lens.project(p), 0, 1)
    return Tracks(parts, points, uv, np.ones(uv.shape[:2]))


def _segment(truth: Trajectory) -> Segment:
    first, last = truth.first_frame, truth.last_frame
    return Segment(first, last, truth.pose(first), truth.pose(last), NOTHING)


def _plain(truth: Trajectory) -> Trajectory:
    first, last = truth.first_frame, truth.last_frame
    return interpolate(truth.pose(first), truth.pose(last), first, last)


def _scene(truth: Trajectory, lens: Camera = CAMERA, skeleton: Skeleton = SKELETON) -> Scene:
    return Scene.of(skeleton, lens, [truth.pose(truth.first_frame)])


def _fitted(truth: Trajectory, tracks: Any, base: Trajectory, lens: Camera = CAMERA) -> Trajectory:
    return lift(_scene(truth, lens), _segment(truth), base, tracks)


def _miss(found: Trajectory, truth: Trajectory, lens: Camera = CAMERA) -> tuple[float, float]:
    """Mean distance of the joints from the truth between the ends, cm and px."""
    ours, true = found.joints(SKELETON)[1:-1], truth.joints(SKELETON)[1:-1]
    px = np.linalg.norm(lens.project(ours) - lens.project(true), axis=-1)
    return float(100 * np.linalg.norm(ours - true, axis=-1).mean()), float(px.mean())


def _same_ends(found: Trajectory, truth: Trajectory) -> None:
    for k in (0, -1):
        np.testing.assert_array_equal(found.Rs_parent_part[k], truth.Rs_parent_part[k])
        np.testing.assert_array_equal(found.ps_camera_root[k], truth.ps_camera_root[k])


@pytest.mark.parametrize("lens", [CAMERA, TELEPHOTO], ids=["perspective", "telephoto"])
def test_interpolation_is_brought_onto_the_tracks_and_most_of_the_way_in_space(
    lens: Camera,
) -> None:
    truth = _truth()
    base = _plain(truth)
    found = _fitted(truth, _tracks(lens, truth), base, lens)
    assert _miss(base, truth, lens)[1] > 8.0
    assert _miss(found, truth, lens)[1] < 0.12 * _miss(base, truth, lens)[1]
    assert _miss(found, truth, lens)[0] < 0.4 * _miss(base, truth, lens)[0]
    _same_ends(found, truth)


def test_a_start_on_the_tracks_stays_where_it_is() -> None:
    truth = _truth()
    found = _fitted(truth, _tracks(CAMERA, truth), truth)
    assert _miss(found, truth)[1] < 0.02


def test_noise_of_the_tracks_is_evened_out() -> None:
    truth = _truth()
    tracks = _tracks(CAMERA, truth)
    noise = np.random.default_rng(4).normal(0, 2.0, tracks.uv.shape)
    noisy = replace(tracks, uv=tracks.uv + noise, sigma_px=2 * tracks.sigma_px)
    assert _miss(_fitted(truth, noisy, truth), truth)[1] < 1.2


def test_without_any_track_the_start_comes_back() -> None:
    truth = _truth()
    base = _plain(truth)
    tracks = _tracks(CAMERA, truth)
    found = _fitted(truth, replace(tracks, uv=np.full_like(tracks.uv, np.nan)), base)
    np.testing.assert_allclose(found.Rs_parent_part, base.Rs_parent_part, atol=1e-12)
    np.testing.assert_allclose(found.ps_camera_root, base.ps_camera_root, atol=1e-12)


def test_a_limb_that_is_not_followed_keeps_to_the_start() -> None:
    truth = _truth()
    base = _plain(truth)
    tracks = _tracks(CAMERA, truth)
    arm = {SKELETON.body.index(f"left_{name}") for name in ("upper_arm", "forearm")}
    lost = [k for k, part in enumerate(tracks.parts) if part in arm]
    tracks.uv[lost] = np.nan
    found = _fitted(truth, tracks, base)
    bone = [SKELETON.body.index(f"left_{name}") for name in ("upper_arm", "forearm", "hand")]
    np.testing.assert_allclose(
        found.Rs_parent_part[:, bone], base.Rs_parent_part[:, bone], atol=1e-6
    )
    leg = SKELETON.body.index("left_foot")
    ours, plain, true = (t.joints(SKELETON)[1:-1, leg] for t in (found, base, truth))
    assert (
        np.linalg.norm(ours - true, axis=-1).mean()
        < 0.4 * np.linalg.norm(plain - true, axis=-1).mean()
    )


def test_a_stretch_where_a_limb_is_lost_is_bridged() -> None:
    truth = _truth()
    base = _plain(truth)
    tracks = _tracks(CAMERA, truth)
    tracks.uv[:, 9:15] = np.nan
    found = _fitted(truth, tracks, base)
    px = _miss(found, truth)[1]
    assert px < 0.35 * _miss(base, truth)[1]
    step = np.linalg.norm(np.diff(CAMERA.project(found.joints(SKELETON)), axis=0), axis=-1)
    true = np.linalg.norm(np.diff(CAMERA.project(truth.joints(SKELETON)), axis=0), axis=-1)
    assert step.max() < 1.5 * true.max()  # no jump at its ends


def test_an_outlier_does_not_spoil_the_motion() -> None:
    truth = _truth()
    base = _plain(truth)
    tracks = _tracks(CAMERA, truth)
    clean = _miss(_fitted(truth, tracks, base), truth)[1]
    tracks.uv[:4, 10:12] += 70.0
    tracks.uv[5, 17] -= 120.0
    assert _miss(_fitted(truth, tracks, base), truth)[1] < clean + 0.5


def test_what_is_unsure_counts_less() -> None:
    truth = _truth()
    base = _plain(truth)
    tracks = _tracks(CAMERA, truth)
    tracks.uv[0, 4:-4] += 12.0

    def miss(sigma: float) -> float:
        tracks.sigma_px[0] = sigma
        return _miss(_fitted(truth, tracks, base), truth)[1]

    assert miss(30.0) < 0.7 * miss(1.0)


def test_an_elbow_does_not_bend_backwards_however_the_tracks_go() -> None:
    truth = _truth()
    elbow = SKELETON.body.index("left_forearm")
    Rs = truth.Rs_parent_part.copy()
    Rs[4:-4, elbow] = exp_rotation([0.9, 0.0, 0.0])
    beyond = Trajectory(truth.first_frame, Rs, truth.ps_camera_root)
    found = _fitted(truth, _tracks(CAMERA, beyond), _plain(truth))
    limits = Limits.of(SKELETON.body)
    worst = max(float(limits.excess(R)[0][elbow].max()) for R in found.Rs_parent_part)
    assert np.degrees(worst) < 6.0


def test_a_joint_may_go_as_far_as_it_was_posed() -> None:
    truth = _truth()
    elbow = SKELETON.body.index("left_forearm")
    Rs = truth.Rs_parent_part.copy()
    Rs[:, elbow] = exp_rotation([0.5, 0.0, 0.0])
    posed = Trajectory(truth.first_frame, Rs, truth.ps_camera_root)
    found = _fitted(posed, _tracks(CAMERA, posed), posed)
    np.testing.assert_allclose(found.Rs_parent_part[:, elbow], Rs[:, elbow], atol=5e-3)


def test_rotations_stay_rotations_and_what_is_not_tracked_stays() -> None:
    truth = _truth()
    base = _plain(truth)
    R = _fitted(truth, _tracks(CAMERA, truth), base).Rs_parent_part
    np.testing.assert_allclose(
        R @ np.swapaxes(R, -1, -2), np.broadcast_to(np.eye(3), R.shape), atol=1e-9
    )
    still = [i for i in range(SKELETON.part_count) if i not in SKELETON.dof_part]
    np.testing.assert_array_equal(R[:, still], base.Rs_parent_part[:, still])


@pytest.mark.parametrize("frames", [2, 3, 4])
def test_short_stretches_have_their_keyframes_as_ends(frames: int) -> None:
    truth = _truth(30, 29 + frames)
    off = truth.Rs_parent_part @ exp_rotation([0.02, 0.0, 0.0])
    base = Trajectory(truth.first_frame, off, truth.ps_camera_root)
    found = _fitted(truth, _tracks(CAMERA, truth), base)
    assert len(found) == frames
    _same_ends(found, truth)
    if frames > 2:
        assert _miss(found, truth)[1] < _miss(base, truth)[1]


def test_a_body_of_one_part_follows_its_point() -> None:
    skeleton = random_body(3, parts=1)
    s = np.linspace(0, np.pi, 20)[:, None]
    path = np.concatenate([0.3 * s, -0.4 * np.sin(s), 3 + 0.1 * s], axis=1)
    truth = Trajectory(0, np.tile(np.eye(3), (20, 1, 1, 1)), path)
    uv = CAMERA.project(path)
    tracks: Any = Tracks(np.array([0]), np.zeros((1, 3)), uv[None], np.ones((1, 20)))
    base = _plain(truth)
    found = lift(_scene(truth, CAMERA, skeleton), _segment(truth), base, tracks)

    def away(path: Trajectory) -> float:
        return float(np.linalg.norm(CAMERA.project(path.ps_camera_root) - uv, axis=-1).mean())

    assert away(found) < 0.1 * away(base)


def test_a_body_that_is_not_tracked_stays() -> None:
    skeleton = random_body(3, parts=1, root_dofs=())
    truth = random_trajectory(skeleton, 3, 6)
    tracks: Any = Tracks(np.array([0]), np.zeros((1, 3)), np.full((1, 6, 2), 9.0), np.ones((1, 6)))
    base = _plain(truth)
    found = lift(_scene(truth, CAMERA, skeleton), _segment(truth), base, tracks)
    np.testing.assert_array_equal(found.Rs_parent_part, base.Rs_parent_part)
