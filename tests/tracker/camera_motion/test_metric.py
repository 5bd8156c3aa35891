"""How long a path's unit is, by feet that stand and by how smoothly a body moves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from keypose.tracker.camera_motion.metric import (
    FEWEST_FRAMES,
    PathScale,
    StandingPoint,
    scale_from_smoothness,
    scale_from_stances,
)
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, apply_transform, exp_rotation, transform

METRES = 3.7
FEET = np.array([[0.2, 1.4, 3.0], [-0.1, 1.4, 3.4], [0.3, 1.4, 2.6]])


def _path(metres: float = 1.0, frames: int = 90) -> CameraPath:
    """1.2 m on an arc, in units of so many metres."""
    share = np.linspace(0, 1, frames)
    R = exp_rotation(np.stack([0.05 * np.sin(7 * share), -0.5 * share, 0 * share], axis=1))
    p = np.stack([1.2 * share, 0.02 * np.sin(20 * share), 0.3 * share**2], axis=1) / metres
    return CameraPath(np.linalg.inv(transform(R, p)), np.ones(frames))


def _standing(noise: Array) -> list[StandingPoint]:
    """Three feet, each 30 frames long, seen with this noise (90, 3)."""
    true = _path()
    seen = [
        apply_transform(true.Ts_camera_world[n], FEET[n // 30][None])[0] + noise[n]
        for n in range(90)
    ]
    return [StandingPoint(n, np.array(seen[n : n + 30])) for n in (0, 30, 60)]


def test_feet_that_stand_tell_the_scale_to_rounding():
    found = scale_from_stances(_path(METRES), _standing(np.zeros((90, 3))))
    assert found is not None
    assert found.metres == pytest.approx(METRES, rel=1e-9)
    assert found.points == 3


def test_the_scale_is_off_by_about_what_is_said_and_a_foot_that_slides_hardly_counts():
    rng, errors = np.random.default_rng(0), []
    for _ in range(20):
        noise = rng.normal(0, 0.01, (90, 3))
        noise[60:75, 0] += 0.15
        found = scale_from_stances(_path(METRES), _standing(noise))
        assert found is not None
        errors.append((found.metres - METRES) / found.sd)
        assert found.metres == pytest.approx(METRES, rel=0.1)
    assert 0.2 < np.sqrt(np.mean(np.square(errors))) < 2.5


def test_no_scale_is_told_by_a_camera_that_stays_and_by_no_feet():
    still = CameraPath.standing_still(90)
    noise = np.random.default_rng(0).normal(0, 0.01, (90, 3))
    assert scale_from_stances(still, _standing(noise)) is None
    trembling = np.tile(np.eye(4), (90, 1, 1))
    trembling[:, :3, 3] = np.random.default_rng(1).normal(0, 1e-4, (90, 3))
    assert scale_from_stances(CameraPath(trembling, np.ones(90)), _standing(noise)) is None
    assert scale_from_stances(_path(), []) is None


@pytest.mark.parametrize("length", [0, 1])
def test_a_foot_that_is_seen_once_tells_nothing(length: int):
    standing = [StandingPoint(5, np.full((length, 3), 3.0))]
    assert scale_from_stances(_path(METRES), standing) is None


def test_more_feet_are_surer():
    noise = np.random.default_rng(3).normal(0, 0.01, (90, 3))
    feet = _standing(noise)
    few, all_ = (scale_from_stances(_path(METRES), feet[:count]) for count in (1, 3))
    assert all_ is not None
    assert few is not None
    assert few.sd > 1.2 * all_.sd


def test_errors_that_last_for_frames_make_the_scale_less_sure():
    white = np.random.default_rng(4).normal(0, 0.01, (90, 3))
    lasting = gaussian_filter1d(white, 4, axis=0)
    lasting *= white.std() / lasting.std()
    sure, unsure = (
        scale_from_stances(_path(METRES), _standing(noise)) for noise in (white, lasting)
    )
    assert sure is not None
    assert unsure is not None
    assert unsure.sd > 1.7 * sure.sd


# --- by smoothness


def _hand_held(shake_m: float, seed: int = 5, metres: float = METRES) -> CameraPath:
    """A camera whose hand shakes, in units of so many metres."""
    rng = np.random.default_rng(seed)
    p = rng.normal(0, shake_m, (90, 3))
    R = exp_rotation(rng.normal(0, 0.01, (90, 3)))
    return CameraPath(np.linalg.inv(transform(R, p / metres)), np.ones(90))


def _smooth_body(path: CameraPath, noise_m: float, metres: float = METRES) -> Array:
    """Somebody who walks up and down, seen from there (90, 3)."""
    n = np.arange(90)
    p_world = np.stack([0.3 * np.sin(n / 20), 0 * n, 3 + 0.01 * n], axis=1)
    Ts = path.Ts_world_camera
    seen = np.einsum("nba,nb->na", Ts[:, :3, :3], p_world - metres * Ts[:, :3, 3])
    return np.asarray(seen + np.random.default_rng(7).normal(0, noise_m, (90, 3)))


def _by_smoothness(shake_m: float, noise_m: float = 0.002) -> PathScale | None:
    path = _hand_held(shake_m)
    return scale_from_smoothness(path, 0, _smooth_body(path, noise_m))


@pytest.mark.parametrize("shake_m", [0.01, 0.03])
def test_a_hand_that_shakes_before_a_body_that_does_not_tells_the_scale(shake_m: float):
    found = _by_smoothness(shake_m)
    assert found is not None
    assert found.metres == pytest.approx(METRES, rel=0.06)
    assert abs(found.metres - METRES) < 3 * found.sd


def test_frames_at_which_the_body_jumps_hardly_count():
    path = _hand_held(0.02)
    body = _smooth_body(path, 0.002)
    body[40] += 0.3
    found = scale_from_smoothness(path, 0, body)
    assert found is not None
    assert found.metres == pytest.approx(METRES, rel=0.06)


def test_a_motion_that_begins_later_is_compared_with_its_own_frames():
    path = _hand_held(0.02)
    found = scale_from_smoothness(path, 30, _smooth_body(path, 0.002)[30:])
    assert found is not None
    assert found.metres == pytest.approx(METRES, rel=0.1)


def test_a_hand_too_steady_or_a_motion_too_short_tells_nothing():
    assert _by_smoothness(0.0) is None
    assert _by_smoothness(0.0005, noise_m=0.01) is None
    path = _hand_held(0.02)
    short = _smooth_body(path, 0.002)[: FEWEST_FRAMES - 1]
    assert scale_from_smoothness(path, 0, short) is None
