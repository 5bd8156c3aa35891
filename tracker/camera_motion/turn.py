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
"""Of the weights, on the way; then as the residuals' own spread is, within these."""
LEAST_SCALE_PX = 0.35
MOST_SCALE_PX = 1.0
STEPS_AT_END = 3
INLIER_PX = 1.0
"""A point agrees where its residual is below this, or below so many times the inliers' spread."""
INLIER_SPREADS = 3.0
START = Cauchy(4.0)
"""By which points bear out a start, pixels."""
START_SHARE = 0.5
"""A start is good where points bear it out to this share, or pairs are asked."""
GOOD_SHARE = 0.8
"""And so good here that no other is tried."""
PAIRS = 60
LEAST_NOISE_PX = 0.05
"""Below which no residual is believed."""
MOST_STEP = 0.3
"""Radians, and share of zoom."""


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
    directions: Array,
    seen: Array,
    focal_px: float,
    trust: Array,
    starts: Sequence[Turn],
    scales_px: Sequence[float] = SCALES_PX,
    shear: Shear | None = None,
) -> Solved | None:
    """Find the turn that shows directions (K, 3) where they are seen (K, 2), focal lengths from
    the centre. None with too few points, or where they do not tell it.

    trust: (K,) from 0 to 1.  scales_px: of the weights on the way.
    """
    if len(seen) < FEWEST:
        return None
    shifts = np.zeros((len(seen), 2, 0)) if shear is None else shear.shifts
    if shear is not None:
        seen = seen - shifts @ shear.share
    turn = _start(directions, seen, focal_px, trust, starts)
    scales = (*scales_px, *[None] * STEPS_AT_END)

    def step(turn: Turn, count: int) -> Array:
        residual, J = linearised(turn, directions, seen, focal_px)
        error = np.linalg.norm(residual, axis=1)
        scale_px = scales[count] or _spread(error, trust)
        return _step(residual, J, trust * GemanMcClure(scale_px).weight(error))

    criteria = replace(GAUSS_NEWTON, most_steps=len(scales), longest_step=MOST_STEP)
    solution = gauss_newton(step, Turn.moved, turn, criteria)
    if solution.end == "unsolvable":
        return None
    residual, J = linearised(solution.state, directions, seen, focal_px)
    return _solved(solution.state, residual, J, trust, shifts * focal_px)


def _solved(turn: Turn, residual: Array, J: Array, trust: Array, sheared: Array) -> Solved:
    error = np.linalg.norm(residual, axis=1)
    spread = _spread(error, trust)
    agrees = np.asarray(error < max(INLIER_PX, INLIER_SPREADS * spread / 2.5))
    weight = trust * GemanMcClure(spread).weight(error) * agrees
    squares = (weight * (error**2)).sum() / max(weight.sum(), 1e-9) / 2
    noise = max(float(np.sqrt(squares)), LEAST_NOISE_PX)
    every = np.concatenate([J, sheared], axis=2).reshape(2 * len(J), -1)
    weighted = (every * np.repeat(weight, 2)[:, None]).T / noise**2
    A, b = weighted @ every, weighted @ residual.reshape(-1)
    own = A[:4, :4] + 1e-9 * np.trace(A[:4, :4]) * np.eye(4)
    taken = np.linalg.solve(own, np.column_stack([A[:4, 4:], b[:4]]))  # what the turn takes up
    alone, pull = A[4:, 4:] - A[4:, :4] @ taken[:, :-1], b[4:] - A[4:, :4] @ taken[:, -1]
    return Solved(turn, residual, agrees, A[:4, :4], noise, pull, alone, -taken[:, :-1])


def _start(
    directions: Array,
    seen: Array,
    focal_px: float,
    trust: Array,
    starts: Sequence[Turn],
) -> Turn:
    score, best = -1.0, starts[0]
    for start in [*starts, _shifted(starts[0], directions, seen, trust)]:
        found = _score(start, directions, seen, focal_px, trust)
        if found > score:
            score, best = found, start
        if score >= GOOD_SHARE:
            break
    if score >= START_SHARE:
        return best
    for pair in _from_pairs(directions, seen, focal_px, best):
        found = _score(pair, directions, seen, focal_px, trust)
        if found > score + 1e-9:
            score, best = found, pair
    return best


