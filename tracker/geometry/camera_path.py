"""Where a camera is at every frame of a film, how it is turned, and how far it has zoomed.

World frame: the camera's own at the first frame, unless something else is said. A camera that
stands still is the identity at every frame, and has no path.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True, eq=False)
class CameraPath:
    """The motion of a camera over N frames, the first of them frame 0 of its film.

    Ts_camera_world (N, 4, 4), metres.  zoom (N,): the focal length as a multiple of the camera's.
    """

    Ts_camera_world: Array
    zoom: Array

    @classmethod
    def standing_still(cls, frame_count: int) -> CameraPath:
        """The path of a camera that neither moves nor zooms."""
        return cls(np.broadcast_to(np.eye(4), (frame_count, 4, 4)), np.ones(frame_count))

    def __len__(self) -> int:
        return len(self.zoom)

    @property
    def Ts_world_camera(self) -> Array:
        """(N, 4, 4) poses of the camera in the world, metres."""
        R = np.swapaxes(self.Ts_camera_world[:, :3, :3], -1, -2)
        Ts = np.zeros_like(self.Ts_camera_world)
        Ts[:, :3, :3], Ts[:, 3, 3] = R, 1.0
        Ts[:, :3, 3] = -np.einsum("nab,nb->na", R, self.Ts_camera_world[:, :3, 3])
        return Ts

    @property
    def turns(self) -> bool:
        """Return whether the camera is turned at any frame."""
        return bool((self.Ts_camera_world[:, :3, :3] != np.eye(3)).any())

    @property
    def moves(self) -> bool:
        """Return whether the camera is elsewhere at any frame."""
        return bool(self.Ts_camera_world[:, :3, 3].any())

    @property
    def zooms(self) -> bool:
        """Return whether the focal length changes."""
        return bool((self.zoom != 1.0).any())

    def camera_at(self, camera: Camera, frame: int) -> Camera:
        """The film's camera with the focal length of one frame."""
        if self.zoom[frame] == 1.0:
            return camera
        f = {"fx": camera.fx * self.zoom[frame], "fy": camera.fy * self.zoom[frame]}
        return camera.model_copy(update=f)
