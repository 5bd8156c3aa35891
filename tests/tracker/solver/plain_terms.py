"""Plain NumPy twins of the loops that compare poses, and of the motion between poses."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import part_transforms, twists
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import log_rotation, transpose
from keypose.tracker.solver.pose_terms import DepthFromRoot, JointLimits, PointsInPicture
from keypose.tracker.solver.posed import BodyPoints, Posed, image_jacobian, image_points
from keypose.tracker.solver.smoothness import Increments, Smoothness
from keypose.tracker.solver.terms import Equations, Rows, SummedTerm

Floats: TypeAlias = NDArray[np.float64]


def motion_from(
    posed: Posed, Rs_parent_part: Floats, p_camera_root: Floats, backward: bool
) -> Floats:
    """(..., D) as `Posed.motion_from`."""
    skeleton = posed.skeleton
    turn = log_rotation(transpose(Rs_parent_part) @ posed.Rs_parent_part)
    Rs = posed.Rs_parent_part if backward else Rs_parent_part
    inside = np.einsum("...ba,...b->...a", Rs[..., 0, :, :], posed.p_camera_root - p_camera_root)
    by_turn = turn[..., skeleton.dof_part, skeleton.dof_axis]
    return np.where(skeleton.dof_turns == 1, by_turn, inside[..., skeleton.dof_axis])


def jacobian(points: BodyPoints, posed: Posed) -> tuple[Floats, Floats]:
    """Positions (..., J, 3) and how they move (..., J, D, 3), as `BodyPoints.jacobian`."""
    skeleton = posed.skeleton
    T = part_transforms(skeleton, posed.Rs_parent_part, posed.p_camera_root)
    S = twists(skeleton, T)
    where, motion = [], []
    for place in points.points:
        p = np.zeros((*posed.batch, 3))
        J = np.zeros((*posed.batch, skeleton.dof_count, 3))
        for part, at in place:
            H = T[..., part, :, :]
            one = H[..., :3, :3] @ np.array(at) + H[..., :3, 3]
            moves = skeleton.below[part][skeleton.dof_part][:, None]
            J += moves * (S[..., :3] + np.cross(S[..., 3:], one[..., None, :])) / len(place)
            p += one / len(place)
        where.append(p)
        motion.append(J)
    return np.stack(where, axis=-2), np.stack(motion, axis=-3)


def rows(term: SummedTerm, posed: Posed) -> Rows:
    """The residuals of a term, weighted if robust, their Jacobian and cost."""
    if isinstance(term, PointsInPicture):
        return _pixels(term, posed)
    if isinstance(term, DepthFromRoot):
        return _depths(term, posed)
    assert isinstance(term, JointLimits)
    return _limits(term, posed)


def equations(term: SummedTerm, posed: Posed) -> Equations:
    """Those of its residuals."""
    return Equations.of(rows(term, posed))


def _pixels(term: PointsInPicture, posed: Posed) -> Rows:
    p, J = jacobian(term.points, posed)
    away = (image_points(term.camera, p) - term.uv) * term.scale[..., None]
    length = np.linalg.norm(away, axis=-1)
    weight = np.sqrt(term.kernel.weight(length))
    seen = image_jacobian(term.camera, p, J) * (weight * term.scale)[..., None, None]
    r, seen = away * weight[..., None], np.swapaxes(seen, -1, -2)
    cost = 0.5 * float(term.kernel.loss(length).sum())
    flat = seen.reshape(*posed.batch, -1, posed.skeleton.dof_count)
    return Rows(r.reshape(*posed.batch, -1), flat, cost)


def _depths(term: DepthFromRoot, posed: Posed) -> Rows:
    skeleton = posed.skeleton
    p, J = jacobian(term.points, posed)
    away = (p[..., 2] - posed.p_camera_root[..., None, 2] - term.depth) * term.scale
    shifts = np.flatnonzero(skeleton.dof_turns == 0)
    along = J[..., 2].copy()
    R_root = posed.Rs_parent_part[..., 0, :, :]
    along[..., shifts] -= R_root[..., 2, skeleton.dof_axis[shifts]][..., None, :]
    weight = np.sqrt(term.kernel.weight(np.abs(away)))
    cost = 0.5 * float(term.kernel.loss(np.abs(away)).sum())
    return Rows(away * weight, along * (weight * term.scale)[..., None], cost)


def _limits(term: JointLimits, posed: Posed) -> Rows:
    skeleton = posed.skeleton
    outside, slopes = term.limits.excess(posed.Rs_parent_part)
    if term.allowed is not None:
        low, high = np.minimum(term.allowed, 0.0), np.maximum(term.allowed, 0.0)
        outside = outside - np.clip(outside, low, high)
    slopes = slopes * (outside != 0)[..., None]
    if term.onset_rad:
        share = np.minimum(np.abs(outside) / term.onset_rad, 1.0)
        lag = term.onset_rad * (share - share**2 / 2)
        outside = np.copysign(np.abs(outside) - lag, outside)
        slopes = slopes * share[..., None]
    J = np.zeros((*outside.shape, skeleton.dof_count))
    for d in np.flatnonzero(skeleton.dof_turns == 1):
        part, axis = skeleton.dof_part[d], skeleton.dof_axis[d]
        J[..., part, :, d] = slopes[..., part, :, axis]
    J = J.reshape(*posed.batch, -1, skeleton.dof_count) / term.sigma_rad
    r = outside.reshape(*posed.batch, -1) / term.sigma_rad
    return Rows(r, J, 0.5 * float((r**2).sum()))


def link_rows(link: Increments | Smoothness, of: Floats) -> Rows:
    """Residuals (M,) of differences (m, D), weighted if robust, and their Jacobian (M, N D) as it
    is of small motions."""
    (m, dofs), reach = of.shape, len(link.stencil)
    precision = np.broadcast_to(link.precision, of.shape)
    away = of - link.wanted
    size = np.sqrt(precision) * np.abs(away)
    scale = np.sqrt(precision * link.kernel.weight(size))
    J = np.zeros((m, dofs, m + reach - 1, dofs))
    for k in range(m):
        for i, share in enumerate(link.stencil):
            J[k, np.arange(dofs), k + i, np.arange(dofs)] = share * scale[k]
    cost = 0.5 * float(link.kernel.loss(size).sum())
    return Rows((scale * away).ravel(), J.reshape(m * dofs, -1), cost)


def all_places(skeleton: Skeleton) -> BodyPoints:
    """A place on every part, and the middle of some."""
    single = [((i, (0.01 * i, 0.02, -0.01)),) for i in range(skeleton.part_count)]
    ends = ((0, (0.0, 0.1, 0.0)), (skeleton.part_count - 1, (0.0, 0.0, 0.02)))
    return BodyPoints(skeleton, (*single, ends))
