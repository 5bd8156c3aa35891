"""Learn how long a camera takes to read a picture, row after row, and what that does to it.

While the camera turns, each row is seen from a little farther on: a point is shifted by its share
of the readout times how fast the picture moves there. The readout, as a share of the time between
frames, is one constant of the film. Every frame says by how much to change it, and the next is
straightened by what is known so far; the shear is then neither taken for roll nor for points that
move by themselves. A phone held upright reads columns: both axes have their own.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.geometry.rotations import Array

PRIOR_SIGMA = 0.3
IN_COMMON = 25.0
"""How many points and frames err alike, as a number: they share a keyframe's errors."""
LEAST_SIGMA = 0.01
"""What the frames have in common that their number does not better."""
MOST = 1.5
LEAST_SHARE = 0.1
LEAST_SIGMAS = 5.0
USED_SIGMAS = 3.0
"""A readout that is smaller, or less sure, is not reported."""


@dataclass(eq=False)
class Shutter:
    """The readouts (2,) along u and v, from the first column or row to the last, as the frames so
    far told them, and their information (2, 2). size: of the film's pictures.
    """

    size: tuple[int, int]
    estimate: Array = field(default_factory=lambda: np.zeros(2))
    information: Array = field(default_factory=lambda: np.eye(2) / PRIOR_SIGMA**2)

    @property
    def share(self) -> Array:
        """The readouts (2,) that pictures are straightened by: 0 for one that is not sure."""
        sigma = np.sqrt(np.diag(np.linalg.inv(self.information)))
        return np.where(np.abs(self.estimate) > USED_SIGMAS * sigma, self.estimate, 0.0)

    def shifts(self, uv: Array, flat: Array, rate: Array) -> Array:
        """Shifts (K, 2, 2) of points for a readout of 1 along u and along v, in the units of
        `flat` (K, 2), tangents; uv (K, 2): where they are seen.  rate (3,): turn a frame, radians.
        """
        x, y = flat.T
        way = np.stack(
            [
                -x * y * rate[0] + (1 + x * x) * rate[1] - y * rate[2],
                -(1 + y * y) * rate[0] + x * y * rate[1] + x * rate[2],
            ],
            axis=1,
        )
        part = (uv + 0.5) / self.size - 0.5
        return np.asarray(way[:, :, None] * part[:, None, :])

    def straightened(self, lens: Lens, uv: Array, zoom: float, rate: Array) -> Array:
        """Where points (K, 2) of a picture would be seen if it were read at once."""
        return uv - self._shifted(lens, uv, zoom, rate)

    def sheared(self, lens: Lens, uv: Array, zoom: float, rate: Array) -> Array:
        """Where points (K, 2) are seen that would be here if the picture were read at once."""
        return uv + self._shifted(lens, uv, zoom, rate)

    def _shifted(self, lens: Lens, uv: Array, zoom: float, rate: Array) -> Array:
        tangents = lens.flat(uv, zoom) / zoom
        shifts = self.shifts(uv, tangents, rate) @ self.share
        return np.asarray(shifts * zoom * (lens.camera.fx, lens.camera.fy))

    def learn(self, pull: Array, information: Array) -> None:
        """Take what a frame's points say: by how much `share` (2,) should change, times the
        information (2, 2) they have of it.
        """
        total = self.information + information / IN_COMMON
        asked = pull + information @ (self.share - self.estimate)
        found = self.estimate + np.linalg.solve(total, asked / IN_COMMON)
        self.estimate = np.clip(found, -MOST, MOST)
        most = np.linalg.eigvalsh(total)[-1] * LEAST_SIGMA**2
        self.information = total / max(1.0, most)

    def found(self) -> float | None:
        """The readout as a share of the time between frames, None where there is none."""
        sigma = np.sqrt(np.diag(np.linalg.inv(self.information)))
        size = np.abs(self.estimate)
        sure = (size > LEAST_SHARE) & (size > LEAST_SIGMAS * sigma)
        return float(size[sure].max()) if sure.any() else None
