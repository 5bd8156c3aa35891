"""A piece of a keyframe's picture that turns with the limb it shows."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.tracking.initial.templates.search import Template, cut
from keypose.tracker.video.pyramid import USABLE, Picture

STEP_RAD = np.radians(3.0)
"""Turns are rounded to this: less hardly changes a small template."""


@dataclass(eq=False)
class Rotatable:
    """The surroundings of a place in one picture, as templates at any angle in the picture's plane.

    picture: (h, w, 4) as in a clip. wanted: (h, w) the pixels that count. uv: (2,) the place.
    """

    picture: Picture
    wanted: NDArray[np.bool_]
    uv: Array
    half: int
    _templates: dict[int, Template | None] = field(default_factory=dict)

    def at(self, turn_rad: float) -> Template | None:
        """The template turned from the picture's u axis towards its v axis; None where too little
        of the place is to be seen."""
        step = round(turn_rad / STEP_RAD)
        if step not in self._templates:
            self._templates[step] = self._cut(step * STEP_RAD)
        return self._templates[step]

    def _cut(self, turn_rad: float) -> Template | None:
        side, middle = 2 * self.half + 1, float(self.half)
        c, s = np.cos(turn_rad), np.sin(turn_rad)
        back = np.array([[c, s], [-s, c]])  # from the template to the picture
        warp = np.column_stack([back, self.uv - back @ (middle, middle)])
        flags = cv2.WARP_INVERSE_MAP | cv2.INTER_LINEAR
        grey = cv2.warpAffine(
            np.ascontiguousarray(self.picture[..., 0]), warp, (side, side), flags=flags,
            borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        counts = ((self.picture[..., 3] == USABLE) & self.wanted).astype(np.float32)
        counts = cv2.warpAffine(counts, warp, (side, side), flags=flags)
        piece = np.zeros((side, side, 4), np.float32)
        piece[..., 0], piece[..., 3] = grey, np.where(counts > 0.5, USABLE, 0.0)
        return cut(piece, np.array([middle, middle]), self.half, counts > 0.5)
