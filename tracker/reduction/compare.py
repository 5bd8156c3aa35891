"""A motion and what interpolation between some of its frames makes of it, point by point."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Part
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.intervals import interval_costs, interval_misses, reached_from
from keypose.tracker.kernels.layout import ComparedBody, DenseMotion, IntervalWork, Lens, Limits
from keypose.tracker.reduction.result import Tolerance

Frames = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Intervals of a motion, each compared with interpolation between its ends.

    Frames here count from the motion's first. tolerance: None where no miss is too large; they are
    in metres then, and otherwise shares of the tolerance. parts: those that are interpolated and
    compared, all where None; the others move as they do.  path: of the camera over the motion,
    whose poses are in its frame; they are interpolated in the world. None where it stands still.
    """

    skeleton: Skeleton
    camera: Camera
    motion: Trajectory
    tolerance: Tolerance | None = None
    parts: frozenset[int] | None = None
    path: CameraPath | None = None

    @cached_property
    def known(self) -> NDArray[np.bool_]:
        """(N,) the frames with a pose: all of it finite."""
        Rs, ps = self.motion.Rs_parent_part, self.motion.ps_camera_root
        return np.asarray(np.isfinite(Rs).all(axis=(1, 2, 3)) & np.isfinite(ps).all(axis=1))

    def reached(self, froms: Frames, tos: Frames) -> NDArray[np.bool_]:
        """(len(tos),) whether interpolation from any of the frames leads there within limits."""
        is_reached = np.zeros(len(tos), dtype=np.bool_)
        reached_from(*self._arrays, froms, tos, self._work(), is_reached)
        return is_reached

    def costs(self, froms: Frames, tos: Frames) -> Array:
        """(len(froms), len(tos)) the sum over the frames between of the squared miss; infinite
        where a frame is off by more than the tolerance."""
        found = np.empty((len(froms), len(tos)))
        interval_costs(*self._arrays, froms, tos, self._work(), found)
        return found

    def misses(self, first: int, last: int) -> Array:
        """(last − first − 1,) the miss of each frame between two."""
        squares = np.zeros(max(last - first - 1, 0))
        interval_misses(*self._arrays, first, last, self._work(give_up=False), squares)
        return np.sqrt(squares)

    def _work(self, give_up: bool = True) -> IntervalWork:
        P = self.skeleton.part_count
        return IntervalWork(
            np.empty((P, 3)),
            np.empty((P, 3, 3)),
            np.empty((P, 3)),
            np.empty((2, 3, 3)),
            np.empty(3),
            np.empty(P, np.int64),
            np.array([-1, 0]),
            np.array([give_up]),
        )

    @cached_property
    def _arrays(self) -> tuple[DenseMotion, ComparedBody, Limits, Lens]:
        body = _compared_body(self.skeleton, self.parts)
        of = np.repeat(np.arange(self.skeleton.part_count), np.diff(body.starts))
        path = self.path or CameraPath.standing_still(len(self.motion))
        placed = self.motion if self.path is None else self.motion.carried(path.Ts_world_camera)
        Rs, ps = placed.writable()
        T = placed.transforms(self.skeleton)[:, of]
        points = (T[..., :3, :3] @ body.points[..., None])[..., 0] + T[..., :3, 3]
        camera = self.camera
        lens = Lens(
            camera.fx,
            camera.fy,
            camera.cx,
            camera.cy,
            int(camera.projection == "perspective"),
            camera.telephoto_distance_m or 1.0,
        )
        return (
            DenseMotion(
                Rs,
                ps,
                np.ascontiguousarray(points),
                self.known,
                np.array(path.Ts_camera_world),
                np.array(path.zoom),
            ),
            body,
            _limits(self.tolerance),
            lens,
        )


def _limits(tolerance: Tolerance | None) -> Limits:
    if tolerance is None:
        return Limits(metres=1.0, pixels=math.inf, largest=math.inf)
    return Limits(tolerance.metres, tolerance.pixels, largest=1.0)


def _compared_body(skeleton: Skeleton, parts: Collection[int] | None) -> ComparedBody:
    chosen = range(skeleton.part_count) if parts is None else parts
    points: list[tuple[float, ...]] = []
    starts = [0]
    for i, part in enumerate(skeleton.body.parts):
        points += _points_of(part) if i in chosen else []
        starts.append(len(points))
    return ComparedBody(
        np.array(skeleton.parents),
        np.array(skeleton.joints),
        np.array(points, dtype=np.float64).reshape(-1, 3),
        np.array(starts, dtype=np.int64),
        np.array([i in chosen for i in range(skeleton.part_count)]),
    )


def _points_of(part: Part) -> list[tuple[float, ...]]:
    """A part's joint, its landmarks and marks, and its sides in the middle.

    Not all of them lie on one line, so that a turn about any axis moves some, about a limb's own
    length those on its sides.
    """
    x, y, z = part.shape.centre
    a, b = part.shape.half_widths(y)
    sides = [(x + a, y, z), (x - a, y, z), (x, y, z + b), (x, y, z - b)]
    return [(0.0, 0.0, 0.0), *part.landmarks.values(), *map(tuple, part.shape.marks()), *sides]
