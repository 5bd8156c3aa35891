"""Find how long a path's unit is, in metres, by feet that stand still.

Pictures tell where a camera went but for the scale. A body that is tracked is known in metres, in
the camera's frame of every frame. While a foot stands, its place in the world is one:
R p + s c is the same at all its frames, where the camera was at c in the path's unit, is turned by
R and sees the foot at p. That is linear in s and in the feet's places.
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
KERNEL = 3.0
MEDIAN_OF_THREE = 1.538
"""The median length of three standard normal numbers."""
LEAST_SURE = 0.2
"""Standard deviation of the scale, as a share of it, above which it is not known."""


@dataclass(frozen=True, eq=False)
class StandingPoint:
    """A point of the body that stands still in the world.

    p_camera: (n, 3) metres, in the camera's frame at `first_frame` and those that follow.
    """

    first_frame: int
    p_camera: Array


@dataclass(frozen=True)
class PathScale:
    """metres: of the path's unit.  sd: its standard deviation.  points: how many tell it."""

    metres: float
    sd: float
    points: int


def scale_from_stances(path: CameraPath, standing: Sequence[StandingPoint]) -> PathScale | None:
    """The scale by least squares, robust to stances that slide; None where the camera moved too
    little while feet stood to tell it.
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
        weights = [GemanMcClure(KERNEL * spread).weight(a) for a in away]
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
    """Of s: errors of a motion last for frames, so that these count as fewer."""
    near, own, away = 0.0, 0.0, []
    for stance, w in zip(stances, weights, strict=True):
        r = stance.about(stance.q + s * stance.c, w) * np.sqrt(w)[:, None]
        near += float((r[1:] * r[:-1]).sum())
        own += float((r * r).sum())
        away.append(stance.away(s, w))
    alike = np.clip(near / max(own, 1e-300), 0.0, 0.98)
    spread = float(np.median(np.concatenate(away))) / MEDIAN_OF_THREE
    return float(spread / np.sqrt(power) * np.sqrt((1 + alike) / (1 - alike)))
