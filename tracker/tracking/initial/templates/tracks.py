"""Follow the ends of limbs from both keyframes: INITIAL's templates, carried further.

Beyond INITIAL §3.1: a patch of each keyframe and one that is renewed on the way, places to a
fraction of a pixel, both directions combined, and occlusion as predicted by a base trajectory.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.raster import BodyMesh, Raster, raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import readable
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.tracking.initial.chains import Chain, Chains, blend_chains, follow_both
from keypose.tracker.tracking.initial.templates.follow_point import (
    BaseCourse,
    Course,
    combine_courses,
    follow_point,
)
from keypose.tracker.tracking.initial.templates.patch import Patch
from keypose.tracker.tracking.initial.templates.search import GreyPicture
from keypose.tracker.tracking.method import FULL
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.tracking.windows import show_all
from keypose.tracker.video.pyramid import FloatPicture, Window, in_grey_levels


@dataclass(frozen=True, eq=False)
class Start:
    """A first trajectory of a segment, and notes for a person on what could not be followed."""

    trajectory: Trajectory
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class LimbTracks:
    """Where points of the body are seen in the N frames of a segment.

    A limb's end has two rows, the point of its surface that either keyframe shows.

    parts:    (L,) index of the part that each point belongs to.
    points:   (L, 3) the points in their parts' frames, metres.
    uv:       (L, N, 2) pixels of the working pictures; NaN where a point was lost.
    sigma_px: (L, N) how far a place may be wrong, one standard deviation; inf where lost.
    notes:    plain sentences about what was lost.
    """

    parts: NDArray[np.int64]
    points: Array
    uv: Array
    sigma_px: Array
    notes: tuple[str, ...]


KNEE_SHARE = 0.3
"""How far along the lower link, from its joint to its end, the point for knee and elbow is."""


@dataclass(frozen=True, eq=False)
class TwoLinks:
    """A limb of two links that ends in a leaf: upper arm, forearm and hand.

    upper, lower, leaf: part indices; the leaf is the lower link itself where nothing hangs on it.
    p_leaf: (3,) the followed point in the leaf's frame.
    """

    upper: int
    lower: int
    leaf: int
    p_leaf: Array


def leaves(skeleton: Skeleton) -> list[int]:
    """Parts from which no other part hangs, the root aside."""
    return [i for i in range(1, skeleton.part_count) if i not in skeleton.parents]


def two_link_limbs(skeleton: Skeleton) -> list[TwoLinks]:
    """All limbs of two links whose upper one is tracked.

    Of a limb with more parts the last three are upper link, lower link and leaf; of one with two
    parts the second is lower link and leaf at once.
    """
    limbs = []
    for leaf in leaves(skeleton):
        limb = np.flatnonzero(skeleton.limbs == skeleton.limbs[leaf])
        if len(limb) < 2:
            continue
        upper, lower = int(limb[-3:][0]), int(limb[-3:][1])
        if np.isin([upper, lower], skeleton.dof_part).all() and _moves_on(skeleton, lower, leaf):
            p = middle(skeleton, leaf) if leaf != lower else 1.8 * middle(skeleton, leaf)
            limbs.append(TwoLinks(upper, lower, leaf, p))
    return limbs


def _moves_on(skeleton: Skeleton, lower: int, leaf: int) -> bool:
    """Whether the lower link is long enough to show how it is turned."""
    p = skeleton.joints[leaf] if leaf != lower else middle(skeleton, leaf)
    return bool(np.linalg.norm(p) > 1e-3)


def middle(skeleton: Skeleton, part: int) -> Array:
    """(3,) the middle of a part's shape in its frame."""
    vertices = skeleton.body.parts[part].shape.mesh().vertices
    return np.asarray((vertices.min(axis=0) + vertices.max(axis=0)) / 2, np.float64)


def is_left_out(skeleton: Skeleton, part: int, left_out: Collection[str]) -> bool:
    """Whether a part, or any other part of its limb, is among these names."""
    limb = np.flatnonzero(skeleton.limbs == skeleton.limbs[part])
    return any(skeleton.body.names[i] in left_out for i in limb)


