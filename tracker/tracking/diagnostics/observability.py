"""How observable a motion is: rank, observability, residual (DRIFT §5.3, Fig. 10)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.pairs import observe_pairs
from keypose.tracker.tracking.frame_pair import SINGULAR_CUT
from keypose.tracker.tracking.result import Diagnostics
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.windows import show
from keypose.tracker.video.pyramid import Clip


@dataclass(frozen=True, eq=False)
class Observation:
    """Facts about every frame pair (n of them) of a trajectory.

    diagnostics: singular values are those of A with its columns scaled; observability is the share
        of a part's motion that the picture decides, 0 (all prediction) to 1, NaN for parts that are
        not tracked; the residual is the root mean square difference of brightness.
    shown: (n, P) number of surface points seen.
    """

    diagnostics: Diagnostics
    shown: NDArray[np.int64]


def observe(scene: Scene, clip: Clip, trajectory: Trajectory) -> Observation:
    """Measure a trajectory as it is, without moving it."""
    n, parts = len(trajectory) - 1, scene.skeleton.part_count
    dofs = scene.skeleton.dof_count
    A, sigma = np.empty((n, dofs, dofs)), np.empty(n)
    residual, shown = np.empty((n, parts)), np.empty((n, parts), np.int64)
    pictures = show(scene, clip, *trajectory.writable())
    observe_pairs(
        scene.arrays,
        pictures.seen_by(scene.lens),
        scene.visibility,
        pictures.levels[0],
        clip.slots(trajectory.first_frame, trajectory.last_frame),
        *trajectory.writable(),
        A,
        residual,
        shown,
        sigma,
    )
    scale = scene.skeleton.column_scale
    values = np.linalg.eigvalsh(A * scale * scale[:, None])[:, ::-1]
    singular = np.sqrt(np.maximum(values, 0.0))
    rank = (singular > SINGULAR_CUT * singular[:, :1]).sum(axis=1)
    q = scene.information(1) / sigma**2
    observability = _observability(scene, A * q[:, None, None])
    return Observation(Diagnostics(rank, singular, observability, residual), shown)


def unobserved(scene: Scene, _clip: Clip, trajectory: Trajectory) -> Observation:
    """An observation without measurements: rank −1, NaN elsewhere."""
    n, parts, dofs = len(trajectory) - 1, scene.skeleton.part_count, scene.skeleton.dof_count
    unknown = Diagnostics.side_by_side((), n + 1, parts, dofs)
    return Observation(unknown, np.zeros((n, parts), np.int64))


def _observability(scene: Scene, data: Array) -> Array:
    """(n, P) mean over a part's degrees of freedom of diag((data + Λ)⁻¹ data), data (n, D, D)."""
    precision = np.diag(scene.prior(1).precision)
    resolution = np.linalg.solve(data + precision, data)
    by_dof = np.diagonal(resolution, axis1=-2, axis2=-1)
    out = np.full((len(data), scene.skeleton.part_count), np.nan)
    for i in np.unique(scene.skeleton.dof_part):
        out[:, i] = by_dof[:, scene.skeleton.dof_part == i].mean(axis=1)
    return out
