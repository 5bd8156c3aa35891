"""Cameras about the body, where nobody stood: how they look, and how far off they must be.

The level frame is the camera's, turned so that the world's down is y: x right, y down, z away. An
azimuth of 0 looks as the video's camera does, 90 from the right of its picture as the side view,
180 from behind what it films; an elevation of 90 looks straight down.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from keypose.app.posing import eye_rotation
from keypose.app.render.lettering import round_length
from keypose.app.render.pictures import posed_points
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, frozen, transform
from keypose.tracker.geometry.view import ViewCamera

ELEVATION_DEG = 12.0
"""A little above, so that the floor is seen to lie."""

FOCAL = 1.5
"""Of the shorter side of the picture: an angle of view of 37°."""
MARGIN = 1.12
NEAREST_M, FARTHEST_M = 0.1, 1e5


@dataclass(frozen=True)
class Viewpoint:
    """Where a camera stands about the body. distance_m None: as near as all of it is seen."""

    azimuth_deg: float = 0.0
    elevation_deg: float = ELEVATION_DEG
    distance_m: float | None = None


@dataclass(frozen=True, eq=False)
class Ground:
    """The level world that a body moves in.

    R_level_camera: (3, 3) from the camera's frame to the level one.
    floor_m:        y of the floor in the level frame: what is lowest in the motion stands on it.
    step_m:         between the lines of its grid.
    """

    R_level_camera: Array
    floor_m: float
    step_m: float

    @classmethod
    def under(cls, skeleton: Skeleton, R_level_camera: Array, poses: Iterable[Pose]) -> Ground:
        """The floor under a body in all of these poses; one at least."""
        down = R_level_camera[1]
        lowest = max(float((posed_points(skeleton, pose) @ down).max()) for pose in poses)
        return cls.at(skeleton, R_level_camera, -lowest)

    @classmethod
    def at(cls, skeleton: Skeleton, R_level_camera: Array, height_m: float) -> Ground:
        """A floor at a known height, so far along up from the camera's centre."""
        at_rest = posed_points(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))
        size_m = float(np.linalg.norm(np.ptp(at_rest, axis=0)))
        return cls(R_level_camera, -height_m, round_length(1.25 * size_m))


def view_from(
    viewpoint: Viewpoint,
    distance_m: float,
    R_level_camera: Array,
    p_camera_centre: Array,
    size: tuple[int, int],
) -> ViewCamera:
    """The camera of a picture of `size` = (width, height), looking at centre (3,) from there."""
    R = _R_eye_level(viewpoint) @ R_level_camera
    shift = np.array([0.0, 0.0, distance_m]) - R @ p_camera_centre
    focal = FOCAL * min(size)
    centre = ((size[0] - 1) / 2, (size[1] - 1) / 2)
    return ViewCamera(frozen(transform(R, shift)), (focal, focal), centre, *size)


def least_distance(
    viewpoint: Viewpoint,
    R_level_camera: Array,
    p_camera_centre: Array,
    p_camera: Array,
    size: tuple[int, int],
) -> float:
    """The smallest distance at which points (N, 3) are all in a picture of that size, with a
    margin, and none is nearer to the camera than half of what the farthest is to the centre."""
    q = (p_camera - p_camera_centre) @ (_R_eye_level(viewpoint) @ R_level_camera).T
    reach = np.array(size) / (2 * FOCAL * min(size)) / MARGIN
    nearest = 0.5 * np.linalg.norm(q, axis=1).max()
    depth = np.maximum((np.abs(q[:, :2]) / reach).max(axis=1), nearest)
    needed = depth - q[:, 2]
    return float(np.clip(needed.max(initial=NEAREST_M), NEAREST_M, FARTHEST_M))


def round_trip(count: int) -> list[Viewpoint]:
    """`count` viewpoints once round the body, from where the video's camera stands; the one after
    the last would be the first again."""
    return [Viewpoint(360.0 * i / count) for i in range(count)]


def smoothed(places: Array, sigma: float) -> Array:
    """Places (N, 3), smoothed over about `sigma` frames, for a camera to look at."""
    if len(places) < 2 or sigma < 0.5:
        return places
    reach = min(int(3 * sigma), len(places) - 1)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    weights /= weights.sum()
    padded = np.pad(places, ((reach, reach), (0, 0)), mode="edge")
    return np.stack([np.convolve(column, weights, "valid") for column in padded.T], axis=1)


def _R_eye_level(viewpoint: Viewpoint) -> Array:
    return eye_rotation(viewpoint.azimuth_deg, viewpoint.elevation_deg)
