"""Limbs that a person set right at frames between two keyframes, and where they are on a body that
is tracked.

A limb set right is where its pose has it in the camera frame, for that is what a person saw. What
carries it may be tracked otherwise later; then the end of the limb stays where it was put, and the
parts between bend as little as they must.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tracker.body.body import ROTATIONS
from tracker.body.pose import Pose, pose_transforms
from tracker.body.skeleton import Skeleton
from tracker.geometry.rotations import Array
from tracker.solver.body_points import BodyPoint, BodyPoints
from tracker.solver.least_squares import Criteria, Damping, least_squares
from tracker.solver.one_pose import OnePose
from tracker.solver.terms import PointsInSpace, PosePrior, Term

SAME = 1e-9
"""Entries of transforms up to which what carries a limb stands where it stood."""
END_M, BETWEEN_M, TURN_RAD = 1e-4, 0.02, np.radians(15.0)
"""Standard deviations of the last joint of a limb, of those before it, and of its parts' turns."""
CRITERIA = Criteria(
    most_steps=60, longest_step=0.3, settled=1e-9,
    damping=Damping(first=1e-6, least=1e-12, most=1e6),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class KeyedParts:
    """What is exact at one frame: parts (k,) of the body, with all that hangs on them, where a pose
    of the whole body has them in the camera frame."""

    frame: int
    parts: NDArray[np.int64]
    pose: Pose

    @classmethod
    def of(cls, skeleton: Skeleton, frame: int, parts: Sequence[str], pose: Pose) -> KeyedParts:
        """By the names of parts."""
        named = [skeleton.body.index(name) for name in parts]
        return cls(frame, np.flatnonzero(skeleton.below[:, named].any(axis=1)), pose)

    def hanging(self, skeleton: Skeleton) -> NDArray[np.int64]:
        """Those of the parts that hang on another one of them: their joints are exact as well."""
        return self.parts[np.isin(skeleton.parents[self.parts], self.parts)]


@dataclass(frozen=True, eq=False)
class KeyedLimb:
    """Parts (k,) that hang together, and the frames at which they, or some of them, are exact."""

    parts: NDArray[np.int64]
    keyed: tuple[KeyedParts, ...]


def keyed_limbs(skeleton: Skeleton, keyed: Sequence[KeyedParts]) -> list[KeyedLimb]:
    """What is exact at some frames by limbs, which can be corrected one after another."""
    anywhere = np.zeros(skeleton.part_count, dtype=np.bool_)
    for each in keyed:
        anywhere[each.parts] = True
    tops = [i for i in np.flatnonzero(anywhere) if not anywhere[skeleton.parents[i]]]
    found = []
    for top in tops:
        limb = np.flatnonzero(anywhere & skeleton.below[:, top])
        own = [
            KeyedParts(each.frame, np.intersect1d(each.parts, limb), each.pose)
            for each in sorted(keyed, key=lambda each: each.frame)
        ]
        found.append(KeyedLimb(limb, tuple(each for each in own if len(each.parts))))
    return found


def placed(skeleton: Skeleton, keyed: KeyedParts, rest: Pose) -> Pose:
    """The rest of a body with the keyed parts where they were set."""
    R, t = rest.writable()
    there, here = pose_transforms(skeleton, keyed.pose), pose_transforms(skeleton, rest)
    R[keyed.parts] = keyed.pose.Rs_parent_part[keyed.parts]
    inside = np.isin(np.arange(skeleton.part_count), keyed.parts)
    tops = [int(i) for i in keyed.parts if not inside[skeleton.parents[i]]]
    moved = [top for top in tops if np.abs(_carrier(there - here, skeleton, top)).max() > SAME]
    if not moved:
        return Pose(R, t)
    for top in moved:
        R_carrier = here[skeleton.parents[top], :3, :3]
        R[top] = R_carrier.T @ there[top, :3, :3]  # it goes on pointing where it points
    reached = _reached(skeleton, keyed, Pose(R, t), there, moved).Rs_parent_part
    R[keyed.parts] = reached[keyed.parts]
    return Pose(R, t)


def _carrier(Ts: Array, skeleton: Skeleton, top: int) -> Array:
    return np.asarray(Ts[skeleton.parents[top]])


def _reached(
    skeleton: Skeleton, keyed: KeyedParts, pose: Pose, there: Array, tops: Sequence[int]
) -> Pose:
    """With the last joints of moved limbs where they were, and their last parts turned as they
    were."""
    below = np.asarray(skeleton.below[:, list(tops)].any(axis=1))
    limb = np.array([i for i in keyed.parts if below[i]], dtype=np.int64)
    joints = np.array([i for i in limb if i not in tops], dtype=np.int64)
    last = ~np.isin(limb, skeleton.parents)
    if len(joints):
        free = turning(skeleton, tuple(limb[~last].tolist()))
        precision = np.full(free.dof_count, TURN_RAD**-2.0)
        terms: list[Term] = [PosePrior.of(pose, precision)]
        for some, sigma in ((limb[last], END_M), (limb[~last], BETWEEN_M)):
            chosen = np.intersect1d(some, joints)
            if len(chosen):
                places: tuple[BodyPoint, ...] = tuple(((int(i), (0.0, 0.0, 0.0)),) for i in chosen)
                points = BodyPoints(free, places)
                terms.append(PointsInSpace(points, there[chosen, :3, 3], sigma))
        pose = least_squares(OnePose(free, terms), pose, CRITERIA).state
    R, t = pose.writable()
    now = pose_transforms(skeleton, pose)
    for i in limb[last]:
        R[i] = now[skeleton.parents[i], :3, :3].T @ there[i, :3, :3]
    return Pose(R, t)


@lru_cache(maxsize=32)
def turning(skeleton: Skeleton, parts: tuple[int, ...]) -> Skeleton:
    """The skeleton with these parts free to turn in every way, and nothing else."""
    body, free = skeleton.body, {skeleton.body.names[i] for i in parts}
    return Skeleton.of(
        body.replaced(
            part.model_copy(update={"tracked": ROTATIONS if part.name in free else ()})
            for part in body.parts
        )
    )


@lru_cache(maxsize=32)
def tracking_only(skeleton: Skeleton, parts: tuple[int, ...]) -> Skeleton:
    """The skeleton with nothing tracked but these parts, as they are."""
    body, kept = skeleton.body, {skeleton.body.names[i] for i in parts}
    return Skeleton.of(
        body.replaced(
            part if part.name in kept else part.model_copy(update={"tracked": ()})
            for part in body.parts
        )
    )
