"""Tell from residuals how long a camera takes to read a picture, row after row.

While the camera pans, each row is seen from a little farther on, so the picture is sheared in
proportion to the speed. Measured from an anchor, a frame is sheared by the difference of the two
speeds. A turn takes up the part of the shear that looks like a roll; what is left of it is fitted
here, frame by frame, and set against the speeds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.geometry.rotations import Array

FAR_PX = 5.0
"""Residuals beyond this are other motion."""
LEAST_PX = 0.3
"""Shear between the first and the last row, root mean square, below which nothing is said."""
LEAST_SHARE, LEAST_SIGMAS, FEWEST_FRAMES = 0.1, 5.0, 10


@dataclass(frozen=True)
class Readout:
    """The share of the time between frames from the first row to the last, its standard
    deviation, and the frames over which it shows.
    """

    share: float
    sigma: float
    first_frame: int
    last_frame: int


class Shutter:
    """Sums over frames."""

    def __init__(self) -> None:
        self._sums = np.zeros(3)
        self._speeds: list[tuple[int, float]] = []

    def add(self, frame: int, at: Array, residual_px: Array, speed_px: float, height: int) -> None:
        """Take points at (K, 2) pixels and what is left of them (K, 2); speed_px: of the picture
        along its rows, less the anchor's, a frame.
        """
        near = np.linalg.norm(residual_px, axis=1) < FAR_PX
        if near.sum() < FEWEST_FRAMES:
            return
        x, y = (at[near] - at[near].mean(axis=0)).T
        roll = (y @ y) / max(x @ x + y @ y, 1e-9)
        template = np.stack([(1 - roll) * y, roll * x], axis=1)
        shear = (template * residual_px[near]).sum() / max((template**2).sum(), 1e-9) * height
        self._sums += speed_px * shear, speed_px**2, shear**2
        self._speeds.append((frame, abs(speed_px)))

    def readout(self) -> Readout | None:
        """Return what the frames say; None where that is nothing."""
        product, power, shears = self._sums
        count = len(self._speeds)
        if count < FEWEST_FRAMES or np.sqrt(shears / count) < LEAST_PX or power < 1e-9:
            return None
        share = product / power
        sigma = np.sqrt(max(shears - share * product, 1e-12) / count / power)
        if not LEAST_SHARE < share < 1.5 or share < LEAST_SIGMAS * sigma:
            return None
        typical = np.sqrt(power / count)
        frames = [frame for frame, speed in self._speeds if speed >= typical]
        return Readout(float(share), float(sigma), frames[0], frames[-1])
