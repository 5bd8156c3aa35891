"""A tracked motion made to pass through limbs that a person set right: their drift is corrected as
that of a segment is (DRIFT §3), and nothing else moves."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.geometry.rotations import transpose
from keypose.tracker.tracking.drift import Motions, correct_drift
from keypose.tracker.tracking.parts.keyed import KeyedLimb, KeyedParts, keyed_limbs, placed


def closed_on(skeleton: Skeleton, motion: Trajectory, keyed: tuple[KeyedParts, ...]) -> Trajectory:
    """The motion with every limb where it is keyed, its drift spread evenly between."""
    for limb in keyed_limbs(skeleton, keyed):
        motion = joined([piece for piece, _ in closed_pieces(skeleton, motion, limb)])
    return motion


def closed_pieces(
    skeleton: Skeleton, motion: Trajectory, limb: KeyedLimb
) -> list[tuple[Trajectory, tuple[Pose, Pose]]]:
    """The motion from each frame at which the limb is exact to the next, and the poses there.

    It is exact at both ends of the motion, too.
    """
    at = {motion.first_frame: motion.pose(motion.first_frame)}
    for each in limb.keyed:
        at[each.frame] = placed(skeleton, each, motion.pose(each.frame))
    at[motion.last_frame] = motion.pose(motion.last_frame)
    return [
        (closed(part_of(motion, a, b), at[a], at[b], limb.parts), (at[a], at[b]))
        for a, b in pairwise(sorted(at))
    ]


def closed(motion: Trajectory, start: Pose, end: Pose, parts: NDArray[np.int64]) -> Trajectory:
    """A motion whose limb begins and ends as two poses have it, its own motion between."""
    R, t = motion.writable()
    R_next = R[1:].copy()
    R_next[0, parts] = start.Rs_parent_part[parts] @ transpose(R[0, parts]) @ R[1, parts]
    R[0, parts] = start.Rs_parent_part[parts]
    led = Motions(R_next, t[1:].copy())
    found = correct_drift(Trajectory(motion.first_frame, R, t), led, end).trajectory
    return with_limb(motion, found, parts, start, end)


def with_limb(
    motion: Trajectory, limbs: Trajectory, parts: NDArray[np.int64], start: Pose, end: Pose
) -> Trajectory:
    """A motion with a limb turned as in another one, between two poses."""
    R, t = with_parts(motion, limbs, parts).writable()
    R[0, parts], R[-1, parts] = start.Rs_parent_part[parts], end.Rs_parent_part[parts]
    return Trajectory(motion.first_frame, R, t)


def with_parts(motion: Trajectory, other: Trajectory, parts: NDArray[np.int64]) -> Trajectory:
    """A motion with parts turned as in another one of the same frames."""
    R, t = motion.writable()
    R[:, parts] = other.Rs_parent_part[:, parts]
    return Trajectory(motion.first_frame, R, t)


def part_of(motion: Trajectory, first: int, last: int) -> Trajectory:
    """The frames from first to last."""
    rows = slice(first - motion.first_frame, last - motion.first_frame + 1)
    return Trajectory(first, motion.Rs_parent_part[rows], motion.ps_camera_root[rows])
