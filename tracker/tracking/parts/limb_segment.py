"""Treat a limb alone as a segment between frames at which it is known: drift, keypoints.

Where on its part a detector puts a joint the keyframes of the whole segment show alone. What it
misses the joint by beside that changes slowly from frame to frame: where a limb was set right this
is known, so near by it is taken off the keypoints, and keypoints that are elsewhere count for
little there. Far from there nothing of the limb is known that was not known before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate, joined
from keypose.tracker.geometry.rotations import Array, transpose
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.robust import Cauchy
from keypose.tracker.tracking.cues.anchors import Anchors
from keypose.tracker.tracking.cues.other_film import OtherFilm
from keypose.tracker.tracking.drift import Motions, correct_drift
from keypose.tracker.tracking.parts.limb_keyframes import KeyedLimb, KeyedParts, keyed_limbs, placed
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment


def closed_on(skeleton: Skeleton, motion: Trajectory, keyed: tuple[KeyedParts, ...]) -> Trajectory:
    """The motion with every limb where it is keyed, its drift spread evenly between."""
    for limb in keyed_limbs(skeleton, keyed):
        motion = joined([piece for piece, _ in closed_pieces(skeleton, motion, limb)])
    return motion


def closed_pieces(
    skeleton: Skeleton, motion: Trajectory, limb: KeyedLimb
) -> list[tuple[Trajectory, tuple[Pose, Pose]]]:
    """The motion from each frame at which the limb is exact to the next, and the poses there.

    It is exact at both ends of the motion, too.
    """
    at = {motion.first_frame: motion.pose(motion.first_frame)}
    for each in limb.keyed:
        at[each.frame] = placed(skeleton, each, motion.pose(each.frame))
    at[motion.last_frame] = motion.pose(motion.last_frame)
    return [
        (closed(part_of(motion, a, b), at[a], at[b], limb.parts), (at[a], at[b]))
        for a, b in pairwise(sorted(at))
    ]


def closed(motion: Trajectory, start: Pose, end: Pose, parts: NDArray[np.int64]) -> Trajectory:
    """A motion whose limb begins and ends as two poses have it, its own motion between."""
    R, t = motion.writable()
    R_next = R[1:].copy()
    R_next[0, parts] = start.Rs_parent_part[parts] @ transpose(R[0, parts]) @ R[1, parts]
    R[0, parts] = start.Rs_parent_part[parts]
    led = Motions(R_next, t[1:].copy())
    trajectory = correct_drift(Trajectory(motion.first_frame, R, t), led, end).trajectory
    return with_limb(motion, trajectory, parts, start, end)


def with_limb(
    motion: Trajectory, limbs: Trajectory, parts: NDArray[np.int64], start: Pose, end: Pose
) -> Trajectory:
    """A motion with a limb turned as in another one, between two poses."""
    R, t = with_parts(motion, limbs, parts).writable()
    R[0, parts], R[-1, parts] = start.Rs_parent_part[parts], end.Rs_parent_part[parts]
    return Trajectory(motion.first_frame, R, t)


def with_parts(motion: Trajectory, trajectory: Trajectory, parts: NDArray[np.int64]) -> Trajectory:
    """A motion with parts turned as in another one of the same frames."""
    R, t = motion.writable()
    R[:, parts] = trajectory.Rs_parent_part[:, parts]
    return Trajectory(motion.first_frame, R, t)


def part_of(motion: Trajectory, first: int, last: int) -> Trajectory:
    """The frames from first to last."""
    rows = slice(first - motion.first_frame, last - motion.first_frame + 1)
    return Trajectory(first, motion.Rs_parent_part[rows], motion.ps_camera_root[rows])


@dataclass(frozen=True, eq=False, kw_only=True)
class LimbSegment(Segment):
    """A segment in which nothing but a limb, of these parts (k,), may move otherwise than in a
    motion that is given, which is where the limb belongs at both ends."""

    given: Trajectory
    parts: NDArray[np.int64]

    def set_right(self, whole: Segment) -> list[int]:
        """The frames of its ends that are no keyframes of the whole segment."""
        keyframes = (whole.first_frame, whole.last_frame)
        return [n for n in (self.first_frame, self.last_frame) if n not in keyframes]

    def rows_set_right(self, whole: Segment) -> list[int]:
        """The same as rows of the given motion."""
        return [frame - self.first_frame for frame in self.set_right(whole)]

    def interpolated(self) -> Trajectory:
        """The given motion, the limb's turns interpolated."""
        even = interpolate(self.start, self.end, self.first_frame, self.last_frame)
        return with_limb(self.given, even, self.parts, self.start, self.end)

    def expected(self, Rs: Array, ps: Array, n: int) -> Pose:
        """The nth pose of the given motion, the limb turned as in the last one."""
        R = Rs[n].copy()
        R[self.parts] = Rs[n - 1, self.parts]
        return Pose(R, ps[n])


