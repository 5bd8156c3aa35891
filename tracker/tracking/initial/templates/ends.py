"""Which points of a body are followed: the ends of its limbs."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array

KNEE_SHARE = 0.3
"""How far along the lower link, from its joint to its end, the point for knee and elbow is."""


@dataclass(frozen=True, eq=False)
class TwoLinks:
    """A limb of two links that ends in a leaf: upper arm, forearm and hand.

    upper, lower, leaf: part indices; the leaf is the lower link itself where nothing hangs on it.
    p_leaf: (3,) the followed point in the leaf's frame.
    """

    upper: int
    lower: int
    leaf: int
    p_leaf: Array


def leaves(skeleton: Skeleton) -> list[int]:
    """Parts from which no other part hangs, the root aside."""
    return [i for i in range(1, skeleton.part_count) if i not in skeleton.parents]


def two_link_limbs(skeleton: Skeleton) -> list[TwoLinks]:
    """All limbs of two links whose upper one is tracked.

    Of a limb with more parts the last three are upper link, lower link and leaf; of one with two
    parts the second is lower link and leaf at once.
    """
    found = []
    for leaf in leaves(skeleton):
        limb = np.flatnonzero(skeleton.limbs == skeleton.limbs[leaf])
        if len(limb) < 2:
            continue
        upper, lower = int(limb[-3:][0]), int(limb[-3:][1])
        if np.isin([upper, lower], skeleton.dof_part).all() and _moves_on(skeleton, lower, leaf):
            p = middle(skeleton, leaf) if leaf != lower else 1.8 * middle(skeleton, leaf)
            found.append(TwoLinks(upper, lower, leaf, p))
    return found


def _moves_on(skeleton: Skeleton, lower: int, leaf: int) -> bool:
    """Whether the lower link is long enough to show how it is turned."""
    p = skeleton.joints[leaf] if leaf != lower else middle(skeleton, leaf)
    return bool(np.linalg.norm(p) > 1e-3)


def middle(skeleton: Skeleton, part: int) -> Array:
    """(3,) the middle of a part's shape in its frame."""
    vertices = skeleton.body.parts[part].shape.mesh().vertices
    return np.asarray((vertices.min(axis=0) + vertices.max(axis=0)) / 2, np.float64)


def is_left_out(skeleton: Skeleton, part: int, left_out: Collection[str]) -> bool:
    """Whether a part, or any other part of its limb, is among these names."""
    limb = np.flatnonzero(skeleton.limbs == skeleton.limbs[part])
    return any(skeleton.body.names[i] in left_out for i in limb)


@dataclass(frozen=True, eq=False)
class Followed:
    """A point that is followed: of which part, where in its frame (3,), and what moves with it.

    size_m: how much of the body about it is looked at.
    """

    part: int
    p_part: Array
    rigid: tuple[int, ...]
    size_m: float


def followed_points(skeleton: Skeleton, left_out: Collection[str] = ()) -> list[Followed]:
    """The middles of all leaves, and of limbs of two links a point of the lower one near its joint.

    That point shows knee and elbow; it lies far enough from the joint that what is around it
    moves as one.
    """
    points = []
    for leaf in leaves(skeleton):
        if not is_left_out(skeleton, leaf, left_out):
            above = int(skeleton.parents[leaf])
            still = leaf not in skeleton.dof_part and above > 0
            rigid = (leaf, above) if still else (leaf,)
            points.append(Followed(leaf, middle(skeleton, leaf), rigid, _extent(skeleton, leaf)))
    for limb in two_link_limbs(skeleton):
        if limb.leaf != limb.lower and not is_left_out(skeleton, limb.leaf, left_out):
            p = KNEE_SHARE * skeleton.joints[limb.leaf]
            size = _extent(skeleton, limb.lower) / 2
            points.append(Followed(limb.lower, p, (limb.lower,), size))
    return points


def _extent(skeleton: Skeleton, part: int) -> float:
    """The longest side of a part, metres."""
    return float(np.ptp(skeleton.body.parts[part].shape.mesh().vertices, axis=0).max())
