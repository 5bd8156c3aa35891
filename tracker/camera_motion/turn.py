"""Find how a camera is turned and zoomed from directions that are known and where they are seen.

A direction d (in a frame of reference) is seen at zoom · (R d)_xy / (R d)_z. The four unknowns,
a small turn on the left of R and the logarithm of the zoom, are found by Gauss–Newton with the
weights of Geman and McClure, whose scale becomes smaller from step to step: what is far from what
most points say ends without weight. The start is the best of those given and, where none explains
the points, of pairs of points, so that something large that moves by itself does not win by size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.gauss_newton import GAUSS_NEWTON, gauss_newton
from keypose.tracker.solver.robust import Cauchy, GemanMcClure

FEWEST = 6
"""Points that four unknowns are found from."""
SCALES_PX = (6.0, 3.0, 1.5)
"""Of the weights on the way, from step to step; then as the residuals' own spread is."""
LEAST_SCALE_PX = 0.35
MOST_SCALE_PX = 1.0
"""Within which the scale by the residuals' spread stays."""
STEPS_AT_END = 3
"""Steps with that scale."""
INLIER_PX = 1.0
"""A point agrees where its residual is below this."""
INLIER_SPREADS = 3.0
"""Or below so many times the inliers' standard deviation."""
SPREAD_SIGMAS = 2.5
"""The scale of the weights, in standard deviations of the noise along an axis."""
MEDIAN_OF_TWO = 1.18
"""The median length of two standard normal numbers."""
START = Cauchy(4.0)
"""By which points bear out a start, pixels."""
START_SHARE = 0.5
"""A start is good where points bear it out to this share, or pairs are asked."""
GOOD_SHARE = 0.8
"""And so good here that no other is tried."""
PAIRS = 60
"""Pairs of points that are asked: of 60, when half of the points are right, 15 are."""
LEAST_APART = 0.3
"""Of the pairs' median distance, below which a pair tells no roll and no zoom."""
LEAST_NOISE_PX = 0.05
"""Below which no residual is believed."""
BEHIND_PX = 1e3
"""Residual of a point behind the camera."""
MOST_STEP = 0.3
"""Radians, and share of zoom: a longer step leads beyond where slopes hold."""


_EYE = np.eye(3)


@dataclass(frozen=True, eq=False)
class Turn:
    """How a camera is turned (3, 3), from a frame of reference into its own, and its zoom."""

    R: Array
    zoom: float

    @classmethod
    def none(cls) -> Turn:
        return cls(np.eye(3), 1.0)

    def then(self, turn: Turn) -> Turn:
        """The turn that leads to `turn` from the frame of reference that this one ends in."""
        return Turn(turn.R @ self.R, turn.zoom * self.zoom)

    def inverse(self) -> Turn:
        return Turn(self.R.T, 1.0 / self.zoom)

    def moved(self, step: Array) -> Turn:
        """Turned on by step[:3] radians and zoomed by exp(step[3]), made orthogonal to rounding:
        its error would double with every frame that is predicted from the two before.
        """
        R = cv2.Rodrigues(step[:3])[0] @ self.R  # ten times as quick as ours for one
        R = R @ (1.5 * _EYE - 0.5 * R.T @ R)
        return Turn(R, float(self.zoom * np.exp(step[3])))

    @property
    def rotation(self) -> Array:
        """(3,) the axis times the angle, radians: ten times as quick as ours for one."""
        return np.asarray(cv2.Rodrigues(self.R)[0][:, 0])

    def rotated(self, directions: Array) -> Array:
        """Directions (K, 3) of the frame of reference in the camera's own."""
        return np.asarray(directions @ self.R.T)

    def flat(self, directions: Array) -> Array:
        """Where directions (K, 3) are seen, (K, 2) focal lengths from the centre; NaN behind."""
        p = directions @ self.R.T
        z = np.where(p[:, 2:] > 1e-3, p[:, 2:], np.nan)
        return np.asarray(self.zoom * p[:, :2] / z)


@dataclass(frozen=True, eq=False)
class SeenDirections:
    """K directions of a frame of reference, and where a camera sees them.

    directions (K, 3).  xy (K, 2): focal lengths from the centre.  focal_px: of the pixels in which
    residuals count.  trust (K,): from 0 to 1.
    """

    directions: Array
    xy: Array
    focal_px: float
    trust: Array

    @classmethod
    def trusted(cls, directions: Array, xy: Array, focal_px: float) -> SeenDirections:
        """All trusted alike."""
        return cls(directions, xy, focal_px, np.ones(len(xy)))

    def __len__(self) -> int:
        return len(self.xy)


