"""Turn pixels into directions and back, for a lens that may be zoomed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True)
class Lens:
    """A camera as its directions need it; a telephoto one is turned as any other."""

    camera: Camera

    @classmethod
    def of(cls, camera: Camera) -> Lens:
        plain = {"projection": "perspective", "telephoto_distance_m": None}
        return cls(camera.model_copy(update=plain))

    @property
    def focal_px(self) -> float:
        """The geometric mean of both focal lengths."""
        return float(np.sqrt(self.camera.fx * self.camera.fy))

    def scaled(self, by: float) -> Lens:
        """The same lens with another focal length."""
        return Lens(self.camera.zoomed(by))

    def flat(self, uv: Array, zoom: float) -> Array:
        """Where an ideal lens at zoom 1 would show the pixels (K, 2), focal lengths from the
        centre: `zoom` times x/z and y/z. NaN where the lens shows nothing.

        zoom matters to the distortion alone, so a rough one will do.
        """
        if not self.camera.is_distorted:
            c, f = (self.camera.cx, self.camera.cy), (self.camera.fx, self.camera.fy)
            return np.asarray((uv - c) / f)
        zoomed = self.scaled(zoom).camera
        return zoomed.back_project(uv, 1.0)[..., :2] * zoom

    def directions(self, uv: Array, zoom: float) -> Array:
        """Unit vectors (K, 3) in the camera's frame towards what is seen at pixels (K, 2)."""
        return unit(self.flat(uv, zoom) / zoom)

    def pixels(self, directions: Array, zoom: float) -> Array:
        """Pixels (K, 2) at which directions (K, 3) are seen; NaN behind the camera."""
        return self.scaled(zoom).camera.project(directions)


def unit(xy: Array) -> Array:
    """Unit vectors (..., 3) of tangents (..., 2)."""
    ray = np.concatenate([xy, np.ones((*xy.shape[:-1], 1))], axis=-1)
    return np.asarray(ray / np.linalg.norm(ray, axis=-1, keepdims=True))
