"""From tracks in the picture to a motion in space: whole limb chains fitted over a segment.

INITIAL follows head, hands and feet in the picture and takes the motion to lie in a plane; it names
motion in 3D as future work. Here all inner poses of a segment are unknown at once, and the
followed points must fall on their tracks. Bones keep their lengths because only turns and the
root's place are unknown. What a picture leaves open, such as depth, comes from both keyframes: the
motion is smooth, bends no joint beyond its limits, and has a start as its prior.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.least_squares import USUAL
from keypose.tracker.solver.motion_problem import MotionProblem
from keypose.tracker.solver.pose_terms import JointLimits, PointsInPicture, PosePrior
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.solver.robust import Cauchy, Huber, Kernel
from keypose.tracker.solver.sigmas import (
    BEND_FROM_START,
    LEAST_TRACK_PX,
    LIFTED_LIMB_RAD,
    LIFTED_SHIFT_PX,
    LIFTED_TRUNK_RAD,
    LIMIT_RAD,
)
from keypose.tracker.solver.smoothness import Smoothness, second_differences
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import NEAREST_M, Segment

if TYPE_CHECKING:
    from keypose.tracker.tracking.initial.templates import LimbTracks


def lift(scene: Scene, segment: Segment, base: Trajectory, tracks: LimbTracks) -> Trajectory:
    """The motion near `base` whose limbs fall on their tracks; its ends are the keyframes.

    It never fits worse than `base`, which is returned where there is nothing to fit.
    """
    base = _between_keyframes(segment, base)
    if len(base) < 3 or not scene.skeleton.dof_count or not _is_followed(tracks).any():
        return base
    first = _fit(scene, segment, base, tracks, Huber())
    trajectory = first.solve(base, USUAL)
    trajectory = _fit(scene, segment, base, tracks, Cauchy()).solve(trajectory, USUAL)
    return trajectory if first.cost(trajectory) < first.cost(base) else base


def _between_keyframes(segment: Segment, base: Trajectory) -> Trajectory:
    R, t = base.writable()
    R[0], R[-1] = segment.start.Rs_parent_part, segment.end.Rs_parent_part
    t[0], t[-1] = segment.start.p_camera_root, segment.end.p_camera_root
    return Trajectory(base.first_frame, R, t)


def _is_followed(tracks: LimbTracks) -> NDArray[np.bool_]:
    """(L, n) where a point was followed to, at the inner frames."""
    uv, sigma = tracks.uv[:, 1:-1], tracks.sigma_px[:, 1:-1]
    return np.asarray(np.isfinite(uv).all(axis=-1) & np.isfinite(sigma))


def _fit(
    scene: Scene, segment: Segment, base: Trajectory, tracks: LimbTracks, kernel: Kernel
) -> MotionProblem:
    """What a motion is compared with. kernel: that of the tracks; the prior has Huber's."""
    skeleton = scene.skeleton
    followed = _is_followed(tracks)
    sigma = np.maximum(np.where(followed, tracks.sigma_px[:, 1:-1], 1.0), LEAST_TRACK_PX)
    scale = np.where(followed, 1 / sigma, 0.0).T
    uv = np.swapaxes(np.where(followed[..., None], tracks.uv[:, 1:-1], 0.0), 0, 1)
    points = BodyPoints.single(skeleton, tracks.parts, tracks.points)
    keyed = [pose.Rs_parent_part for pose in (segment.start, segment.end)]
    smooth = scene.precision(BEND_FROM_START)
    terms = (
        PointsInPicture(points, scene.camera, uv, scale, NEAREST_M, kernel),
        JointLimits(Limits.of(skeleton.body).widened(keyed), LIMIT_RAD),
        PosePrior(
            base.Rs_parent_part[1:-1], base.ps_camera_root[1:-1], _keep_precision(scene), Huber()
        ),
    )
    smoothness = Smoothness(skeleton, second_differences(skeleton, base), smooth, Huber())
    return MotionProblem(skeleton, terms, (smoothness,))


def _keep_precision(scene: Scene) -> Array:
    """(D,) precision of the prior, higher for the trunk than for the limbs it carries."""
    skeleton = scene.skeleton
    child_counts = np.bincount(skeleton.parents[1:], minlength=skeleton.part_count)
    turn = np.where(child_counts > 1, LIFTED_TRUNK_RAD, LIFTED_LIMB_RAD)[skeleton.dof_part]
    return np.where(skeleton.dof_turns == 1, turn, LIFTED_SHIFT_PX * scene.pixel_m) ** -2.0
