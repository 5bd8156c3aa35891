"""Refine a pose on a picture, with the posed keyframe as prior and edges of the body as a term.

Clothes are thicker than the body: how far all edges of a part lie outward is free, within limits,
so that thickness is not taken for nearness.

Gauss–Newton from coarse to fine on the differences to known textures and on the outline. At the end
only those directions of motion count about which the picture has more information than the prior:
along all others the pose is exactly as set.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.fitting.pose.outline import Colours, Edges, Outline
from keypose.tracker.fitting.pose.texture import TextureMatch
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.least_squares import UNJUDGED, Problem, damped_step, least_squares
from keypose.tracker.solver.pose_terms import JointLimits, PosePrior
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.projection import image_jacobian, image_points
from keypose.tracker.solver.sigmas import EDGE_PX, LIMIT_RAD, MOST_EDGE_PX, POSED, THICKNESS_M
from keypose.tracker.solver.terms import Equations, Term, total_equations
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.video.pyramid import LEVELS

STRAY_PX = 3.0
"""Beyond it an edge counts less."""
INFORMATION = 0.3
"""Independent observations that a sampled edge counts for: neighbours err alike."""


@dataclass(frozen=True, eq=False)
class EdgeDistances:
    """Edges of the body at those of a picture, each part's thickness marginalised: a term.

    part (M,), p_part (M, 3): places on the body, in their parts' frames.
    normal (M, 2), target_px (M,): each seen at a pixel whose product with its normal is its target.
    weights (M,): 1/px².  thickness_px: σ of how far the edges of a part lie outward together.
    """

    camera: Camera
    part: NDArray[np.int64]
    p_part: Array
    normal: Array
    target_px: Array
    weights: Array
    thickness_px: float

    @classmethod
    def of(cls, outline: Outline, posed: Posed, edges: Edges) -> EdgeDistances:
        """Make the term of edges that were found at a pose.

        Parts that are not tracked, such as hands and feet, get no weight: they stay as posed,
        so their edges would pull at their parents.
        """
        used = edges.located & np.isin(edges.part, outline.skeleton.dof_part)
        away = np.abs(edges.away_px[used])
        spread = max(EDGE_PX, 1.4826 * float(np.median(away))) if away.size else EDGE_PX
        weights = INFORMATION * used / (edges.variance + min(spread, MOST_EDGE_PX) ** 2)
        weights *= np.minimum(1.0, STRAY_PX / np.maximum(np.abs(edges.away_px), 1e-9))
        T = posed.Ts_camera_part[edges.part]
        p_part = np.einsum("mba,mb->ma", T[:, :3, :3], edges.p_camera - T[:, :3, 3])
        uv = image_points(outline.camera, edges.p_camera)
        target = (edges.normal * uv).sum(axis=-1) + edges.away_px
        thickness = THICKNESS_M / outline.pixel_m
        return cls(outline.camera, edges.part, p_part, edges.normal, target, weights, thickness)

    def cost(self, posed: Posed) -> float:
        """The cost at the best thicknesses."""
        r = self._offsets_px(posed.points(self.part, self.p_part))
        precision, pull = self._thickness(r, posed.skeleton.part_count)
        return self._cost(r, precision, pull)

    def equations(self, posed: Posed) -> Equations:
        dofs, parts = posed.skeleton.dof_count, posed.skeleton.part_count
        p = posed.points(self.part, self.p_part)
        J = image_jacobian(self.camera, p, posed.point_jacobian(self.part, p))
        outward = np.asarray((J * self.normal[:, None]).sum(axis=-1))
        thicker = (self.part[:, None] == np.arange(parts)).astype(float)
        r = self._offsets_px(p)
        rows = np.concatenate([outward, thicker, r[:, None]], axis=1)
        weighed = outward * self.weights[:, None]
        # einsum, not @: of a matrix so small, threads of a product cost more than they save
        A, cross, b = np.split(np.einsum("md,me->de", weighed, rows), [dofs, dofs + parts], axis=1)
        precision, pull = self._thickness(r, parts)
        share, cost = cross / precision, self._cost(r, precision, pull)
        return Equations(A - share @ cross.T, b[:, 0] - share @ pull, cost)

    def _thickness(self, r: Array, parts: int) -> tuple[Array, Array]:
        """(P,) precision of each part's thickness, and its gradient."""
        weight_sums = np.bincount(self.part, weights=self.weights, minlength=parts)
        pull = np.bincount(self.part, weights=self.weights * r, minlength=parts)
        return np.asarray(weight_sums + 1 / self.thickness_px**2, np.float64), np.asarray(
            pull, np.float64
        )

    def _cost(self, r: Array, precision: Array, pull: Array) -> float:
        return 0.5 * float(self.weights @ r**2 - (pull**2 / precision).sum())

    def _offsets_px(self, p: Array) -> Array:
        """(M,) pixels by which places p (M, 3) in the camera frame lie too far outward."""
        uv = image_points(self.camera, p)
        return np.asarray((self.normal * uv).sum(axis=-1) - self.target_px)


