"""What another film shows of a segment, whose frames and whose camera are the first film's."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.frames import TermIn
from keypose.tracker.solver.in_film import FilmFrames, InFilm
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.sigmas import ON_PART_M
from keypose.tracker.solver.terms import Link, Term
from keypose.tracker.tracking.cues.joint_evidence import Sight
from keypose.tracker.tracking.cues.reweighting import smoothed_keypoints

if TYPE_CHECKING:
    from collections.abc import Sequence

    from keypose.tracker.solver.robust import Kernel
    from keypose.tracker.tracking.cues.anchors import Anchors
    from keypose.tracker.tracking.scene import Scene
    from keypose.tracker.video.pyramid import Clip


FEWEST_FRAMES = 3
"""Of a film within a segment, with which its pictures tell anything of it."""


@dataclass(frozen=True, eq=False)
class OtherFilm:
    """A film besides the first.

    scene: of the skeleton with free joints, before the film's camera.
    frames, clip: its own frames within the segment, and their pictures.
    anchors: what its keypoints say at the segment's N frames; None where they say nothing.
    Ts_film_first (N, 4, 4): from the first camera's frame to this one's, at each of these.
    """

    scene: Scene
    frames: FilmFrames
    clip: Clip
    anchors: Anchors | None
    Ts_film_first: Array

    def between(self, first: int, last: int) -> OtherFilm | None:
        """The same of some rows of the segment alone; None where it hardly reaches over them."""
        frames = self.frames.between(first, last)
        if len(frames) < FEWEST_FRAMES:
            return None
        rows = slice(first, last + 1)
        anchors = None if self.anchors is None else self.anchors.of_rows(rows)
        return replace(self, frames=frames, anchors=anchors, Ts_film_first=self.Ts_film_first[rows])

    def of_skeleton(self, skeleton: Skeleton) -> OtherFilm:
        """The same of the same body with other parts tracked."""
        anchors = self.anchors and self.anchors.of_skeleton(skeleton)
        return replace(self, scene=self.scene.of_skeleton(skeleton), anchors=anchors)

    def frame_terms(self, frames: slice | int, kernel: Kernel) -> tuple[Term, ...]:
        """What the film's keypoints say of the poses of some frames, or of one."""
        if self.anchors is None:
            return ()
        terms = self.anchors.terms(self.scene.camera, kernel, frames)
        return tuple(TermIn(term, self.Ts_film_first[frames]) for term in terms)

    def link(self, steps: Sequence[Link]) -> Link:
        """What the steps between the film's own frames are compared with."""
        return InFilm(self.scene.skeleton, self.frames, links=steps)

    def inner(self, term: Term) -> Link:
        """What poses at its frames but the first and the last are compared with."""
        return InFilm(self.scene.skeleton, self.frames.inner, terms=(term,))

    def seen(self, motion: Trajectory) -> Trajectory:
        """A motion of the segment as the film saw it, at its own frames."""
        return self.frames.seen(motion)

    def here(self, motion: Trajectory) -> Trajectory:
        """A motion of the segment before the film's camera, at the segment's own frames."""
        return motion.carried(self.Ts_film_first)

    def sight(self, motion: Trajectory) -> Sight | None:
        """What the film's keypoints say of a motion of the segment; None where it has none."""
        if self.anchors is None:
            return None
        anchors, camera = self.anchors, self.scene.camera
        p = anchors.where(self.here(motion).transforms(self.scene.skeleton))
        away = np.linalg.norm(image_points(camera, p) - anchors.uv, axis=-1) / anchors.height_px
        from_first = p - self.Ts_film_first[:, None, :3, 3]
        aside = np.linalg.norm(np.cross(p, from_first), axis=-1)
        sine = aside / (np.linalg.norm(p, axis=-1) * np.linalg.norm(from_first, axis=-1))
        with np.errstate(divide="ignore"):
            across_m = p[..., 2] / camera.fy / anchors.scale
            depth_sigma_m = np.hypot(across_m, ON_PART_M) / sine
        return Sight(
            anchors.parts,
            np.where(anchors.known, away, np.nan),
            np.where(anchors.known, anchors.visibility, 0.0),
            depth_sigma_m,
        )

    def steadied(self, present: Trajectory, weight: float) -> OtherFilm:
        """The same with smooth keypoints, their standard deviations divided by the weight."""
        if self.anchors is None:
            return self
        smooth = smoothed_keypoints(self.anchors, self.scene, self.here(present))
        return replace(self, anchors=smooth.weighted(weight))
