"""Points in a place, and where cameras see them, known exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.camera_motion.bundle import Bundle, nudged
from keypose.tracker.geometry.rotations import Array, exp_rotation, transform

NOISE = 0.2 / 720
"""A fifth of a pixel."""


@dataclass(frozen=True, eq=False)
class Place:
    """Points X (P, 3), cameras Ts (V, 4, 4) that go 1.5 m aside and turn by 25°, and where these
    see those: xy (V, P, 2) and z (V, P)."""

    X: Array
    Ts: Array

    @classmethod
    def of(cls, views: int = 8, points: int = 200) -> Place:
        rng = np.random.default_rng(0)
        low, high = (-4, -2, 3), (4, 2, 10)
        X = rng.uniform(low, high, (points, 3))
        share = np.linspace(0, 1, views)
        wave = 0.1 * np.sin(5 * share)
        p = np.stack([1.5 * share, wave - wave[0], 0.4 * share], axis=1)
        turn = np.radians(25) * share[:, None] * (0.1, -1.0, 0.15)
        return cls(X, np.linalg.inv(transform(exp_rotation(turn), p)))

    @property
    def seen(self) -> tuple[Array, Array]:
        Y = np.einsum("vab,pb->vpa", self.Ts[:, :3, :3], self.X) + self.Ts[:, None, :3, 3]
        return Y[..., :2] / Y[..., 2:], Y[..., 2]


def bundle_of(place: Place, outliers: float = 0.0, off: float = 0.01) -> tuple[Bundle, Array]:
    """All but the first two cameras off, all depths too; and the true inverse depths."""
    rng = np.random.default_rng(1)
    (xy, z), (views, points) = place.seen, (len(place.Ts), len(place.X))
    anchor = rng.integers(0, views // 2, points)
    seen = (np.arange(views)[:, None] > anchor) & (rng.random((views, points)) < 0.7)
    view, point = np.nonzero(seen)
    at = xy[view, point] + NOISE * rng.standard_normal((len(view), 2))
    wrong = rng.random(len(view)) < outliers
    at[wrong] += rng.normal(0, 0.03, (wrong.sum(), 2))
    free = np.arange(views) > 1
    Ts = np.where(free[:, None, None], nudged(place.Ts, rng.normal(0, off, (views, 6))), place.Ts)
    depths = 1 / z[anchor, np.arange(points)]
    guess = depths * np.exp(rng.normal(0, 20 * off, points))
    usual = np.full(points, 0.15)
    bundle = Bundle(
        Ts,
        free,
        anchor,
        xy[anchor, np.arange(points)],
        guess,
        usual,
        2 * usual,
        view,
        point,
        at,
        NOISE,
    )
    return bundle, depths


def off_by(T: Array, true: Array) -> tuple[float, float]:
    """Degrees and metres between two cameras' places."""
    both = T @ np.linalg.inv(true)
    cosine = np.clip((np.trace(both[:3, :3]) - 1) / 2, -1, 1)
    return float(np.degrees(np.arccos(cosine))), float(np.linalg.norm(both[:3, 3]))