@dataclass(frozen=True, eq=False)
class FollowedPoint:
    """A point that is followed: of which part, where in its frame (3,), and what moves with it.

    size_m: how much of the body about it is looked at.
    """

    part: int
    p_part: Array
    rigid: tuple[int, ...]
    size_m: float


def followed_points(skeleton: Skeleton, left_out: Collection[str] = ()) -> list[FollowedPoint]:
    """The middles of all leaves, and of limbs of two links a point of the lower one near its joint.

    That point shows knee and elbow; it lies far enough from the joint that what is around it
    moves as one.
    """
    points = []
    for leaf in leaves(skeleton):
        if not is_left_out(skeleton, leaf, left_out):
            above = int(skeleton.parents[leaf])
            still = leaf not in skeleton.dof_part and above > 0
            rigid = (leaf, above) if still else (leaf,)
            points.append(
                FollowedPoint(leaf, middle(skeleton, leaf), rigid, _extent(skeleton, leaf))
            )
    for limb in two_link_limbs(skeleton):
        if limb.leaf != limb.lower and not is_left_out(skeleton, limb.leaf, left_out):
            p = KNEE_SHARE * skeleton.joints[limb.leaf]
            size = _extent(skeleton, limb.lower) / 2
            points.append(FollowedPoint(limb.lower, p, (limb.lower,), size))
    return points


def _extent(skeleton: Skeleton, part: int) -> float:
    """The longest side of a part, metres."""
    return float(np.ptp(skeleton.body.parts[part].shape.mesh().vertices, axis=0).max())


NEAR_M = 0.07
"""Surface points no further than this from an anchor decide whether it is hidden."""
STILL_SEEN = 0.4
"""Of those that the keyframe shows, how many must be seen for it not to be."""


@dataclass(frozen=True, eq=False)
class Anchor:
    """A point (3,) of a part's surface, in its frame, that a keyframe shows at uv (2,).

    shows: (h, w) the pixels of that keyframe that move as the point does. is_seen: False where the
    keyframe does not show the part; the point then lies within.
    """

    part: int
    p_part: Array
    uv: Array
    shows: NDArray[np.bool_]
    size_m: float
    is_seen: bool


def find_anchor(scene: Scene, point: FollowedPoint, T: Array, shown: Raster, half: int) -> Anchor:
    """Where a keyframe shows the part about a point.

    T (4, 4): the part in the camera frame. The pixel nearest to where the point would be seen
    through the part is taken, if it lies within `half` pixels along both axes.
    """
    uv, p_part = scene.camera.project(T[:3, :3] @ point.p_part + T[:3, 3]), point.p_part
    rows, columns = np.nonzero(shown.part == point.part)
    is_seen = bool(len(rows) and np.isfinite(uv).all())
    if is_seen:
        nearest = int(np.argmin(np.hypot(columns - uv[0], rows - uv[1])))
        at = np.array([columns[nearest], rows[nearest]], np.float64)
        is_seen = bool(np.abs(at - uv).max() <= half)
    if is_seen:
        p_camera = scene.camera.back_project(
            at, float(shown.depth[rows[nearest], columns[nearest]])
        )
        uv, p_part = at, T[:3, :3].T @ (p_camera - T[:3, 3])
    shows = np.isin(shown.part, point.rigid)
    return Anchor(point.part, p_part, uv, shows, point.size_m, is_seen)


def hidden(
    scene: Scene, motion: Trajectory, anchors: Sequence[tuple[Anchor, bool]]
) -> NDArray[np.bool_]:
    """(A, N) whether a motion has what is about each anchor turned away or behind another part.

    anchors: each with whether the first frame of the motion shows it, or else the last one.
    """
    mesh, view = BodyMesh.of(scene.skeleton), ViewCamera.of(scene.camera)
    visible_counts = np.zeros((len(anchors), len(motion)))
    about = [_about(scene, anchor) for anchor, _ in anchors]
    for n, T in enumerate(motion.transforms(scene.skeleton)):
        depth = raster(mesh, T, view).depth
        for a, ((anchor, _), chosen) in enumerate(zip(anchors, about, strict=True)):
            visible_counts[a, n] = _seen_count(scene, T[anchor.part], chosen, depth)
    shown = np.array(
        [
            row[0] if first else row[-1]
            for row, (_, first) in zip(visible_counts, anchors, strict=True)
        ]
    )
    return np.asarray(visible_counts < STILL_SEEN * shown.reshape(-1, 1))