def _shifted(turn: Turn, directions: Array, seen: Array, trust: Array) -> Turn:
    """The same, turned as the middle one of the points asks."""
    asked = (seen - turn.flat(directions))[trust >= np.median(trust)]
    asked = asked[np.isfinite(asked).all(axis=1)]
    if not len(asked):
        return turn
    right, down = np.median(asked, axis=0) / turn.zoom
    return turn.moved(np.array([-down, right, 0.0, 0.0]))


def _score(turn: Turn, directions: Array, seen: Array, focal_px: float, trust: Array) -> float:
    """The share of trust that lies where this turn shows it."""
    away_px = np.linalg.norm(turn.flat(directions) - seen, axis=1) * focal_px
    held = np.nan_to_num(START.weight(away_px), nan=0.0)
    return float((trust * held).sum() / max(trust.sum(), 1e-9))


def _from_pairs(directions: Array, seen: Array, focal_px: float, start: Turn) -> list[Turn]:
    """Turns that show two points each where they are seen; the same ones every time."""
    order = np.random.default_rng(0).integers(0, len(seen), (PAIRS, 2))
    apart = np.linalg.norm(seen[order[:, 0]] - seen[order[:, 1]], axis=1)
    order = order[apart > 0.3 * np.median(apart)]
    if not len(order):
        return []
    residual, J = linearised(start, directions, seen, focal_px)
    Jp = J[order].reshape(len(order), 4, 4)
    A = np.swapaxes(Jp, 1, 2) @ Jp
    A[:, np.arange(4), np.arange(4)] += 1e-6 * np.trace(A, axis1=1, axis2=2)[:, None] + 1e-9
    b = np.einsum("pij,pi->pj", Jp, residual[order].reshape(len(order), 4))
    steps = np.linalg.solve(A, b[..., None])[..., 0]
    sound = steps[(np.abs(steps) < MOST_STEP).all(axis=1)]
    return [start.moved(step) for step in sound]


def linearised(turn: Turn, directions: Array, seen: Array, focal_px: float) -> tuple[Array, Array]:
    """What is left to each point (K, 2), pixels, and how it follows the unknowns (K, 2, 4);
    points behind the camera have neither.
    """
    p = directions @ turn.R.T
    ahead = p[:, 2] > 1e-3
    q = p[:, :2] / np.where(ahead, p[:, 2], 1.0)[:, None]
    x, y = q[:, 0], q[:, 1]
    J = np.empty((len(q), 2, 4))
    J[:, 0, 0], J[:, 0, 1], J[:, 0, 2], J[:, 0, 3] = -x * y, 1 + x * x, -y, x
    J[:, 1, 0], J[:, 1, 1], J[:, 1, 2], J[:, 1, 3] = -1 - y * y, x * y, x, y
    residual = (seen - turn.zoom * q) * focal_px
    J *= turn.zoom * focal_px
    if not ahead.all():
        J[~ahead], residual[~ahead] = 0.0, 1e3
    return residual, J


def _spread(error: Array, trust: Array) -> float:
    """The scale of the weights: 2.5 times the noise along an axis, told by the nearest half."""
    trusted = error[trust > 0.5] if (trust > 0.5).sum() >= FEWEST else error
    noise = np.partition(trusted, len(trusted) // 2)[len(trusted) // 2] / 1.18
    return float(np.clip(2.5 * noise, LEAST_SCALE_PX, MOST_SCALE_PX))


def _step(residual: Array, J: Array, weight: Array) -> Array:
    """The step (4,) of turn and zoom, of residuals (K, 2), their slopes (K, 2, 4), weighed by
    (K,)."""
    weighted = (J * weight[:, None, None]).reshape(-1, 4).T
    A = weighted @ J.reshape(-1, 4)
    A.flat[::5] += 1e-9 * np.trace(A) + 1e-12
    return np.asarray(np.linalg.solve(A, weighted @ residual.reshape(-1)))
