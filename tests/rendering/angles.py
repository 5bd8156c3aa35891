"""Motions written as angles over time, part by part."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory

Floats = NDArray[np.float64]


class Angles:
    """Angles (N, P, 3) about z, y, x, radians, of every part: R = Qz Qy Qx, at rest unless set."""

    def __init__(self, skeleton: Skeleton, count: int) -> None:
        self.skeleton = skeleton
        self.zyx = np.zeros((count, skeleton.part_count, 3))

    def turn(self, part: str, x: ArrayLike = 0.0, y: ArrayLike = 0.0, z: ArrayLike = 0.0) -> None:
        """Set a part's angles, each a number or one per frame."""
        place = self.skeleton.body.index(part)
        for column, angle in enumerate((z, y, x)):
            self.zyx[:, place, column] = angle

    def rotations(self) -> Floats:
        """Rs_parent_part (N, P, 3, 3)."""
        matrices = Rotation.from_euler("ZYX", self.zyx.reshape(-1, 3)).as_matrix()
        return matrices.reshape(*self.zyx.shape, 3)

    def trajectory(self, ps_camera_root: ArrayLike) -> Trajectory:
        """The motion with its root at (N, 3) or (3,), metres."""
        count = len(self.zyx)
        return Trajectory(0, self.rotations(), np.broadcast_to(ps_camera_root, (count, 3)))


def wave(seconds: Floats, hertz: float, phase: float = 0.0) -> Floats:
    """A sine of this frequency."""
    return np.sin(2 * np.pi * hertz * seconds + phase)


def bump(cycle: Floats, middle: float, width: float) -> Floats:
    """A smooth bump of height 1 that comes once per cycle, `cycle` in turns."""
    distance = (cycle - middle + 0.5) % 1.0 - 0.5
    return np.exp(-0.5 * (distance / width) ** 2)
