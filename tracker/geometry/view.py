"""An ideal camera as drawing needs it: perspective, telephoto, or one of three orthographic views.

The view's frame is x right, y down, z away. It differs from the camera's frame in the orthographic
views only.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, frozen, transform

NEAR_M = 0.05
"""Nothing nearer to a camera than this is drawn."""

ViewName: TypeAlias = Literal["top", "side", "front"]

_R_VIEW_CAMERA: dict[ViewName, list[list[float]]] = {
    "front": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "top": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
    "side": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
}


@dataclass(frozen=True, eq=False)
class ViewCamera:
    """A picture of width × height pixels, their centres at integers.

    T_view_camera:   (4, 4) from the camera frame to the view's.
    focal, centre:  (fx, fy) and (cx, cy), pixels.
    parallel_m:     the one distance used for every point (parallel rays), or None.
    near_m:         what has a smaller z in the view's frame is not drawn.
    """

    T_view_camera: Array
    focal: tuple[float, float]
    centre: tuple[float, float]
    width: int
    height: int
    parallel_m: float | None = None
    near_m: float = NEAR_M

    @classmethod
    def of(cls, camera: Camera) -> ViewCamera:
        """The camera with an ideal lens: pictures are drawn over the rectified frame."""
        return cls(
            frozen(np.eye(4)),
            (camera.fx, camera.fy),
            (camera.cx, camera.cy),
            camera.width,
            camera.height,
            camera.telephoto_distance_m,
        )

    @classmethod
    def orthographic(
        cls,
        view: ViewName,
        p_camera_centre: Array,
        pixels_per_metre: float,
        size: tuple[int, int],
        R_eye_camera: Array | None = None,
    ) -> ViewCamera:
        """One of the three views, `size` = (width, height), with p_camera_centre in its middle.

        "front" looks along the camera's +z: x to the right, y down.
        "top" looks down along +y: x to the right, z (away from the camera) up.
        "side" looks along −x, from the picture's right: z (away) to the right, y down.
        R_eye_camera replaces their rotation where the world is not upright in the camera's frame.
        """
        R = np.array(_R_VIEW_CAMERA[view] if R_eye_camera is None else R_eye_camera)
        return cls(
            frozen(transform(R, -R @ p_camera_centre)),
            (pixels_per_metre, pixels_per_metre),
            ((size[0] - 1) / 2, (size[1] - 1) / 2),
            *size,
            parallel_m=1.0,
            near_m=-np.inf,
        )

    def resized(self, width: int, height: int) -> ViewCamera:
        """The same picture resampled to another size.

        The picture's borders stay, so pixel centres move: u' = (u + 1/2) width'/width − 1/2.
        """
        sx, sy = width / self.width, height / self.height
        return replace(
            self,
            focal=(self.focal[0] * sx, self.focal[1] * sy),
            centre=((self.centre[0] + 0.5) * sx - 0.5, (self.centre[1] + 0.5) * sy - 0.5),
            width=width,
            height=height,
        )

    def cropped(self, left: int, top: int, width: int, height: int) -> ViewCamera:
        """The part of the picture that begins at pixel (left, top)."""
        centre = (self.centre[0] - left, self.centre[1] - top)
        return replace(self, centre=centre, width=width, height=height)

    def project(self, p_eye: Array) -> Array:
        """Pixels (..., 2) of points (..., 3) in the view's frame; NaN nearer than near_m."""
        z = p_eye[..., 2:]
        distance = z if self.parallel_m is None else np.full_like(z, self.parallel_m)
        uv: Array = p_eye[..., :2] / np.where(z >= self.near_m, distance, np.nan)
        return uv * self.focal + self.centre

    def back_project(self, uv: Array, depth_m: Array) -> Array:
        """Points (..., 3) in the view's frame that are seen at pixels (..., 2), z = depth_m."""
        z = depth_m[..., None]
        xy = (uv - self.centre) / self.focal
        return np.concatenate([xy * (z if self.parallel_m is None else self.parallel_m), z], -1)

    def rays(self, p_eye: Array) -> Array:
        """Viewing directions (..., 3), of any length, at points (..., 3) in the view's frame."""
        if self.parallel_m is None:
            return p_eye
        return np.broadcast_to(np.array([0.0, 0.0, 1.0]), p_eye.shape)
