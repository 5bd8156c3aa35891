"""Pose boxes by their corners, and find their sizes with the pose from six of them.

One view does not tell how large a thing is, only its proportions: the volume stays. Six corners
leave nothing of these open, four of one side nearly everything of the third edge.

A corner that was dragged stays there while others are. The first carries the box across the
picture, a second turns it there and brings it nearer or farther, a third tilts it, and from the
fourth on the pose is the one that agrees best with all of them: of those poses that do so equally
well the one that is nearest to the pose before. Sizes stay, unless six corners are in their places,
these sizes cannot reach them, and nothing else was posed with these sizes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from keypose.app.posing.gesture import (
    BoxCorner,
    Gesture,
    GestureContext,
    PlacedCorner,
    Posed,
    Readout,
)
from keypose.app.posing.labels import number_text, part_label
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.resizing import part_sizes, with_size
from keypose.app.posing.trunk import limits_as_posed, turning
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import BodyError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.least_squares import (
    Criteria,
    Damping,
    Problem,
    damped_step,
    least_squares,
)
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import PointsInPicture, PosePrior, RootPosition
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.solver.posed import Posed as SolverPosed
from keypose.tracker.solver.projection import image_jacobian, image_points
from keypose.tracker.solver.terms import Term, total_cost, total_equations

EDGE_SIGMA = 0.5
VOLUME_SIGMA = 1e-3
"""Of the logarithms of an edge's ratio to the one before, and of the volume's."""
_PRECISION = np.eye(3) / EDGE_SIGMA**2 + np.ones((3, 3)) / VOLUME_SIGMA**2
SIZES_CRITERIA = Criteria(
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
        return least_squares(self, SizedPose(start, np.zeros(3)), SIZES_CRITERIA).state

    def at(self, state: SizedPose, count: int) -> _SizedPoint:
        return _SizedPoint(self, state)

    def moved(self, state: SizedPose, step: Array) -> SizedPose:
        pose = moved(self.seen.points.skeleton, state.pose, step[:-3])
        return SizedPose(pose, state.edges + step[-3:])

    def corners(self, ratios: Array) -> Array:
        """(K, 3) those that are seen, in the part's frame."""
        points = self.seen.points.points
        return np.array([place[0][1] for place in points]) * ratios

    def projected(self, ratios: Array) -> PointsInPicture:
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
    def _posed(self) -> SolverPosed:
        return SolverPosed.of(self.box.seen.points.skeleton, self.state.pose)

    @cached_property
    def _seen(self) -> PointsInPicture:
        return self.box.projected(self.state.ratios)

    @cached_property
    def cost(self) -> float:
        prior = self.state.edges @ _PRECISION @ self.state.edges
        return total_cost([self._seen, *self.box.terms], self._posed) + 0.5 * float(prior)

    def step(self, damping: float) -> Array | None:
        J, r = self._rows()
        pose, A, b = total_equations(self.box.terms, self._posed), J.T @ J, J.T @ r
        A[:-3, :-3] += pose.A
        b[:-3] += pose.b
        A[-3:, -3:] += _PRECISION
        b[-3:] += _PRECISION @ self.state.edges
        return damped_step(A, b, damping)

    def _rows(self) -> tuple[Array, Array]:
        """(2 K, D + 3) how the corners' pixels move, in sigmas, with the pose and as edges grow,
        and (2 K,) how far they are away."""
        points_in_picture, R = self._seen, self._posed.Ts_camera_part[self.box.part, :3, :3]
        p, by_pose = points_in_picture.points.jacobian(self._posed)
        corners = self.box.corners(self.state.ratios)
        by_edges = corners[:, :, None] * R.T  # each edge grows along its own axis
        J = image_jacobian(points_in_picture.camera, p, np.concatenate([by_pose, by_edges], axis=1))
        scaled = np.swapaxes(J, 1, 2) * points_in_picture.scale[:, None, None]
        away = (
            image_points(points_in_picture.camera, p) - points_in_picture.uv
        ) * points_in_picture.scale[:, None]
        return scaled.reshape(away.size, -1), away.ravel()


