"""Drift correction over soft anchors: all poses of a segment in one solve, the keyframes exact.

Unknown are the poses x_1 … x_{n−1}, and x_n where the end is open. With inc_j the motion from x_j
to x_{j+1} and m_j that which a pass measured at the present motion,

    E = Σ ρ(√w_j (inc_j − m_j)) + Σ ρ(|π(x_j) − uv_j| / σ_j) + Σ ρ((z_j − ẑ_j) / σ_z)
        + Σ (excess / 3°)² + Σ (Δinc)² / bend²,     w_j = 1 / (step² (floor + doubt_j)).

Without keypoints the first sum alone spreads what is missing at the second keyframe over the steps
by their doubts: that is DRIFT §3 in least squares.

Where brightness leads farther astray than its doubts say (`reweighting.py`), λ times as far,
its steps count by w / λ². It does so slowly, so that how the steps change, m_{j+1} − m_j, stays as
sure as it is, and the motion does not shake for it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.solver.least_squares import QUICK
from keypose.tracker.solver.motion_problem import MotionProblem
from keypose.tracker.solver.pose_terms import JointLimits
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.robust import Cauchy, Huber, Kernel
from keypose.tracker.solver.sigmas import BEND, DOUBT_FLOOR, LIMIT_RAD, STEP, MotionSigma
from keypose.tracker.solver.smoothness import Increments, Smoothness, increments
from keypose.tracker.solver.terms import Link, Term
from keypose.tracker.tracking.drift import Doubt, Motions
from keypose.tracker.tracking.prior_motion import prior_motion_links

if TYPE_CHECKING:
    from collections.abc import Sequence

    from keypose.tracker.tracking.cues.anchors import Anchors
    from keypose.tracker.tracking.cues.other_film import OtherFilm
    from keypose.tracker.tracking.scene import Scene
    from keypose.tracker.tracking.segment import Segment


@dataclass(frozen=True, eq=False)
class Correction:
    """What a segment's motion is corrected with: anchors, limits and smoothness.

    scene: of the skeleton with free joints.  drift_scale: how many times as far as its doubts say
    brightness leads astray.  films: others that show the segment.

    What was measured are the steps of the first film, and those of each of the others at its own
    frames, where these were looked at.
    """

    scene: Scene
    segment: Segment
    anchors: Anchors
    open_end: bool = False
    drift_scale: float = 1.0
    films: tuple[OtherFilm, ...] = ()

    def solve(
        self, present: Trajectory, measured: Sequence[Increments], kernel: Kernel
    ) -> Trajectory:
        """The motion nearest to what was measured and to the anchors, from `present` on."""
        if len(present) < 3 and not self.open_end:
            return present
        return self.problem(measured, kernel).solve(present, QUICK)

    def problem(
        self, measured: Sequence[Increments], kernel: Kernel, bend: MotionSigma | None = BEND
    ) -> MotionProblem:
        """All terms, with smoothness of this σ, unless a motion of before says how it goes."""
        scene, skeleton = self.scene, self.scene.skeleton
        unknown = slice(1, None if self.open_end else -1)
        own, *elsewhere = measured
        links = with_drift(own, self.drift_scale)
        for film, steps in zip(self.films, elsewhere, strict=False):
            links = (*links, film.link(with_drift(steps, self.drift_scale)))
        if self.segment.own is not None:
            links = (*links, *prior_motion_links(scene, self.segment.own))
        elif bend is not None:
            frames = self.segment.last_frame - self.segment.first_frame + 1
            links = (*links, Smoothness.even(skeleton, frames, scene.precision(bend)))
        return MotionProblem(skeleton, self.frame_terms(unknown, kernel), links, unknown)

    def frame_terms(self, frames: slice | int, kernel: Kernel) -> tuple[Term, ...]:
        """What the poses of some frames, or that of one, are compared with by themselves."""
        posed = [self.segment.start.Rs_parent_part, self.segment.end.Rs_parent_part]
        limits = Limits.of(self.scene.skeleton.body).widened(posed[: 1 if self.open_end else 2])
        anchored = self.anchors.terms(self.scene.camera, kernel, frames)
        beside = (term for film in self.films for term in film.frame_terms(frames, kernel))
        return *anchored, *beside, JointLimits(limits, LIMIT_RAD)

    def cost(self, motion: Trajectory, measured: Sequence[Increments]) -> float:
        """What motions from different starts are compared by: the anchors, the limits, and
        how far each step is from what the picture shows there.
        """
        return float(self.problem(measured, Cauchy(), bend=None).cost(motion))


def measured_increments(scene: Scene, present: Trajectory, motions: Motions) -> Increments:
    """What a pass measured at the present motion, with its doubts."""
    skeleton = scene.skeleton
    led = Posed(skeleton, motions.Rs_parent_part, motions.ps_camera_root)
    R, t = present.Rs_parent_part[:-1], present.ps_camera_root[:-1]
    steps = led.motion_from(R, t, backward=False)
    doubt = motions.doubt or Doubt.equal(*motions.Rs_parent_part.shape[:2])
    by_part, of_root = doubt.turned[:, skeleton.dof_part], doubt.shifted[:, None]
    variance = DOUBT_FLOOR + np.where(skeleton.dof_turns == 1, by_part, of_root)
    precision = scene.precision(STEP) / variance
    is_known = np.isfinite(steps)
    return Increments(
        skeleton, np.where(is_known, steps, 0.0), np.where(is_known, precision, 0.0), Huber()
    )


def with_drift(measured: Increments, scale: float) -> tuple[Link, ...]:
    """Steps by which brightness leads so many times as far astray as their doubts say, slowly."""
    if scale <= 1.0 or len(measured.wanted) < 2:
        return (measured,)
    share = 1 / scale**2
    slow = replace(measured, precision=share * measured.precision)
    both = np.stack([measured.precision[:-1], measured.precision[1:]])
    is_known = (both > 0).all(axis=0)
    # variances of two steps add up in their difference
    changes = (1 - share) * is_known * both.prod(axis=0) / np.where(is_known, both.sum(axis=0), 1.0)
    wanted = np.diff(measured.wanted, axis=0)
    return slow, Smoothness(measured.skeleton, wanted, changes, measured.kernel)


def even_increments(scene: Scene, path: Trajectory) -> Increments:
    """The steps of a path, held weakly: where no picture is asked."""
    skeleton = scene.skeleton
    weak = scene.precision(STEP)
    own = increments(skeleton, path)
    return Increments(skeleton, own, np.broadcast_to(weak, own.shape), Huber())
