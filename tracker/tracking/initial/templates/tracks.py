"""The ends of limbs followed from both keyframes: INITIAL's templates, carried further.

Beyond INITIAL §3.1: a patch of each keyframe and one that is renewed on the way, places to a
fraction of a pixel, both directions beside each other, and what lies before a part heeded as far as
a base trajectory tells.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker.body.raster import BodyMesh, Raster, raster
from tracker.body.trajectory import Trajectory, interpolate
from tracker.geometry.rotations import Array
from tracker.geometry.view import ViewCamera
from tracker.tracking.initial.chains import Chain, blend_chains, follow
from tracker.tracking.initial.templates.anchors import Anchor, find_anchor, hidden, places
from tracker.tracking.initial.templates.course import Course, Guide, follow_point
from tracker.tracking.initial.templates.ends import Followed, followed_points, plain_name
from tracker.tracking.initial.templates.given import LimbTracks
from tracker.tracking.initial.templates.meeting import combine_courses
from tracker.tracking.initial.templates.patch import Patch
from tracker.tracking.initial.templates.search import Shown
from tracker.tracking.method import FULL
from tracker.tracking.scene import Scene
from tracker.tracking.segment import Segment, is_sound
from tracker.video.pyramid import Picture

Chains = tuple[Chain, Chain]

LEAST_HALF, MOST_HALF = 5, 16
"""Half a patch's side, pixels."""
TRUSTED_PX, HEEDED_PX = 6.0, 20.0
"""How near each other the two chains must lie for where they have a point to be believed, and for
what they have before it."""
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

    Every point is followed twice, as either keyframe shows it: what one of them sees of a part's
    surface the other one need not. chains: the body followed from both keyframes, if known.
    """
    points = followed_points(scene.skeleton, left_out)
    view = _View.of(scene, segment, chains or _followed(scene, segment))
    anchors = [view.anchor(point, forward) for point in points for forward in (True, False)]
    covered = hidden(scene, view.base, [(a, k % 2 == 0) for k, a in enumerate(anchors)])
    uv, sigma = np.full((len(anchors), len(view.shown), 2), np.nan), np.full(covered.shape, np.inf)
    notes: list[str] = []
    for i in range(0, len(anchors), 2):
        pair = slice(i, i + 2)
        courses = [view.course(anchors[k], covered[k], forward=k == i) for k in (i, i + 1)]
        offset = places(scene, view.base, anchors[i + 1]) - places(scene, view.base, anchors[i])
        uv[pair], sigma[pair] = combine_courses(courses[0], courses[1], offset)
        notes += _words(view, points[i // 2], uv[pair])
    return LimbTracks(
        np.array([anchor.part for anchor in anchors], np.int64),
        np.array([anchor.p_part for anchor in anchors]).reshape(-1, 3),
        uv, sigma, tuple(notes),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _View:
    """A segment's pictures, and what the chains from both keyframes say of the body in them.

    ends: what the first and the last keyframe show.
    """

    scene: Scene
    pictures: list[Picture]
    shown: list[Shown]
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
        return cls(scene, pictures, [Shown.of(p) for p in pictures], chains, base, ends)

    def anchor(self, point: Followed, forward: bool) -> Anchor:
        """The point as the first keyframe shows it, or the last one."""
        seen, slot = (self.ends[0], 0) if forward else (self.ends[1], -1)
        T = self.base.transforms(self.scene.skeleton)[slot, point.part]
        return find_anchor(self.scene, point, T, seen, self._half(point.size_m))

    def course(self, anchor: Anchor, covered: NDArray[np.bool_], forward: bool) -> Course:
        """An anchor followed from its keyframe on, in frame order."""
        along = slice(None, None, 1 if forward else -1)
        uv = places(self.scene, self.base, anchor)
        ways = [places(self.scene, chain, anchor) for chain in self.chains]
        apart = np.linalg.norm(ways[0] - ways[1], axis=-1)
        covered, trusted = covered & (apart < HEEDED_PX), apart < TRUSTED_PX
        guide = Guide(uv[along], covered[along], trusted[along])
        start, pictures = anchor.uv, self.pictures[along]
        key = None
        if anchor.is_seen:
            place = (float(start[0]), float(start[1]), 0.0, 0.0)
            key = Patch.cut(pictures[0], place, self._half(anchor.size_m), anchor.shows)
        course = Course.at_its_start(start, len(pictures))
        if key is not None:
            reach = int(np.clip(REACH_M / self.scene.pixel_m, LEAST_REACH, MOST_REACH))
            course = follow_point(key, start, pictures, self.shown[along], guide, reach)
        return course if forward else course.reversed()

    def _half(self, size_m: float) -> int:
        return int(np.clip(size_m / self.scene.pixel_m / 2, LEAST_HALF, MOST_HALF))


def _followed(scene: Scene, segment: Segment) -> Chains:
    """The body followed from both keyframes; interpolation where that gets lost."""
    first, last = segment.first_frame, segment.last_frame
    how = (FULL.stride, FULL.chain_inner, FULL.stop, 1)
    chains = (
        follow(scene, segment.clip, segment.start, first, last, *how),
        follow(scene, segment.clip, segment.end, last, first, *how),
    )
    if all(is_sound(scene, segment, chain) for chain in chains):
        return chains
    plain = Chain.even(interpolate(segment.start, segment.end, first, last))
    return plain, plain


def _words(view: _View, point: Followed, uv: Array) -> list[str]:
    """What a person should know of a point's tracks (2, N, 2): hands and feet stand for limbs."""
    lost = 1 + np.flatnonzero(np.isnan(uv[:, 1:-1, 0]).all(axis=0))  # the ends are posed
    if not len(lost) or point.part in view.scene.skeleton.parents:
        return []
    name, first = plain_name(view.scene.skeleton, point.part), view.base.first_frame
    if len(lost) >= uv.shape[1] - 2:
        return [f"{name} was not found between the keyframes: {INSTEAD}"]
    at = f"{name} lost at frame {first + int(lost[0])}"
    return [f"{at}, {len(lost)} frames in all: {INSTEAD}" if len(lost) > 1 else f"{at}: {INSTEAD}"]
