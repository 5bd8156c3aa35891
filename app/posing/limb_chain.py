"""A chain of parts that is pulled at its end: what all ways of bending it start from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.app.posing.gesture_context import GestureContext
from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True, eq=False)
class LimbChain:
    """Parts that follow one another; tip (3,) is their end in the last part's frame."""

    context: GestureContext
    parts: tuple[int, ...]
    tip: Array

    @property
    def centre(self) -> Array:
        """(3,) the first joint, in the camera frame."""
        return self.context.joint(self.parts[0])

    @property
    def end(self) -> Array:
        """(3,) the tip before the drag, in the camera frame."""
        return self.context.placed(self.parts[-1], self.tip)

    def levers(self) -> Array:
        """(K, 3) from each part's joint to the next one's, at last to the tip, camera frame."""
        points = [self.context.joint(part) for part in self.parts]
        return np.diff(np.stack([*points, self.end]), axis=0)