def other_side(skeleton: Skeleton, parts: NDArray[np.int64]) -> list[int]:
    """The parts that mirror these."""
    names, body = {skeleton.body.names[i] for i in parts}, skeleton.body
    pairs = [*body.mirror_pairs, *((b, a) for a, b in body.mirror_pairs)]
    return [body.index(mirror_name) for name, mirror_name in pairs if name in names]


SIDES_MARGIN = 4.0
"""By how much more a frame's keypoints are contradicted, as a loss, to be taken for those of the
other side: as of one that lies two standard deviations off."""
FADES = 5.0
"""Frames over which what keypoints miss falls to 1/e."""
ELSEWHERE = 0.08
"""A keypoint farther than this share of the body's height from where the joint was set shows
something else."""


def limb_anchors(
    candidates: Sequence[Anchors], segment: LimbSegment, whole: Segment, scene: Scene
) -> Anchors:
    """The anchors of a limb's segment.

    candidates: those of the whole segment, which take left and right differently.
    """
    first = segment.first_frame - whole.first_frame
    rows = slice(first, first + len(segment.given))
    anchors = resolve_sides([each.of_rows(rows) for each in candidates], segment, scene)
    return _missing_as_near(anchors, segment.given, segment, scene, segment.rows_set_right(whole))


def limb_film(
    film: OtherFilm, segment: LimbSegment, whole: Segment, skeleton: Skeleton
) -> OtherFilm | None:
    """What another film shows of a limb's segment; None where it hardly reaches over it.

    film: of the whole segment.  skeleton: in which the limb alone is tracked.
    """
    first = segment.first_frame - whole.first_frame
    part = film.between(first, first + len(segment.given) - 1)
    if part is None:
        return None
    part = part.of_skeleton(skeleton)
    if part.anchors is None:
        return part
    there, set_right = part.here(segment.given), segment.rows_set_right(whole)
    return replace(
        part, anchors=_missing_as_near(part.anchors, there, segment, part.scene, set_right)
    )


def _missing_as_near(
    anchors: Anchors,
    body: Trajectory,
    segment: LimbSegment,
    scene: Scene,
    set_right: Sequence[int],
) -> Anchors:
    """Without what the limb's keypoints miss it by at the rows where it was set right, fading from
    there.

    body: the segment's own motion as the camera saw it whose keypoints these are.
    """
    p = anchors.where(body.transforms(scene.skeleton))
    miss = (anchors.uv - image_points(scene.camera, p))[set_right]
    deeper = (anchors.depth - (p[..., 2] - body.ps_camera_root[:, None, 2]))[set_right]
    own = np.isin(anchors.parts, segment.parts) & (anchors.scale[set_right] > 0)
    away = np.linalg.norm(miss, axis=-1) > ELSEWHERE * anchors.height_px
    near = _alike(np.arange(len(anchors.uv)), set_right)
    doubt = (near[:, :, None] * (own & away)).max(axis=1)
    share = np.linalg.solve(_alike(set_right, set_right), near.T)  # exact at each
    miss = np.where((own & ~away)[..., None], miss, 0.0)
    detected = (anchors.scale > 0)[..., None]
    return replace(
        anchors,
        uv=anchors.uv - detected * np.einsum("rn,rkc->nkc", share, miss),
        scale=anchors.scale * (1 - doubt),
        depth=anchors.depth - share.T @ (own * deeper),
    )


def _alike(rows: Sequence[int] | NDArray[np.int64], others: Sequence[int]) -> Array:
    """(N, R) correlation of what keypoints miss at rows and at others: a Markov process."""
    return np.asarray(np.exp(-np.abs(np.subtract.outer(rows, others)) / FADES))


def resolve_sides(candidates: Sequence[Anchors], segment: LimbSegment, scene: Scene) -> Anchors:
    """Choose of anchors that take left and right differently those that the rest of the body
    contradicts least; in frames where the limb of the other side contradicts them, the others: what
    is seen where that one was tracked is not this one.
    """
    against = np.stack([_contradiction(each, segment, scene) for each in candidates])  # (A, N, K)
    parts = candidates[0].parts
    rest = against[..., ~np.isin(parts, segment.parts)].sum(axis=(1, 2))
    best, *others = np.argsort(rest, kind="stable").tolist()
    chosen: Anchors = candidates[best]
    beside = np.isin(parts, other_side(scene.skeleton, segment.parts))
    for k in others:
        lacks = (against[best] - against[k])[:, beside].sum(axis=-1)
        chosen = chosen.in_rows(lacks > SIDES_MARGIN, candidates[k])
    return chosen


def _contradiction(anchors: Anchors, segment: LimbSegment, scene: Scene) -> Array:
    """(N, K) how far keypoints lie from where the body was tracked."""
    image_uv = image_points(scene.camera, anchors.where(segment.given.transforms(scene.skeleton)))
    return Cauchy().loss(np.linalg.norm(image_uv - anchors.uv, axis=-1) * anchors.scale)
