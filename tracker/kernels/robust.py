"""The robust kernels of the solvers, by number: see `keypose.tracker.solver.robust`."""

from __future__ import annotations

import math

from keypose.tracker.kernels import compiled

LEAST_SQUARES = 0
HUBER = 1
TUKEY = 2
CAUCHY = 3
"""Kinds of losses, as the compiled loops are told them."""


@compiled
def robust_loss(kind, width, away):
    """Twice the cost of a distance in standard deviations."""
    if kind == CAUCHY:
        return width * width * math.log1p(away * away / (width * width))
    if kind == HUBER and away > width:
        return width * (2 * away - width)
    if kind == TUKEY:
        inside = max(1 - away * away / (width * width), 0.0)
        return width * width / 3 * (1 - inside * inside * inside)
    return away * away


@compiled
def robust_weight(kind, width, away):
    """By what the square of a distance counts, for the same gradient."""
    if kind == CAUCHY:
        return 1 / (1 + away * away / (width * width))
    if kind == HUBER and away > width:
        return width / away
    if kind == TUKEY:
        inside = max(1 - away * away / (width * width), 0.0)
        return inside * inside
    return 1.0
