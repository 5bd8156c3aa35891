"""Where limbs hang on the trunk dragged: a shoulder or a hip.

The trunk follows as a whole. Root, chest, neck and head turn, and the body is carried, so that the
dragged joint comes under the pointer while the others of the trunk and the head stay as near to
their places as they can: in the film's own view to where they are seen, in others to where they are
in space. Of all ways to do that it is the one by which the trunk turns least. A drag that leads
farther than the trunk can follow so carries the body with it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from keypose.app.posing.gesture import Gesture, GestureContext, Posed, Readout
from keypose.app.posing.handles import BodyHandle, handles
from keypose.app.posing.moving import Aim, aim, depth_text, distance_text
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.vectors import length
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.least_squares import Criteria, Damping, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import (
    JointLimits,
    PointsInPicture,
    PointsInSpace,
    PosePrior,
    RootPosition,
)
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.solver.terms import Term

TURN_SIGMA_RAD = np.radians(12.0)
SHIFT_SIGMA_M = 0.1
FARTHER_SIGMA_M = 0.03
"""How readily a part of the trunk turns, and the body is carried across the view and along it."""
DRAGGED_SIGMA_M = 0.001
KEPT_SIGMA_M = 0.01
"""How exactly the dragged point follows the pointer, and points that are held stay."""
LIMIT_SIGMA_RAD = np.radians(2.0)
LIMIT_ONSET_RAD = np.radians(2.0)
"""Of `JointLimits`: a limit that holds at once, or not at all, lets the trunk jump where it is just
met on the way."""

NEAREST_M = 0.05
"""Depth of a point that can be seen."""
YIELD_M = 0.12
"""How far a joint can be dragged before the whole body goes along."""
CRITERIA = Criteria(
    most_steps=5,
    longest_step=0.3,
    settled=1e-5,
    rejects=False,
    damping=Damping(first=1e-3, easier=1.0),
)
"""Every step is taken, damped alike: then a small move of the pointer moves the trunk little."""


def drag_corner(
    context: GestureContext, view: PointerView, gesture: Gesture, handle: BodyHandle
) -> Posed:
    """The trunk posed so that a shoulder or a hip comes under the pointer.

    Alt (`carry`) lets the other joints of the trunk go where they will.
    """
    start = context.joint(context.skeleton.body.index(handle.anchor))
    goal = aim(view, start, gesture)
    pose = _Trunk.of(context, view, handle, goal, alone=gesture.carry).solved()
    after = GestureContext.of(context.skeleton, pose, False)
    reached = after.joint(context.skeleton.body.index(handle.anchor))
    readout = Readout(
        label=handle.label,
        value=depth_text(reached, kept=False),
        change="" if goal.line is None else distance_text(reached - start, goal.line),
        part=handle.part,
        depth_m=float(reached[2]),
    )
    return Posed(pose, None, readout)


@dataclass(frozen=True, eq=False)
class _Trunk:
    """What is known of a trunk that is dragged at one of its joints."""

    context: GestureContext
    view: PointerView
    handle: BodyHandle
    goal: Aim
    kept: tuple[str, ...]

    @classmethod
    def of(
        cls, context: GestureContext, view: PointerView, handle: BodyHandle, goal: Aim, alone: bool
    ) -> _Trunk:
        others = (h for h in handles(context.skeleton.body) if h.kind in ("corner", "head"))
        kept = tuple(h.anchor for h in others if h.anchor != handle.anchor)
        return cls(context, view, handle, goal, () if alone else kept)

    def solved(self) -> Pose:
        """The pose that agrees best with all that is asked for."""
        skeleton = turning(self.context.skeleton, self.handle.movers)
        terms = [*self._places(skeleton), *self._priors(skeleton)]
        if self.context.limits_on:
            terms.append(limits_as_posed(self.context, LIMIT_ONSET_RAD))
        problem = OnePose(skeleton, terms)
        return self._shifted(least_squares(problem, self.context.pose, CRITERIA).state)

    def _shifted(self, pose: Pose) -> Pose:
        """The pose with the body carried by what the dragged joint still lacks."""
        p = GestureContext.of(self.context.skeleton, pose, False).joint(self._dragged)
        if self.goal.line is None:
            lacks = self.view.at_depth(self.goal.at, p) - p
        else:
            lacks = self.goal.p_camera - p
        return Pose(pose.Rs_parent_part, pose.p_camera_root + lacks)

    @property
    def _dragged(self) -> int:
        return self.context.skeleton.body.index(self.handle.anchor)

    def _near(self) -> Array:
        """(3,) the goal, or as far on the way to it as the trunk follows by itself."""
        start = self.context.joint(self._dragged)
        offset = self.goal.p_camera - start
        far = length(offset)
        return start + offset * (YIELD_M * math.tanh(far / YIELD_M) / far) if far > 0 else start

    def _places(self, skeleton: Skeleton) -> list[Term]:
        """The dragged joint under the pointer, the kept ones in their places."""
        dragged = self._term(skeleton, (self.handle.anchor,), DRAGGED_SIGMA_M, self._near())
        kept = self._term(skeleton, self.kept, KEPT_SIGMA_M) if self.kept else None
        return [dragged] if kept is None else [dragged, kept]

    def _term(
        self, skeleton: Skeleton, names: tuple[str, ...], sigma_m: float, goal: Array | None = None
    ) -> Term:
        """Points of the body where they are now, or a single one at a goal (3,)."""
        context, camera = self.context, self.view.camera
        parts, places = zip(*(context.point(name) for name in names), strict=True)
        points = BodyPoints.single(skeleton, np.array(parts), np.array(places))
        now = [context.placed(*at) for at in zip(parts, places, strict=True)]
        p = np.array(now if goal is None else [goal])
        if self.goal.line is not None or camera is None or not self.view.is_films:
            return PointsInSpace(points, p, sigma_m)
        scale = np.array([self.view.metres_per_unit(point) for point in p]) / sigma_m
        return PointsInPicture(points, camera, self.view.project(p), scale, NEAREST_M)

    def _priors(self, skeleton: Skeleton) -> list[Term]:
        """The pose as it was."""
        pose = self.context.pose
        sigma = np.where(skeleton.dof_turns == 1, TURN_SIGMA_RAD, SHIFT_SIGMA_M)
        away = self.view.away if self.goal.line is None else np.zeros(3)
        return [
            PosePrior.of(pose, sigma**-2.0),
            RootPosition(pose.p_camera_root, away[None] / FARTHER_SIGMA_M),
        ]


def limits_as_posed(context: GestureContext, onset_rad: float = 0.0) -> JointLimits:
    """Joint limits, but for what is beyond one already, which may stay there."""
    limits = Limits.of(context.skeleton.body)
    posed, _ = limits.excess(context.pose.Rs_parent_part)
    return JointLimits(limits, LIMIT_SIGMA_RAD, posed, onset_rad)


def turning(skeleton: Skeleton, names: tuple[str, ...], shifts: bool = True) -> Skeleton:
    """The body of which some parts turn every way, and the root shifts."""
    parts = [skeleton.body.index(name) for name in names]
    dofs = [(0, 0, axis) for axis in range(3) if shifts]
    dofs += [(i, 1, axis) for i in parts for axis in range(3)]
    part, turns, axis = (np.array(column) for column in zip(*dofs, strict=True))
    return replace(skeleton, dof_part=part, dof_turns=turns, dof_axis=axis)
