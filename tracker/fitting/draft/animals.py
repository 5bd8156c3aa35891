"""Fit the poses of an animal on four legs to keypoints in the picture alone.

No network says how far away a keypoint is: the body's joints are fitted to where they are seen,
within joint limits, near the pose at rest and evenly over time. What the picture leaves open is
which way the animal is headed. Every frame is posed from each of several headings by itself; then
the way through the frames is taken on which poses fit and follow one another, and all are solved
together from there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft.observed import Observed, unit
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.keypoints.keypoints import other_side
from keypose.tracker.keypoints.on_animal import ANIMAL_POINTS, points_on_animal
from keypose.tracker.solver.least_squares import EXACT, USUAL
from keypose.tracker.solver.motion_problem import EVERY, MotionProblem
from keypose.tracker.solver.pose_terms import JointLimits, PointsInPicture, PosePrior
from keypose.tracker.solver.posed import BodyPoints, Posed
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.robust import Cauchy, Huber, Kernel
from keypose.tracker.solver.sigmas import (
    ANIMAL_HEADING_RAD,
    ANIMAL_KEYPOINT_SHARE,
    ANIMAL_LEAN_RAD,
    ANIMAL_REST_RAD,
    BEND,
    LIMIT_RAD,
    UNDECIDED_PER_M,
    keypoint_blur,
)
from keypose.tracker.solver.smoothness import Smoothness
from keypose.tracker.solver.terms import Link, Term
from keypose.tracker.tracking.segment import NEAREST_M

HEADINGS: Final = 8
"""Directions, all around, from which every frame is posed."""
FOLLOWS: Final = 0.08
"""Of how a keypoint moves in a frame about the trunk, a share of the trunk's length."""
MOST_APART: Final = 4.0
"""Keypoints that move by more of that count no more: another heading is another heading."""
NEAREST_START_M: Final = 0.5
"""No start is nearer to the camera."""
UNSEEN: Final = "tail"
"""A part of which nothing is seen but where it begins."""
Ends: TypeAlias = tuple[str, ...]
AS_THEY_ARE: Final[Ends] = ()
BOTH_ENDS: Final[Ends] = ("front", "hind")
EXCHANGED: Final[tuple[Ends, ...]] = (AS_THEY_ARE, ("front",), ("hind",), BOTH_ENDS)
"""Where left and right may be exchanged in a frame: a network does so of the whole animal, or of
the legs at one end."""
EXCHANGE_COST: Final = 3.0
"""Of either, as half the square of a deviation."""
_OF_END: Final = {
    "front": tuple(
        k
        for k, name in enumerate(ANIMAL_POINTS)
        if name.split("_", 1)[-1] in ("eye", "shoulder", "elbow", "front_paw")
    ),
    "hind": tuple(
        k
        for k, name in enumerate(ANIMAL_POINTS)
        if name.split("_", 1)[-1] in ("hip", "knee", "back_paw")
    ),
}
_TRUNK: Final = tuple(ANIMAL_POINTS.index(name) for name in ("neck", "tail_root"))


