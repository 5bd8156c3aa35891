"""A limb of two bones whose joints are where they are seen: each lies on a line of sight.

How far away each is follows from the lengths of the bones, on the side, near or far, where it was.
So one joint that is dragged on the picture leaves the others where they are seen, and their depth
gives way. Where a bone is too short for that, joints come as near to their lines as they can. A
limb whose body is taken much nearer or farther points to the side where it was, unless it clearly
pointed to the other one and the body was not turned: then it only was seen too large or too small.
A bone that lies level has no side of its own: its joint goes to where it is at the frames beside,
or else as the hinge bends.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from keypose.app.posing.elbows import Elbow
from keypose.app.posing.gesture import GestureContext
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.swinging import farness, under_pointer
from keypose.app.posing.two_bones import Reached, TwoBones
from keypose.app.posing.vectors import across, cross, length, smooth_step, turn, unit
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.geometry.rotations import Array

CLEAR = 0.2
"""Of `Elbow`: here the end is to be where it is seen also of a limb that is nearly straight."""

LEVEL = 0.08
CHANGED_M = 0.01
"""Of `farness`: a joint changes sides only where its depth determined next to nothing, and soon, so
that it hardly leaves the pointer."""

NEAR_M = 0.1
FAR_M = 0.25
LEANS = 0.2
"""Taken nearer or farther by more than the first, a bone begins to point to where it was; by the
second it does. One that points nearer or farther by a larger share of its length, more than legs of
somebody who stands do, keeps its side, unless what carries it was turned."""

SAME = 1e-9
"""Entries of a rotation up to which it is the same."""

SIDEWAYS = math.radians(10.0)
NOT_SIDEWAYS = math.radians(30.0)
"""What a hinge lacks is done to its sides up to the first angle; from the second on not at all."""


@dataclass(frozen=True, eq=False)
class SeenLimb:
    """A limb as it is seen in the film's own view, before something is dragged.

    limb:  where its first joint is now.
    sides: of the middle joint as seen from the first one, and of the end as seen from it: how far
           beyond that it lies, in lengths of the bone.
    bends: how far away, of 1, the hinge bends the lower bone to.
    left_m: metres by which the first joint lay farther away.
    beside: as the first of `sides`, at the frames beside; 0 where that is not known, or not asked.
    turned: whether what carries it was turned, not only taken elsewhere.
    """

    limb: TwoBones
    view: PointerView
    sides: tuple[float, float]
    bends: float
    left_m: float = 0.0
    beside: float = 0.0
    turned: bool = False

    @classmethod
    def of(
        cls,
        limb: TwoBones,
        view: PointerView,
        before: GestureContext,
        others: Sequence[Pose] = (),
    ) -> SeenLimb:
        """A limb as it was seen before it was perhaps carried along. others: poses of the frames
        beside."""
        centre, middle = before.joint(limb.upper), before.joint(limb.lower)
        end = before.placed(limb.lower, limb.tip)
        bones = (centre, middle), (middle, end)
        sides = [float(unit(to - start) @ view.ray_through(to)) for start, to in bones]
        bends_to = before.R_camera_part(limb.upper) @ Elbow(limb).natural()
        bends = float(bends_to @ view.ray_through(middle))
        left_m = float(view.depth(centre) - view.depth(limb.centre))
        beside = _side_of(limb, view, others) if abs(sides[0]) <= LEVEL else 0.0
        carriers = (each.R_camera_parent(limb.upper) for each in (before, limb.context))
        turned = bool(np.abs(np.subtract(*carriers)).max() > SAME)
        return cls(limb, view, (sides[0], sides[1]), bends, left_m, beside, turned)

    @property
    def middle_at(self) -> Array:
        """(2,) where the middle joint is seen."""
        return self.view.project(self._elbow.joint)

    @property
    def end_at(self) -> Array:
        """(2,) where the end is seen."""
        return self.view.project(self.limb.end)

    def with_end(self, middle_at: Array, end_at: Array) -> Reached:
        """The limb with its end seen at `end_at` (2,), and its middle joint as near to `middle_at`
        (2,) as that allows."""
        limb = self.limb
        reached = self._bent(self._reaching(self._middle(middle_at), end_at), end_at)
        return Reached(reached.rotations, limb.centre, limb.hinge.farthest_m)

    def with_middle(self, middle_at: Array, end_at: Array) -> Reached:
        """The limb with its middle joint seen at `middle_at` (2,), and its end as near to `end_at`
        (2,) as that allows."""
        return self._bent(self._middle(middle_at), end_at)

    @property
    def _elbow(self) -> Elbow:
        return Elbow(self.limb, CLEAR)

    def _bent(self, middle: Array, end_at: Array) -> Reached:
        limb = self.limb
        before = middle + limb.end - self._elbow.joint
        end = self._end_as_seen(end_at, middle, before, self.sides[1], self.bends)
        return self._sideways(self._elbow.bent(middle, end), end)

    def _middle(self, at: Array) -> Array:
        """(3,) where the upper bone ends on a line of sight, or as near to it as it can. Where the
        bone lies level, the joint goes to its side at the frames beside, or else to that from which
        the lower one bends away."""
        clear = abs(self.beside) > LEVEL
        toward = math.copysign(1.0, self.beside) if clear else -self.bends
        return self._end_as_seen(at, self.limb.centre, self._elbow.joint, self.sides[0], toward)

    def _end_as_seen(
        self, at: Array, centre: Array, before: Array, side: float, toward: float
    ) -> Array:
        drawn = length(self.view.at_depth(at, before) - before)
        share = farness(side, toward, drawn, LEVEL, CHANGED_M)
        if self.turned or abs(side) <= LEANS:
            left = smooth_step((abs(self.left_m) - NEAR_M) / (FAR_M - NEAR_M))
            share += left * (math.copysign(1.0, self.left_m) - share)
        return under_pointer(self.view, at, centre, length(before - centre), share)

    def _reaching(self, middle: Array, end_at: Array) -> Array:
        """(3,) the middle joint, swung until the lower bone reaches the line of sight of the end.

        It is swung in the plane of the first joint, itself, and the point of the line nearest to
        the first joint, which lies at D q: it is L₁ (c q + √(1 − c²) m), of m a share α is along
        the line, and its distance from the line, squared, is
        (α L₁ c)² − 2 L₁ D c + D² + (1 − α²) L₁².
        """
        centre, lower = self.limb.centre, length(self.limb.tip)
        origin, ray = self.view.ray(end_at)
        passing, joint = across(origin - centre, ray), middle - centre
        if length(across(joint - passing, ray)) <= lower:
            return middle
        upper, D, q = length(joint), length(passing), unit(passing)
        m = unit(across(joint, q))
        a = (upper * float(m @ ray)) ** 2
        c = _nearest_root(a, upper * D, D**2 + upper**2 - a - lower**2, float(joint @ q) / upper)
        return np.asarray(centre + upper * (c * q + math.sqrt(max(1.0 - c * c, 0.0)) * m))

    def _sideways(self, bent: Reached, end: Array) -> Reached:
        """Turn sideways what the hinge lacks, as far as the joint's limits allow."""
        limb, context = self.limb, self.limb.context
        after = GestureContext.of(context.skeleton, context.turned(bent.rotations), True)
        R, joint = after.R_camera_part(limb.lower), after.joint(limb.lower)
        tip, wanted = unit(R @ limb.tip), unit(end - joint)
        lacking = math.acos(min(max(float(tip @ wanted), -1.0), 1.0))
        share = 1.0 - smooth_step((lacking - SIDEWAYS) / (NOT_SIDEWAYS - SIDEWAYS))
        if lacking < 1e-6 or share == 0.0 or context.joint_range(limb.lower) is None:
            return bent
        by = turn(unit(cross(tip, wanted)), share * lacking)
        lower = context.allowed(limb.lower, after.R_camera_parent(limb.lower).T @ by @ R)
        return Reached({**bent.rotations, limb.lower: lower}, bent.centre, bent.radius_m)


def _side_of(limb: TwoBones, view: PointerView, poses: Sequence[Pose]) -> float:
    """How far beyond the first joint the middle one lies in poses, in bone lengths."""
    depths = []
    for pose in poses:
        p = pose_transforms(limb.context.skeleton, pose)[:, :3, 3]
        first, middle = p[limb.upper], p[limb.lower]
        depths.append(float(unit(middle - first) @ view.ray_through(middle)))
    return sum(depths) / len(depths) if depths else 0.0


def _nearest_root(a: float, b: float, c: float, start: float) -> float:
    """Where a x² − 2 b x + c, which is above 0 at `start`, first is 0 on the way to its
    least, or that where it never is; at most 1. a, b: not below 0.
    """
    inside = math.sqrt(max(b * b - a * c, 0.0))
    falls = b > a * start
    x = c / max(b + inside, 1e-12) if falls else (b + inside) / max(a, 1e-12)
    if b * b < a * c:
        x = b / a
    return min(x, 1.0)
