"""Measures of a fitted step: how near the surfaces lie, and what they do not show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array, frozen
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.fit.pairing import Pairs, TargetSurface
from keypose.tracker.surface.fit.solving import SurfaceRegistration, turns_seen

FAR_SHARE = 0.02
"""Of the surface's size: a point that has nothing within it is not explained."""
SHOWN = 1e-7
"""Information, per unit² and (surface size)², from which on a degree of freedom counts as shown."""


@dataclass(frozen=True, eq=False)
class StepFit:
    """One step, by part (P,).

    residual:      root mean square distance of the part's pairs, metres; NaN where none counts.
    counts:        share of the part's surface that counts, 0 to 1: the rest is in contact or has no
                   reliable counterpart.
    observability: how well the surface shows the part's turning, mean over three axes, 0 to 1.
    least_seen:    the same of the axis that is shown least.
    singular:      (D,) square roots of the information's eigenvalues, metres per radian or metre.
    rank:          degrees of freedom that the surface shows.
    unexplained:   share of the observed surface, by ρ_p, that lies far from the body's.
    uncovered:     share of the body's surface out of contact that lies far from the observed one.
    rms_m:         root mean square of all pairs, by their weights, metres; NaN without any.
    """

    residual: Array
    counts: Array
    observability: Array
    least_seen: Array
    singular: Array
    rank: int
    unexplained: float
    uncovered: float
    rms_m: float


def misfit(model: SurfaceModel, observed: TargetSurface, pairs: Pairs) -> float:
    """Mean squared distance of the two surfaces, both ways, each point's capped; metres².

    Unlike the energy, which counts only reliable pairs, it compares poses that are far apart.
    """
    square = np.minimum(pairs.square, (FAR_SHARE * model.size_m) ** 2)
    sides = (
        (square[: pairs.forward], pairs.clear),
        (square[pairs.forward :], observed.weights),
    )
    return float(sum(side @ weight / max(weight.sum(), 1e-12) for side, weight in sides))


def measure(model: SurfaceModel, observed: TargetSurface, fit: SurfaceRegistration) -> StepFit:
    """The measures of a step's outcome."""
    pairs = fit.pairs
    turns = turns_seen(model, point_weights(model, pairs))
    information = np.linalg.eigvalsh(fit.information)[::-1]
    far = FAR_SHARE * model.size_m
    off = pairs.square > far * far
    there, back = off[: pairs.forward], off[pairs.forward :]
    return StepFit(
        frozen(_residual(model, pairs)),
        frozen(_counts(model, pairs)),
        frozen(turns.certainty.mean(axis=1)),
        frozen(turns.certainty.min(axis=1)),
        frozen(np.sqrt(np.maximum(information, 0.0))),
        int((information > SHOWN * model.size_m**2).sum()),
        _share(back, observed.weights),
        _share(there, pairs.clear),
        _rms(pairs),
    )


def _residual(model: SurfaceModel, pairs: Pairs) -> Array:
    part, count = model.own[pairs.model], model.skeleton.part_count
    weight = np.bincount(part, pairs.weights, count)
    total = np.bincount(part, pairs.weights * pairs.square, count)
    mean = np.divide(total, weight, out=np.full(count, np.nan), where=weight > 0)
    return np.asarray(np.sqrt(mean))


def _counts(model: SurfaceModel, pairs: Pairs) -> Array:
    """The mean weight of each part's own points, of 1 for those that count most."""
    own, count = model.own, model.skeleton.part_count
    points = np.maximum(np.bincount(own, minlength=count), 1)
    return np.asarray(np.bincount(own, point_weights(model, pairs), count) / points)


def point_weights(model: SurfaceModel, pairs: Pairs) -> Array:
    """(V,) how much each of the model's points counts at a step, 1 for those that count most.

    Without the trust that the model gives it.
    """
    weights = pairs.weights[: pairs.forward] / model.trust
    return np.asarray(weights / max(weights.max(initial=0.0), 1e-12))


def _rms(pairs: Pairs) -> float:
    total = float(pairs.weights.sum())
    return float(np.sqrt(pairs.weights @ pairs.square / total)) if total > 0 else np.nan


def _share(which: NDArray[np.bool_], weights: Array) -> float:
    return float(which @ weights / max(weights.sum(), 1e-12))
