"""One estimate of sizes and poses: contours looked for and fitted to, again and again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.fitting.sizes.residuals import (
    Pictures,
    contours,
    joint_rows,
    residuals_by_pose,
)
from keypose.tracker.fitting.sizes.shared import Residuals, Shared, SharedFit, solve
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.sigmas import FEW_SHARE

STEPS = 3
OBSERVABLE_SHARE = 0.05
"""A size whose sigma is larger is not observable."""
FEWEST_POINTS = 40
"""Points of the contour that must be seen in a picture, on average."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Sizes and poses after some rounds, sigmas of the sizes, which of them are observable, whether
    the pictures, or other films, show the body at all, and what was fitted to last."""

    shared: Shared
    spread: Array
    observable: NDArray[np.bool_]
    enough: bool
    rows: tuple[Residuals, ...] = ()


def estimate(
    fit: SharedFit,
    start: Shared,
    pictures: Pictures,
    looked: list[int],
    reaches: Sequence[float],
    cancelled: Callable[[], bool],
) -> Estimate | None:
    """Look for the contours and fit to them, again and again; None when cancelled."""
    joints = [joint_rows(fit, k) for k in range(len(fit.posed))]
    shown_contours = contours(fit, start, looked)
    colour_models = pictures.colour_models(shown_contours, fit)
    shared, observable, enough = start, np.ones(len(fit.free), dtype=np.bool_), False
    spread, rows = np.zeros(len(fit.free)), joints
    for number, reach in enumerate(reaches):
        if cancelled():
            return None
        if number:
            shown_contours = contours(fit, shared, looked)
        contour_residuals = residuals_by_pose(
            fit, shared, looked, shown_contours, colour_models, reach
        )
        rows = [
            Residuals.concatenate(
                [joints[k], *([contour_residuals[k]] if k in contour_residuals else [])]
            )
            for k in range(len(joints))
        ]
        result = solve(fit, shared, rows, STEPS)
        shared, spread = result.shared, result.spread
        if not number:
            observable = spread < OBSERVABLE_SHARE
            enough = bool(
                np.mean([len(residuals.parts) for residuals in contour_residuals.values()])
                >= FEWEST_POINTS
            ) or bool(fit.beside)
        # another film tells lengths from the distance: all may change
        favours_few = fit.free[: fit.proportions.count].all() and not fit.beside
        fit = replace(fit, share=_favour_few(fit, shared)) if favours_few else fit
    return Estimate(shared, spread, observable, enough, tuple(rows))


def _favour_few(fit: SharedFit, shared: Shared) -> Array:
    """(S + 2,) sigmas of a prior that favours few changes: narrow where a value hardly changed.

    Else all would change a little, and the distance with them, instead of the few.
    """
    share = np.minimum(np.hypot(shared.values, FEW_SHARE), fit.usual)
    sizes = fit.proportions.count
    return np.append(share[:sizes], fit.usual[sizes:])