@dataclass(frozen=True, eq=False)
class Shear:
    """What a picture is sheared by: shifts (K, 2, S) of points in focal lengths for each of S
    numbers, and these (S,) as far as they are known.
    """

    shifts: Array
    share: Array


@dataclass(frozen=True, eq=False)
class Solved:
    """A turn, and how the points bear it out.

    residual_px (K, 2), large for points behind.  agrees (K,).  information (4, 4), inverse
    covariance of a small turn (radians) and the logarithm of the zoom.  noise_px: one standard
    deviation of the inliers.  pull (S,) and pull_information (S, S): what the points say of the
    numbers of a shear, the turn being unknown: by how much these should change, times information.
    lever (4, S): how the turn and the zoom follow them.
    """

    turn: Turn
    residual_px: Array
    agrees: NDArray[np.bool_]
    information: Array
    noise_px: float
    pull: Array
    pull_information: Array
    lever: Array

    @property
    def agreeing(self) -> int:
        return int(self.agrees.sum())

    def covariance(self, systematic: float) -> Array:
        """The covariance (4, 4) of the turn, radians, and of the logarithm of the zoom, with what
        the points have in common and no spread shows, radians."""
        scale = max(np.trace(self.information), 1e-12)
        floor = (systematic**2 + 1e-16) * np.eye(4)
        return np.asarray(np.linalg.inv(self.information + 1e-12 * scale * np.eye(4)) + floor)


def solve_turn(
    points: SeenDirections,
    starts: Sequence[Turn],
    scales_px: Sequence[float] = SCALES_PX,
    shear: Shear | None = None,
) -> Solved | None:
    """Find the turn that shows directions where they are seen; None with too few of them, or where
    it is not observable.

    Args:
        points: the directions.
        starts: turns to begin with, the likeliest first; one at least.
        scales_px: of the weights on the way.
        shear: of the picture, where that is read row after row.
    """
    if len(points) < FEWEST:
        return None
    shifts = np.zeros((len(points), 2, 0)) if shear is None else shear.shifts
    if shear is not None:
        points = replace(points, xy=points.xy - shifts @ shear.share)
    scales = (*scales_px, *[None] * STEPS_AT_END)

    def step(turn: Turn, count: int) -> Array:
        residual, J = linearised(turn, points)
        error = np.linalg.norm(residual, axis=1)
        scale_px = scales[count] or _spread(error, points.trust)
        return _step(residual, J, points.trust * GemanMcClure(scale_px).weight(error))

    criteria = replace(GAUSS_NEWTON, most_steps=len(scales), longest_step=MOST_STEP)
    solution = gauss_newton(step, Turn.moved, _start(points, starts), criteria)
    return None if solution.end == "unsolvable" else _solved(solution.state, points, shifts)


def _solved(turn: Turn, points: SeenDirections, shifts: Array) -> Solved:
    """How the points bear a turn out, and what they say of S numbers that shift them by (K, 2,
    S), focal lengths."""
    (residual, J), trust = linearised(turn, points), points.trust
    error = np.linalg.norm(residual, axis=1)
    spread = _spread(error, trust)
    agrees = np.asarray(error < max(INLIER_PX, INLIER_SPREADS * spread / SPREAD_SIGMAS))
    weight = trust * GemanMcClure(spread).weight(error) * agrees
    squares = (weight * (error**2)).sum() / max(weight.sum(), 1e-9) / 2
    noise = max(float(np.sqrt(squares)), LEAST_NOISE_PX)
    every = np.concatenate([J, shifts * points.focal_px], axis=2).reshape(2 * len(J), -1)
    weighted = (every * np.repeat(weight, 2)[:, None]).T / noise**2
    A, b = weighted @ every, weighted @ residual.reshape(-1)
    own = A[:4, :4] + 1e-9 * np.trace(A[:4, :4]) * np.eye(4)
    taken = np.linalg.solve(own, np.column_stack([A[:4, 4:], b[:4]]))  # what the turn takes up
    alone, pull = A[4:, 4:] - A[4:, :4] @ taken[:, :-1], b[4:] - A[4:, :4] @ taken[:, -1]
    return Solved(turn, residual, agrees, A[:4, :4], noise, pull, alone, -taken[:, :-1])


