"""The camera of a film: what it sees of the world, and where that is in the world.

Poses lie in the frame of the camera at their own frame of the film, as a person posed them over
its picture. This is the one place where they are carried to the world, and from there to the camera
at another frame. Before a camera that stands still all these frames are one: everything is returned
as it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Trajectory, blended, carried
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath, rigid_inverse
from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True, eq=False)
class FilmCamera:
    """lens: the camera without zoom.  path: where it was at every frame of the film; None where it
    stands still, or nobody knows: its frame is the world's then."""

    lens: Camera
    path: CameraPath | None = None

    def at(self, frame: int) -> Camera:
        """The camera with the focal length it has at a frame."""
        return self.lens if self.path is None else self.path.camera_at(self.lens, frame)

    def zoom_at(self, frame: int) -> float:
        """The focal length at a frame, as a multiple of the lens's."""
        return 1.0 if self.path is None else float(self.path.zoom[frame])

    def T_camera_world(self, frame: int) -> Array:
        """(4, 4) where the world is for the camera at a frame."""
        return np.eye(4) if self.path is None else np.asarray(self.path.Ts_camera_world[frame])

    def path_over(self, motion: Trajectory) -> CameraPath | None:
        """Where the camera was over the frames of a motion; None where it stands still."""
        path = self.path
        return None if path is None else path.between(motion.first_frame, motion.last_frame)

    def eyes(self, motion: Trajectory) -> Array | None:
        """(N, 3) where the camera was in the world over a motion; None where it stands still."""
        path = self.path_over(motion)
        return None if path is None else path.Ts_world_camera[:, :3, 3]

    def motion_to_world(self, motion: Trajectory) -> Trajectory:
        """A motion that the camera saw, in the world."""
        path = self.path_over(motion)
        return motion if path is None else motion.carried(path.Ts_world_camera)

    def pose_to_world(self, frame: int, pose: Pose) -> Pose:
        """A pose that the camera sees at a frame, in the world."""
        return pose if self.path is None else pose.carried(self.path.Ts_world_camera[frame])

    def poses_to_world(self, poses: Mapping[int, Pose]) -> dict[int, Pose]:
        """Poses that the camera sees at their frames, in the world."""
        return {frame: self.pose_to_world(frame, pose) for frame, pose in poses.items()}

    def pose_to_camera(self, frame: int, pose: Pose) -> Pose:
        """A pose of the world as the camera sees it at a frame."""
        return pose if self.path is None else pose.carried(self.path.Ts_camera_world[frame])

    def pose_seen_at(self, seen_frame: int, frame: int, pose: Pose) -> Pose:
        """The pose of a frame where it stands in the world, as the camera sees it at another."""
        if self.path is None:
            return pose
        return pose.carried(self.parts_seen_at(seen_frame, np.eye(4)[None], [frame])[0])

    def even_motion(
        self, start: Pose, end: Pose, span: tuple[int, int], frames: NDArray[np.int64]
    ) -> tuple[Array, Array]:
        """Rotations (N, P, 3, 3) and root positions (N, 3) at frames (N,) of the motion from one
        pose, at the first frame of a span, to another at its last, that is even in the world, as
        the camera sees it."""
        first, last = span
        path, shares = self.path, (frames - first) / (last - first)
        if path is None:
            return blended(start, end, shares)
        Ts = path.Ts_camera_world
        begin, finish = rigid_inverse(Ts[[first, last]])
        return carried(*blended(start.carried(begin), end.carried(finish), shares), Ts[frames])

    def parts_to_world(self, Ts_camera: Array, frames: ArrayLike) -> Array:
        """Ts_camera (N, ..., 4, 4), each in the frame of the camera at its own of N frames, in the
        world."""
        if self.path is None:
            return Ts_camera
        return _each(self.path.Ts_world_camera[np.asarray(frames)], Ts_camera)

    def parts_seen_at(self, frame: int, Ts_camera: Array, frames: ArrayLike) -> Array:
        """Ts_camera (N, ..., 4, 4), each in the frame of the camera at its own of N frames, in that
        of the camera at one frame."""
        path = self.path
        if path is None:
            return Ts_camera
        T = path.Ts_camera_world[frame] @ path.Ts_world_camera[np.asarray(frames)]
        return _each(T, Ts_camera)

    def points_to_world(self, frame: int, p_camera: Array) -> Array:
        """Points (..., 3) that the camera sees at a frame, in the world."""
        if self.path is None:
            return p_camera
        T = self.path.Ts_world_camera[frame]
        return np.asarray(p_camera @ T[:3, :3].T + T[:3, 3])

    def points_to_camera(self, frame: int, p_world: Array) -> Array:
        """Points (..., 3) of the world for the camera at a frame."""
        if self.path is None:
            return p_world
        T = self.path.Ts_camera_world[frame]
        return np.asarray(p_world @ T[:3, :3].T + T[:3, 3])

    def direction_to_world(self, frame: int, direction: ArrayLike) -> Array:
        """A direction (3,) that the camera sees at a frame, in the world."""
        return np.asarray(self.T_camera_world(frame)[:3, :3].T @ np.asarray(direction))


def _each(Ts: Array, Ts_camera: Array) -> Array:
    """Ts (N, 4, 4) before each of Ts_camera (N, ..., 4, 4)."""
    return np.asarray(Ts.reshape(-1, *(1,) * (Ts_camera.ndim - 3), 4, 4) @ Ts_camera)
