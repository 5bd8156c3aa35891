"""The ends of limbs followed from both keyframes: INITIAL's templates, carried further.

Beyond INITIAL §3.1: a patch of each keyframe and one that is renewed on the way, places to a
fraction of a pixel, both directions combined, and occlusion as predicted by a base trajectory.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.raster import BodyMesh, Raster, raster
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import readable
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.tracking.initial.chains import Chain, Chains, blend_chains, follow_both
from keypose.tracker.tracking.initial.templates.anchors import Anchor, find_anchor, hidden
from keypose.tracker.tracking.initial.templates.combine_courses import combine_courses
from keypose.tracker.tracking.initial.templates.ends import Followed, followed_points
from keypose.tracker.tracking.initial.templates.follow_point import BaseCourse, Course, follow_point
from keypose.tracker.tracking.initial.templates.patch import Patch
from keypose.tracker.tracking.initial.templates.results import LimbTracks
from keypose.tracker.tracking.initial.templates.search import GreyPicture
from keypose.tracker.tracking.method import FULL
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.video.pyramid import Picture

LEAST_HALF, MOST_HALF = 5, 16
"""Half a patch's side, pixels."""
TRUSTED_PX, OCCLUDER_PX = 6.0, 20.0
"""Distance of the two chains up to which their position of a point is used, and up to which their
occlusion of it is."""
INSTEAD = "followed from both keyframes there"
REACH_M, LEAST_REACH, MOST_REACH = 0.055, 6, 24
"""How far beside its expected place a point is looked for: metres on the body, and pixels."""


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
        uv, sigma, tuple(notes),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _View:
    """A segment's pictures, and the chains from both keyframes.

    ends: what the first and the last keyframe show.
    """

    scene: Scene
    pictures: list[Picture]
    shown: list[GreyPicture]
    chains: Chains
    base: Trajectory
    ends: tuple[Raster, Raster]

    @classmethod
    def of(cls, scene: Scene, segment: Segment, chains: Chains) -> _View:
        """Of one segment."""
        slots = segment.clip.slots(segment.first_frame, segment.last_frame)
        pictures = [segment.clip.levels[0][slot] for slot in slots]
        base = blend_chains(scene, *chains)
        mesh, view = BodyMesh.of(scene.skeleton), ViewCamera.of(scene.camera)
        Ts = base.transforms(scene.skeleton)
        ends = (raster(mesh, Ts[0], view), raster(mesh, Ts[-1], view))
        return cls(scene, pictures, [GreyPicture.of(p) for p in pictures], chains, base, ends)

    def anchor(self, point: Followed, forward: bool) -> Anchor:
        """The point as the first keyframe shows it, or the last one."""
        seen, slot = (self.ends[0], 0) if forward else (self.ends[1], -1)
        T = self.base.transforms(self.scene.skeleton)[slot, point.part]
        return find_anchor(self.scene, point, T, seen, self._half(point.size_m))

    def course(self, anchor: Anchor, covered: NDArray[np.bool_], forward: bool) -> Course:
        """An anchor followed from its keyframe on, in frame order."""
        along = slice(None, None, 1 if forward else -1)
        uv = self.scene.point_pixels(self.base, anchor.part, anchor.p_part)
        ways = [self.scene.point_pixels(chain, anchor.part, anchor.p_part) for chain in self.chains]
        apart = np.linalg.norm(ways[0] - ways[1], axis=-1)
        covered, trusted = covered & (apart < OCCLUDER_PX), apart < TRUSTED_PX
        expected = BaseCourse(uv[along], covered[along], trusted[along])
        start, pictures = anchor.uv, self.pictures[along]
        key = None
        if anchor.is_seen:
            place = (float(start[0]), float(start[1]), 0.0, 0.0)
            key = Patch.cut(pictures[0], place, self._half(anchor.size_m), anchor.shows)
        course = Course.at_its_start(start, len(pictures))
        if key is not None:
            reach = int(np.clip(REACH_M / self.scene.pixel_m, LEAST_REACH, MOST_REACH))
            course = follow_point(key, start, pictures, self.shown[along], expected, reach)
        return course if forward else course.reversed()

    def _half(self, size_m: float) -> int:
        return int(np.clip(size_m / self.scene.pixel_m / 2, LEAST_HALF, MOST_HALF))


def _words(view: _View, point: Followed, uv: Array) -> list[str]:
    """Notes for a person on a point's tracks (2, N, 2): hands and feet represent their limbs."""
    lost = 1 + np.flatnonzero(np.isnan(uv[:, 1:-1, 0]).all(axis=0))  # the ends are posed
    if not len(lost) or point.part in view.scene.skeleton.parents:
        return []
    name, first = readable(view.scene.skeleton.body.names[point.part]), view.base.first_frame
    if len(lost) >= uv.shape[1] - 2:
        return [f"{name} was not found between the keyframes: {INSTEAD}"]
    at = f"{name} lost at frame {first + int(lost[0])}"
    return [f"{at}, {len(lost)} frames in all: {INSTEAD}" if len(lost) > 1 else f"{at}: {INSTEAD}"]
