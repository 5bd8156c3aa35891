"""The pull of joints back into their limits: surfaces of rough proportions turn a foot around."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracker.body.pose import Pose
from tracker.geometry.rotations import Array
from tracker.surface.fit.model import SurfaceModel

HARDNESS = 1e-3
"""Per radian² beyond a limit and (surface size)²: what a limb's surface tells of its turning."""


@dataclass(frozen=True, eq=False)
class Bounds:
    """energy: metres².  slope (D,) and information (D, D): of half of it, over free degrees of
    freedom."""

    energy: float
    slope: Array
    information: Array


def bounds_at(model: SurfaceModel, pose: Pose) -> Bounds:
    """What joints beyond their limits add to a step's energy at a pose."""
    skeleton = model.skeleton
    slope, information = np.zeros(skeleton.dof_count), np.zeros((skeleton.dof_count,) * 2)
    if not np.isfinite([model.limits.low, model.limits.high]).any():
        return Bounds(0.0, slope, information)
    beyond, slopes = model.limits.excess(pose.Rs_parent_part)
    hardness = HARDNESS * model.size_m**2
    for part in np.flatnonzero(beyond.any(axis=1)):
        its = np.flatnonzero((skeleton.dof_part == part) & (skeleton.dof_turns == 1))
        active = slopes[part][beyond[part] != 0]
        slope[its] = hardness * slopes[part].T @ beyond[part]
        information[np.ix_(its, its)] = hardness * active.T @ active
    return Bounds(float(hardness * (beyond**2).sum()), slope, information)
