"""Where on a body given positions are, and how they move when the body does."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tracker.body.body import ALL_DOFS, ROTATIONS, Body, Point
from tracker.body.pose import twists
from tracker.body.skeleton import Skeleton
from tracker.geometry.rotations import Array

Place: TypeAlias = tuple[tuple[int, Point], ...]
"""A place on a body: the middle of points, each a part's index and metres in that part's frame."""


@dataclass(frozen=True, eq=False)
class Places:
    """Where on a body the given positions are, laid out for the numerics."""

    skeleton: Skeleton
    places: tuple[Place, ...]

    @cached_property
    def _points(self) -> tuple[NDArray[np.int64], Array, Array]:
        """Part (K,) and position (K, 3) of every point, and the mean (J, K) over them."""
        flat = [(j, *point) for j, place in enumerate(self.places) for point in place]
        mean = np.zeros((len(self.places), len(flat)))
        for k, (j, _, _) in enumerate(flat):
            mean[j, k] = 1 / len(self.places[j])
        parts = np.array([part for _, part, _ in flat], dtype=np.int64)
        return parts, np.array([p for _, _, p in flat], dtype=np.float64).reshape(-1, 3), mean

    def at(self, Ts_camera_part: Array) -> Array:
        """Positions (..., J, 3) in the camera frame."""
        parts, p, mean = self._points
        T = Ts_camera_part[..., parts, :, :]
        return np.asarray(mean @ ((T[..., :3, :3] @ p[..., None])[..., 0] + T[..., :3, 3]))

    def moving(self, Ts_camera_part: Array) -> tuple[Array, Array]:
        """Positions (J, 3) of one pose and their slopes (J, 3, D)."""
        parts, p, mean = self._points
        T = Ts_camera_part[parts]
        points: Array = (T[:, :3, :3] @ p[..., None])[..., 0] + T[:, :3, 3]
        S = twists(self.skeleton, Ts_camera_part)
        slopes = S[None, :, :3] + np.cross(S[None, :, 3:], points[:, None, :])
        slopes *= self.skeleton.below[parts][:, self.skeleton.dof_part][..., None]
        return mean @ points, np.tensordot(mean, np.swapaxes(slopes, 1, 2), axes=1)

    def of_part(self, part: int) -> list[tuple[int, Array]]:
        """Single points that stand still in a part's frame, with their place there: its own, and
        the joints of what hangs on it."""
        still = []
        for j, place in enumerate(self.places):
            if len(place) == 1:
                owner, p = place[0]
                if owner == part:
                    still.append((j, np.array(p)))
                elif self.skeleton.parents[owner] == part and not np.any(p):
                    still.append((j, self.skeleton.joints[owner]))
        return still


def freed(body: Body) -> Skeleton:
    """The body with every part free to turn in every way."""
    parts = (
        part.model_copy(update={"tracked": ROTATIONS if part.parent else ALL_DOFS})
        for part in body.parts
    )
    return Skeleton.of(body.model_copy(update={"parts": tuple(parts)}))
