"""Up from where feet stand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.space.level import up_from_places

CAMERA_UP = np.array([0.0, -1.0, 0.0])


def floor_places(up: Array, seed: int, *, spread_m: tuple[float, float]) -> Array:
    """Places on a floor 1.6 m below the camera, 6 m away, with a centimetre of noise."""
    rng = np.random.default_rng(seed)
    across = np.cross(up, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    along = np.cross(across, up)
    steps = rng.uniform(-1, 1, (12, 2)) * spread_m
    middle = -1.6 * up + 6.0 * np.array([0.0, 0.0, 1.0])
    return middle + steps @ np.stack([across, along]) + rng.normal(0, 0.01, (12, 3))


def angle_deg(a: Array, b: Array) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


@pytest.mark.parametrize("seed", range(5))
def test_places_all_over_a_floor_give_up(seed: int) -> None:
    lean = Rotation.from_euler("xz", [4.0, -3.0], degrees=True).apply(CAMERA_UP)
    found = up_from_places(floor_places(lean, seed, spread_m=(2.0, 2.0)), CAMERA_UP)
    assert angle_deg(found, lean) < 0.5


def test_places_in_one_line_give_the_slope_along_it_alone() -> None:
    lean = Rotation.from_euler("z", 3.0, degrees=True).apply(CAMERA_UP)
    found = up_from_places(floor_places(lean, 1, spread_m=(2.5, 0.0)), CAMERA_UP)
    assert angle_deg(found, lean) < 0.6


def test_one_place_leaves_up_as_it_is_known() -> None:
    np.testing.assert_allclose(up_from_places(np.ones((1, 3)), CAMERA_UP), CAMERA_UP)
