"""Drift correction of a segment: the accumulated motion made to meet the second keyframe.

DRIFT §3. The equations, and where they differ from the printed ones, are in the loops.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.closing import close_segment
from keypose.tracker.solver.sigmas import DOUBT_FLOOR


@dataclass(frozen=True, eq=False)
class Doubt:
    """Variances of n steps as shares of the prior's: turned (n, P) by part, shifted (n,)."""

    turned: Array
    shifted: Array

    @classmethod
    def equal(cls, steps: int, parts: int) -> Doubt:
        """Equal doubts for so many steps."""
        return cls(np.ones((steps, parts)), np.ones(steps))

    @property
    def shares(self) -> tuple[Array, Array]:
        """The weights of the steps in a correction, of mean 1: (n, P) and (n,)."""
        turned, shifted = DOUBT_FLOOR + self.turned, DOUBT_FLOOR + self.shifted
        return turned / turned.mean(axis=0), shifted / shifted.mean()


@dataclass(frozen=True, eq=False)
class Motions:
    """Where the motion of every frame of a trajectory leads: the pose at the next frame.

    Rs_parent_part: (n, P, 3, 3), ps_camera_root: (n, 3), for frames 0 … n − 1 of the trajectory.
    doubt: how uncertain every step is, 0 to 1, by part and for the root's shift; None: all equal.
    """

    Rs_parent_part: Array
    ps_camera_root: Array
    doubt: Doubt | None = None


@dataclass(frozen=True, eq=False)
class Corrected:
    """A trajectory that meets both keyframes.

    rounds: (P,) rounds in which each part's X was found; −1 where the motions left no single X
    (a full turn) and the rest was spread along one axis.
    gap: largest angle, radians, by which the corrected motions missed the keyframe, before the
        last pose was set to it exactly.
    """

    trajectory: Trajectory
    rounds: NDArray[np.int64]
    gap: float


def correct_drift(trajectory: Trajectory, motions: Motions, end: Pose) -> Corrected:
    """Accumulate the motions from the trajectory's first pose and close on `end`."""
    R, t = trajectory.writable()
    R_out, t_out = np.empty_like(R), np.empty_like(t)
    rounds, gaps = np.empty(R.shape[1], np.int64), np.empty(R.shape[1])
    doubt = motions.doubt or Doubt.equal(*motions.Rs_parent_part.shape[:2])
    close_segment(
        R,
        t,
        motions.Rs_parent_part,
        motions.ps_camera_root,
        *doubt.shares,
        *end.writable(),
        R_out,
        t_out,
        rounds,
        gaps,
    )
    trajectory = Trajectory(trajectory.first_frame, R_out, t_out)
    return Corrected(trajectory, rounds, float(gaps.max()))


def closing_error(trajectory: Trajectory, start: Pose, end: Pose) -> float:
    """Largest difference of the trajectory's ends from the keyframes: matrix entries and metres."""
    gaps = [
        trajectory.Rs_parent_part[0] - start.Rs_parent_part,
        trajectory.Rs_parent_part[-1] - end.Rs_parent_part,
        trajectory.ps_camera_root[0] - start.p_camera_root,
        trajectory.ps_camera_root[-1] - end.p_camera_root,
    ]
    return float(max(np.abs(gap).max() for gap in gaps))
