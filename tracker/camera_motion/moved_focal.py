"""Learn the focal length from a camera that moves: with another, no place explains what is seen.

The bundle of the first views is adjusted with other focal lengths; where its cost is least is the
length, and how steeply it rises from there says how sure that is. It is a proposal: where the
camera's own number is far off, points are lost that would have told. It holds where a path that is
found again with it tells no other.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from keypose.tracker.camera_motion.bundle import Bundle, adjusted, away, cost_of
from keypose.tracker.camera_motion.focal import FocalScale
from keypose.tracker.camera_motion.view_map import ViewMap

VIEWS = 20
"""From which it is learned at most, the first ones."""
FEWEST_VIEWS = 4
WIDTHS = (0.12, 0.04, 0.015)
"""Of the logarithm to either side: first roughly, then nearer."""
STEPS = 8
ASIDE = 4.0
"""Standard deviations; a point that is farther off is left aside."""
FARTHEST = 0.6
"""Of the logarithm; what would be farther is not believed."""


def focal_of(map_: ViewMap) -> FocalScale | None:
    """How many times longer the focal length is than was said; None where that is not told."""
    if not map_.known or len(map_.views) < FEWEST_VIEWS:
        return None
    found = map_.bundle(range(min(len(map_.views), VIEWS)), 1)
    if found is None:
        return None
    bundle, log, sd = found[0], 0.0, np.inf
    for width in WIDTHS:
        costs = []
        for side in (-1, 0, 1):
            tried = adjusted(_with(bundle, log + side * width), STEPS)[0]
            costs.append(cost_of(tried))
        bend = costs[0] - 2 * costs[1] + costs[2]
        if bend <= 0.0:
            return None
        # the cost is half that of squares in standard deviations: it rises by ½ within one
        sd = width * float(np.sqrt(1 / bend))
        log += float(np.clip(0.5 * width * (costs[0] - costs[2]) / bend, -2 * width, 2 * width))
        if abs(log) > FARTHEST:
            return None
    aside = float((away(adjusted(_with(bundle, log), STEPS)[0]) > ASIDE).mean())
    return FocalScale(float(np.exp(log)), sd, aside)


def _with(bundle: Bundle, log: float) -> Bundle:
    """The bundle as a lens shows it that is exp(log) times as long."""
    by = np.exp(-log)
    return replace(bundle, rays=by * bundle.rays, xy=by * bundle.xy, noise=by * bundle.noise)
