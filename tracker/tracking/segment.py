"""The frames between two keyframes, and measures of a trajectory over them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Trajectory, interpolate
from keypose.tracker.geometry.rotations import Array

if TYPE_CHECKING:
    from keypose.tracker.tracking.scene import Scene
    from keypose.tracker.video.pyramid import Clip

NEAREST_M = 0.05
FURTHEST = 50.0
"""A body nearer than this, or this many times further than it was keyed, has been lost."""


@dataclass(frozen=True, eq=False)
class Segment:
    """The frames between two keyframes, with their pictures.

    imported: a motion from elsewhere that meets both keyframes, to start from; None without one.
    own: the film's own motion of before, that meets both keyframes: where tracking starts, and what
        counts where the film shows nothing; None without one.
    to_posed_s: (N, P) seconds to the nearest of its keyframes, and of those of limbs within, at
        which a person posed a part; infinite without one. None where nobody knows.
    """

    first_frame: int
    last_frame: int
    start: Pose
    end: Pose
    clip: Clip
    imported: Trajectory | None = None
    own: Trajectory | None = None
    to_posed_s: Array | None = None

    @property
    def damaged(self) -> frozenset[int]:
        """The frames between the keyframes whose pictures are missing or damaged."""
        inside = range(self.first_frame + 1, self.last_frame)
        return frozenset(n for n in self.clip.damaged if n in inside)

    def interpolated(self) -> Trajectory:
        """Plain interpolation of the keyframes."""
        return interpolate(self.start, self.end, self.first_frame, self.last_frame)

    def expected(self, Rs: Array, ps: Array, n: int) -> Pose:
        """The nth pose as those before it lead to expect: turned as the last one, the root going on
        as it did. Rs (N, P, 3, 3), ps (N, 3): the interpolated motion, found up to there."""
        velocity = ps[n - 1] - ps[n - 2] if n > 1 else np.zeros(3)
        return Pose(Rs[n - 1], ps[n - 1] + velocity)


def is_sound(scene: Scene, segment: Segment, trajectory: Trajectory) -> bool:
    """Whether every joint of a trajectory lies before the camera, and not too far away."""
    z = scene.transforms(trajectory)[..., 2, 3]
    far = FURTHEST * max(segment.start.p_camera_root[2], segment.end.p_camera_root[2])
    return bool(np.isfinite(z).all() and z.min() > NEAREST_M and z.max() < far)


def extent_px(scene: Scene, trajectory: Trajectory) -> float:
    """How large the body is in the picture, as a rule; at least a pixel."""
    uv = scene.mark_pixels(trajectory)
    extent = np.median((uv.max(axis=1) - uv.min(axis=1)).max(axis=-1))
    return max(float(np.nan_to_num(extent)), 1.0)


def distance_px(scene: Scene, a: Trajectory, b: Trajectory) -> Array:
    """(N, M) distance of two trajectories' marks in the picture."""
    return np.asarray(np.linalg.norm(scene.mark_pixels(a) - scene.mark_pixels(b), axis=-1))
