"""A stretch of frames in one solve: joints in the picture, their depths, limits and smoothness.

    E = Σ ρ(|π(x_j) − uv_j| / σ_j) + Σ ρ((z_j − z_root − ẑ_j) / σ_z) + Σ (excess / 3°)²
        + Σ (Δinc)² / bend² + a weak prior.

Long stretches are solved in windows that overlap: the time is linear in the number of frames. A
window begins at a pose of the one before, which stays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft.first_poses import landmark_axes
from keypose.tracker.fitting.draft.observed import POINTS, Joints, Observed, place_of
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import height_px
from keypose.tracker.solver.least_squares import USUAL
from keypose.tracker.solver.motion_problem import EVERY, MotionProblem
from keypose.tracker.solver.pose_terms import DepthFromRoot, JointLimits, PointsInPicture, PosePrior
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.robust import Cauchy, Huber, Kernel
from keypose.tracker.solver.sigmas import (
    BEND,
    DRAFTED,
    DRAFTED_ENDS,
    ENDS_WIDER,
    FOOT_DEPTH_M,
    KEYPOINT_DEPTH_M,
    KEYPOINT_SHARE,
    LEAST_DEPTH_M,
    LIFTED_BEND_RAD,
    LIMIT_RAD,
    TRUNK_DEPTH_M,
    keypoint_blur,
)
from keypose.tracker.solver.smoothness import Smoothness
from keypose.tracker.solver.terms import Term
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import NEAREST_M

HEAD: Final = "head"
ROUNDS: Final = 3
FOOT_ENDS: Final = ("heel", "foot_index")
WINDOW = 120
OVERLAP = 24
"""Frames of a window, and of those that the next one solves again."""


@dataclass(frozen=True, eq=False)
class Whole:
    """What the poses of N consecutive frames are compared with.

    points: K on the body, seen at `uv` (N, K, 2).  scale (N, K): 1/σ in 1/px, 0 where unknown.
    depth (N, K): metres farther than the root; depth_scale (N, K): 1/σ, 0 where unknown.
    first: where it starts from.  keep (D,) or (N, D): 1/σ² of how poses stay near it.
    """

    scene: Scene
    points: BodyPoints
    uv: Array
    scale: Array
    depth: Array
    depth_scale: Array
    first: Trajectory
    keep: Array

    @classmethod
    def of_joints(
        cls, scene: Scene, joints: Joints, observed: Observed, first: Trajectory
    ) -> Whole:
        """The joints of a person.

        scene: of a skeleton whose limbs are free to turn.
        first: a pose for every frame, whose depths are those that the keypoints give.
        """
        columns = np.arange(len(JOINTS))
        is_known, sigma, wider = _sigmas(scene, observed, first, columns)
        z = joints.seen.at(first.transforms(scene.skeleton))[..., 2]
        usual_m = np.array([TRUNK_DEPTH_M.get(j.split("_")[1], KEYPOINT_DEPTH_M) for j in JOINTS])
        own_m = observed.depth_sigma_m[:, columns]
        depth_m = np.where(
            np.isfinite(own_m),
            np.maximum(own_m, LEAST_DEPTH_M),
            usual_m * wider,
        )
        return cls(
            scene,
            joints.seen,
            observed.uv[:, columns],
            np.where(is_known, 1 / sigma, 0.0),
            z - first.ps_camera_root[:, 2:],
            np.where(is_known, 1 / depth_m, 0.0),
            first,
            _precision(scene, joints, observed),
        )

    @classmethod
    def of_ends(cls, scene: Scene, joints: Joints, observed: Observed, posed: Trajectory) -> Whole:
        """Head and feet of a body whose other parts stay as posed.

        scene: of a skeleton in which nothing else moves.
        """
        columns, points = joints.ends
        is_known, sigma, wider = _sigmas(scene, observed, posed, columns)
        depth = _depth_of_ends(scene, joints, observed, posed)
        deep = is_known & np.isfinite(depth)
        return cls(
            scene,
            points,
            observed.uv[:, columns],
            np.where(is_known, 1 / (ENDS_WIDER * sigma), 0.0),
            np.where(deep, depth, 0.0),
            np.where(deep, 1 / (FOOT_DEPTH_M * wider), 0.0),
            posed,
            DRAFTED_ENDS.precision(scene.skeleton),
        )

    def __len__(self) -> int:
        return len(self.first)

    def cost(self, motion: Trajectory) -> float:
        """What motions that have left and right otherwise are compared by."""
        return float(self._problem(slice(0, len(self)), Cauchy()).cost(motion))

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
            trajectory = self._window(rows, R[rows], t[rows], step)
            R[rows], t[rows] = trajectory.Rs_parent_part, trajectory.ps_camera_root
            if end == len(self):
                return Trajectory(self.first.first_frame, R, t)
            start = end - OVERLAP

    def solve_turns(self, step: Callable[[int], None]) -> Trajectory:
        """The motion nearest to all, where a head may sit elsewhere on its neck than the body's.

        Its points count by where they are seen about their middle: a head that sits too low would
        be tipped back to bring them up. step: as of `solve`.
        """
        turning, motion = self, self.solve(step)
        for _ in range(ROUNDS):
            turning = replace(self, uv=self._about_middle(motion))
            motion = turning.solve(step)
        return motion

    def _about_middle(self, motion: Trajectory) -> Array:
        """(N, K, 2) where points are seen, those of the head moved together onto the motion's."""
        skeleton, uv = self.scene.skeleton, self.uv.copy()
        names = skeleton.body.names
        head = [k for k, ((part, _),) in enumerate(self.points.points) if names[part] == HEAD]
        if not head:
            return uv
        at = image_points(self.scene.camera, self.points.at(motion.transforms(skeleton)))
        weight = self.scale[:, head, None]
        total = np.maximum(weight.sum(axis=1, keepdims=True), 1e-12)
        missed = uv[:, head] - at[:, head]
        uv[:, head] -= (weight * missed).sum(axis=1, keepdims=True) / total
        return uv

    def _window(self, rows: slice, R: Array, t: Array, step: Callable[[int], None]) -> Trajectory:
        motion = Trajectory(self.first.first_frame + rows.start, R, t)

        def cancelled() -> bool:
            step(rows.start)
            return False

        for kernel in (Huber(), Cauchy()):
            motion = self._problem(rows, kernel).solve(motion, USUAL, cancelled)
        return motion

    def _problem(self, rows: slice, kernel: Kernel) -> MotionProblem:
        """A window after the first one begins with a pose that stays."""
        scene, skeleton = self.scene, self.scene.skeleton
        unknown = slice(1, None) if rows.start else EVERY
        even = Smoothness.even(skeleton, rows.stop - rows.start, scene.precision(BEND))
        terms = self._terms(slice(rows.start + bool(rows.start), rows.stop), kernel)
        return MotionProblem(skeleton, terms, (even,), unknown)

    def _terms(self, rows: slice, kernel: Kernel) -> tuple[Term, ...]:
        scene, camera = self.scene, self.scene.camera
        uv, scale, depth = self.uv[rows], self.scale[rows], self.depth[rows]
        R, t = self.first.Rs_parent_part[rows], self.first.ps_camera_root[rows]
        terms: list[Term] = [
            PointsInPicture(self.points, camera, uv, scale, NEAREST_M, kernel),
            JointLimits(Limits.of(scene.skeleton.body), LIMIT_RAD),
            PosePrior(R, t, self.keep if self.keep.ndim == 1 else self.keep[rows]),
        ]
        if self.depth_scale.any():
            terms.append(DepthFromRoot(self.points, depth, self.depth_scale[rows], Huber()))
        return tuple(terms)


