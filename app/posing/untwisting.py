"""A limb turned about a line, so that its upper part is not twisted beyond its limits.

About the line from shoulder to hand both stay where they are and the elbow goes round; about the
upper arm itself the elbow stays. Either way one turn alone leads to a wanted twist.
"""

from __future__ import annotations

import math

import numpy as np

from keypose.app.posing.gesture import GestureContext
from keypose.app.posing.limits import FREE, SLACK, JointRange, nearest_within, range_of, twist_of
from keypose.app.posing.vectors import length, smooth_step, turn
from keypose.tracker.body.joint_limits import TwistLimits
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, exp_rotation

EASED_M = 0.05
"""What is bent the wrong way, or twisted too far, is brought right over a drag of this length."""

SAME_M = 0.01
"""Ends of a limb that lie no farther apart are as good: then the least twist counts."""

_TRIED = 41
"""Twists that are compared, from one limit to the other."""


def twist_allowed(context: GestureContext, part: int, drawn_m: float) -> TwistLimits | None:
    """The limits of a part's twist in a drag of a length; None where none count.

    Where the pose before is twisted too far it stays so at first: nothing jumps.
    """
    limits = twist_of(context.skeleton.body.parts[part]) if context.limits_on else None
    if limits is None:
        return None
    share = 1.0 - smooth_step(drawn_m / EASED_M)
    return limits.widened(share * limits.excess(context.posed.Rs_parent_part[part]))


def untwisted(
    context: GestureContext, part: int, R_parent_part: Array, axis: Array, drawn_m: float
) -> Array:
    """A part's rotation turned about a unit axis (3,) of its parent's frame until it is allowed.

    What lies just beyond a limit comes back to it, what lies farther beyond to within, and what
    lies half round to the middle: so it does from either side, and nothing jumps.
    """
    limits = twist_allowed(context, part, drawn_m)
    if limits is None:
        return R_parent_part
    beyond = float(limits.excess(R_parent_part))
    if abs(beyond) <= SLACK:
        return R_parent_part
    middle, half = float(limits.low + limits.high) / 2, float(limits.high - limits.low) / 2
    back = 1.0 - min(abs(beyond) / (math.pi - half), 1.0)
    wanted = middle + math.copysign(half * back, beyond)
    return np.asarray(turn(axis, limits.turn_to(R_parent_part, axis, wanted)) @ R_parent_part)


def untwisted_limb(skeleton: Skeleton, pose: Pose, part: int) -> Pose:
    """The pose with a part turned about its own length until it is allowed: its far joint stays,
    what hangs on it bends anew so that the end stays as near as its limits let it.

    The same pose where the part has no limit of twist.
    """
    parts, R = skeleton.body.parts, pose.Rs_parent_part[part]
    limits, children = twist_of(parts[part]), np.flatnonzero(skeleton.parents == part)
    if limits is None:
        return pose
    tried: list[tuple[float, float, Pose]] = []
    for twist in np.linspace(limits.low, limits.high, _TRIED).tolist():
        by = np.array([0.0, twist - float(limits.twist(R)), 0.0])
        Rs, moved_m = pose.Rs_parent_part.copy(), 0.0
        for child in children.tolist():
            wanted = exp_rotation(-by) @ pose.Rs_parent_part[child]
            Rs[child] = nearest_within(wanted, range_of(parts[child]))
            moved_m += parts[child].shape.length_m * length((Rs[child] - wanted)[:, 1])
        Rs[part] = R @ exp_rotation(by)
        tried.append((moved_m, abs(twist), Pose(Rs, pose.p_camera_root)))
    least = min(moved_m for moved_m, _, _ in tried)
    return min(
        (tried_turn for tried_turn in tried if tried_turn[0] <= least + SAME_M),
        key=lambda tried_turn: tried_turn[1],
    )[2]


def twist_range(context: GestureContext, part: int, drawn_m: float) -> JointRange | None:
    """The limits of `twist_allowed` as a range without a box; None where none count."""
    limits = twist_allowed(context, part, drawn_m)
    return None if limits is None else JointRange(FREE, limits)
