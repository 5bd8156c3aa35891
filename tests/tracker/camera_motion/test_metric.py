from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.metric import StandingPoint, scale_from_stances
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
