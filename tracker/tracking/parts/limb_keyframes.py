"""Limbs that a person set right at frames between two keyframes, and where they are on a body that
is tracked.

A limb set right is seen where its pose has it, for that is what a person looked at, and as much
nearer or farther than the body's root, since a picture shows no more of depth. What carries it may
be tracked otherwise later; then the end of the limb stays there, and the parts between bend as
little as they must.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import ROTATIONS
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.least_squares import EXACT, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import PointsInSpace, PosePrior
from keypose.tracker.solver.posed import BodyPoint, BodyPoints
from keypose.tracker.solver.sigmas import BETWEEN_M, END_M, LIMB_RAD
from keypose.tracker.solver.terms import Term

SAME = 1e-9
"""Entries of transforms up to which what carries a limb stands where it stood."""


@dataclass(frozen=True, eq=False)
class KeyedParts:
    """What is exact at one frame: parts (k,) of the body, with all that hangs on them, as a pose of
    the whole body has them.

    telephoto: whether depth changes nothing of where things are seen.
    """

    frame: int
    parts: NDArray[np.int64]
    pose: Pose
    telephoto: bool = False

    @classmethod
    def of(
        cls,
        skeleton: Skeleton,
        frame: int,
        parts: Sequence[str],
        pose: Pose,
        telephoto: bool = False,
    ) -> KeyedParts:
        """Key parts by their names."""
        named = [skeleton.body.index(name) for name in parts]
        below = np.flatnonzero(skeleton.below[:, named].any(axis=1))
        return cls(frame, below, pose, telephoto)

    def joints(self, skeleton: Skeleton, root_z: float) -> Array:
        """(P, 3) where joints are on a body whose root is so far away: seen where they were."""
        p = pose_transforms(skeleton, self.pose)[:, :3, 3]
        farther = root_z - self.pose.p_camera_root[2]
        if self.telephoto:
            return np.asarray(p + np.array([0.0, 0.0, farther]))
        return np.asarray(p * (1 + farther / p[:, 2:]))

    def hanging(self, skeleton: Skeleton) -> NDArray[np.int64]:
        """Add the parts that hang on another one of them: their joints are exact as well."""
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
    limbs = []
    for top in tops:
        limb = np.flatnonzero(anywhere & skeleton.below[:, top])
        own = [
            replace(each, parts=np.intersect1d(each.parts, limb))
            for each in sorted(keyed, key=lambda each: each.frame)
        ]
        limbs.append(KeyedLimb(limb, tuple(each for each in own if len(each.parts))))
    return limbs


def placed(skeleton: Skeleton, keyed: KeyedParts, rest: Pose) -> Pose:
    """The rest of a body with the keyed parts where they were set."""
    R, t = rest.writable()
    there, here = pose_transforms(skeleton, keyed.pose), pose_transforms(skeleton, rest)
    R[keyed.parts] = keyed.pose.Rs_parent_part[keyed.parts]
    inside = np.isin(np.arange(skeleton.part_count), keyed.parts)
    tops = [int(i) for i in keyed.parts if not inside[skeleton.parents[i]]]
    away = np.abs(there - here).max(axis=(1, 2))
    moved = [top for top in tops if away[skeleton.parents[top]] > SAME]
    if not moved:
        return Pose(R, t)
    for top in moved:
        R_carrier = here[skeleton.parents[top], :3, :3]
        R[top] = R_carrier.T @ there[top, :3, :3]  # it goes on pointing where it points
    reached = _reached(skeleton, keyed, Pose(R, t), there, moved).Rs_parent_part
    R[keyed.parts] = reached[keyed.parts]
    return Pose(R, t)


def with_exact_ends(skeleton: Skeleton, keyed: KeyedParts, solved: Pose) -> Pose:
    """A pose that was solved for with the keyed parts about where they were set, the last joint of
    each limb exactly there and its last part turned as it was.

    Elbows and knees stay where they were solved, beside those of the frames before and after: bent
    by themselves they would leap there and back.
    """
    there = pose_transforms(skeleton, keyed.pose)
    tops = [i for i in keyed.parts if i not in keyed.hanging(skeleton)]
    bent = _reached(skeleton, keyed, solved, there, tops, ends_alone=True)
    R, t = solved.writable()
    R[keyed.parts] = bent.Rs_parent_part[keyed.parts]
    return Pose(R, t)


def _reached(
    skeleton: Skeleton,
    keyed: KeyedParts,
    pose: Pose,
    there: Array,
    tops: Sequence[int],
    *,
    ends_alone: bool = False,
) -> Pose:
    """Put the last joints of moved limbs where they were, and turn their last parts as they were.
    ends_alone: those between are where the pose has them, else about where they were.
    """
    below = np.asarray(skeleton.below[:, list(tops)].any(axis=1))
    limb = np.array([i for i in keyed.parts if below[i]], dtype=np.int64)
    joints = np.array([i for i in limb if i not in tops], dtype=np.int64)
    last = ~np.isin(limb, skeleton.parents)
    if len(joints):
        free = turning(skeleton, tuple(limb[~last].tolist()))
        wanted = keyed.joints(skeleton, float(pose.p_camera_root[2]))
        precision = np.full(free.dof_count, LIMB_RAD**-2.0)
        terms: list[Term] = [PosePrior.of(pose, precision)]
        sigmas = ((limb[last], END_M), (limb[~last], BETWEEN_M))
        for of_joints, sigma in sigmas[:1] if ends_alone else sigmas:
            chosen = np.intersect1d(of_joints, joints)
            if len(chosen):
                places: tuple[BodyPoint, ...] = tuple(((int(i), (0.0, 0.0, 0.0)),) for i in chosen)
                terms.append(PointsInSpace(BodyPoints(free, places), wanted[chosen], sigma))
        pose = least_squares(OnePose(free, terms), pose, EXACT).state
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
