"""The camera: from points in metres to pixels and back.

Camera frame: x right, y down, z forward. Pixels (u, v) have their centres at integers. Lens
distortion is the usual five-number model (k1, k2, p1, p2, k3) on normalised coordinates, as OpenCV
writes it. A telephoto camera scales every point by one reference distance instead of its own z
(DRIFT's assumption in §5.3): depth then leaves no trace in the picture.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated, Literal, Self, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, model_validator

from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.rotations import Array

PixelSize: TypeAlias = Annotated[int, Field(ge=2, le=65536)]
Focal: TypeAlias = Annotated[FiniteFloat, Field(ge=1, le=1e7)]
Centre: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]
Coefficient: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e3, le=1e3)]

USUAL_FIELDS_OF_VIEW = (math.radians(40.0), math.radians(65.0))
"""Along the longer side: of a camcorder at rest, and of a phone's main camera."""
GUESSED_FIELD_OF_VIEW = math.radians(50.0)
"""Between these."""

FILM_MM = 36.0
"""Width of a frame of 35 mm film, by which focal lengths are compared."""


class Camera(BaseModel):
    """A calibrated camera for pictures of one size; `origin` says how far to trust it."""

    model_config = ConfigDict(frozen=True, extra="allow")

    width: PixelSize
    height: PixelSize
    fx: Focal
    fy: Focal
    cx: Centre
    cy: Centre
    distortion: tuple[Coefficient, Coefficient, Coefficient, Coefficient, Coefficient] = (
        *(0.0, 0.0, 0.0, 0.0),
        0.0,
    )
    projection: Literal["perspective", "telephoto"] = "perspective"
    telephoto_distance_m: Annotated[FiniteFloat, Field(ge=0.01, le=1e5)] | None = Field(
        default=None, description="Distance at which a telephoto camera's scale holds."
    )
    origin: Literal["intrinsics", "field of view", "guess"] = "intrinsics"

    @model_validator(mode="after")
    def _telephoto_has_a_distance(self) -> Self:
        if self.projection == "telephoto" and self.telephoto_distance_m is None:
            raise ValueError("the telephoto projection needs telephoto_distance_m")
        if self.projection == "perspective" and self.telephoto_distance_m is not None:
            raise ValueError("telephoto_distance_m goes with the telephoto projection only")
        return self

    @classmethod
    def from_field_of_view(cls, width: int, height: int, angle_rad: float) -> Camera:
        """A camera whose longer picture side spans this angle (radians, 0 to pi)."""
        if not 0.0 < angle_rad < math.pi:
            raise CameraError("The field of view must lie between 0 and 180 degrees.")
        f = max(width, height) / 2 / math.tan(angle_rad / 2)
        cx, cy = (width - 1) / 2, (height - 1) / 2
        return cls(width=width, height=height, fx=f, fy=f, cx=cx, cy=cy, origin="field of view")

    @classmethod
    def from_focal_length(cls, width: int, height: int, focal_mm: float) -> Camera:
        """A camera with the lens that shows as much on 35 mm film, whose frame is 36 mm wide."""
        return cls.from_field_of_view(width, height, 2 * math.atan(FILM_MM / 2 / focal_mm))

    @classmethod
    def guess(cls, width: int, height: int) -> Camera:
        """A usual camera for pictures of this size; its `origin` says that it is a guess."""
        camera = cls.from_field_of_view(width, height, GUESSED_FIELD_OF_VIEW)
        return camera.model_copy(update={"origin": "guess"})

    @property
    def K(self) -> Array:
        """The 3×3 matrix of intrinsics."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def focal_mm(self) -> float:
        """The focal length of the lens that shows as much on 35 mm film."""
        return FILM_MM * min(self.fx / self.width, self.fy / self.height)

    @property
    def usual_spread(self) -> float:
        """By what share distances change, at most, with one of the usual lenses instead of
        this one: what is seen as large is farther away by as much as the focal length is longer.
        """
        longer = max(self.width / self.fx, self.height / self.fy) / 2
        return max(abs(longer / math.tan(usual / 2) - 1) for usual in USUAL_FIELDS_OF_VIEW)

    @property
    def is_distorted(self) -> bool:
        return any(self.distortion)

    def without_distortion(self) -> Camera:
        """The same camera with an ideal lens: what `rectify` turns its pictures into."""
        return self.model_copy(update={"distortion": (0.0,) * 5})

    def zoomed(self, ratio: float) -> Camera:
        """The same camera with a focal length so many times as long."""
        if ratio == 1.0:
            return self
        return self.model_copy(update={"fx": self.fx * ratio, "fy": self.fy * ratio})

    def depth(self, p_camera: Array) -> Array:
        """The distances (...) by which points (..., 3) are divided: z, or telephoto's one."""
        if self.telephoto_distance_m is not None:
            return np.full(p_camera.shape[:-1], self.telephoto_distance_m)
        return np.asarray(p_camera[..., 2])

    def project(self, p_camera: Array) -> Array:
        """Pixels (..., 2) of points (..., 3) in metres; NaN for points not before the camera."""
        p_camera = np.asarray(p_camera, dtype=np.float64)
        z = np.where(p_camera[..., 2] > 1e-6, self.depth(p_camera), np.nan)
        xy = _distorted(p_camera[..., :2] / z[..., None], self.distortion)
        return xy * (self.fx, self.fy) + (self.cx, self.cy)

    def ray_to(self, p_camera: Array) -> tuple[Array, Array]:
        """Where the line of sight to a point (3,) begins, and its unit direction (3,)."""
        if self.telephoto_distance_m is not None:
            return np.array([p_camera[0], p_camera[1], 0.0]), np.array([0.0, 0.0, 1.0])
        return np.zeros(3), p_camera / np.sqrt(p_camera @ p_camera)

    def back_project(self, uv: Array, depth_m: Array | float) -> Array:
        """Points (..., 3) in metres that are seen at pixels (..., 2), at z = depth_m.

        NaN where the lens shows nothing.
        """
        uv = np.asarray(uv, dtype=np.float64)
        xy = (uv - (self.cx, self.cy)) / (self.fx, self.fy)
        xy = _undistorted(xy, self.distortion)
        z = np.broadcast_to(np.asarray(depth_m, dtype=np.float64), xy.shape[:-1])[..., None]
        scale = z if self.telephoto_distance_m is None else self.telephoto_distance_m
        return np.concatenate([xy * scale, z], axis=-1)

    def rectify(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The picture as `without_distortion()` would have taken it; itself with an ideal lens."""
        if not self.is_distorted:
            return image
        size = image.shape[1], image.shape[0]
        shifts, fractions = _rectifying(self.K.tobytes(), self.distortion, size)
        return np.asarray(cv2.remap(image, shifts, fractions, cv2.INTER_LINEAR), dtype=np.uint8)


@lru_cache(maxsize=2)
def _rectifying(
    K: bytes, distortion: tuple[float, ...], size: tuple[int, int]
) -> tuple[NDArray[np.int16], NDArray[np.uint16]]:
    """Where each pixel of a rectified picture (width, height) comes from, as cv2.undistort has it,
    which finds it anew for every picture: two thirds of its time."""
    matrix = np.frombuffer(K).reshape(3, 3)
    coefficients = np.array(distortion)
    shifts, fractions = cv2.initUndistortRectifyMap(
        matrix, coefficients, np.eye(3), matrix, size, cv2.CV_16SC2
    )
    return np.asarray(shifts, np.int16), np.asarray(fractions, np.uint16)


def _distorted(xy: Array, coefficients: tuple[float, ...]) -> Array:
    """Where the lens shows the ideal direction (..., 2), both as x/z, y/z."""
    k1, k2, p1, p2, k3 = coefficients
    if not any(coefficients):
        return xy
    x, y = xy[..., 0], xy[..., 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return np.stack(
        [
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        ],
        axis=-1,
    )


def _undistorted(xy: Array, coefficients: tuple[float, ...]) -> Array:
    """The ideal direction (..., 2) that the lens shows at xy: `_distorted` solved by Newton's rule.

    NaN where the lens shows no direction at all.
    """
    if not any(coefficients):
        return xy
    ideal = xy
    for _ in range(30):
        step = _solved(_distortion_slope(ideal, coefficients), _distorted(ideal, coefficients) - xy)
        ideal = ideal - np.clip(step, -0.3, 0.3)  # far out the slope may lead astray
        if np.abs(step).max(initial=0.0) < 1e-15:
            break
    missed = np.abs(_distorted(ideal, coefficients) - xy).max(axis=-1, keepdims=True) > 1e-9
    return np.where(missed, np.nan, ideal)


def _distortion_slope(xy: Array, coefficients: tuple[float, ...]) -> tuple[Array, Array, Array]:
    """∂`_distorted`/∂(x, y), which is symmetric: its entries xx, xy, yy."""
    k1, k2, p1, p2, k3 = coefficients
    x, y = xy[..., 0], xy[..., 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    bend = 2 * (k1 + r2 * (2 * k2 + 3 * r2 * k3))
    return (
        radial + bend * x * x + 2 * p1 * y + 6 * p2 * x,
        bend * x * y + 2 * p1 * x + 2 * p2 * y,
        radial + bend * y * y + 6 * p1 * y + 2 * p2 * x,
    )


def _solved(slope: tuple[Array, Array, Array], miss: Array) -> Array:
    xx, xy, yy = slope
    u, v = miss[..., 0], miss[..., 1]
    det = xx * yy - xy * xy
    det = np.where(np.abs(det) < 1e-12, 1e-12, det)
    return np.stack([(yy * u - xy * v) / det, (xx * v - xy * u) / det], axis=-1)
