"""How like a frame is to what other frames, whose poses are known, show of the body.

Each known pose puts its picture's brightness onto the surface points it shows: a texture. Laid onto
another frame at a pose to be found, the differences of brightness say where the pose should go.
Light may differ between the two: each part has a gain and a bias where that is asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tracker.body.pose import Pose
from tracker.geometry.rotations import Array
from tracker.kernels.chain import camera_twists, normal_equations, place_parts, sum_subtrees
from tracker.kernels.noise import BINS, capped_square, robust_sigma
from tracker.kernels.pairs import CAP, scaled_lens
from tracker.kernels.seeing import pick, room, see
from tracker.kernels.sums import (
    BLOCK,
    HUBER,
    HUBER_WIDTH,
    LEAST_SQUARES,
    TUKEY,
    TUKEY_WIDTH,
    sum_points,
)
from tracker.tracking.scene import Scene
from tracker.video.pyramid import Picture

OF = 2
"""One surface point of so many is followed, the one with the strongest gradient."""
COARSE_LEVEL = 2
"""From this level of the pyramid on, every second point is enough."""
FIRST_SIGMA = (6.0, 12.0, 20.0)
"""Noise of the residuals, grey levels, before it is known, by level of the pyramid."""
STATED_INFORMATION = 0.25
"""What a point tells here as a share of what it tells between neighbouring frames: the textures of
one frame are all wrong together where its pose is."""


@dataclass(frozen=True, eq=False)
class Texture:
    """What one frame shows of the body, for each level of the pyramid.

    chosen: surface points.  grey: their brightness.  starts: (P + 1,) where each part's begin.
    weight: what this frame counts among others.
    """

    chosen: tuple[NDArray[np.int32], ...]
    grey: tuple[NDArray[np.float32], ...]
    starts: tuple[NDArray[np.int64], ...]
    weight: float


def visible_points(
    scene: Scene, size: tuple[int, int], pose: Pose
) -> tuple[NDArray[np.uint8], Picture]:
    """Which surface points (S,) a pose shows in a picture of (height, width), and uvz (S, 3)."""
    HR, Ho, uvz, seen, depth, owner = room(scene.arrays, scene.sight, size[1], size[0])[:6]
    place_parts(scene.arrays, *pose.loose(), HR, Ho)
    see(scene.arrays, HR, Ho, scene.lens, scene.sight, size[1], size[0], uvz, seen, depth, owner)
    return seen, uvz


def texture_of(scene: Scene, pictures: Sequence[Picture], pose: Pose, weight: float) -> Texture:
    """The texture of a frame, its pyramid `pictures` finest first, each (h, w, 4)."""
    seen, uvz = visible_points(scene, pictures[0].shape[:2], pose)
    chosen, grey, starts = [], [], []
    for level, picture in enumerate(pictures):
        points, brightness = np.empty(len(seen) + 1, np.int32), np.empty(len(seen) + 1, np.float32)
        first = np.empty(scene.skeleton.part_count + 1, np.int64)
        coarse = level >= COARSE_LEVEL
        of, every = (1, 2) if coarse else (OF, 1)
        pick(scene.arrays, uvz, seen, picture, 0.5**level, of, every, points, brightness, first)
        chosen.append(points)
        grey.append(brightness)
        starts.append(first)
    return Texture(tuple(chosen), tuple(grey), tuple(starts), weight)


def without_parts(texture: Texture, left_out: NDArray[np.bool_]) -> Texture:
    """The texture without these parts (P,)."""
    chosen, grey, starts = [], [], []
    for points, brightness, first in zip(texture.chosen, texture.grey, texture.starts, strict=True):
        counts = np.diff(first)
        keep = np.flatnonzero(np.repeat(~left_out, counts))
        chosen.append(np.append(points[keep], np.int32(0)))
        grey.append(np.append(brightness[keep], np.float32(0)))
        starts.append(np.concatenate([[0], np.cumsum(counts * ~left_out)]).astype(np.int64))
    return replace(texture, chosen=tuple(chosen), grey=tuple(grey), starts=tuple(starts))


@dataclass(eq=False)
class Likeness:
    """A frame's pyramid beside the textures of others. Remembers the noise of the residuals."""

    scene: Scene
    pictures: Sequence[Picture]
    textures: Sequence[Texture]

    def __post_init__(self) -> None:
        self._seen = np.zeros(len(self.scene.points.points), np.uint8)
        self._sigma = np.full(len(self.textures), FIRST_SIGMA[0])

    def look(self, pose: Pose) -> None:
        """Find anew which points the pose shows."""
        self._seen = visible_points(self.scene, self.pictures[0].shape[:2], pose)[0]

    def begin(self, level: int) -> None:
        """Forget the noise: a level of the pyramid begins."""
        self._sigma[:] = FIRST_SIGMA[min(level, len(FIRST_SIGMA) - 1)]

    def equations(self, pose: Pose, level: int, fine: bool) -> tuple[Array, Array]:
        """A (D, D) and b (D,) of the sum of squares, in units of the noise.

        fine: redescending weights, gain and bias for each part, for a pose that is nearly right.
        """
        parts, dofs = self.scene.skeleton.part_count, self.scene.skeleton.dof_count
        HR, Ho, centre = self._placed(pose)
        total = np.zeros((parts, 7, 7))
        loss, width = (TUKEY, TUKEY_WIDTH) if fine else (HUBER, HUBER_WIDTH)
        for k, texture in enumerate(self.textures):
            N, histogram, points = self._sums(
                texture, level, (HR, Ho, centre), loss, width * self._sigma[k], fine
            )
            self._sigma[k] = robust_sigma(histogram, points)
            told = self.scene.information(OF) * STATED_INFORMATION
            total += N * (texture.weight * told / self._sigma[k] ** 2)
        S, A, b = np.empty((dofs, 6)), np.empty((dofs, dofs)), np.empty(dofs)
        camera_twists(self.scene.arrays, HR, Ho - centre, S)
        sum_subtrees(self.scene.arrays, total)
        normal_equations(self.scene.arrays, total, S, A, b)
        return A, b

    def score(self, pose: Pose) -> float:
        """Mean capped square of the differences, grey levels², over the points last looked at."""
        placed, total = self._placed(pose), 0.0
        for texture in self.textures:
            _, histogram, points = self._sums(texture, 0, placed, LEAST_SQUARES, 1.0, False)
            total += texture.weight * capped_square(histogram, points, CAP)
        return total / max(sum(texture.weight for texture in self.textures), 1e-12)

    def _placed(self, pose: Pose) -> tuple[Array, Array, Array]:
        """The parts in the camera frame, and the centre that twists are taken about."""
        parts = self.scene.skeleton.part_count
        HR, Ho = np.empty((parts, 3, 3)), np.empty((parts, 3))
        place_parts(self.scene.arrays, *pose.loose(), HR, Ho)
        return HR, Ho, Ho[0].copy()

    def _sums(
        self, texture: Texture, level: int, placed: tuple[Array, Array, Array],
        loss: int, width: float, gain: bool,
    ) -> tuple[Array, NDArray[np.int32], int]:  # fmt: skip
        """One texture's sums (P, 7, 7), the histogram of its residuals, and how many there are."""
        N, histogram = np.empty((self.scene.skeleton.part_count, 7, 7)), np.empty(BINS, np.int32)
        points = sum_points(
            self.scene.arrays, texture.chosen[level], texture.grey[level], texture.starts[level],
            *placed, self.pictures[level], scaled_lens(self.scene.lens, 0.5**level), self._seen,
            True, loss, width, gain, N, histogram, np.empty((9, BLOCK), np.float32),
        )  # fmt: skip
        return N, histogram, int(points)