def _about(scene: Scene, anchor: Anchor) -> NDArray[np.int64]:
    """Indices of the surface points near an anchor."""
    first, beyond = scene.points.starts[anchor.part : anchor.part + 2]
    away = np.linalg.norm(scene.points.points[first:beyond] - anchor.p_part, axis=1)
    return np.asarray(first + np.flatnonzero(away < max(NEAR_M, 1.01 * away.min(initial=0.0))))


def _seen_count(
    scene: Scene, T: Array, chosen: NDArray[np.int64], depth: NDArray[np.float32]
) -> int:
    """How many of these surface points are seen, their part at T (4, 4)."""
    p_camera = scene.points.points[chosen].astype(np.float64) @ T[:3, :3].T + T[:3, 3]
    normals = scene.points.normals[chosen].astype(np.float64) @ T[:3, :3].T
    facing = np.einsum("ij,ij->i", normals, p_camera) < 0
    uv = np.rint(np.nan_to_num(scene.camera.project(p_camera), nan=-1.0)).astype(np.int64)
    height, width = depth.shape
    inside = facing & ((uv >= 0) & (uv < (width, height))).all(axis=1)
    over = depth[uv[inside, 1], uv[inside, 0]] < p_camera[inside, 2] - scene.visibility.tolerance
    return int((~over).sum())


LEAST_HALF = 5
MOST_HALF = 16
"""Half a patch's side, pixels."""
TRUSTED_PX = 6.0
OCCLUDER_PX = 20.0
"""Distance of the two chains up to which their position of a point is used, and up to which their
occlusion of it is."""
INSTEAD = "followed from both keyframes there"
REACH_M = 0.055
LEAST_REACH = 6
MOST_REACH = 24
"""How far beside its expected place a point is looked for: metres on the body, and pixels."""
WANDER_PX = MOST_REACH + 1.5 * MOST_HALF
"""Around the body of both chains: what a template that is cut or sought there shows at most."""


