"""Sizes of a box from where its corners are seen, together with its pose.

One view does not tell how large a thing is, only its proportions: the volume stays. Six corners
leave nothing of these open, four of one side nearly everything of the third edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.body_points import BodyPoints
from keypose.tracker.solver.least_squares import (
    Criteria,
    Damping,
    Problem,
    damped_step,
    least_squares,
)
from keypose.tracker.solver.pose_terms import PointsInPicture
from keypose.tracker.solver.posed import Posed, image_jacobian
from keypose.tracker.solver.terms import Equations, Rows, Term, total_cost, total_equations

EDGE_SIGMA, VOLUME_SIGMA = 0.5, 1e-3
"""Of the logarithms of an edge's ratio to the one before, and of the volume's."""
_PRECISION = np.eye(3) / EDGE_SIGMA**2 + np.ones((3, 3)) / VOLUME_SIGMA**2
CRITERIA = Criteria(
    most_steps=60, longest_step=0.3, settled=1e-6, gain=1e-6, gain_floor=1e-3,
    damping=Damping(least=1e-9),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class SizedPose:
    """A pose, and the logarithms (3,) of how many times as long the box's edges are."""

    pose: Pose
    edges: Array

    @property
    def ratios(self) -> Array:
        """(3,)"""
        return np.exp(self.edges)


@dataclass(frozen=True, eq=False)
class SizedBox(Problem[SizedPose, "_SizedPoint"]):
    """The box that agrees best with its corners and the terms of its pose.

    part: its number.  seen: its corners with its sizes as they are.
    """

    part: int
    seen: PointsInPicture
    terms: Sequence[Term]

    def solved(self, start: Pose) -> SizedPose:
        """The pose and sizes that are reached from a pose with the sizes as they are."""
        return least_squares(self, SizedPose(start, np.zeros(3)), CRITERIA).state

    def at(self, state: SizedPose, count: int) -> _SizedPoint:
        return _SizedPoint(self, state)

    def moved(self, state: SizedPose, step: Array) -> SizedPose:
        pose = moved(self.seen.points.skeleton, state.pose, step[:-3])
        return SizedPose(pose, state.edges + step[-3:])

    def corners(self, ratios: Array) -> Array:
        """(K, 3) those that are seen, in the part's frame."""
        points = self.seen.points.points
        return np.array([place[0][1] for place in points]) * ratios

    def seen_at(self, ratios: Array) -> PointsInPicture:
        """The corners with such sizes, seen where they were."""
        corners, skeleton = self.corners(ratios), self.seen.points.skeleton
        points = BodyPoints.single(skeleton, np.full(len(corners), self.part), corners)
        return replace(self.seen, points=points)


@dataclass(frozen=True, eq=False)
class _SizedPoint:
    """What is known at a pose with sizes."""

    box: SizedBox
    state: SizedPose

    @cached_property
    def _posed(self) -> Posed:
        return Posed.of(self.box.seen.points.skeleton, self.state.pose)

    @cached_property
    def _seen(self) -> PointsInPicture:
        return self.box.seen_at(self.state.ratios)

    @cached_property
    def cost(self) -> float:
        prior = self.state.edges @ _PRECISION @ self.state.edges
        return total_cost([self._seen, *self.box.terms], self._posed) + 0.5 * float(prior)

    def step(self, damping: float) -> Array | None:
        seen = self._seen.rows(self._posed)
        both = Equations.of(Rows(seen.r, np.hstack([seen.J, self._edge_jacobian()]), seen.cost))
        pose, A, b = total_equations(self.box.terms, self._posed), both.A.copy(), both.b.copy()
        A[:-3, :-3] += pose.A
        b[:-3] += pose.b
        A[-3:, -3:] += _PRECISION
        b[-3:] += _PRECISION @ self.state.edges
        return damped_step(A, b, damping)

    def _edge_jacobian(self) -> Array:
        """(2 K, 3) how the corners' pixels move, in sigmas, as edges grow."""
        R = self._posed.Ts_camera_part[self.box.part, :3, :3]
        corners = self.box.corners(self.state.ratios)
        J = corners[:, :, None] * R.T  # each edge grows along its own axis
        p = self._seen.points.of(self._posed)
        uv = image_jacobian(self._seen.camera, p, J) * self._seen.scale[:, None, None]
        return np.swapaxes(uv, 1, 2).reshape(-1, 3)
