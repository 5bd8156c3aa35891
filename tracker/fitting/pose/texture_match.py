"""How well a frame matches what other frames, whose poses are known, show of the body.

Each known pose puts its picture's brightness onto the surface points it shows: a texture. Projected
into another frame at a pose to be found, the differences of brightness say where it should go.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from keypose.tracker.body.pose import Pose
from keypose.tracker.fitting.pose.texture import Texture, visible_points
from keypose.tracker.fitting.pose.texture_differences import PlacedTextures, TextureDifferences
from keypose.tracker.kernels.noise import capped_square, robust_sigma
from keypose.tracker.kernels.pairs import CAP
from keypose.tracker.kernels.sums import HUBER, HUBER_WIDTH, LEAST_SQUARES, TUKEY, TUKEY_WIDTH
from keypose.tracker.solver.posed import Posed
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.video.pyramid import Picture

FIRST_SIGMA = (6.0, 12.0, 20.0)
"""Noise of the residuals, grey levels, before it is known, by level of the pyramid."""


@dataclass(eq=False)
class TextureMatch:
    """A frame's pyramid beside the textures of others. Keeps the noise of the residuals."""

    scene: Scene
    pictures: Sequence[Picture]
    textures: Sequence[Texture]

    def __post_init__(self) -> None:
        self._seen = np.zeros(len(self.scene.points.points), np.uint8)
        self._sigma = np.full(len(self.textures), FIRST_SIGMA[0])

    def update_visibility(self, pose: Pose) -> None:
        """Find which points the pose shows."""
        self._seen = visible_points(self.scene, self.pictures[0].shape[:2], pose)[0]

    def reset_noise(self, level: int) -> None:
        """Forget the noise: a level of the pyramid begins."""
        self._sigma = np.full(len(self.textures), FIRST_SIGMA[min(level, len(FIRST_SIGMA) - 1)])

    def term(self, posed: Posed, level: int, fine: bool) -> TextureDifferences:
        """The differences about a pose, the noise learnt there."""
        placed, width = self._placed(level), (TUKEY_WIDTH if fine else HUBER_WIDTH) * self._sigma
        sums = placed.sums(posed, TUKEY if fine else HUBER, width, fine)
        self._sigma = np.array([robust_sigma(found.histogram, found.points) for found in sums])
        return TextureDifferences(placed, fine, width, self._sigma, (posed, sums))

    def score(self, pose: Pose) -> float:
        """Mean capped square of the differences, grey levels², over the visible points."""
        posed, total = Posed.of(self.scene.skeleton, pose), 0.0
        sums = self._placed(0).sums(posed, LEAST_SQUARES, np.ones(len(self.textures)), False)
        for texture, found in zip(self.textures, sums, strict=True):
            total += texture.weight * capped_square(found.histogram, found.points, CAP)
        return total / max(sum(texture.weight for texture in self.textures), 1e-12)

    def _placed(self, level: int) -> PlacedTextures:
        return PlacedTextures(self.scene, self.pictures[level], level, self.textures, self._seen)
