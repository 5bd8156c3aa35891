"""Find where the weight of a person is, and the foot that carries it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from keypose.tracker.geometry.rotations import Array

SOLE_M: Final = 0.05
"""How much higher than the other a foot carries a third as much."""
MASSES: Final = {"shoulder": 0.406, "elbow": 0.1, "hip": 0.284, "knee": 0.15, "ankle": 0.06}
"""Of a body as shares at its joints: trunk and head between shoulders and hips, then arms, thighs
and shins (Winter, Biomechanics and Motor Control of Human Movement)."""


def centre_of_mass(joints: Mapping[str, Array]) -> Array:
    """(..., 3) by the joints that `MASSES` names, (..., 2, 3) left and right, metres."""
    parts = [mass * joints[joint].mean(axis=-2) for joint, mass in MASSES.items()]
    return np.asarray(np.sum(parts, axis=0))


def support(ankles: Array, up: Array) -> Array:
    """(..., 3) between the ankles (..., 2, 3), nearer to the lower one, metres."""
    high = ankles @ up
    weight = np.exp(-(high - high.min(axis=-1, keepdims=True)) / SOLE_M)
    weight = weight / weight.sum(axis=-1, keepdims=True)
    return np.asarray((weight[..., None] * ankles).sum(axis=-2))
