"""The jerk that limbs keyed alone ask for themselves.

Where they are keyed close together and disagree, mostly in depth, of which a picture shows little,
no motion through them is smooth. Asked for nevertheless, smoothness would take elbows and knees
from where they were seen, even where they were keyed. So a limb is granted as much jerk as the
smoothest way has through the frames at which it is exact.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Final

import numpy as np

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.tracking.parts.keyed import KeyedParts

FEWEST: Final = 4
"""Frames that ask for any jerk: through three goes a steady push."""
NATURAL: Final = [(3, (0.0, 0.0, 0.0)), (4, (0.0, 0.0, 0.0))]
"""Derivatives at both ends of a quintic spline, with which it has the least jerk of all ways."""


def with_jerk_of_keyed(
    sigma: Array, points: BodyPoints, motion: Trajectory, keyframes: Collection[int],
    keyed: Sequence[KeyedParts], frames_per_second: float,
) -> Array:  # fmt: skip
    """Standard deviations of jerk, (K,) or (N − 3, K) of N frames, widened where keyed limbs ask
    for more; the same array where none does.

    points: single ones, K.  motion: as tracked, through all exact frames.  keyframes: of the whole
    body, exact.
    """
    p_camera, whole = points.at(motion.transforms(points.skeleton)), set(keyframes)
    asked = np.zeros((len(motion) - 3, len(points.points)))
    for k, ((part, _),) in enumerate(points.points):
        own = {each.frame for each in keyed if part in each.parts}
        if own:
            rows = np.array(sorted(whole | own)) - motion.first_frame
            asked[:, k] = _asked(p_camera[:, k], rows) * frames_per_second**3
    return np.maximum(sigma, asked) if (asked > sigma).any() else sigma


def _asked(p: Array, rows: Array) -> Array:
    """(N − 3,) third differences of the smoothest way through a point's places (N, 3) at rows."""
    from scipy.interpolate import make_interp_spline  # loads longer than a page needs to start

    asked = np.zeros(len(p) - 3)
    if len(rows) >= FEWEST:
        way = make_interp_spline(rows, p[rows], k=5, bc_type=(NATURAL, NATURAL))
        places = way(np.arange(rows[0], rows[-1] + 1))
        asked[rows[0] : rows[-1] - 2] = np.linalg.norm(np.diff(places, 3, axis=0), axis=-1)
    return asked
