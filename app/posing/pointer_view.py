"""One of the four views as the pointer knows it: from points to the view and back.

View coordinates are pixels (u, v) of the rectified picture in the main view, and metres to the
right and down, from the camera's centre, in the three others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array, frozen


@dataclass(frozen=True, eq=False)
class PointerView:
    """The main view through a camera with an ideal lens, or a view along parallel rays.

    R_view_camera: (3, 3) the view's axes, right, down and away, in the camera frame, as rows.
    """

    name: str
    R_view_camera: Array
    camera: Camera | None = None

    @classmethod
    def of(cls, camera: Camera) -> PointerView:
        """The main view: the picture as `rectify` shows it."""
        return cls("main", frozen(np.eye(3)), camera.without_distortion())

    @classmethod
    def parallel(cls, name: str, R_view_camera: ArrayLike) -> PointerView:
        """A small view."""
        return cls(name, frozen(R_view_camera))

    @property
    def is_perspective(self) -> bool:
        return self.camera is not None and self.camera.telephoto_distance_m is None

    @property
    def away(self) -> Array:
        """(3,) the direction in which the view looks."""
        return np.asarray(self.R_view_camera[2])

    def project(self, p_camera: ArrayLike) -> Array:
        """View coordinates (..., 2) of points (..., 3); NaN for those behind the camera."""
        p = np.asarray(p_camera, dtype=np.float64)
        if self.camera is not None:
            return self.camera.project(p)
        return np.asarray(p @ self.R_view_camera[:2].T)

    def ray(self, at: Sequence[float] | Array) -> tuple[Array, Array]:
        """A point of the line that is seen at `at`, and its unit direction, away from the eye."""
        a, b = float(at[0]), float(at[1])
        if self.camera is None:
            return self.R_view_camera[:2].T @ (a, b), self.away
        x, y = (a - self.camera.cx) / self.camera.fx, (b - self.camera.cy) / self.camera.fy
        distance = self.camera.telephoto_distance_m
        if distance is not None:
            return np.array([x * distance, y * distance, 0.0]), self.away
        direction = np.array([x, y, 1.0])
        return np.zeros(3), direction / np.sqrt(direction @ direction)

    def ray_through(self, p_camera: Array) -> Array:
        """(3,) unit direction of the line of sight to a point."""
        if not self.is_perspective:
            return self.away
        return np.asarray(p_camera / np.sqrt(p_camera @ p_camera))

    def at_depth(self, at: Sequence[float] | Array, p_camera_reference: Array) -> Array:
        """(3,) the point seen at `at` in the plane of the picture that holds the reference."""
        origin, direction = self.ray(at)
        ahead = float((p_camera_reference - origin) @ self.away) / float(direction @ self.away)
        return np.asarray(origin + ahead * direction)

    def metres_per_unit(self, p_camera: Array) -> float:
        """Metres, across the line of sight at a point, that one unit of the view stands for.

        A camera's units are pixels along u; those along v differ where fx and fy do.
        """
        if self.camera is None:
            return 1.0
        return float(self.camera.depth(p_camera)) / self.camera.fx

    def slope(self, p_camera: Array) -> Array:
        """(2, 3) how far a point moves in the view for each metre in the camera frame."""
        if self.camera is None:
            return np.asarray(self.R_view_camera[:2])
        fx, fy = self.camera.fx, self.camera.fy
        if self.camera.telephoto_distance_m is not None:
            scale = 1.0 / self.camera.telephoto_distance_m
            return np.array([[fx * scale, 0.0, 0.0], [0.0, fy * scale, 0.0]])
        x, y, z = p_camera.tolist()
        return np.array([[fx / z, 0.0, -fx * x / z**2], [0.0, fy / z, -fy * y / z**2]])

    def moved(self, p_camera: Array, start: Sequence[float], end: Sequence[float]) -> Array:
        """(2,) where a point is seen after the pointer went from `start` to `end`.

        The point keeps its distance from the pointer, so nothing jumps when it is grabbed.
        """
        at = self.project(p_camera)
        return np.array([at[0] + end[0] - start[0], at[1] + end[1] - start[1]])