CORNER_SIGMA_PX = 1.0
"""How well a person sees where a corner is."""
TURN_SIGMA_RAD = np.radians(10.0)
SHIFT_SHARE = 3.0
"""Of the pose before, the shift as a share of the distance: it decides what corners leave open, so
that the box is rather shifted than turned."""
DECIDED = 10.0
"""So many times wider these are where corners leave nothing open."""
DEPTH_SHARE = 0.001
"""Of the distance, which parallel rays do not show."""
NEAREST_M = 0.05
CRITERIA = Criteria(
    most_steps=60, longest_step=0.5, settled=1e-6, gain=1e-6, gain_floor=1e-3,
    damping=Damping(least=1e-9),
)  # fmt: skip
DECIDING = 4
SIZING = 6
"""So many corners leave nothing of the pose open, and nothing of the sizes."""
POOR_PX = 2.5
BETTER = 0.5
"""Where they are missed by more, root mean square, a box that is seen from its other side is tried,
and other sizes; what misses them by less than that share is taken."""


def drag_box_corner(
    context: GestureContext,
    view: PointerView,
    gesture: Gesture,
    handle: BoxCorner,
    placed: tuple[PlacedCorner, ...],
    free_sizes: bool = False,
) -> Posed:
    """The box posed so that a corner comes under the pointer and those placed before stay.

    placed: of this part or others; Alt (`carry`) lets go of them. free_sizes: its sizes may change.
    """
    if view.camera is None or not view.is_films:
        raise BodyError("Corners of a box are dragged in the camera view.")
    body = context.skeleton.body
    part = body.index(handle.part)
    corners = body.parts[part].shape.corners()
    if corners is None:
        raise BodyError(f"{part_label(handle.part)} is not a box: it has no corners.")
    start = context.placed(part, corners[handle.index])
    u, v = view.moved(start, gesture.from_, gesture.at).tolist()
    others = () if gesture.carry else _of_others(placed, handle)
    now = (*others, PlacedCorner(handle.part, handle.index, (u, v)))
    free_sizes = free_sizes and all(child.parent != handle.part for child in body.parts)
    fit = _BoxCornerFit.of(context, view, part, corners, now)
    pose = fit.solved()
    missed = fit.missed_px(pose)
    sized = fit.sized(pose) if free_sizes and len(now) >= SIZING and missed > POOR_PX else None
    if sized is not None:
        pose, missed = sized.pose, fit.missed_px(sized.pose, sized.ratios)
    off = f"off by {number_text(missed, 1)} px" if len(now) >= DECIDING else ""
    readout = Readout(
        label=f"{part_label(handle.part)} corner",
        value=_count_text(len(now), free_sizes),
        change=off if sized is None else f"sizes fitted, {off}",
        part=handle.part,
        corners=now,
    )
    resized = None if sized is None else _resized(body, handle.part, sized.ratios)
    return Posed(pose, resized, readout)


def _resized(body: Body, part: str, ratios: Array) -> Body:
    """The box with its edges so many times as long."""
    cm_of_size = {size.key: size.cm for size in part_sizes(body, part)}
    for key, ratio in zip(("width", "length", "depth"), ratios, strict=True):
        body = with_size(body, part, key, float(cm_of_size[key] * ratio), linked=False)
    return body


def _of_others(placed: tuple[PlacedCorner, ...], handle: BoxCorner) -> tuple[PlacedCorner, ...]:
    return tuple(
        placed_corner
        for placed_corner in placed
        if placed_corner.part == handle.part and placed_corner.index != handle.index
    )


def _count_text(count: int, free_sizes: bool) -> str:
    if count < DECIDING:
        return f"{count} of {DECIDING} placed"
    more = SIZING - count
    return (
        f"{count} placed, {more} more fit its sizes"
        if free_sizes and more > 0
        else f"{count} placed"
    )


def _prior(skeleton: Skeleton, pose: Pose, is_decided: bool) -> PosePrior:
    """The pose before."""
    shift = SHIFT_SHARE * float(pose.p_camera_root[2])
    sigma = np.where(skeleton.dof_turns == 1, TURN_SIGMA_RAD, shift)
    return PosePrior.of(pose, (sigma * (DECIDED if is_decided else 1.0)) ** -2.0)


