"""A film beside the first, made ready to be tracked with it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.surface_points import SurfacePoints
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.film_clock import FilmClock, sampled
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.solver.in_film import FilmFrames
from keypose.tracker.tracking.cues.anchors import anchors_of
from keypose.tracker.tracking.cues.other_film import FEWEST_FRAMES, OtherFilm
from keypose.tracker.tracking.prepared_film import PreparedFilm
from keypose.tracker.tracking.segment import Segment

SAME_MOMENT = 1e-6
"""Frames: what is nearer was taken at the same moment."""


@dataclass(frozen=True, eq=False)
class FilmBeside:
    """A film besides the first.

    clock: beside the first film's.
    Ts_own (F, 4, 4), Ts_first (N, 4, 4): from the first camera's frame to this one's, at each frame
        of this film, and at each of the first.
    keypoints: over all its frames; None where nobody was found.
    """

    film: PreparedFilm
    clock: FilmClock
    Ts_own: Array
    Ts_first: Array
    keypoints: Keypoints | None

    def over(
        self,
        segment: Segment,
        followed: Trajectory,
        skeleton: Skeleton,
        density: float,
        sample: Callable[[Skeleton, float], SurfacePoints],
        agreed: Collection[int],
    ) -> tuple[OtherFilm, ...]:
        """What the film shows of a segment: where it seems to exchange left and right, also set
        right. None where it does not reach over it.

        followed: about the motion, as the first film shows it, which tells left from right.
        skeleton: with free joints.  density, sample: of surface points.
        agreed: as of `anchors_of`.
        """
        frames = self._frames(segment)
        if frames is None:
            return ()
        filmed = frames.seen(segment.interpolated())
        clip = self.film.pictures(skeleton, filmed)
        ends = [filmed.pose(filmed.first_frame), filmed.pose(filmed.last_frame)]
        scene = self.film.scene(skeleton, ends, len(frames), density, sample)
        scene = self.film.before_plate(scene, clip, filmed)
        Ts = self.Ts_first[segment.first_frame : segment.last_frame + 1]
        there = followed.carried(Ts)
        own = replace(
            segment,
            start=there.pose(segment.first_frame),
            end=there.pose(segment.last_frame),
            clip=clip,
            imported=None,
            own=None,
        )
        keypoints = self.keypoints_at(segment.first_frame, segment.last_frame)
        candidates = (
            ()
            if keypoints is None
            else anchors_of(scene, own, self.film.camera, keypoints, followed=there, agreed=agreed)
        )
        return tuple(
            OtherFilm(scene, frames, clip, anchors, Ts) for anchors in candidates or (None,)
        )

    def _frames(self, segment: Segment) -> FilmFrames | None:
        """Its own frames within a segment."""
        begins, ends = self.clock.frames_at([segment.first_frame, segment.last_frame])
        first = max(0, int(np.ceil(begins - SAME_MOMENT)))
        last = min(self.film.frame_count - 1, int(np.floor(ends + SAME_MOMENT)))
        if last - first + 1 < FEWEST_FRAMES:
            return None
        moments = self.clock.moments_of(np.arange(first, last + 1)) - segment.first_frame
        moments = np.clip(moments, 0.0, segment.last_frame - segment.first_frame)
        return FilmFrames(first, moments, self.Ts_own[first : last + 1])

    def keypoints_at(self, first: int, last: int) -> Keypoints | None:
        """Its keypoints at frames of the first film: between two frames on the even way."""
        if self.keypoints is None:
            return None
        whole = self.keypoints.over(0, self.film.frame_count - 1)
        frames = self.clock.frames_at(np.arange(first, last + 1))

        def at(values: Array | None) -> Array | None:
            return None if values is None else sampled(values, frames)

        uv = sampled(whole.uv, frames)
        is_seen = np.isfinite(uv).all(axis=-1)
        visibility = np.where(is_seen, np.nan_to_num(sampled(whole.visibility, frames)), 0.0)
        depth, sigma = at(whole.p_hips), at(whole.depth_sigma_m)
        return Keypoints(first, whole.names, uv, visibility, depth, depth_sigma_m=sigma)
