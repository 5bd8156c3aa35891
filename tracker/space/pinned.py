"""What pins of a stretch hold, and what of the body and its frames lies near them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.pose_terms import PointsInSpace, PosePrior
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.solver.sigmas import KNEE_RAD

KNEES: Final = ("left_shin", "right_shin")
"""Parts that turn in a knee."""


@dataclass(frozen=True)
class PinnedPoint:
    """A point of the body that stays at one place from one frame to another, both included.

    above_floor_m: how high that place is above the floor; None where it may be anywhere.
    """

    part: int
    p_part: tuple[float, float, float]
    first_frame: int
    last_frame: int
    above_floor_m: float | None = None

    @property
    def floor(self) -> bool:
        """Whether its place is known by the floor."""
        return self.above_floor_m is not None

    def rows(self, motion: Trajectory) -> slice:
        """The frames of a motion over which it is held."""
        first = motion.first_frame
        return slice(self.first_frame - first, self.last_frame + 1 - first)

    def nearness(self, motion: Trajectory, fade: int) -> Array:
        """(N,) 1 at the frames over which it is held, less and less over so many before and after,
        0 beyond."""
        frames = motion.first_frame + np.arange(len(motion))
        off = np.maximum(self.first_frame - frames, frames - self.last_frame)
        return np.asarray(1 - np.clip(off, 0, fade + 1) / (fade + 1))


@dataclass(frozen=True, eq=False)
class HeldPoint:
    """A point of the body that is at known places, p_camera (n, 3), at n frames one after the
    other."""

    part: int
    p_part: tuple[float, float, float]
    first_frame: int
    p_camera: Array

    @property
    def last_frame(self) -> int:
        """The last frame at which it is held."""
        return self.first_frame + len(self.p_camera) - 1

    def nearness(self, motion: Trajectory, fade: int) -> Array:
        """As of a point that stays at one place."""
        pinned = PinnedPoint(self.part, self.p_part, self.first_frame, self.last_frame)
        return pinned.nearness(motion, fade)


def at_places(
    skeleton: Skeleton, motion: Trajectory, held: Sequence[HeldPoint], sigma_m: float
) -> tuple[PointsInSpace, ...]:
    """Held points at their places, over the frames at which they are."""
    terms = []
    for point in held:
        positions = np.zeros((len(motion), 1, 3))
        sigma = np.full((len(motion), 1, 1), np.inf)
        start = point.first_frame - motion.first_frame
        rows = slice(start, start + len(point.p_camera))
        positions[rows, 0], sigma[rows] = point.p_camera, sigma_m
        points = BodyPoints(skeleton, (((point.part, point.p_part),),))
        terms.append(PointsInSpace(points, positions, sigma))
    return tuple(terms)


def near_pins(
    motion: Trajectory, pins: Sequence[PinnedPoint | HeldPoint], fade: int
) -> tuple[list[tuple[int, tuple[float, float, float]]], NDArray[np.bool_]]:
    """The points that are held, K of them, and (N − 2, K) which second differences of each have a
    frame of the so many before and after its pins."""
    places = list(dict.fromkeys((pin.part, pin.p_part) for pin in pins))
    near = np.zeros((max(len(motion) - 2, 0), len(places)), dtype=np.bool_)
    for k, place in enumerate(places):
        shares = [pin.nearness(motion, fade) for pin in pins if (pin.part, pin.p_part) == place]
        share = np.max(shares, axis=0)
        free = (share > 0) & (share < 1)
        near[:, k] = free[:-2] | free[1:-1] | free[2:]
    return places, near


def knees_as_tracked(
    skeleton: Skeleton, motion: Trajectory, pins: Sequence[PinnedPoint]
) -> tuple[PosePrior, ...]:
    """The knees of legs that pins hold, nearly as they were tracked. Where a leg is too long for
    the floor the body is as far off as that, or the floor is tilted: a knee would bend by 16° for a
    distance that is 1 % wrong."""
    pinned = sorted({pin.part for pin in pins})
    held = np.asarray(skeleton.below[pinned].any(axis=0))
    knees = [i for i, name in enumerate(skeleton.body.names) if name in KNEES and held[i]]
    if not knees:
        return ()
    bends = np.isin(skeleton.dof_part, knees) & (skeleton.dof_turns == 1)
    precision = np.where(bends, KNEE_RAD**-2.0, 0.0)
    each = np.tile(precision, (len(motion), 1))
    return (PosePrior(motion.Rs_parent_part, motion.ps_camera_root, each),)
