"""A camera that turns in one place, and one that turns as it does but without its tremble.

Pictures as the steady one would have taken them show a body that moves as smoothly as it does.
Otherwise a tremble of some pixels would be a motion of the whole body, against the smoothness
that motions are told by.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from keypose.tracker.geometry.rotations import (
    Array,
    frozen,
    quaternion_wxyz,
    rotation_from_quaternion,
    transpose,
)

STEADY_FRAMES = 6.0
"""Standard deviation of the frames over which turns are averaged."""


@dataclass(frozen=True, eq=False)
class TurningCamera:
    """How a camera is turned at every frame, Rs_camera_world (F, 3, 3), and how the steady one is,
    Rs_steady_world (F, 3, 3).
    """

    Rs_camera_world: Array
    Rs_steady_world: Array

    @classmethod
    def of(cls, Rs_camera_world: Array, pieces: Sequence[int] = (0,)) -> TurningCamera:
        """pieces: first frames of what hangs together; no turn is averaged across their borders."""
        quaternions = quaternion_wxyz(Rs_camera_world)
        alike = np.sign((quaternions[1:] * quaternions[:-1]).sum(axis=1, keepdims=True))
        signs = np.cumprod(np.concatenate([[[1.0]], np.where(alike < 0, -1.0, 1.0)]), axis=0)
        smooth = np.concatenate([
            _averaged(piece) for piece in np.split(signs * quaternions, pieces[1:])
        ])  # fmt: skip
        smooth /= np.linalg.norm(smooth, axis=1, keepdims=True)
        return cls(frozen(Rs_camera_world), frozen(rotation_from_quaternion(smooth)))

    def Rs_steady_camera(self, first: int, last: int) -> Array:
        """(N, 3, 3) from the camera to the steady one, of the frames first to last."""
        rows = slice(first, last + 1)
        return self.Rs_steady_world[rows] @ transpose(self.Rs_camera_world[rows])

    def sampled(self, most: int) -> list[int]:
        """At most so many frames, spread evenly over the film and over its turns."""
        R = self.Rs_camera_world
        cosine = (np.trace(R[1:] @ transpose(R[:-1]), axis1=1, axis2=2) - 1) / 2
        turned = np.arccos(np.clip(cosine, -1.0, 1.0))
        steps = 1 / max(len(turned), 1) + turned / max(turned.sum(), 1e-9)
        way = np.concatenate([[0.0], np.cumsum(steps)])
        wanted = np.linspace(0, way[-1], most)
        return [int(frame) for frame in np.unique(np.searchsorted(way, wanted - 1e-12))]


def _averaged(rows: Array) -> Array:
    """Rows (N, 4) averaged over neighbouring ones, which go on beyond the ends as they went."""
    beyond = int(4 * STEADY_FRAMES)
    longer = np.pad(rows, ((beyond, beyond), (0, 0)), mode="reflect", reflect_type="odd")
    return np.asarray(gaussian_filter1d(longer, STEADY_FRAMES, axis=0)[beyond:-beyond])
