"""How much a place of a surface counts: near contact, and where cameras disagree.

SURFACE §3. Both are soft switches, near 0 where there can be no counterpart, 1 elsewhere.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

PHOTO_SLOPE, PHOTO_MIDDLE = 12.0, 0.4
"""α_p and τ_p of SURFACE (3), for ZNCC of little noisy pictures."""
CONTACT_SLOPE = 6.0
"""α_c · τ_c: at twice the middle distance all counts."""
LEAST_SHARE = 0.1
"""Of a part's surface that counts at least, though all of it be in contact."""


def contact_weights(distance: Array, middle_m: float) -> Array:
    """ρ_c of signed distances to other parts, metres.  SURFACE (2)

    middle_m: τ_c, some three times the observed surface's resolution.
    """
    return _switch(CONTACT_SLOPE * (distance / middle_m - 1.0))


def photo_weights(consistency: Array) -> Array:
    """ρ_p of ZNCC −1 to 1.  SURFACE (3)"""
    return _switch(PHOTO_SLOPE * (consistency - PHOTO_MIDDLE))


def raise_to_floor(weights: Array, part: NDArray[np.int64], part_count: int) -> Array:
    """Weights (V,) raised where the points of a part (V,) would hardly count: a hand on the hip.

    All of a part are raised alike, so that what is least in contact still counts most.
    """
    count = np.maximum(np.bincount(part, minlength=part_count), 1)
    share = np.bincount(part, weights, part_count) / count
    lift = np.clip(LEAST_SHARE / np.maximum(share, 1e-12), 1.0, 1e3)
    return np.minimum(weights * lift[part], 1.0)


def _switch(x: Array) -> Array:
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(x, -60.0, 60.0))))
