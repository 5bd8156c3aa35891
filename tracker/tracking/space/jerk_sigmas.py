"""How much jerk the parts of a body have in life: standard deviations for `Jerk`."""

from __future__ import annotations

from typing import Final

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import BodyPoint, BodyPoints
from keypose.tracker.tracking.space.contacts import speed_m_s

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
FOOT: Final = "foot"
FAST_M_S, LEAST_SHARE, NEAR_S = 2.0, 0.2, 0.1
"""A foot has its jerk at this speed and above, a slower one as much less as it is slower, but no
less than this share: what stands does not jerk, whatever the tracker's noise. Of the speeds within
so many seconds the highest counts, so that a landing is as sharp as the step before it."""


def parts_of_known_jerk(body: Body) -> set[str]:
    """Names of a person's own parts, not of what a hand holds. Without feet, whose turns shape the
    swing of a leg: were they free, a fast foot would lose some of its peak speed."""
    return {name for name in body.names if _bare(name) in SIGMAS and _bare(name) != FOOT}


def jerk_points(
    skeleton: Skeleton, motion: Trajectory, frames_per_second: float
) -> tuple[BodyPoints, Array]:
    """The joints of a body and its landmarks, and their sigmas, m/s³: (K,), or (N − 3, K) of every
    third difference of the motion as tracked, N frames, where the body has feet."""
    places: list[BodyPoint] = []
    names = []
    for i, part in enumerate(skeleton.body.parts):
        for p in ((0.0, 0.0, 0.0), *part.landmarks.values()):
            places.append(((i, p),))
            names.append(_bare(part.name))
    points = BodyPoints(skeleton, tuple(places))
    sigma = np.array([SIGMAS.get(name, OTHER) for name in names])
    feet = np.array([name == FOOT for name in names])
    if not feet.any():
        return points, sigma
    share = np.ones((len(motion) - 3, len(names)))
    p_camera = points.at(motion.transforms(skeleton))
    for k in np.flatnonzero(feet):
        share[:, k] = _share(speed_m_s(p_camera[:, k], frames_per_second), frames_per_second)
    return points, sigma * share


def _bare(name: str) -> str:
    """Without its side."""
    return name.removeprefix("left_").removeprefix("right_")


def _share(speed: Array, frames_per_second: float) -> Array:
    """(N − 3,) of the jerk of a fast foot, by a foot's speed (N,) m/s; a difference is that of the
    four frames it is made of."""
    near = max(1, round(NEAR_S * frames_per_second))
    padded = np.pad(speed, near, mode="edge")
    highest = np.lib.stride_tricks.sliding_window_view(padded, 2 * near + 4).max(axis=1)
    return np.asarray(np.clip(highest / FAST_M_S, LEAST_SHARE, 1.0))
