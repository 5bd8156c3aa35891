"""How far beside a body's joints a network puts them, as far as posed frames show.

A network puts an elbow beside where the arm bends, one way throughout a film and another way for a
while: what it is off in one frame is of use in those near it, less so far away. So where posed
frames show by how much, every other frame's offset is the best linear guess from them: Gaussian
process regression ("kriging"), with a part that lasts and a part that passes. A posed frame is not
exact itself; what is learned from one is believed by half, from several by more.

Measured on four people in five clips: of what a keypoint is off (1.6 % of the height), the
correlation is 0.64 over 4 frames, 0.47 over 8, 0.35 over 16 and 0.25 over 24 to 32; of what its
depth is off (14 cm) 0.85 over 8, 0.65 over 16 and 0.43 over 24.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True)
class Varies:
    """How a value varies over frames: standard deviations of what lasts and of what passes, and
    over how many frames that does."""

    lasting: float
    passing: float
    frames: float

    def covariance(self, one: Array, other: Array) -> Array:
        """(N, M) between frames (N,) and others (M,)."""
        apart = np.abs(one[:, None] - other[None])
        return self.lasting**2 + self.passing**2 * np.exp(-apart / self.frames)


PLACE_M: Final = Varies(lasting=0.010, passing=0.016, frames=12.0)
"""Of a keypoint's place on its part, along each axis."""
POSED_PX, SHAKES_M = 4.5, 0.01
"""How exactly somebody poses a joint in the picture, and by how much a keypoint shakes."""
DEPTH_M: Final = Varies(lasting=0.08, passing=0.11, frames=18.0)
"""Of a keypoint's depth beside the root's."""
POSED_DEPTH_M: Final = 0.06
"""How exactly somebody poses that."""


def learned_places(
    frames: Array, posed: Sequence[int], slopes: Array, missed_px: Array, pixel_m: Array
) -> Array:
    """(N, 3) where on its part a keypoint is beside its joint, metres, at frames (N,).

    posed: the rows of those that show it, R of them.  slopes (R, 2, 3): pixels by metre in the
    part's axes.  missed_px (R, 2): from the joint to the keypoint.  pixel_m (R,): metres there.
    """
    at = frames[list(posed)]
    pixels = _block_diagonal(slopes)
    noise = np.repeat((SHAKES_M / pixel_m) ** 2 + POSED_PX**2, 2)
    own = np.kron(PLACE_M.covariance(at, at), np.eye(3))
    known = pixels @ own @ pixels.T + np.diag(noise)
    weighted = pixels.T @ np.linalg.solve(known, missed_px.ravel())
    return np.asarray(np.kron(PLACE_M.covariance(frames, at), np.eye(3)) @ weighted).reshape(-1, 3)


def learned_depths(frames: Array, posed: Sequence[int], missed_m: Array) -> Array:
    """(N,) what a keypoint's depth lacks at frames (N,), metres; missed_m (R,): at posed rows."""
    at = frames[list(posed)]
    known = DEPTH_M.covariance(at, at) + POSED_DEPTH_M**2 * np.eye(len(at))
    return np.asarray(DEPTH_M.covariance(frames, at) @ np.linalg.solve(known, missed_m))


def _block_diagonal(blocks: Array) -> Array:
    """(2R, 3R) of (R, 2, 3)."""
    count, rows, columns = blocks.shape
    out = np.zeros((count, rows, count, columns))
    out[np.arange(count), :, np.arange(count)] = blocks
    return out.reshape(count * rows, count * columns)
