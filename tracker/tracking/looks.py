"""What a segment's frames show of a body, remembered while it hardly moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.kernels.layout import Views

if TYPE_CHECKING:
    from keypose.tracker.body.surface_points import SurfacePoints
    from keypose.tracker.body.trajectory import Trajectory
    from keypose.tracker.tracking.scene import Scene


class Looks:
    """Which points of a body the frames of a segment show, as they were last looked at. They are
    looked at again where the body has moved."""

    def __init__(self) -> None:
        self._known: dict[tuple[SurfacePoints, int, int, int], Views] = {}

    def over(self, scene: Scene, trajectory: Trajectory, stride: int) -> Views:
        """Those of a trajectory's frames but the last."""
        first, frames = trajectory.first_frame, len(trajectory) - 1
        key = (scene.points, stride, first, frames)
        if key not in self._known:
            self._known[key] = _unseen(scene, frames, stride)
        return self._known[key]


def _unseen(scene: Scene, frames: int, stride: int) -> Views:
    parts = scene.skeleton.part_count
    most = len(scene.points.points) // stride + parts + 1
    return Views(
        np.full((frames, parts, 2, 2), np.nan, np.float32), np.zeros((frames, most), np.int32),
        np.zeros((frames, parts + 1), np.int64), np.zeros(frames, np.int64),
    )  # fmt: skip
