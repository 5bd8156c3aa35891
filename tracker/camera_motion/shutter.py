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
"""Standard deviation of a camera's readout before anything is seen of it."""
IN_COMMON = 25.0
"""How many points and frames err alike, as a number: they share a keyframe's errors."""
LEAST_SIGMA = 0.01
"""What the frames have in common that their number does not better."""
MOST = 1.5
"""Largest readout that is learned; more than 1 is one of another frame time."""
LEAST_SHARE = 0.1
"""A smaller readout is not reported."""
LEAST_SIGMAS = 5.0
"""Nor one of fewer standard deviations."""
USED_SIGMAS = 3.0
"""Standard deviations from which on pictures are straightened by it."""


@dataclass(eq=False)
class Shutter:
    """The readouts (2,) along u and v, from the first column or row to the last, as estimated from
    the frames so far, and their information (2, 2). size: of the film's pictures.
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
        velocity = np.stack(
            [
                -x * y * rate[0] + (1 + x * x) * rate[1] - y * rate[2],
                -(1 + y * y) * rate[0] + x * y * rate[1] + x * rate[2],
            ],
            axis=1,
        )
        part = (uv + 0.5) / self.size - 0.5
        return np.asarray(velocity[:, :, None] * part[:, None, :])

    def straightened(self, lens: Lens, uv: Array, zoom: float, rate: Array) -> Array:
        """Where points of a picture would be seen if it were read at once, pixels (K, 2).

        Args:
            lens: of the film.
            uv: (K, 2) where they are seen, pixels.
            zoom: of the picture.
            rate: (3,) how fast the camera turns, radians a frame.
        """
        return uv - self._shifted(lens, uv, zoom, rate)

    def sheared(self, lens: Lens, uv: Array, zoom: float, rate: Array) -> Array:
        """Where points are seen that would be at uv (K, 2) if the picture were read at once; the
        rest as of `straightened`."""
        return uv + self._shifted(lens, uv, zoom, rate)

    def _shifted(self, lens: Lens, uv: Array, zoom: float, rate: Array) -> Array:
        """By how much the readout shifts points, pixels (K, 2); as of `straightened`."""
        tangents = lens.flat(uv, zoom) / zoom
        shifts = self.shifts(uv, tangents, rate) @ self.share
        return np.asarray(shifts * zoom * (lens.camera.fx, lens.camera.fy))

    def learn(self, pull: Array, information: Array) -> None:
        """Take what a frame's points say: by how much `share` (2,) should change, times the
        information (2, 2) they have of it.
        """
        total = self.information + information / IN_COMMON
        asked = pull + information @ (self.share - self.estimate)
        estimate = self.estimate + np.linalg.solve(total, asked / IN_COMMON)
        self.estimate = np.clip(estimate, -MOST, MOST)
        most = np.linalg.eigvalsh(total)[-1] * LEAST_SIGMA**2
        self.information = total / max(1.0, most)

    def reported(self) -> float | None:
        """The readout as a share of the time between frames, None where there is none."""
        sigma = np.sqrt(np.diag(np.linalg.inv(self.information)))
        size = np.abs(self.estimate)
        sure = (size > LEAST_SHARE) & (size > LEAST_SIGMAS * sigma)
        return float(size[sure].max()) if sure.any() else None
