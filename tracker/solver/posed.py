"""Pose a body: where points of it are, and how they move with it (Jacobians).

Everything works on any batch axes before the named ones: one pose, or those of many frames. Motions
are x (D,) over the tracked degrees of freedom, on the right, in each part's own frame: R · exp(x).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import ALL_DOFS, ROTATIONS, Body, Point
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.layout import Places
from keypose.tracker.solver.plain_placed import PlainPlaced

if TYPE_CHECKING:
    from keypose.tracker.solver.placed import Placed


@dataclass(frozen=True, eq=False)
class Posed:
    """A body as posed: what several terms need of it is computed once.

    Rs_parent_part (..., P, 3, 3), p_camera_root (..., 3): as in Pose.
    """

    skeleton: Skeleton
    Rs_parent_part: Array
    p_camera_root: Array

    @classmethod
    def of(cls, skeleton: Skeleton, pose: Pose) -> Posed:
        """A body in one pose."""
        return cls(skeleton, pose.Rs_parent_part, pose.p_camera_root)

    @property
    def batch(self) -> tuple[int, ...]:
        """The axes of its poses; none where it is one."""
        return self.p_camera_root.shape[:-1]

    @cached_property
    def placed(self) -> Placed | PlainPlaced:
        """All N poses, one after another: many by the loops, one without them."""
        R, p = self.each(self.Rs_parent_part, 3), self.each(self.p_camera_root, 1)
        if not self.batch:
            return PlainPlaced(self.skeleton, R, p)
        from keypose.tracker.solver.placed import Placed  # loops: who poses by hand needs none

        return Placed.of(self.skeleton, R, p)

    @cached_property
    def Ts_camera_part(self) -> Array:
        """(..., P, 4, 4)"""
        T = self.placed.Ts_camera_part
        return T.reshape(*self.batch, *T.shape[1:])

    @cached_property
    def twists(self) -> Array:
        """(..., D, 6) of the degrees of freedom, as `keypose.tracker.body.pose.twists`."""
        return self.placed.twists.reshape(*self.batch, -1, 6)

    def points(self, parts: NDArray[np.int64], points: Array) -> Array:
        """Points (..., K, 3) in the camera frame of points (K, 3) in the frames of parts (K,)."""
        return points_on_parts(self.Ts_camera_part, parts, points)

    def point_jacobian(self, parts: NDArray[np.int64], p: Array) -> Array:
        """(..., K, D, 3) how points p (..., K, 3) in the camera frame move, carried by parts."""
        S = self.twists[..., None, :, :]
        vx, vy, vz, wx, wy, wz = (S[..., k] for k in range(6))
        x, y, z = (p[..., None, k] for k in range(3))
        J = np.empty((*p.shape[:-1], self.skeleton.dof_count, 3))
        J[..., 0] = vx + (wy * z - wz * y)  # v + w × p, component by component: it is quicker
        J[..., 1] = vy + (wz * x - wx * z)
        J[..., 2] = vz + (wx * y - wy * x)
        J *= self.skeleton.below[parts][:, self.skeleton.dof_part][..., None]
        return J

    def motion_from(
        self, Rs_parent_part: Array, p_camera_root: Array, backward: bool = True
    ) -> Array:
        """(..., D) the tracked part of the motion that leads here from another pose.

        backward: the root's shift in its frame here, so that the motion's negative leads back;
            otherwise in its frame there, so that the motion leads from there to here.
        """
        motion = self.placed.motion_from(
            self.each(Rs_parent_part, 3), self.each(p_camera_root, 1), backward=backward
        )
        return motion.reshape(*self.batch, -1)

    def each(self, values: Array, own: int) -> Array:
        """(N, …) a copy of values, so many axes of their own, for all poses alike or for each.

        Row by row: for another order in memory loops would be compiled once more.
        """
        shape = (*self.batch, *values.shape[values.ndim - own :])
        copy = np.array(np.broadcast_to(values, shape), order="C")
        return copy.reshape(-1, *shape[len(self.batch) :])


def points_on_parts(Ts_camera_part: Array, parts: NDArray[np.int64], points: Array) -> Array:
    """Points (..., K, 3) in the camera frame of points (K, 3) in the frames of parts (K,)."""
    T = Ts_camera_part[..., parts, :, :]
    return np.asarray((T[..., :3, :3] @ points[..., None])[..., 0] + T[..., :3, 3])


BodyPoint: TypeAlias = tuple[tuple[int, Point], ...]
"""A place on a body: the middle of points, each a part's index and metres in that part's frame."""


def places_of(
    skeleton: Skeleton, counts: Sequence[int], parts: NDArray[np.int64], points: Array
) -> Places:
    """Places on a body, each the mean of so many points (K, 3) in the frames of parts (K,)."""
    starts = np.cumsum([0, *counts])
    moves = np.ascontiguousarray(skeleton.below[parts][:, skeleton.dof_part])
    moved = [np.flatnonzero(moves[first:last].any(axis=0)) for first, last in pairwise(starts)]
    dof_starts = np.cumsum([0, *(len(dofs) for dofs in moved)])
    dofs = np.concatenate([*moved, np.zeros(0, np.int64)])
    return Places(starts, parts, points, dof_starts, dofs, moves)


@dataclass(frozen=True, eq=False)
class BodyPoints:
    """Where on a body the given positions are, with arrays for the numerics."""

    skeleton: Skeleton
    points: tuple[BodyPoint, ...]

    @classmethod
    def single(cls, skeleton: Skeleton, parts: NDArray[np.int64], points: Array) -> BodyPoints:
        """Single points (K, 3) in the frames of parts (K,)."""
        flat = zip(parts.tolist(), points.tolist(), strict=True)
        return cls(skeleton, tuple(((part, (x, y, z)),) for part, (x, y, z) in flat))

    @cached_property
    def _points(self) -> tuple[NDArray[np.int64], Array, Array | None]:
        """Part (K,) and position (K, 3) of every point, and the mean (J, K) over them; None where
        every place is a single point."""
        flat = [(j, *point) for j, place in enumerate(self.points) for point in place]
        mean = np.zeros((len(self.points), len(flat)))
        for k, (j, _, _) in enumerate(flat):
            mean[j, k] = 1 / len(self.points[j])
        parts = np.array([part for _, part, _ in flat], dtype=np.int64)
        points = np.array([p for _, _, p in flat], dtype=np.float64).reshape(-1, 3)
        return parts, points, None if all(len(place) == 1 for place in self.points) else mean

    def at(self, Ts_camera_part: Array) -> Array:
        """Positions (..., J, 3) in the camera frame."""
        parts, p, mean = self._points
        where = points_on_parts(Ts_camera_part, parts, p)
        return where if mean is None else np.asarray(mean @ where)

    @cached_property
    def places(self) -> Places:
        """The same for the loops."""
        parts, points, _ = self._points
        return places_of(self.skeleton, [len(place) for place in self.points], parts, points)

    def of(self, posed: Posed) -> Array:
        """Positions (..., J, 3) on a posed body, camera frame."""
        return posed.placed.positions(self.places).reshape(*posed.batch, -1, 3)

    def jacobian(self, posed: Posed) -> tuple[Array, Array]:
        """Positions (..., J, 3) and how they move (..., J, D, 3) with each degree of freedom."""
        p, J = posed.placed.jacobian(self.places)
        return p.reshape(*posed.batch, -1, 3), J.reshape(*posed.batch, *J.shape[1:])

    def of_skeleton(self, skeleton: Skeleton) -> BodyPoints:
        """The same of the same body with other parts tracked."""
        return BodyPoints(skeleton, self.points)

    def only(self, chosen: NDArray[np.bool_]) -> BodyPoints:
        """Some of the places (J,)."""
        if chosen.all():
            return self  # with its cached arrays
        chosen_places = (place for place, wanted in zip(self.points, chosen, strict=True) if wanted)
        return BodyPoints(self.skeleton, tuple(chosen_places))

    def of_part(self, part: int) -> list[tuple[int, Array]]:
        """Single points that are fixed in a part's frame, with their position there: its own, and
        the joints of its children."""
        fixed = []
        for j, place in enumerate(self.points):
            if len(place) == 1:
                owner, p = place[0]
                if owner == part:
                    fixed.append((j, np.array(p)))
                elif self.skeleton.parents[owner] == part and not np.any(p):
                    fixed.append((j, self.skeleton.joints[owner]))
        return fixed


def joints_and_landmarks(skeleton: Skeleton) -> BodyPoints:
    """Every joint of a body, then every landmark."""
    joints = [((i, (0.0, 0.0, 0.0)),) for i in range(skeleton.part_count)]
    parts = enumerate(skeleton.body.parts)
    ends = [((i, p),) for i, part in parts for p in part.landmarks.values()]
    return BodyPoints(skeleton, (*joints, *ends))


def with_free_parts(skeleton: Skeleton, names: Collection[str]) -> Skeleton:
    """The skeleton with the parts of these names free to turn about all axes."""
    parts = (
        part.model_copy(update={"tracked": (*(d for d in part.tracked if d[0] == "t"), *ROTATIONS)})
        if part.name in names
        else part
        for part in skeleton.body.parts
    )
    return Skeleton.of(skeleton.body.replaced(parts))


def free_skeleton(body: Body) -> Skeleton:
    """The body with every part free to turn in every way."""
    parts = (
        part.model_copy(update={"tracked": ROTATIONS if part.parent else ALL_DOFS})
        for part in body.parts
    )
    return Skeleton.of(body.model_copy(update={"parts": tuple(parts)}))
