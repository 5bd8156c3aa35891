"""Where on a body given positions are, and how they move when the body does."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import ALL_DOFS, ROTATIONS, Body, Point
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import Posed

BodyPoint: TypeAlias = tuple[tuple[int, Point], ...]
"""A place on a body: the middle of points, each a part's index and metres in that part's frame."""


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
        T = Ts_camera_part[..., parts, :, :]
        return _average(mean, (T[..., :3, :3] @ p[..., None])[..., 0] + T[..., :3, 3])

    def of(self, posed: Posed) -> Array:
        """Positions (..., J, 3) on a posed body, camera frame."""
        return self.at(posed.Ts_camera_part)

    def jacobian(self, posed: Posed) -> tuple[Array, Array]:
        """Positions (..., J, 3) and how they move (..., J, D, 3) with each degree of freedom."""
        parts, p_part, mean = self._points
        p = posed.points(parts, p_part)
        J = posed.point_jacobian(parts, p)
        if mean is None:
            return p, J
        return mean @ p, np.einsum("jk,...kdc->...jdc", mean, J, optimize=True)

    def only(self, chosen: NDArray[np.bool_]) -> BodyPoints:
        """Some of the places (J,)."""
        if chosen.all():
            return self  # with its cached arrays
        some = (place for place, wanted in zip(self.points, chosen, strict=True) if wanted)
        return BodyPoints(self.skeleton, tuple(some))

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


def _average(mean: Array | None, p: Array) -> Array:
    return np.asarray(p if mean is None else mean @ p)


def with_free_parts(skeleton: Skeleton, names: Collection[str]) -> Skeleton:
    """The skeleton with the parts of these names free to turn about all axes."""
    some = (
        part.model_copy(update={"tracked": (*(d for d in part.tracked if d[0] == "t"), *ROTATIONS)})
        if part.name in names
        else part
        for part in skeleton.body.parts
    )
    return Skeleton.of(skeleton.body.replaced(some))


def free_skeleton(body: Body) -> Skeleton:
    """The body with every part free to turn in every way."""
    parts = (
        part.model_copy(update={"tracked": ROTATIONS if part.parent else ALL_DOFS})
        for part in body.parts
    )
    return Skeleton.of(body.model_copy(update={"parts": tuple(parts)}))
