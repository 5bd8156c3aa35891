"""Find the focal length of a camera from its own turning.

Two pictures that a camera took between which it turned by a known angle overlap in only one way,
and the wrong focal length leaves residuals that grow with the square of the distance from the
centre. Turn, zoom and the common focal length together are fitted to some pairs of pictures: the
cost over a row of focal lengths, its least by a parabola, its doubt by leaving pairs out.
A distortion that the lens has and the camera's numbers have not is taken for focal length in part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.turn import Solved, Turn, solve_turn
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.robust import GemanMcClure

MOST_PAIRS = 24
LEAST_AWAY = 0.04
"""Way of the picture between a pair, as a share of its width, below which it says nothing."""
GRID = np.linspace(-0.8, 0.8, 17)
"""Logarithms of the focal lengths tried, and then so much nearer to the best."""
NEARER = (0.08, 0.02)
NOISE_PX = 0.5
"""Of the cost's scale, size looked at."""
MUCH_PX = 1e3
MOST_DOUBT = 0.05
"""Standard deviation, as a share, above which nothing is said."""
ASIDE_PX = 0.6
"""A point is aside where the best focal length leaves it so much."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Points (K, 2) of one picture and where they are in another, pixels of the film; the zooms,
    and by what share of the width the picture went between.
    """

    one: Array
    other: Array
    zooms: tuple[float, float]
    away: float


@dataclass(frozen=True)
class FocalScale:
    """The focal length as a multiple of the camera's, its standard deviation, and the share of
    points that it leaves beside where they should be.
    """

    scale: float
    sigma: float
    aside: float


def focal_scale(lens: Lens, look: float, pairs: Sequence[Pair]) -> FocalScale | None:
    """Find the focal length from pairs of pictures; None where they do not tell it.

    look: from pixels of the film to those in which noise is known.
    """
    chosen = sorted((p for p in pairs if p.away >= LEAST_AWAY), key=lambda p: -p.away)[:MOST_PAIRS]
    if not chosen:
        return None
    near = GRID
    for reach in (*NEARER, 0.0):
        costs = np.stack([_costs(lens, look, pair, near) for pair in chosen])
        best = near[costs.sum(axis=0).argmin()]
        if best in (GRID[0], GRID[-1]):
            return None
        if reach:
            near = best + np.linspace(-reach, reach, 5)
    noise = [_noise(lens, look, pair, best) for pair in chosen]
    costs = costs * (NOISE_PX / np.array(noise))[:, None] ** 2
    found = _least(near, costs.sum(axis=0))
    if found is None:
        return None
    at, sigma = found[0], max(found[1], _by_leaving_out(near, costs, found[0]))
    if sigma > MOST_DOUBT:
        return None
    left = np.concatenate([_left(lens, look, pair, at) for pair in chosen])
    return FocalScale(float(np.exp(at)), sigma, float((left > ASIDE_PX).mean()))


def _costs(lens: Lens, look: float, pair: Pair, logs: Array) -> Array:
    """The costs of focal lengths' logarithms, all of one scale, so that they are smooth."""
    left = np.stack([_left(lens, look, pair, log) for log in logs])
    return np.asarray((GemanMcClure(NOISE_PX).loss(left) / NOISE_PX**2).sum(axis=1))


def _noise(lens: Lens, look: float, pair: Pair, log: float) -> float:
    """The standard deviation of what a focal length leaves of its points, pixels looked at."""
    solved = _solved(lens, look, pair, log)
    return NOISE_PX if solved is None else max(NOISE_PX / 2, solved.noise_px)


def _left(lens: Lens, look: float, pair: Pair, log: float) -> Array:
    """What a focal length leaves of each point (K,), pixels looked at; much where it explains
    none."""
    solved = _solved(lens, look, pair, log)
    if solved is None:
        return np.full(len(pair.one), MUCH_PX)
    return np.asarray(np.linalg.norm(solved.residual_px, axis=1))


def _solved(lens: Lens, look: float, pair: Pair, log: float) -> Solved | None:
    tried, (zoom, other) = lens.scaled(float(np.exp(log))), pair.zooms
    directions = tried.directions(pair.one, zoom)
    seen = tried.flat(pair.other, other) / zoom
    start = [Turn(np.eye(3), other / zoom)]
    focal_px = tried.focal_px * look * zoom
    return solve_turn(directions, seen, focal_px, np.ones(len(seen)), start)


def _least(logs: Array, costs: Array) -> tuple[float, float] | None:
    """Where a parabola through costs is least, and its standard deviation there."""
    curve, slope, _ = np.polyfit(logs - logs.mean(), costs, 2)
    if curve <= 0:
        return None
    at = -slope / 2 / curve
    if abs(at) > 2 * np.ptp(logs):
        return None
    return float(at + logs.mean()), float(1 / np.sqrt(curve))


def _by_leaving_out(logs: Array, costs: Array, at: float) -> float:
    """The standard deviation of the least by the jackknife over pairs (P, G); 0 for one pair."""
    count = len(costs)
    if count < 2:
        return 0.0
    least = [_least(logs, costs.sum(axis=0) - own) for own in costs]
    aside = [MOST_DOUBT if one is None else one[0] - at for one in least]
    return float(np.sqrt((count - 1) / count * np.sum(np.square(aside))))