@dataclass(frozen=True, eq=False)
class AnimalFit:
    """What the poses of N consecutive frames are fitted with.

    skeleton: whose tail does not move.  up (N, 3): in the camera's axes.
    """

    skeleton: Skeleton
    camera: Camera
    observed: Observed
    up: Array

    @classmethod
    def of(cls, skeleton: Skeleton, camera: Camera, observed: Observed, up: Array) -> AnimalFit:
        body = skeleton.body
        parts = (
            part.model_copy(update={"tracked": ()}) if part.name == UNSEEN else part
            for part in body.parts
        )
        still = Skeleton.of(body.replaced(parts))
        up = np.broadcast_to(unit(np.asarray(up, dtype=np.float64)), (len(observed), 3))
        return cls(still, camera, observed, up)

    @cached_property
    def points(self) -> BodyPoints:
        """K of them on the body."""
        return animal_points(self.skeleton)

    def of_rows(self, rows: list[int]) -> AnimalFit:
        """The same of some of the frames."""
        observed = replace(
            self.observed,
            first_frame=0,
            uv=self.observed.uv[rows],
            known=self.observed.known[rows],
            visibility=self.observed.visibility[rows],
            p_hips=self.observed.p_hips[rows],
            usable=self.observed.usable[rows],
            jumped=self.observed.jumped[rows],
            depth_sigma_m=self.observed.depth_sigma_m[rows],
        )
        return replace(self, observed=observed, up=self.up[rows])

    def posed_anew(self, start: Trajectory) -> tuple[Trajectory, Array]:
        """Every frame posed by itself from a start, and all that it deviates by, in units of σ."""
        motion = self._problem(start, Huber()).solve(start, EXACT)
        uv = image_points(self.camera, self.points.at(motion.transforms(self.skeleton)))
        missed = (uv - self.observed.uv) * self._scale[..., None]
        weight = np.sqrt(Huber().weight(np.linalg.norm(missed, axis=-1)))
        prior = self._prior(motion)
        posed = Posed(self.skeleton, motion.Rs_parent_part, motion.ps_camera_root)
        turned = np.sqrt(prior.precision) * prior.away(posed)
        return motion, np.concatenate([(missed * weight[..., None]).ravel(), turned.ravel()])

    def solved(self, step: Callable[[], None] = lambda: None) -> tuple[AnimalFit, Trajectory]:
        """The motion nearest to all, with what it was fitted to: left and right are exchanged where
        a network exchanged them.

        step: called again and again; what it raises ends the work.
        """

        def cancelled() -> bool:
            step()
            return False

        headings = [self._at_rest(2 * np.pi * k / HEADINGS) for k in range(HEADINGS)]
        starts = [(start, ends) for start in headings for ends in (AS_THEY_ARE, BOTH_ENDS)]
        fit, motion = self._with_sides(starts, cancelled)
        motion = fit._together(motion, cancelled)
        sided, again = fit._with_sides([(motion, ends) for ends in EXCHANGED], cancelled)
        if sided is fit:
            return fit, motion
        return sided, sided._together(again, cancelled)

    def _with_sides(
        self, starts: Sequence[tuple[Trajectory, Ends]], cancelled: Callable[[], bool]
    ) -> tuple[AnimalFit, Trajectory]:
        """The way through the poses that all frames have by themselves, from several starts, each
        with left and right exchanged at some ends; and what they were fitted to."""
        variants = [replace(self, observed=_exchanged(self.observed, ends)) for _, ends in starts]
        candidates = [
            variant._alone(start, cancelled)
            for variant, (start, _) in zip(variants, starts, strict=True)
        ]
        costs = [
            variant._costs(candidate) + EXCHANGE_COST * len(ends)
            for variant, candidate, (_, ends) in zip(variants, candidates, starts, strict=True)
        ]
        chosen = self._way(candidates, np.stack(costs, axis=1))
        motion = chosen_of(candidates, chosen)
        if not any(starts[k][1] for k in chosen.tolist()):
            return self, motion
        return replace(self, observed=_observed_of(variants, chosen)), motion

    def _alone(self, start: Trajectory, cancelled: Callable[[], bool]) -> Trajectory:
        """Every frame by itself, from a start."""
        return self._problem(start, Huber()).solve(start, USUAL, cancelled)

    def _together(self, motion: Trajectory, cancelled: Callable[[], bool]) -> Trajectory:
        """All frames from where they were posed by themselves."""
        pixel_m = float(np.median(motion.ps_camera_root[:, 2])) / self.camera.fy
        precision = BEND.precision(self.skeleton, pixel_m)
        even = Smoothness.even(self.skeleton, len(self.observed), precision)
        motion = self._problem(motion, Huber(), (even,)).solve(motion, USUAL, cancelled)
        return self._problem(motion, Cauchy(), (even,)).solve(motion, USUAL, cancelled)

    def _problem(
        self, start: Trajectory, kernel: Kernel, links: Sequence[Link] = ()
    ) -> MotionProblem:
        return MotionProblem(self.skeleton, self._terms(start, kernel), links, EVERY)

    def _terms(self, start: Trajectory, kernel: Kernel) -> list[Term]:
        uv, scale = self.observed.uv, self._scale
        return [
            PointsInPicture(self.points, self.camera, uv, scale, NEAREST_M, kernel),
            JointLimits(Limits.of(self.skeleton.body), LIMIT_RAD),
            self._prior(start),
        ]

    def _prior(self, start: Trajectory) -> PosePrior:
        """Legs and neck near the pose at rest, the trunk level, headed anywhere."""
        skeleton = self.skeleton
        precision = np.full(skeleton.dof_count, ANIMAL_REST_RAD**-2.0)
        of_root = skeleton.dof_part == 0
        turns = skeleton.dof_turns == 1
        precision[of_root & ~turns] = UNDECIDED_PER_M**2
        leans = (ANIMAL_LEAN_RAD, ANIMAL_HEADING_RAD, ANIMAL_LEAN_RAD)
        precision[of_root & turns] = np.array(leans) ** -2.0
        return PosePrior(self._levelled(start), start.ps_camera_root, precision)

    @property
    def _scale(self) -> Array:
        """(N, K) 1/σ of every keypoint in 1/px, 0 where it is not known."""
        is_known, uv = (
            self.observed.known,
            np.where(self.observed.known[..., None], self.observed.uv, np.nan),
        )
        rows = is_known.any(axis=1)
        extent = np.nanmax(np.nanmax(uv[rows], axis=1) - np.nanmin(uv[rows], axis=1), axis=1)
        size = max(float(np.median(extent)), 1.0)
        sigma = ANIMAL_KEYPOINT_SHARE * size * keypoint_blur(self.observed.visibility)
        return np.where(is_known, 1 / sigma, 0.0)

    def _at_rest(self, heading: float) -> Trajectory:
        """The body at rest, headed some way from the camera, where it is seen."""
        count = len(self.observed)
        rest = np.tile(np.eye(3), (count, self.skeleton.part_count, 1, 1))
        rest[:, 0] = _level(self.up, np.array([0.0, 0.0, 1.0]))
        rest[:, 0] = rest[:, 0] @ exp_rotation(np.array([0.0, heading, 0.0]))
        about = Trajectory(self.observed.first_frame, rest, np.zeros((count, 3)))
        p = self.points.at(about.transforms(self.skeleton))
        return Trajectory(self.observed.first_frame, rest, self._placed(p))

    def _placed(self, p: Array) -> Array:
        """(N, 3) where the root is, from where points (N, K, 3) about it are seen: linear. Frames
        that show too little are between those around."""
        rays = self.camera.back_project(self.observed.uv, 1.0)
        rows = np.zeros((*rays.shape[:2], 2, 3))
        rows[..., 0, 0] = rows[..., 1, 1] = 1.0
        rows[..., 2] = -rays[..., :2]
        weight = self.observed.known[..., None]
        wanted = weight * (rays[..., :2] * p[..., 2:] - p[..., :2])
        A = np.einsum("nkij,nkil->njl", rows * weight[..., None], rows)
        b = np.einsum("nkij,nki->nj", rows, wanted)
        usable = np.flatnonzero(self.observed.usable)
        placed = np.linalg.solve(A[usable], b[usable][..., None])[..., 0]
        placed[:, 2] = np.maximum(placed[:, 2], NEAREST_START_M)
        every = np.arange(len(p))
        return np.stack([np.interp(every, usable, axis) for axis in placed.T], axis=1)

    def _levelled(self, motion: Trajectory) -> Array:
        """(N, P, 3, 3) the pose at rest, headed as a motion is."""
        rest = np.tile(np.eye(3), (len(motion), self.skeleton.part_count, 1, 1))
        rest[:, 0] = _level(self.up, motion.Rs_parent_part[:, 0, :, 2])
        return rest

    def _way(self, candidates: Sequence[Trajectory], costs: Array) -> NDArray[np.int64]:
        """(N,) of every frame one of the candidates: the way through all that costs least."""
        p = np.stack([self._about_root(motion) for motion in candidates], axis=1)
        step = FOLLOWS * np.linalg.norm(np.subtract(*p[0, 0, list(_TRUNK)]))
        return cheapest_way(costs, p / step)

    def _about_root(self, motion: Trajectory) -> Array:
        """(N, K, 3)"""
        return self.points.at(motion.transforms(self.skeleton)) - motion.ps_camera_root[:, None]

    def _costs(self, motion: Trajectory) -> Array:
        """(N,) of each frame by itself, within limits."""
        uv = image_points(self.camera, self.points.at(motion.transforms(self.skeleton)))
        away = np.linalg.norm(uv - self.observed.uv, axis=-1) * self._scale
        prior = self._prior(motion)
        posed = Posed(self.skeleton, motion.Rs_parent_part, motion.ps_camera_root)
        turned = prior.precision * prior.away(posed) ** 2
        return np.asarray(Huber().loss(away).sum(axis=1) + turned.sum(axis=1)) / 2


