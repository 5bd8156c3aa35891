"""The camera that would have taken a film without shake and zoom, from the same places.

A picture that is turned about the camera's centre is another picture of the same scene, exactly. So
a film whose camera's motion is known is tracked as if a steady hand had turned the camera along,
at one focal length: a body is then where it is expected from frame to frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import (
    Array,
    exp_rotation,
    frozen,
    log_rotation,
    nearest_rotation,
    transpose,
)

SMOOTHED_FRAMES: Final = 8.0
"""Standard deviation: a hand shakes faster than this, and follows somebody more slowly."""
MOST_RAD: Final = np.radians(3.0)
"""By how much a picture is turned at most; what is turned farther loses too much of its side."""


@dataclass(frozen=True, eq=False)
class SteadyCamera:
    """camera: of the film, undistorted ideally.  Rs_steady_camera (F, 3, 3) of every frame of the
    film; zoom (F,): its focal length there as a multiple of the camera's.
    """

    camera: Camera
    Rs_steady_camera: Array
    zoom: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "Rs_steady_camera", frozen(self.Rs_steady_camera))

    @classmethod
    def along(cls, camera: Camera, path: CameraPath) -> SteadyCamera:
        """Of a film whose camera went along a path."""
        from scipy.ndimage import gaussian_filter1d  # loads what only this needs

        if camera.telephoto_distance_m is not None:  # it has no centre to be turned about
            return cls.at_one_focal(camera, path)
        R = path.Ts_camera_world[:, :3, :3]
        smooth = nearest_rotation(
            gaussian_filter1d(R, SMOOTHED_FRAMES, axis=0, mode="nearest", truncate=3.0)
        )
        turn = log_rotation(smooth @ transpose(R))
        size = np.linalg.norm(turn, axis=1, keepdims=True)
        turn = turn * np.minimum(1.0, MOST_RAD / np.maximum(size, 1e-12))
        return cls(camera, exp_rotation(turn), path.zoom)

    @classmethod
    def at_one_focal(cls, camera: Camera, path: CameraPath) -> SteadyCamera:
        """Without the zoom alone: turned as the film's own camera."""
        return cls(camera, np.broadcast_to(np.eye(3), (len(path), 3, 3)), path.zoom)

    @cached_property
    def Ts_camera_steady(self) -> Array:
        """(F, 4, 4)"""
        return np.swapaxes(self.Ts_steady_camera, 1, 2)  # rotations alone

    @cached_property
    def Ts_steady_camera(self) -> Array:
        """(F, 4, 4)"""
        T = np.tile(np.eye(4), (len(self.zoom), 1, 1))
        T[:, :3, :3] = self.Rs_steady_camera
        return T

    def covers(self, frame: int) -> bool:
        """Whether its picture of a frame shows nothing beyond the film's."""
        turned = (self.Rs_steady_camera[frame] != np.eye(3)).any()
        return not turned and bool(self.zoom[frame] <= 1)

    def picture(self, image: NDArray[np.uint8], frame: int) -> NDArray[np.uint8]:
        """The rectified picture of a frame as it would have been taken."""
        zoom = float(self.zoom[frame])
        if zoom == 1 and (self.Rs_steady_camera[frame] == np.eye(3)).all():
            return image
        camera = self.camera
        K_then = camera.K.copy()
        K_then[:2, :2] *= zoom
        H = camera.K @ self.Rs_steady_camera[frame] @ np.linalg.inv(K_then)
        interpolation = cv2.INTER_AREA if zoom > 1.2 else cv2.INTER_LINEAR
        size = (camera.width, camera.height)
        return np.asarray(cv2.warpPerspective(image, H, size, flags=interpolation), dtype=np.uint8)

    def pixels(self, uv: Array, frame: int) -> Array:
        """Where pixels (..., 2) of a frame would have been seen, with the lens's distortion."""
        camera, centre = self.camera, (self.camera.cx, self.camera.cy)
        at_focal = (uv - np.array(centre)) / self.zoom[frame] + centre
        R = self.Rs_steady_camera[frame]
        if (np.eye(3) == R).all():
            return np.asarray(at_focal)
        return camera.project(camera.back_project(at_focal, 1.0) @ R.T)
