"""A stretch of frames in one solve: joints in the picture, their depths, limits and smoothness.

    E = Σ ρ(|π(x_j) − uv_j| / σ_j) + Σ ρ((z_j − z_root − ẑ_j) / σ_z) + Σ (excess / 3°)²
        + Σ (Δinc)² / bend² + a weak prior.

Long stretches are solved in windows that overlap: the time is linear in the number of frames. A
window begins at a pose of the one before, which stays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tracker.body.joint_limits import Limits
from tracker.body.trajectory import Trajectory
from tracker.fitting.draft.limbs import Joints
from tracker.fitting.draft.observed import Observed
from tracker.geometry.rotations import Array
from tracker.solver.least_squares import Criteria, Damping, least_squares
from tracker.solver.robust import SQUARED, Cauchy, Huber, Kernel
from tracker.solver.segment_poses import SegmentPoses
from tracker.solver.smoothness import Smoothness
from tracker.solver.terms import DepthFromRoot, JointLimits, PointsInPicture, PosePrior, Term
from tracker.tracking.cues.anchors import height_px
from tracker.tracking.scene import Scene
from tracker.tracking.segment import NEAREST_M

WINDOW, OVERLAP = 120, 24
"""Frames of a window, and of those that the next one solves again."""
SIGMA = 0.010
"""Standard deviation of a sure keypoint where nobody said where on the body it is: a share of the
body's height."""
SURE, BLUR = 0.6, 3.0
"""Visibility from which a keypoint is sure, and how many times wider it is at visibility 0."""
DEPTH_M = 0.15
BEND_TURN_RAD, BEND_SHIFT_PX = np.radians(3.0), 2.5
"""Standard deviations of the motion's change from frame to frame."""
LIMIT_RAD = np.radians(3.0)
KEEP_TURN_RAD, KEEP_SHIFT_PX = np.radians(90.0), 2500.0
"""Of the prior at the first poses, for what nothing else decides."""
CRITERIA = Criteria(
    most_steps=25, longest_step=0.3, settled=2e-3, gain=1e-3,
    damping=Damping(first=1e-3, least=1e-7, most=1e5),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Whole:
    """What the poses of N consecutive frames are compared with.

    scene: of the freed skeleton.  joints: on it.
    scale (N, 12): 1/σ of the pixels, in 1/px, 0 where unknown.
    depth (N, 12): metres farther than the root; depth_scale (N, 12): 1/σ, 0 where unknown.
    """

    scene: Scene
    joints: Joints
    observed: Observed
    first: Trajectory
    scale: Array
    depth: Array
    depth_scale: Array

    @classmethod
    def of(cls, scene: Scene, joints: Joints, observed: Observed, first: Trajectory) -> Whole:
        """first: a pose for every frame, whose depths are those that the keypoints tell."""
        heights = [
            height_px(scene.skeleton, scene.camera, first.pose(frame))
            for frame in range(first.first_frame, first.last_frame + 1)
        ]
        unsure = np.clip((SURE - observed.visibility) / SURE, 0.0, 1.0)
        sigma = SIGMA * np.array(heights)[:, None] * (1 + (BLUR - 1) * unsure)
        told = observed.known & observed.usable[:, None]
        z = joints.points.at(first.transforms(scene.skeleton))[..., 2]
        depth_sigma = DEPTH_M * (1 + (BLUR - 1) * unsure)
        return cls(
            scene, joints, observed, first, np.where(told, 1 / sigma, 0.0),
            z - first.ps_camera_root[:, 2:], np.where(told, 1 / depth_sigma, 0.0),
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.first)

    def cost(self, motion: Trajectory) -> float:
        """What motions that tell left and right otherwise are compared by."""
        padded = _padded(motion)
        return float(self._problem(slice(0, len(self)), Cauchy()).at(padded, 0).cost)

    def solve(self, step: Callable[[int], None]) -> Trajectory:
        """The motion nearest to all.

        step: called before every step with the number of frames that are done; what it raises
            ends the work.
        """
        R, t = self.first.writable()
        start = 0
        while True:
            end = min(start + WINDOW, len(self))
            rows = slice(start, end)
            found = self._window(rows, R[rows], t[rows], step)
            R[rows], t[rows] = found.Rs_parent_part, found.ps_camera_root
            if end == len(self):
                return Trajectory(self.first.first_frame, R, t)
            start = end - OVERLAP

    def _window(self, rows: slice, R: Array, t: Array, step: Callable[[int], None]) -> Trajectory:
        is_first = rows.start == 0
        motion = Trajectory(self.first.first_frame + rows.start, R, t)
        motion = _padded(motion) if is_first else motion

        def cancelled() -> bool:
            step(rows.start)
            return False

        for kernel in (Huber(), Cauchy()):
            problem = self._problem(rows, kernel)
            motion = least_squares(problem, motion, CRITERIA, cancelled).state
        if not is_first:
            return motion
        return Trajectory(
            motion.first_frame + 1, motion.Rs_parent_part[1:], motion.ps_camera_root[1:]
        )

    def _problem(self, rows: slice, kernel: Kernel) -> SegmentPoses:
        """The first window begins with a pose that stays and is linked to nothing."""
        is_first = rows.start == 0
        scene, skeleton = self.scene, self.scene.skeleton
        unknown = rows if is_first else slice(rows.start + 1, rows.stop)
        bend = scene.precision(BEND_TURN_RAD, BEND_SHIFT_PX * scene.pixel_m)
        linked = np.tile(bend, (max(unknown.stop - unknown.start - 1, 0), 1))
        if is_first:
            linked[:1] = 0.0
        even = np.zeros_like(linked)
        links = (Smoothness(skeleton, even, linked, SQUARED),)
        return SegmentPoses(skeleton, scene.arrays, self._terms(unknown, kernel), links, True)

    def _terms(self, rows: slice, kernel: Kernel) -> tuple[Term, ...]:
        scene, points = self.scene, self.joints.points
        keep = scene.precision(KEEP_TURN_RAD, KEEP_SHIFT_PX * scene.pixel_m)
        uv, R, t = self.observed.uv, self.first.Rs_parent_part, self.first.ps_camera_root
        return (
            PointsInPicture(points, scene.camera, uv[rows], self.scale[rows], NEAREST_M, kernel),
            DepthFromRoot(points, self.depth[rows], self.depth_scale[rows], Huber()),
            JointLimits(Limits.of(scene.skeleton.body), LIMIT_RAD),
            PosePrior(R[rows], t[rows], keep),
        )


def _padded(motion: Trajectory) -> Trajectory:
    """With its first pose twice: the first one of a problem stays."""
    R, t = motion.Rs_parent_part, motion.ps_camera_root
    return Trajectory(
        motion.first_frame - 1, np.concatenate([R[:1], R]), np.concatenate([t[:1], t])
    )
