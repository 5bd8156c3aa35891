"""Start a motion from keypoints alone, where the body could not be followed in the picture."""

from __future__ import annotations

from dataclasses import replace

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation, transpose
from keypose.tracker.solver.least_squares import USUAL, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import PosePrior
from keypose.tracker.solver.robust import Cauchy, Huber
from keypose.tracker.solver.sigmas import NEXT_POSE
from keypose.tracker.tracking.cues.soft_correction import Correction, even_increments

ONE_FRAME = replace(USUAL, most_steps=8, gain=0.0)


def from_keypoints(correction: Correction, reach_far: bool = True) -> Trajectory:
    """The motion that keypoints give as anchors, smooth, within the limits, its ends the keyframes.

    Twice: from interpolation, and, `reach_far`, from following the keypoints frame by frame, which
    reaches what interpolation is too far from. With Huber's kernel first, which comes from afar,
    then with Cauchy's, which gives little weight to what stays far. The cheaper one counts.
    """
    path = correction.segment.interpolated()
    held = even_increments(correction.scene, path)
    ways: list[tuple[float, int, Trajectory]] = []
    begun = (path, _frame_by_frame(correction)) if reach_far else (path,)
    for trajectory in begun:
        for kernel in (Huber(), Cauchy()):
            trajectory = correction.solve(trajectory, (held,), kernel)
        cost = correction.problem((held,), Cauchy()).cost(trajectory)
        ways.append((float(cost), len(ways), trajectory))
    return min(ways)[-1]


def _frame_by_frame(correction: Correction) -> Trajectory:
    """Every pose from the one before it, where the root went on as it did.

    What no keypoint turns, such as a hand at its wrist, goes on as between the keyframes: it would
    stay as it was at the first one, and leap at the second.
    """
    segment = correction.segment
    path = segment.interpolated()
    onward = _turns_not_tracked(correction.scene.skeleton, path)
    R, t = path.writable()
    for n in range(1, len(t)):
        near = segment.expected(R, t, n)
        near = replace(near, Rs_parent_part=near.Rs_parent_part @ onward[n - 1])
        pose = _next(correction, n, near)
        R[n], t[n] = pose.Rs_parent_part, pose.p_camera_root
    if not correction.open_end:
        R[-1], t[-1] = segment.end.Rs_parent_part, segment.end.p_camera_root
    return Trajectory(segment.first_frame, R, t)


def _turns_not_tracked(skeleton: Skeleton, path: Trajectory) -> Array:
    """(N − 1, P, 3, 3) the turns of a path from frame to frame about axes without a degree of
    freedom."""
    R = path.Rs_parent_part
    turn = log_rotation(transpose(R[:-1]) @ R[1:])
    turns = skeleton.dof_turns == 1
    turn[:, skeleton.dof_part[turns], skeleton.dof_axis[turns]] = 0.0
    return exp_rotation(turn)


def _next(correction: Correction, n: int, near: Pose) -> Pose:
    """The pose of the nth frame near another one."""
    scene = correction.scene
    keep = scene.precision(NEXT_POSE)
    terms = (*correction.frame_terms(n, Cauchy()), PosePrior.of(near, keep))
    return least_squares(OnePose(scene.skeleton, terms), near, ONE_FRAME).state
