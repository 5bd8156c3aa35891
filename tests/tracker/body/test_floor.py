"""Where the floor is taken to be."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.ground import floor_height, lowest_heights
from keypose.tracker.body.pose import Pose, part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, exp_rotation

SKELETON = Skeleton.of(preset("adult_male"))
CAMERA_UP = (0.0, -1.0, 0.0)


def standing(heights_m: Array, R: Array | None = None) -> Array:
    """Ts_camera_part at rest, the root so far above the camera, all turned by R."""
    R = np.eye(3) if R is None else R
    places = np.stack([np.zeros_like(heights_m), -heights_m, np.full_like(heights_m, 4.0)], axis=1)
    rest = Pose.rest(SKELETON, (0.0, 0.0, 0.0)).Rs_parent_part
    Rs = np.tile(rest, (len(heights_m), 1, 1, 1))
    Rs[:, 0] = R @ Rs[:, 0]
    return part_transforms(SKELETON, Rs, places @ R.T)


def test_a_floor_that_is_known_is_taken_as_it_is() -> None:
    assert floor_height(-1.25, [-0.9, -0.8]) == -1.25


def test_else_the_body_stands_on_it_where_it_is_lowest() -> None:
    heights = np.zeros(40)
    heights[15:25] = np.sin(np.linspace(0, np.pi, 10)) * 0.4  # a jump
    heights[30] = -0.2  # a pose that is off
    lowest = lowest_heights(SKELETON, standing(heights), CAMERA_UP)
    sole = lowest[0]
    assert lowest == pytest.approx(sole + heights)
    assert floor_height(None, lowest) == pytest.approx(sole, abs=1e-9)


def test_it_lies_along_what_is_up_however_the_camera_leans() -> None:
    R = exp_rotation([0.4, 0.0, 0.3])
    leaning = lowest_heights(SKELETON, standing(np.zeros(3), R), R @ CAMERA_UP)
    assert leaning == pytest.approx(lowest_heights(SKELETON, standing(np.zeros(3)), CAMERA_UP))
    twice = lowest_heights(SKELETON, standing(np.zeros(3), R), 2 * R @ CAMERA_UP)
    assert twice == pytest.approx(leaning)