@dataclass(frozen=True, eq=False)
class _BoxCornerFit:
    """A box, where some of its corners are seen, and the pose before."""

    context: GestureContext
    part: int
    seen: PointsInPicture
    terms: tuple[Term, ...]

    @classmethod
    def of(
        cls,
        context: GestureContext,
        view: PointerView,
        part: int,
        corners: Array,
        placed: tuple[PlacedCorner, ...],
    ) -> _BoxCornerFit:
        assert view.camera is not None
        whole = turning(context.skeleton, (context.skeleton.body.names[part],), shifts=part == 0)
        points = BodyPoints.single(
            whole,
            np.full(len(placed), part),
            corners[[placed_corner.index for placed_corner in placed]],
        )
        uv = np.array([corner.uv for corner in placed])
        scale = np.full(len(placed), 1 / CORNER_SIGMA_PX)
        points_in_picture = PointsInPicture(points, view.camera, uv, scale, NEAREST_M)
        terms: list[Term] = [
            points_in_picture,
            _prior(whole, context.pose, len(placed) >= DECIDING),
        ]
        if not view.is_perspective:
            terms.append(RootPosition.depth(context.pose.p_camera_root, DEPTH_SHARE))
        if context.limits_on:
            terms.append(limits_as_posed(context))
        return cls(context, part, points_in_picture, tuple(terms))

    def solved(self) -> Pose:
        """The pose that is reached from the one before; from its mirror images where corners that
        decide are missed there."""
        near = self._from(self.context.pose)
        missed = self.missed_px(near)
        if len(self.seen.uv) < DECIDING or missed < POOR_PX:
            return near
        others = [self._from(start) for start in self._mirrored(near)]
        best = min(others, key=self.missed_px)
        return best if self.missed_px(best) < BETTER * missed else near

    def sized(self, near: Pose) -> SizedPose | None:
        """The pose and sizes that miss the corners least; None where these are hardly better."""
        terms = tuple(term for term in self.terms if term is not self.seen)
        box = SizedBox(self.part, self.seen, terms)

        def missed(sized_pose: SizedPose) -> float:
            return self.missed_px(sized_pose.pose, sized_pose.ratios)

        best = box.solved(near)
        if missed(best) > POOR_PX:
            best = min((best, *map(box.solved, self._mirrored(near))), key=missed)
        return best if missed(best) < BETTER * self.missed_px(near) else None

    def missed_px(self, pose: Pose, ratios: Array | None = None) -> float:
        """Root mean square distance of the corners from where they were placed, pixels."""
        points_in_picture = self.seen
        if ratios is not None:
            points_in_picture = SizedBox(self.part, points_in_picture, ()).projected(ratios)
        p = points_in_picture.points.at(
            GestureContext.of(self.context.skeleton, pose, False).Ts_camera_part
        )
        off = self.seen.camera.project(p) - self.seen.uv
        return float(np.sqrt((off**2).sum(-1).mean()))

    def _from(self, start: Pose) -> Pose:
        problem = OnePose(self.seen.points.skeleton, self.terms)
        return least_squares(problem, start, CRITERIA).state

    def _mirrored(self, pose: Pose) -> list[Pose]:
        """Mirrored along the line of sight, and back into a rotation along an axis of the box.

        A face of a box looks nearly the same in both, and more so the farther away it is.
        """
        after = GestureContext.of(self.context.skeleton, pose, False)
        sight = after.placed(self.part, self.seen.points.of_part(self.part)[0][1])
        d = sight / np.sqrt(sight @ sight)
        mirror = np.eye(3) - 2 * np.outer(d, d)
        R_parent, R = after.R_camera_parent(self.part), after.R_camera_part(self.part)
        axes = (np.diag(np.where(np.arange(3) == k, -1.0, 1.0)) for k in range(3))
        return [after.turned({self.part: R_parent.T @ mirror @ R @ axis}) for axis in axes]
