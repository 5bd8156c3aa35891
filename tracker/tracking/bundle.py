"""Whole-segment refinement: all inner poses of a segment improved together.

The cycle of DRIFT has the wide basin, this has the accuracy: it compares every frame with the
textures of both keyframes instead of with its neighbour, so no error accumulates. It cannot correct
a start that is far off, and it gains nothing where keyframes are badly posed; the caller keeps the
better of the two.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.pairs import view
from keypose.tracker.kernels.whole import compare_textures, see_all
from keypose.tracker.solver.least_squares import UNJUDGED
from keypose.tracker.solver.motion_problem import MotionProblem
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.sigmas import BEND_IN_PICTURE, FIRST_GREY_OF_SEGMENT
from keypose.tracker.solver.smoothness import Smoothness
from keypose.tracker.solver.terms import Equations, Term
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.windows import show
from keypose.tracker.video.pyramid import Clip

if TYPE_CHECKING:
    from keypose.tracker.tracking.method import Refinement

LOOK_AGAIN = 5
"""Solves after which visibility is updated."""


def refine(
    scene: Scene,
    clip: Clip,
    start: Trajectory,
    how: Refinement,
    others: MotionProblem | None = None,
) -> Trajectory:
    """The refined trajectory; its ends stay exactly where they are.

    others: what the motion is compared with besides the pictures; that it is even, where left out.
    """
    if len(start) < 3 or not scene.skeleton.dof_count:
        return start
    even = Smoothness.even(scene.skeleton, len(start), scene.precision(BEND_IN_PICTURE))
    problem = others or MotionProblem(scene.skeleton, links=(even,))
    textures = Textures.of(scene, clip, start, how.stride)
    problem = replace(problem, terms=(*problem.terms, textures))
    return problem.solve(start, replace(UNJUDGED, most_steps=how.solves))


@dataclass(frozen=True, eq=False)
class Textures(Term):
    """The n inner poses of a segment beside the textures of both keyframes, for one descent.

    slots (n,): of their pictures in the clip.  chosen, grey, starts: the followed points of both
    keyframes, stacked on a first axis of two.  seen (n, S) and sigma (2, n) are updated with every
    solve.
    """

    scene: Scene
    clip: Clip
    slots: NDArray[np.int64]
    chosen: NDArray[np.int32]
    grey: NDArray[np.float32]
    starts: NDArray[np.int64]
    information: float
    seen: NDArray[np.uint8]
    sigma: Array
    solves: Iterator[int] = field(default_factory=count)

    @classmethod
    def of(cls, scene: Scene, clip: Clip, start: Trajectory, stride: int) -> Textures:
        """What the first and the last frame show of the body at the start."""
        frames, shown = len(start), show(scene, clip, *start.writable())
        pictures, lens = shown.levels[0], shown.seen_by(scene.lens)
        slots = clip.slots(start.first_frame, start.last_frame)
        size, (height, width) = len(scene.points.points), pictures.shape[1:3]
        chosen, grey = np.zeros((2, size + 1), np.int32), np.zeros((2, size + 1), np.float32)
        starts = np.zeros((2, scene.skeleton.part_count + 1), np.int64)
        R, t = start.writable()
        for k in (0, -1):
            view(
                scene.arrays,
                lens,
                scene.visibility,
                width,
                height,
                pictures[slots[k]],
                stride,
                R[k],
                t[k],
                chosen[k],
                grey[k],
                starts[k],
            )
        return cls(
            scene,
            clip,
            slots[1:-1],
            chosen,
            grey,
            starts,
            scene.information(stride),
            np.zeros((frames - 2, size), np.uint8),
            np.full((2, frames - 2), FIRST_GREY_OF_SEGMENT),
        )

    def cost(self, posed: Posed) -> float:  # noqa: ARG002
        """How good the poses are is scored elsewhere."""
        return np.nan

    def equations(self, posed: Posed) -> Equations:
        scene, R, t = self.scene, posed.Rs_parent_part.copy(), posed.p_camera_root.copy()
        shown = show(scene, self.clip, R, t)
        pictures, lens = shown.levels[0], shown.seen_by(scene.lens)
        if next(self.solves) % LOOK_AGAIN == 0:
            height, width = pictures.shape[1:3]
            see_all(scene.arrays, lens, scene.visibility, width, height, R, t, self.seen)
        dofs = scene.skeleton.dof_count
        A, b = np.empty((len(t), dofs, dofs)), np.empty((len(t), dofs))
        compare_textures(
            scene.arrays,
            lens,
            pictures,
            self.slots,
            R,
            t,
            self.chosen,
            self.grey,
            self.starts,
            self.seen,
            self.information,
            self.sigma,
            A,
            b,
        )
        return Equations(A, b, np.nan)