def limb_tracks(
    scene: Scene,
    segment: Segment,
    left_out: Collection[str] = (),
    chains: Chains | None = None,
) -> LimbTracks:
    """Where the ends of limbs are seen.

    Every point is followed twice, as either keyframe shows it: they may show different sides of a
    part. chains: the body followed from both keyframes, if known.
    """
    points = followed_points(scene.skeleton, left_out)
    if chains is None:
        chains = follow_both(scene, segment, replace(FULL, finest=1))
    if chains is None:
        even = Chain.even(segment.interpolated())
        chains = even, even
    view = _View.of(scene, segment, chains)
    anchors = [view.anchor(point, forward) for point in points for forward in (True, False)]
    covered = hidden(scene, view.base, [(a, k % 2 == 0) for k, a in enumerate(anchors)])
    uv, sigma = np.full((len(anchors), len(view.shown), 2), np.nan), np.full(covered.shape, np.inf)
    notes: list[str] = []
    for i in range(0, len(anchors), 2):
        pair = slice(i, i + 2)
        courses = [view.course(anchors[k], covered[k], forward=k == i) for k in (i, i + 1)]
        first, second = (
            scene.point_pixels(view.base, anchors[k].part, anchors[k].p_part) for k in (i, i + 1)
        )
        uv[pair], sigma[pair] = combine_courses(courses[0], courses[1], second - first)
        notes += _words(view, points[i // 2], uv[pair])
    return LimbTracks(
        np.array([anchor.part for anchor in anchors], np.int64),
        np.array([anchor.p_part for anchor in anchors]).reshape(-1, 3),
        uv,
        sigma,
        tuple(notes),
    )


@dataclass(frozen=True, eq=False)
class _View:
    """A segment's pictures, and the chains from both keyframes.

    window: what the pictures show, around both chains: points are sought nowhere else, whatever
        more of the film is prepared.
    ends: what the first and the last keyframe show.
    """

    scene: Scene
    window: Window
    pictures: list[FloatPicture]
    shown: list[GreyPicture]
    chains: Chains
    base: Trajectory
    ends: tuple[Raster, Raster]

    @classmethod
    def of(cls, scene: Scene, segment: Segment, chains: Chains) -> _View:
        """Prepare one segment."""
        slots = segment.clip.slots(segment.first_frame, segment.last_frame)
        base = blend_chains(scene, *chains)
        window, prepared = show_all(scene, segment.clip, chains, WANDER_PX)
        pictures = [in_grey_levels(prepared.cut(int(slot), 0, window)) for slot in slots]
        mesh, view = BodyMesh.of(scene.skeleton), ViewCamera.of(scene.camera)
        Ts = base.transforms(scene.skeleton)
        ends = (raster(mesh, Ts[0], view), raster(mesh, Ts[-1], view))
        shown = [GreyPicture.of(picture) for picture in pictures]
        return cls(scene, window, pictures, shown, chains, base, ends)

    def anchor(self, point: FollowedPoint, forward: bool) -> Anchor:
        """The point as the first keyframe shows it, or the last one."""
        shown, slot = (self.ends[0], 0) if forward else (self.ends[1], -1)
        T = self.base.transforms(self.scene.skeleton)[slot, point.part]
        return find_anchor(self.scene, point, T, shown, self._half(point.size_m))

    def course(self, anchor: Anchor, covered: NDArray[np.bool_], forward: bool) -> Course:
        """An anchor followed from its keyframe on, in frame order."""
        along = slice(None, None, 1 if forward else -1)
        uv = self.scene.point_pixels(self.base, anchor.part, anchor.p_part)
        ways = [self.scene.point_pixels(chain, anchor.part, anchor.p_part) for chain in self.chains]
        apart = np.linalg.norm(ways[0] - ways[1], axis=-1)
        covered, trusted = covered & (apart < OCCLUDER_PX), apart < TRUSTED_PX
        corner = np.array([self.window.left, self.window.top])
        expected = BaseCourse(uv[along] - corner, covered[along], trusted[along])
        start, pictures = anchor.uv - corner, self.pictures[along]
        key = None
        if anchor.is_seen:
            place = (float(start[0]), float(start[1]), 0.0, 0.0)
            shows = self.window.of(anchor.shows)
            key = Patch.cut(pictures[0], place, self._half(anchor.size_m), shows)
        course = Course.at_its_start(start, len(pictures))
        if key is not None:
            reach = int(np.clip(REACH_M / self.scene.pixel_m, LEAST_REACH, MOST_REACH))
            course = follow_point(key, start, pictures, self.shown[along], expected, reach)
        course = replace(course, uv=course.uv + corner)
        return course if forward else course.reversed()

    def _half(self, size_m: float) -> int:
        return int(np.clip(size_m / self.scene.pixel_m / 2, LEAST_HALF, MOST_HALF))


def _words(view: _View, point: FollowedPoint, uv: Array) -> list[str]:
    """Notes for a person on a point's tracks (2, N, 2): hands and feet represent their limbs."""
    lost = 1 + np.flatnonzero(np.isnan(uv[:, 1:-1, 0]).all(axis=0))  # the ends are posed
    if not len(lost) or point.part in view.scene.skeleton.parents:
        return []
    name, first = readable(view.scene.skeleton.body.names[point.part]), view.base.first_frame
    if len(lost) >= uv.shape[1] - 2:
        return [f"{name} was not found between the keyframes: {INSTEAD}"]
    at = f"{name} lost at frame {first + int(lost[0])}"
    return [f"{at}, {len(lost)} frames in all: {INSTEAD}" if len(lost) > 1 else f"{at}: {INSTEAD}"]
