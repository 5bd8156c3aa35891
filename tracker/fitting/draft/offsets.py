"""How far beside a body's joints a network puts them, as far as posed frames show.

A network puts an elbow beside where the arm bends, mostly one way throughout a film. A posed frame
is not exact itself: what is learned from one is believed by half, from several by more.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from keypose.tracker.geometry.rotations import Array

PLACE_M: Final = 0.019
"""Standard deviation of a keypoint's place on its part, along each axis."""
POSED_PX, SHAKES_M = 4.5, 0.01
"""How exactly somebody poses a joint in the picture, and by how much a keypoint shakes."""
DEPTH_M: Final = 0.136
"""Standard deviation of a keypoint's depth beside the root's."""
POSED_DEPTH_M: Final = 0.06
"""How exactly somebody poses that."""


def learned_place(slopes: Array, missed_px: Array, pixel_m: Array) -> Array:
    """(3,) where on its part a keypoint is beside its joint, metres.

    slopes (R, 2, 3): pixels by metre in the part's axes, in R posed frames.  missed_px (R, 2): from
    the joint to the keypoint.  pixel_m (R,): metres there.
    """
    known = 1 / ((SHAKES_M / pixel_m) ** 2 + POSED_PX**2)
    weighted = np.swapaxes(slopes, -1, -2) * known[:, None, None]
    A = np.eye(3) / PLACE_M**2 + (weighted @ slopes).sum(axis=0)
    return np.asarray(np.linalg.solve(A, (weighted @ missed_px[..., None]).sum(axis=0)[:, 0]))


def learned_depth(missed_m: Array) -> float:
    """Return what a keypoint's depth lacks, metres; missed_m (R,): in R posed frames."""
    return float(missed_m.sum() / (len(missed_m) + (POSED_DEPTH_M / DEPTH_M) ** 2))