def _start(points: SeenDirections, starts: Sequence[Turn]) -> Turn:
    """The turn that explains most points: one of the starts, or else one by a pair of points."""
    score, best = -1.0, starts[0]
    for start in [*starts, _shifted(starts[0], points)]:
        its_score = _score(start, points)
        if its_score > score:
            score, best = its_score, start
        if score >= GOOD_SHARE:
            break
    if score >= START_SHARE:
        return best
    for turn in _from_pairs(points, best):
        its_score = _score(turn, points)
        if its_score > score + 1e-9:
            score, best = its_score, turn
    return best


def _shifted(turn: Turn, points: SeenDirections) -> Turn:
    """The same, turned as the middle one of the points asks."""
    asked = (points.xy - turn.flat(points.directions))[points.trust >= np.median(points.trust)]
    asked = asked[np.isfinite(asked).all(axis=1)]
    if not len(asked):
        return turn
    right, down = np.median(asked, axis=0) / turn.zoom
    return turn.moved(np.array([-down, right, 0.0, 0.0]))


def _score(turn: Turn, points: SeenDirections) -> float:
    """The share of trust that lies where this turn shows it."""
    away_px = np.linalg.norm(turn.flat(points.directions) - points.xy, axis=1) * points.focal_px
    held = np.nan_to_num(START.weight(away_px), nan=0.0)
    return float((points.trust * held).sum() / max(points.trust.sum(), 1e-9))


def _from_pairs(points: SeenDirections, start: Turn) -> list[Turn]:
    """Turns that show two points each where they are seen; the same ones every time."""
    order = np.random.default_rng(0).integers(0, len(points), (PAIRS, 2))
    apart = np.linalg.norm(points.xy[order[:, 0]] - points.xy[order[:, 1]], axis=1)
    order = order[apart > LEAST_APART * np.median(apart)]
    if not len(order):
        return []
    residual, J = linearised(start, points)
    Jp = J[order].reshape(len(order), 4, 4)
    A = np.swapaxes(Jp, 1, 2) @ Jp
    A[:, np.arange(4), np.arange(4)] += 1e-6 * np.trace(A, axis1=1, axis2=2)[:, None] + 1e-9
    b = np.einsum("pij,pi->pj", Jp, residual[order].reshape(len(order), 4))
    steps = np.linalg.solve(A, b[..., None])[..., 0]
    sound = steps[(np.abs(steps) < MOST_STEP).all(axis=1)]
    return [start.moved(step) for step in sound]


def linearised(turn: Turn, points: SeenDirections) -> tuple[Array, Array]:
    """What is left to each point (K, 2), pixels, and how it follows the unknowns (K, 2, 4);
    points behind the camera have neither.
    """
    p = points.directions @ turn.R.T
    ahead = p[:, 2] > 1e-3
    q = p[:, :2] / np.where(ahead, p[:, 2], 1.0)[:, None]
    x, y = q[:, 0], q[:, 1]
    J = np.empty((len(q), 2, 4))
    J[:, 0, 0], J[:, 0, 1], J[:, 0, 2], J[:, 0, 3] = -x * y, 1 + x * x, -y, x
    J[:, 1, 0], J[:, 1, 1], J[:, 1, 2], J[:, 1, 3] = -1 - y * y, x * y, x, y
    residual = (points.xy - turn.zoom * q) * points.focal_px
    J *= turn.zoom * points.focal_px
    if not ahead.all():
        J[~ahead], residual[~ahead] = 0.0, BEHIND_PX
    return residual, J


def _spread(error: Array, trust: Array) -> float:
    """The scale of the weights by the noise along an axis, by the nearest half."""
    trusted = error[trust > 0.5] if (trust > 0.5).sum() >= FEWEST else error
    noise = np.partition(trusted, len(trusted) // 2)[len(trusted) // 2] / MEDIAN_OF_TWO
    return float(np.clip(SPREAD_SIGMAS * noise, LEAST_SCALE_PX, MOST_SCALE_PX))


def _step(residual: Array, J: Array, weight: Array) -> Array:
    """The step (4,) of turn and zoom, of residuals (K, 2), their slopes (K, 2, 4), weighed by
    (K,)."""
    weighted = (J * weight[:, None, None]).reshape(-1, 4).T
    A = weighted @ J.reshape(-1, 4)
    A.flat[::5] += 1e-9 * np.trace(A) + 1e-12
    return np.asarray(np.linalg.solve(A, weighted @ residual.reshape(-1)))