def chosen_of(motions: Sequence[Trajectory], chosen: NDArray[np.int64]) -> Trajectory:
    """Of every frame the pose of one of several motions."""
    rows = np.arange(len(chosen))
    R = np.stack([motion.Rs_parent_part for motion in motions])[chosen, rows]
    t = np.stack([motion.ps_camera_root for motion in motions])[chosen, rows]
    return Trajectory(motions[0].first_frame, R, t)


def _observed_of(variants: Sequence[AnimalFit], chosen: NDArray[np.int64]) -> Observed:
    """Of every frame what one of several has."""
    rows = np.arange(len(chosen))
    return replace(
        variants[0].observed,
        uv=np.stack([variant.observed.uv for variant in variants])[chosen, rows],
        known=np.stack([variant.observed.known for variant in variants])[chosen, rows],
        visibility=np.stack([variant.observed.visibility for variant in variants])[chosen, rows],
    )


def _exchanged(observed: Observed, ends: Ends) -> Observed:
    """Left and right exchanged at the front, behind, or both."""
    order = np.arange(len(ANIMAL_POINTS))
    for end in ends:
        for k in _OF_END[end]:
            order[k] = ANIMAL_POINTS.index(other_side(ANIMAL_POINTS[k], ANIMAL_POINTS))
    return replace(
        observed,
        uv=observed.uv[:, order],
        known=observed.known[:, order],
        visibility=observed.visibility[:, order],
    )


