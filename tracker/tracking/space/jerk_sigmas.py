"""How much jerk the parts of a body have in life: standard deviations for `Jerk`."""

from __future__ import annotations

from typing import Final

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.body_points import BodyPoint, BodyPoints

SIGMAS: Final = {
    "waist": 225.0,
    "chest": 350.0,
    "neck": 350.0,
    "head": 350.0,
    "upper_arm": 250.0,
    "forearm": 500.0,
    "hand": 750.0,
    "thigh": 400.0,
    "shin": 800.0,
    "foot": 1200.0,
}
"""m/s³ at a part's joint, by its name without its side; wide enough for throws, kicks and jumps."""
OTHER: Final = 750.0
"""Of all other parts: of things that a hand moves."""


def jerk_points(skeleton: Skeleton) -> tuple[BodyPoints, Array]:
    """The joints of a body and its landmarks, and the sigmas (K,) of each, m/s³."""
    places: list[BodyPoint] = []
    sigmas = []
    for i, part in enumerate(skeleton.body.parts):
        sigma = SIGMAS.get(part.name.removeprefix("left_").removeprefix("right_"), OTHER)
        for p in ((0.0, 0.0, 0.0), *part.landmarks.values()):
            places.append(((i, p),))
            sigmas.append(sigma)
    return BodyPoints(skeleton, tuple(places)), np.array(sigmas)
