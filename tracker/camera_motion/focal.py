"""Find the focal length of a camera from its own motion.

Two pictures between which a camera turned overlap in only one way, and the wrong focal length
leaves residuals that grow with the square of the distance from the centre. Turn, zoom and the
common focal length together are fitted to some pairs of pictures: the cost over a row of focal
lengths, its least by a parabola, its doubt by leaving pairs out. A distortion that the lens has and
the camera's numbers have not is taken for focal length in part.

Of a camera that moves the bundle of the first keyframes is adjusted with other focal lengths: with
a wrong one, no poses explain what is seen. Where its cost is least is the length, and how steeply
it rises from there says how sure that is. It is a proposal: where the camera's own number is far
off, points are lost that would show it. It holds where a path that is found with it shows no other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from keypose.tracker.camera_motion.bundle import Bundle, adjusted, cost_of, residual_lengths
from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.point_map import PointMap
from keypose.tracker.camera_motion.turn import SeenDirections, Solved, Turn, solve_turn
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.robust import GemanMcClure

MOST_PAIRS = 24
"""Pairs that are asked, those farthest apart: a bound on the time."""
LEAST_DISPLACEMENT = 0.04
"""Way of the picture between a pair, as a share of its width, below which it says nothing."""
GRID = np.linspace(-0.8, 0.8, 17)
"""Logarithms of the focal lengths tried, as a multiple of the camera's."""
NEARER = (0.08, 0.02)
"""And then to either side of the best."""
NOISE_PX = 0.5
"""Scale of the cost, pixels of the picture looked at."""
MUCH_PX = 1e3
"""Residual of a point that a focal length does not explain."""
MOST_DOUBT = 0.05
"""Standard deviation, as a share, above which nothing is said."""
ASIDE_PX = 0.6
"""A point is aside where the best focal length leaves it so much, pixels looked at."""

# of a camera that moves
KEYFRAMES = 20
"""From which it is learned at most, the first ones: a bound on the time."""
FEWEST_KEYFRAMES = 4
"""Without which nothing is said."""
WIDTHS = (0.12, 0.04, 0.015)
"""To either side of the best logarithm: first roughly, then nearer."""
STEPS = 8
"""Of an adjustment with each focal length."""
ASIDE = 4.0
"""Standard deviations; a point that is farther off is left aside."""
FARTHEST = 0.6
"""Logarithm; what would be farther is not believed."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Points uv (K, 2) of a picture and where they are in a later one, uv_later (K, 2), pixels of
    the film; the zooms of both, and by what share of its width the picture was displaced.
    """

    uv: Array
    uv_later: Array
    zooms: tuple[float, float]
    displacement: float


@dataclass(frozen=True)
class FocalScale:
    """The focal length as a multiple of the camera's, its standard deviation, and the share of
    points that it leaves beside where they should be.
    """

    scale: float
    sigma: float
    aside: float


def focal_scale(lens: Lens, scale: float, pairs: Sequence[Pair]) -> FocalScale | None:
    """Find the focal length from pairs of pictures; None where it is not
    observable.

    scale: from pixels of the film to those in which noise is known.
    """
    wide = (pair for pair in pairs if pair.displacement >= LEAST_DISPLACEMENT)
    chosen = sorted(wide, key=lambda pair: -pair.displacement)[:MOST_PAIRS]
    if not chosen:
        return None
    looked, near = _Looked(lens, scale), GRID
    for reach in (*NEARER, 0.0):
        costs = np.stack([_costs(looked, pair, near) for pair in chosen])
        best = near[costs.sum(axis=0).argmin()]
        if best in (GRID[0], GRID[-1]):
            return None
        if reach:
            near = best + np.linspace(-reach, reach, 5)
    noise = [_noise(looked, pair, best) for pair in chosen]
    costs = costs * (NOISE_PX / np.array(noise))[:, None] ** 2
    least = _least(near, costs.sum(axis=0))
    if least is None:
        return None
    at, sigma = least[0], max(least[1], _by_leaving_out(near, costs, least[0]))
    if sigma > MOST_DOUBT:
        return None
    residuals_px = np.concatenate([_residuals_px(looked, pair, at) for pair in chosen])
    return FocalScale(float(np.exp(at)), sigma, float((residuals_px > ASIDE_PX).mean()))


@dataclass(frozen=True, eq=False)
class _Looked:
    """A lens, and from pixels of its film to those looked at."""

    lens: Lens
    scale: float


def _costs(lens: _Looked, pair: Pair, logs: Array) -> Array:
    """The costs of focal lengths' logarithms, all of one scale, so that they are smooth."""
    residuals_px = np.stack([_residuals_px(lens, pair, log) for log in logs])
    return np.asarray((GemanMcClure(NOISE_PX).loss(residuals_px) / NOISE_PX**2).sum(axis=1))


def _noise(lens: _Looked, pair: Pair, log: float) -> float:
    """The standard deviation of what a focal length leaves of its points, pixels looked at."""
    solved = _solved(lens, pair, log)
    return NOISE_PX if solved is None else max(NOISE_PX / 2, solved.noise_px)


def _residuals_px(lens: _Looked, pair: Pair, log: float) -> Array:
    """What a focal length leaves of each point (K,), pixels looked at; much where it explains
    none."""
    solved = _solved(lens, pair, log)
    if solved is None:
        return np.full(len(pair.uv), MUCH_PX)
    return np.asarray(np.linalg.norm(solved.residual_px, axis=1))


def _solved(lens: _Looked, pair: Pair, log: float) -> Solved | None:
    """The turn between a pair, were the lens so many times as long."""
    tried, (zoom, zoom_later) = lens.lens.scaled(float(np.exp(log))), pair.zooms
    directions = tried.directions(pair.uv, zoom)
    observed = tried.flat(pair.uv_later, zoom_later) / zoom
    start = [Turn(np.eye(3), zoom_later / zoom)]
    focal_px = tried.focal_px * lens.scale * zoom
    return solve_turn(SeenDirections.trusted(directions, observed, focal_px), start)


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
    aside = [MOST_DOUBT if minimum is None else minimum[0] - at for minimum in least]
    return float(np.sqrt((count - 1) / count * np.sum(np.square(aside))))


def focal_of_map(point_map: PointMap) -> FocalScale | None:
    """Find the focal length from the map of a camera that moves; None where it is
    not observable."""
    if not point_map.has_depths or len(point_map.keyframes) < FEWEST_KEYFRAMES:
        return None
    bundle_of_first = point_map.bundle(range(min(len(point_map.keyframes), KEYFRAMES)), 1)
    if bundle_of_first is None:
        return None
    bundle, log, sd = bundle_of_first[0], 0.0, np.inf
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
    aside = float((residual_lengths(adjusted(_with(bundle, log), STEPS)[0]) > ASIDE).mean())
    return FocalScale(float(np.exp(log)), sd, aside)


def _with(bundle: Bundle, log: float) -> Bundle:
    """The bundle as a lens shows it that is exp(log) times as long."""
    by = np.exp(-log)
    return replace(bundle, rays=by * bundle.rays, xy=by * bundle.xy, noise=by * bundle.noise)
