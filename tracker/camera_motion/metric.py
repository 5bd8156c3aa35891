"""Find how long a path's unit is, in metres, by the body: feet that stand, or how it moves.

Pictures show where a camera went up to scale. A body that is tracked is known in metres, in
the camera's frame of every frame. While a foot stands, its place in the world is one:
R p + s c is the same at all its frames, where the camera was at c in the path's unit, is turned by
R and sees the foot at p. That is linear in s and in the feet's places.

A hand that holds a camera shakes, and a body does not shake with it: the right s also leaves R p +
s c of any part of the body the least acceleration. That is known less surely than from feet that
stand, which it helps to find.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.robust import GemanMcClure

ACROSS_M = 0.01
ALONG_M = 0.05
"""Standard deviations of a foot's place as tracked, across the line of sight and along it: only
their ratio matters to the scale."""
ROUNDS = 20
"""Of weighing anew what remains: by then no digit that matters changes."""
STANCE_WIDTH = 3.0
"""Times the median distance of feet from where they stand, at which they count a quarter."""
MEDIAN_OF_THREE = 1.538
"""The median length of three standard normal numbers."""
LEAST_SURE = 0.2
"""Standard deviation of the scale by feet, as a share of it, above which it is not known."""
ALONG_SHARE = 0.05
"""How much acceleration along the view counts, which is tracked less surely."""
ACCELERATION_WIDTH = 2.0
"""Times the median acceleration at which one counts a quarter."""
ALIKE = 3.0
"""Neighbouring frames err alike: so many count as one."""
LEAST_SURE_SMOOTH = 0.35
"""Standard deviation of the scale by smoothness, as a share of it, above which it is not known."""
FEWEST_FRAMES = 8
"""Of a motion whose accelerations are looked at."""


@dataclass(frozen=True, eq=False)
class StandingPoint:
    """A point of the body that stands still in the world.

    p_camera: (n, 3) metres, in the camera's frame at `first_frame` and those that follow.
    """

    first_frame: int
    p_camera: Array


@dataclass(frozen=True)
class PathScale:
    """metres: of the path's unit.  sd: its standard deviation.  points: how many it rests on."""

    metres: float
    sd: float
    points: int


def scale_from_stances(path: CameraPath, standing: Sequence[StandingPoint]) -> PathScale | None:
    """The scale by least squares, robust to stances that slide; None where the camera moved too
    little while feet stood for it to be observable.
    """
    stances = [_Stance.of(path, point) for point in standing if len(point.p_camera) > 1]
    if not stances:
        return None
    s, weights = 0.0, [np.ones(len(stance.c)) for stance in stances]
    for _ in range(ROUNDS):
        power, slope = (sum(terms) for terms in zip(*map(_normal, stances, weights), strict=True))
        if power <= 0.0:
            return None
        s = -slope / power
        away = [stance.away(s, w) for stance, w in zip(stances, weights, strict=True)]
        spread = max(float(np.median(np.concatenate(away))), 1e-12)
        weights = [GemanMcClure(STANCE_WIDTH * spread).weight(a) for a in away]
    sd = _sd(stances, weights, s, power)
    if not s > 0.0 or sd > LEAST_SURE * s:
        return None
    return PathScale(s, sd, len(stances))


@dataclass(frozen=True, eq=False)
class _Stance:
    """q (n, 3): the point as seen from the camera, turned into the world, metres.  c (n, 3): the
    camera, path's units.  W (n, 3, 3): how much each direction counts.
    """

    q: Array
    c: Array
    W: Array

    @classmethod
    def of(cls, path: CameraPath, point: StandingPoint) -> _Stance:
        rows = slice(point.first_frame, point.first_frame + len(point.p_camera))
        Ts = path.Ts_world_camera[rows]
        q = np.einsum("nab,nb->na", Ts[:, :3, :3], point.p_camera)
        ray = q / np.linalg.norm(q, axis=1, keepdims=True)
        along = ray[:, :, None] * ray[:, None, :]
        W = (np.eye(3) - along) / ACROSS_M**2 + along / ALONG_M**2
        return cls(q, Ts[:, :3, 3], W)

    def about(self, x: Array, weights: Array) -> Array:
        """(n, 3) less the one place that is nearest to all."""
        W = weights[:, None, None] * self.W
        return np.asarray(x - np.linalg.solve(W.sum(axis=0), np.einsum("nab,nb->a", W, x)))

    def away(self, s: float, weights: Array) -> Array:
        """Distances (n,) from the place in the world, standard deviations."""
        r = self.about(self.q + s * self.c, weights)
        return np.asarray(np.sqrt(np.einsum("na,nab,nb->n", r, self.W, r)))


def _normal(stance: _Stance, weights: Array) -> tuple[float, float]:
    """The equation of s alone, the place eliminated: power s + slope = 0."""
    W = weights[:, None, None] * stance.W
    c = stance.about(stance.c, weights)
    power = np.einsum("na,nab,nb->", c, W, c)
    return float(power), float(np.einsum("na,nab,nb->", c, W, stance.q))


def _sd(stances: Sequence[_Stance], weights: Sequence[Array], s: float, power: float) -> float:
    """The standard deviation of s: errors of a motion last, so that frames count as fewer.

    Args:
        stances: of the feet.
        weights: (n,) of the frames of each.
        s: the scale.
        power: of its equation.
    """
    near, own, away = 0.0, 0.0, []
    for stance, w in zip(stances, weights, strict=True):
        r = stance.about(stance.q + s * stance.c, w) * np.sqrt(w)[:, None]
        near += float((r[1:] * r[:-1]).sum())
        own += float((r * r).sum())
        away.append(stance.away(s, w))
    alike = np.clip(near / max(own, 1e-300), 0.0, 0.98)
    spread = float(np.median(np.concatenate(away))) / MEDIAN_OF_THREE
    return float(spread / np.sqrt(power) * np.sqrt((1 + alike) / (1 - alike)))


def scale_from_smoothness(path: CameraPath, first_frame: int, p_camera: Array) -> PathScale | None:
    """The scale that leaves a point of the body the least acceleration in the world; None where the
    camera shook too little for it to be observable.

    p_camera: (n, 3) metres, in the camera's frame at `first_frame` and those that follow.
    """
    if len(p_camera) < FEWEST_FRAMES:
        return None
    Ts = path.Ts_world_camera[first_frame : first_frame + len(p_camera)]
    q = np.einsum("nab,nb->na", Ts[:, :3, :3], p_camera)
    view = (q / np.linalg.norm(q, axis=1, keepdims=True))[1:-1]
    a, b = (_across(np.diff(x, 2, axis=0), view) for x in (q, Ts[:, :3, 3]))
    weights, s = np.ones(len(a)), 0.0
    for _ in range(ROUNDS):
        power = float((weights[:, None] * b * b).sum())
        if power <= 0:
            return None
        s = -float((weights[:, None] * a * b).sum()) / power
        left = np.linalg.norm(a + s * b, axis=1)
        spread = max(float(np.median(left)), 1e-12)
        weights = GemanMcClure(ACCELERATION_WIDTH * spread).weight(left)
    sd = spread * np.sqrt(ALIKE / power)
    if not s > 0 or sd > LEAST_SURE_SMOOTH * s:
        return None
    return PathScale(s, float(sd), 1)


def _across(x: Array, view: Array) -> Array:
    along = (x * view).sum(axis=1, keepdims=True) * view
    return np.asarray(x - (1 - ALONG_SHARE) * along)
