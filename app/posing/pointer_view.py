"""Map between a view and space as the pointer does, and pick parts under it.

View coordinates are pixels (u, v) of the rectified picture in the main view, metres to the right
and down, from the camera's centre, in the three small ones, in the view of another film
pixels of its own, and in the free view pixels of a picture with its centre at 0 and a focal length
of `FREE_FOCAL`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import ArrayLike

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.ray_parts import mesh_of, parts_on_ray
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, apply_transform, frozen
from keypose.tracker.geometry.view import NEAR_M

FREE_FOCAL = 1000.0
"""Pixels of the free view's picture."""

_FREE = Camera(width=1000, height=1000, fx=FREE_FOCAL, fy=FREE_FOCAL, cx=0.0, cy=0.0)


@dataclass(frozen=True, eq=False)
class PointerView:
    """The main view through a camera with an ideal lens, a view along parallel rays, or one through
    a camera that stands anywhere: the free one, or another film's.

    R_view_camera: (3, 3) the view's axes, right, down and away, in the camera frame, as rows.
    camera:        the lens; None for parallel rays.
    p_camera_eye:  (3,) where that lens stands; the film's camera stands at 0. Of a view along
                   parallel rays where its coordinates begin.
    """

    name: str
    R_view_camera: Array
    camera: Camera | None = None
    p_camera_eye: Array = field(default_factory=lambda: frozen(np.zeros(3)))

    @classmethod
    def of(cls, camera: Camera) -> PointerView:
        """The main view: the picture as `rectify` shows it."""
        return cls("main", frozen(np.eye(3)), camera.without_distortion())

    @classmethod
    def parallel(
        cls, name: str, R_view_camera: ArrayLike, p_camera_origin: ArrayLike = (0.0, 0.0, 0.0)
    ) -> PointerView:
        """A small view."""
        return cls(name, frozen(R_view_camera), None, frozen(p_camera_origin))

    @classmethod
    def free(cls, R_view_camera: ArrayLike, p_camera_eye: ArrayLike) -> PointerView:
        """The free view from a place, looking along the third row."""
        return cls("free", frozen(R_view_camera), _FREE, frozen(p_camera_eye))

    @classmethod
    def film(cls, camera: Camera, T_film_camera: Array) -> PointerView:
        """The picture of another film as `rectify` shows it, through its own lens."""
        R = T_film_camera[:3, :3]
        return cls(
            "film", frozen(R), camera.without_distortion(), frozen(-R.T @ T_film_camera[:3, 3])
        )

    @property
    def is_films(self) -> bool:
        """Whether it is the first film's own camera, along whose lines of sight depth goes."""
        return self.name == "main"

    @property
    def is_other_films(self) -> bool:
        """Whether it is the camera of another film, which sees what the first one does not."""
        return self.name == "film"

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
            return self.camera.project(self._eye_to_view(p))
        return np.asarray((p - self.p_camera_eye) @ self.R_view_camera[:2].T)

    def ray(self, at: Sequence[float] | Array) -> tuple[Array, Array]:
        """A point of the line that is seen at `at`, and its unit direction, away from the eye."""
        a, b = float(at[0]), float(at[1])
        if self.camera is None:
            return self.p_camera_eye + self.R_view_camera[:2].T @ (a, b), self.away
        x, y = (a - self.camera.cx) / self.camera.fx, (b - self.camera.cy) / self.camera.fy
        distance = self.camera.telephoto_distance_m
        if distance is not None:
            return np.array([x * distance, y * distance, 0.0]), self.away
        direction = self.R_view_camera.T @ (x, y, 1.0)
        return self.p_camera_eye, direction / np.sqrt(direction @ direction)

    def ray_through(self, p_camera: Array) -> Array:
        """(3,) unit direction of the line of sight to a point."""
        if not self.is_perspective:
            return self.away
        sight = p_camera - self.p_camera_eye
        return np.asarray(sight / np.sqrt(sight @ sight))

    def depth(self, p_camera: Array) -> Array:
        """Metres (...) from the eye of points (..., 3), or from the camera's centre where rays are
        parallel, along `away`."""
        return np.asarray((p_camera - self.p_camera_eye) @ self.away)

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
        return float(self.camera.depth(self._eye_to_view(p_camera))) / self.camera.fx

    def slope(self, p_camera: Array) -> Array:
        """(2, 3) how far a point moves in the view for each metre in the camera frame."""
        if self.camera is None:
            return np.asarray(self.R_view_camera[:2])
        fx, fy = self.camera.fx, self.camera.fy
        if self.camera.telephoto_distance_m is not None:
            scale = 1.0 / self.camera.telephoto_distance_m
            return np.array([[fx * scale, 0.0, 0.0], [0.0, fy * scale, 0.0]])
        x, y, z = self._eye_to_view(p_camera).tolist()
        of_view = np.array([[fx / z, 0.0, -fx * x / z**2], [0.0, fy / z, -fy * y / z**2]])
        return np.asarray(of_view @ self.R_view_camera)

    def moved(self, p_camera: Array, start: Sequence[float], end: Sequence[float]) -> Array:
        """(2,) where a point is seen after the pointer went from `start` to `end`.

        The point keeps its distance from the pointer, so nothing jumps when it is grabbed.
        """
        at = self.project(p_camera)
        return np.array([at[0] + end[0] - start[0], at[1] + end[1] - start[1]])

    def _eye_to_view(self, p_camera: Array) -> Array:
        """Points (..., 3) in the frame of the lens."""
        return np.asarray((p_camera - self.p_camera_eye) @ self.R_view_camera.T)


def parts_at(
    skeleton: Skeleton, pose: Pose, view: PointerView, at: Sequence[float]
) -> tuple[str, ...]:
    """Names of the parts seen at a point of the view, from front to back.

    A part lies where the line of sight first enters it. Behind the camera nothing is seen.
    """
    origin, direction = view.ray(at)
    near = -np.inf
    if view.camera is not None:
        near = (NEAR_M - float(view.depth(origin))) / float(direction @ view.away)
    return parts_on_ray(skeleton, pose, origin, direction, near)


def outline(skeleton: Skeleton, pose: Pose, view: PointerView, part: str) -> Array:
    """The convex outline (N, 2) of a part in view coordinates; empty when it cannot be seen."""
    i = skeleton.body.index(part)
    T = pose_transforms(skeleton, pose)[i]
    p_camera = apply_transform(T, mesh_of(skeleton.body.parts[i].shape).vertices)
    if view.camera is not None and view.depth(p_camera).min() <= NEAR_M:
        return np.zeros((0, 2))
    at = view.project(p_camera).astype(np.float32)
    return cv2.convexHull(at)[:, 0].astype(np.float64)
