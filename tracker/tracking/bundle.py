"""Whole-segment refinement: all inner poses of a segment improved together.

The cycle of DRIFT has the wide basin, this has the accuracy: it compares every frame with the
textures of both keyframes instead of with its neighbour, so no error accumulates. It cannot correct
a start that is far off, and it gains nothing where keyframes are badly posed; the caller keeps the
better of the two.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.pairs import view
from keypose.tracker.kernels.whole import move_inner, see_all, whole_segment
from keypose.tracker.solver.banded import added, banded_step
from keypose.tracker.solver.least_squares import UNJUDGED, Problem, least_squares
from keypose.tracker.solver.sigmas import BEND_IN_PICTURE, FIRST_GREY_OF_SEGMENT
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.video.pyramid import Clip, Picture

if TYPE_CHECKING:
    from keypose.tracker.solver.segment_poses import SegmentPoses
    from keypose.tracker.tracking.method import Refinement

LOOK_AGAIN = 5
"""Solves after which visibility is updated."""


@dataclass(frozen=True, eq=False)
class _Textures:
    """The followed points of both keyframes: stacked on a first axis of two."""

    chosen: NDArray[np.int32]
    grey: NDArray[np.float32]
    starts: NDArray[np.int64]


def refine(
    scene: Scene,
    clip: Clip,
    start: Trajectory,
    how: Refinement,
    others: SegmentPoses | None = None,
    *,
    even: bool = True,
) -> Trajectory:
    """The refined trajectory; its ends stay exactly where they are.

    others: what the motion is compared with besides the pictures.  even: whether it is to be smooth
    by itself, where the others do not say how it changes.
    """
    if len(start) < 3 or not scene.skeleton.dof_count:
        return start
    pictures = _Pictures.of(scene, clip, start, how, others, even)
    R, t = least_squares(pictures, start.writable(), replace(UNJUDGED, most_steps=how.solves)).state
    return Trajectory(start.first_frame, R, t)


Poses: TypeAlias = tuple[Array, Array]
"""R (n + 1, P, 3, 3) and t (n + 1, 3) of a segment's frames, as the loops take them."""


@dataclass(frozen=True, eq=False)
class _Pictures(Problem[Poses, "_Point"]):
    """A segment's frames beside the textures of both keyframes.

    seen (n + 1, S) and sigma (2, n + 1) are updated with every solve.
    """

    scene: Scene
    pictures: Picture
    slots: NDArray[np.int64]
    textures: _Textures
    information: float
    smooth: Array
    seen: NDArray[np.uint8]
    sigma: Array
    first_frame: int
    others: SegmentPoses | None

    @classmethod
    def of(
        cls,
        scene: Scene,
        clip: Clip,
        start: Trajectory,
        how: Refinement,
        others: SegmentPoses | None,
        even: bool,
    ) -> _Pictures:
        """The pictures at the start."""
        frames, pictures = len(start), clip.levels[0]
        slots = clip.slots(start.first_frame, start.last_frame)
        smooth = scene.precision(BEND_IN_PICTURE)
        return cls(
            scene, pictures, slots,
            _keyframe_textures(scene, pictures, slots, *start.writable(), how.stride),
            scene.information(how.stride),
            smooth if even else np.zeros_like(smooth),
            np.zeros((frames, len(scene.points.points)), np.uint8),
            np.full((2, frames), FIRST_GREY_OF_SEGMENT), start.first_frame, others,
        )  # fmt: skip

    def at(self, state: Poses, count: int) -> _Point:
        return _Point(self, state, count % LOOK_AGAIN == 0)

    def moved(self, state: Poses, step: Array) -> Poses:
        R, t = state[0].copy(), state[1].copy()
        move_inner(self.scene.arrays, R, t, step.reshape(len(t) - 2, -1))
        return R, t

    def equations(self, poses: Poses) -> tuple[Array, Array]:
        """Upper banded (3D, nD) and gradient (nD,) of the n inner poses, smoothness included."""
        scene, textures = self.scene, self.textures
        inner, dofs = len(poses[1]) - 2, scene.skeleton.dof_count
        banded, gradient = np.empty((3 * dofs, inner * dofs)), np.empty(inner * dofs)
        whole_segment(
            scene.arrays, scene.lens, self.pictures, self.slots, *poses,
            textures.chosen, textures.grey, textures.starts, self.seen,
            self.information, self.smooth, self.sigma, banded, gradient,
        )  # fmt: skip
        if self.others is not None:
            more, pull = self.others.at(Trajectory(self.first_frame, *poses), 0).equations
            banded, gradient = added(banded, more), gradient + pull
        return banded, gradient

    def look(self, poses: Poses) -> None:
        """Update what the poses show."""
        height, width = self.pictures.shape[1:3]
        scene = self.scene
        see_all(scene.arrays, scene.lens, scene.visibility, width, height, *poses, self.seen)


@dataclass(frozen=True, eq=False)
class _Point:
    """The equations of a segment's poses; how good these are is scored elsewhere."""

    pictures: _Pictures
    poses: Poses
    looks: bool
    cost = np.nan

    def step(self, damping: float) -> Array | None:
        if self.looks:
            self.pictures.look(self.poses)
        return banded_step(*self.pictures.equations(self.poses), damping)


def _keyframe_textures(
    scene: Scene, pictures: Picture, slots: NDArray[np.int64], R: Array, t: Array, stride: int
) -> _Textures:
    """Return what the first and the last frame show of the body."""
    size, parts = len(scene.points.points), scene.skeleton.part_count
    chosen, grey = np.zeros((2, size + 1), np.int32), np.zeros((2, size + 1), np.float32)
    starts = np.zeros((2, parts + 1), np.int64)
    height, width = pictures.shape[1:3]
    for k, j in enumerate((0, len(t) - 1)):
        view(
            scene.arrays, scene.lens, scene.visibility, width, height, pictures[slots[j]],
            stride, R[j], t[j], chosen[k], grey[k], starts[k],
        )  # fmt: skip
    return _Textures(chosen, grey, starts)
