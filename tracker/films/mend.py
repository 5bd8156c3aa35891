"""Mend a posed keyframe by what all films show at its moment.

Who poses a body over one picture leaves its depth to guess; another film sees it. The keypoints of
all films are compared with the joints themselves: where on its part a detector puts a joint is not
asked of a keyframe whose depth is wrong. The pose is held weakly near the one that was set.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import FEWEST, OTHER_PERSON, height_px, points_on_body
from keypose.tracker.solver.frames import TermIn
from keypose.tracker.solver.least_squares import USUAL, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import JointLimits, PointsInPicture, PosePrior
from keypose.tracker.solver.posed import BodyPoints, Posed, free_skeleton
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.robust import Cauchy
from keypose.tracker.solver.sigmas import (
    KEYPOINT_SHARE,
    LIMIT_RAD,
    ON_PART_BY_EYE_M,
    MotionSigma,
    keypoint_blur,
)
from keypose.tracker.solver.terms import Term

NEAREST_M = 0.05
"""Nothing nearer to a camera is compared with its picture."""
AS_POSED: Final = MotionSigma(np.radians(20.0), 0.15)
"""How far a pose that looks right in one picture is off: a part's turn, and the root's place in
metres. Four films of a man on a beam: keyframes posed in one of them."""


@dataclass(frozen=True, eq=False)
class SeenInFilm:
    """What one film shows of a body at one moment.

    camera: without distortion, its focal length of that moment.  T_film_first: (4, 4) from the
    first camera's frame to this one's.  uv (J, 2): pixels of `JOINTS` without distortion, NaN where
    not seen.  visibility (J,).
    """

    camera: Camera
    T_film_first: Array
    uv: Array
    visibility: Array


@dataclass(frozen=True, eq=False)
class Mended:
    """A mended pose, and by how far it was off: of its joints in the median, metres."""

    pose: Pose
    moved_m: float


def mended(body: Body, pose: Pose, films: Sequence[SeenInFilm]) -> Mended | None:
    """A pose, in the first camera's frame, as all films show it; None where fewer than two see the
    body about where it is posed.

    films: the first of them first.
    """
    skeleton = free_skeleton(body)
    index, parts, points = points_on_body(body, JOINTS)
    where = BodyPoints.single(skeleton, parts, points)
    compared = [_compared(skeleton, pose, where, index, film) for film in films]
    terms = [term for term in compared if term is not None]
    if len(terms) < 2 or compared[0] is None:
        return None
    limits = Limits.of(body).widened([pose.Rs_parent_part])
    near = PosePrior.of(pose, AS_POSED.precision(skeleton))
    problem = OnePose(skeleton, [*terms, near, JointLimits(limits, LIMIT_RAD)])
    mended_pose = least_squares(problem, pose, USUAL).state
    joints = [where.at(pose_transforms(skeleton, each)) for each in (pose, mended_pose)]
    return Mended(mended_pose, float(np.median(np.linalg.norm(joints[1] - joints[0], axis=-1))))


def _compared(
    skeleton: Skeleton, pose: Pose, where: BodyPoints, index: NDArray[np.int64], film: SeenInFilm
) -> Term | None:
    """What a film's keypoints say of a pose; None where they lie on another body."""
    sigma = sigmas_beside(skeleton, pose, where, index, film)
    if sigma is None:
        return None
    scale, uv = 1 / sigma, film.uv[index]
    points = PointsInPicture(
        where, film.camera, np.where((scale > 0)[:, None], uv, 0.0), scale, NEAREST_M, Cauchy()
    )
    return TermIn(points, film.T_film_first)


def sigmas_beside(
    skeleton: Skeleton, pose: Pose, where: BodyPoints, index: NDArray[np.int64], film: SeenInFilm
) -> Array | None:
    """(M,) of a film's keypoints beside the joints of a pose, pixels, infinite where not seen; None
    where they lie on another body.

    where: the joints on the body.  index (M,): which of `JOINTS` these are.
    """
    uv, visibility = film.uv[index], film.visibility[index]
    is_seen = np.isfinite(uv).all(axis=-1) & (visibility > 0)
    there = pose.carried(film.T_film_first)
    if there.p_camera_root[2] < NEAREST_M:
        return None
    height = height_px(skeleton, film.camera, there)
    here = image_points(film.camera, where.of(Posed.of(skeleton, there)))
    miss = np.linalg.norm(here - uv, axis=-1)[is_seen]
    if is_seen.sum() < FEWEST or np.median(miss) > BESIDE * height:
        return None
    of_joint = ON_PART_BY_EYE_M * film.camera.fy / there.p_camera_root[2]
    sigma = np.hypot(KEYPOINT_SHARE * height, of_joint) * keypoint_blur(visibility)
    return np.where(is_seen, sigma, np.inf)


BESIDE: Final = 2 * OTHER_PERSON
"""Share of the body's height in the picture: a pose whose depth is wrong lies aside in another
film, and another person farther."""