def _precision(scene: Scene, joints: Joints, observed: Observed) -> Array:
    """(D,) of how poses stay near the first ones. Where depth was lifted these know how elbows and
    knees bend: a leg that is a few per cent too long would bend by 20° to make up for that."""
    usual, skeleton = scene.precision(DRAFTED), scene.skeleton
    if not observed.is_lifted:
        return usual
    bends = np.isin(skeleton.dof_part, [limb.lower.part for limb in joints.limbs])
    hinges = bends & (skeleton.dof_turns == 1)
    return np.asarray(np.where(hinges, LIFTED_BEND_RAD**-2.0, usual))


def _depth_of_ends(scene: Scene, joints: Joints, observed: Observed, posed: Trajectory) -> Array:
    """(N, K) metres by which heels and toes are farther than the root: the ankle as posed, and from
    there what the keypoints say; NaN of other points and where that is not known."""
    columns, points = joints.ends
    root, depth = posed.ps_camera_root[:, 2], np.full((len(posed), len(columns)), np.nan)
    Ts = posed.transforms(scene.skeleton)
    p = in_camera(scene.camera, observed)
    for k, ((part, _),) in enumerate(points.points):
        side, _, end = POINTS[columns[k]].partition("_")
        if end in FOOT_ENDS:
            ankle = place_of(side, "ankle")
            depth[:, k] = Ts[:, part, 2, 3] - root + p[:, columns[k], 2] - p[:, ankle, 2]
    return depth


def in_camera(camera: Camera, observed: Observed) -> Array:
    """(N, K, 3) the landmarks along the axes of the camera; NaN where nobody is seen."""
    p, is_known = np.full_like(observed.p_hips, np.nan), observed.known
    for n in np.flatnonzero(is_known.any(axis=1)):
        p[n] = observed.p_hips[n] @ landmark_axes(camera, observed.uv[n], is_known[n]).T
    return p


def _sigmas(
    scene: Scene, observed: Observed, motion: Trajectory, columns: NDArray[np.int64]
) -> tuple[NDArray[np.bool_], Array, Array]:
    """(N, K) of these keypoints whether they are known, their σ in pixels, and how many times wider
    that is than of sure ones."""
    skeleton, camera = scene.skeleton, scene.camera
    frames = range(motion.first_frame, motion.last_frame + 1)
    heights = np.array([height_px(skeleton, camera, motion.pose(frame)) for frame in frames])
    wider = keypoint_blur(observed.visibility[:, columns])
    is_known = observed.known[:, columns] & observed.usable[:, None]
    return is_known, KEYPOINT_SHARE * heights[:, None] * wider, wider
    return is_known, KEYPOINT_SHARE * heights[:, None] * wider, wider