def animal_points(skeleton: Skeleton) -> BodyPoints:
    """`ANIMAL_POINTS` on an animal's body."""
    _, parts, places = points_on_animal(skeleton.body)
    located = zip(parts.tolist(), places.tolist(), strict=True)
    return BodyPoints(skeleton, tuple(((part, (x, y, z)),) for part, (x, y, z) in located))


def cheapest_way(costs: Array, places: Array) -> NDArray[np.int64]:
    """(N,) which of C candidates each of N frames takes so that all cost least.

    costs (N, C): of each.  places (N, C, K, 3): of points, in units of how far they usually move.
    """
    before = np.zeros(costs.shape, dtype=np.int64)
    total = costs[0]
    for n in range(1, len(costs)):
        apart = np.linalg.norm(places[n - 1, :, None] - places[n, None], axis=-1)
        change = (np.minimum(apart, MOST_APART) ** 2).sum(axis=-1) / 2
        both = total[:, None] + change
        before[n] = both.argmin(axis=0)
        total = both.min(axis=0) + costs[n]
    chosen = [int(total.argmin())]
    for n in range(len(costs) - 1, 0, -1):
        chosen.append(int(before[n, chosen[-1]]))
    return np.array(chosen[::-1])


def _level(up: Array, back: Array) -> Array:
    """(N, 3, 3) rotations to the camera's axes of a body whose y is down and whose z is level and
    as near as can be to some direction (3,) or (N, 3)."""
    down = -up
    back = np.broadcast_to(back, down.shape)
    z = unit(back - (back * down).sum(axis=1, keepdims=True) * down)
    return np.stack([np.cross(down, z), down, z], axis=-1)