SOLVES = (10, 8, 8)
"""Solves at most at each level of the pyramid, finest first."""
ROUGH = 4
"""Solves of the finest level in which the pose may still be far off."""
REACH_M = (0.03, 0.055, 0.1)
"""How far from an edge the picture's own is sought, at each level."""
LOOK_AGAIN = 3
"""Solves after which it is found anew which parts are visible."""
LEARN_AGAIN = 3
"""Solves after which the colours are learnt anew."""
DECISIVE = 1.0
"""Information of the picture, as a share of the prior's, above which it decides a direction."""


@dataclass(frozen=True, eq=False)
class RefinedPose:
    """A pose, and the information (D, D) that the picture holds about it."""

    pose: Pose
    information: Array


@dataclass(frozen=True, eq=False)
class PosedKeyframe:
    """A pose as a person set it, and how surely: precision (D,) is 1/σ² of each motion."""

    scene: Scene
    pose: Pose
    limits: Limits

    @cached_property
    def precision(self) -> Array:
        return POSED.precision(self.scene.skeleton)

    @cached_property
    def prior(self) -> PosePrior:
        """The pose as set."""
        return PosePrior.of(self.pose, self.precision, backward=False)

    def away(self, pose: Pose) -> Array:
        """(D,) the tracked part of the motion from the pose as set to another."""
        return self.prior.away(Posed.of(self.scene.skeleton, pose))

    @cached_property
    def joint_limits(self) -> JointLimits:
        """No angle further past its limits than as set."""
        as_posed, _ = self.limits.excess(self.pose.Rs_parent_part)
        return JointLimits(self.limits, LIMIT_RAD, as_posed)


class _OutlineTerm:
    """The outline as a term, its colours learnt anew every few solves."""

    def __init__(self, outline: Outline) -> None:
        self._outline = outline
        self._colours: Colours | None = None

    def term(self, pose: Pose, posed: Posed, level: int, solve: int) -> EdgeDistances:
        shown = self._outline.draw(pose)
        if self._colours is None or solve % LEARN_AGAIN == 0:
            self._colours = self._outline.colours(shown)
        edges = self._outline.edges(shown, self._colours, REACH_M[level])
        return EdgeDistances.of(self._outline, posed, edges)


@dataclass(frozen=True, eq=False)
class _PictureProblem(Problem[Pose, "_Iterate"]):
    """A pose on picture and prior, at one level of the pyramid."""

    keyframe: PosedKeyframe
    match: TextureMatch | None
    outlined: _OutlineTerm | None
    joints: Term | None
    level: int

    def at(self, state: Pose, count: int) -> _Iterate:
        return _Iterate(self, state, count)

    def moved(self, state: Pose, step: Array) -> Pose:
        return moved(self.keyframe.scene.skeleton, state, step)

    def terms(self, pose: Pose, posed: Posed, solve: int, fine: bool) -> list[Term]:
        """Textures and outline linearised about a pose, without the prior."""
        terms: list[Term] = [] if self.joints is None else [self.joints]
        if self.match is not None:
            if solve % LOOK_AGAIN == 0:
                self.match.update_visibility(pose)
            terms.append(self.match.term(posed, self.level, fine))
        if self.outlined is not None:
            terms.append(self.outlined.term(pose, posed, self.level, solve))
        return terms


@dataclass(frozen=True, eq=False)
class _Iterate:
    """A pose after some solves. It has no cost: colours, visibility and noise are learnt anew on
    the way, so that those of two poses do not compare."""

    picture: _PictureProblem
    pose: Pose
    solve: int
    cost = np.nan

    @cached_property
    def posed(self) -> Posed:
        return Posed.of(self.picture.keyframe.scene.skeleton, self.pose)

    @cached_property
    def evidence(self) -> Equations:
        terms = self.picture.terms(self.pose, self.posed, self.solve, self._fine)
        return total_equations(terms, self.posed)

    @property
    def _fine(self) -> bool:
        return self.picture.level == 0 and self.solve >= ROUGH

    def step(self, damping: float) -> Array | None:
        return _step(self.picture.keyframe, self.posed, self.evidence, only_decided=self._fine)


def refine(
    keyframe: PosedKeyframe,
    start: Pose,
    match: TextureMatch | None,
    outline: Outline | None,
    cancelled: Callable[[], bool],
    coarsest: int = LEVELS - 1,
    joints: Term | None = None,
) -> RefinedPose:
    """The most likely pose on textures, outline, joints and the pose as set, from a start.

    coarsest: the level of the pyramid to begin at.  joints: where a detector sees them.
    """
    outlined = None if outline is None else _OutlineTerm(outline)
    evidence = Equations.none(keyframe.scene.skeleton.dof_count)
    pose = start
    for level in range(coarsest, -1, -1):
        if match is not None:
            match.reset_noise(level)
        criteria = replace(UNJUDGED, most_steps=SOLVES[level], settled=5e-4, longest_step=0.1)
        solution = least_squares(
            _PictureProblem(keyframe, match, outlined, joints, level), pose, criteria, cancelled
        )
        if solution.solved is None or solution.end in ("cancelled", "unsolvable"):
            return RefinedPose(keyframe.pose, np.zeros_like(evidence.A))
        pose, evidence = solution.state, solution.solved.evidence
    return RefinedPose(pose, evidence.A)


def _step(keyframe: PosedKeyframe, posed: Posed, evidence: Equations, only_decided: bool) -> Array:
    """The next motion; with `only_decided`, along the directions that the picture decides.

    In sigmas of the pose as set, the directions are the eigenvectors of the picture's information;
    along the others the motion leads straight back to the pose as set.
    """
    evidence = evidence + keyframe.joint_limits.equations(posed)
    if not only_decided:
        whole = evidence + keyframe.prior.equations(posed)
        return damped_step(whole.A, whole.b, 0.0)
    sigma, away = keyframe.precision**-0.5, keyframe.prior.away(posed)
    values, V = np.linalg.eigh(evidence.A * sigma * sigma[:, None])
    y = V.T @ (away / sigma)
    g = V.T @ (evidence.b * sigma)
    along = np.where(values >= DECISIVE, -(g + y) / (values + 1.0), -y)
    return np.asarray(sigma * (V @ along))


def decided_share(keyframe: PosedKeyframe, refined: RefinedPose) -> Array:
    """(P,) share of each part's own motions that the picture decides; 0 where none is tracked."""
    skeleton = keyframe.scene.skeleton
    sigma = keyframe.precision**-0.5
    values, V = np.linalg.eigh(refined.information * sigma * sigma[:, None])
    share = np.where(values >= DECISIVE, values / (values + 1.0), 0.0)
    by_dof = (V**2 * share).sum(axis=1)
    total = np.bincount(skeleton.dof_part, weights=by_dof, minlength=skeleton.part_count)
    count = np.bincount(skeleton.dof_part, minlength=skeleton.part_count)
    return np.asarray(total / np.maximum(count, 1))
