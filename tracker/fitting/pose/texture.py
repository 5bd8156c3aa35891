"""Match the body's texture in one frame with frames whose poses are known: brightness as a term.

Light may differ between the two: in the fine stage each part has a gain and a bias.

Each known pose puts its picture's brightness onto the surface points it shows: a texture. Projected
into another frame at a pose to be found, the differences of brightness say where it should go.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.chain import camera_twists, normal_equations, place_parts, sum_subtrees
from keypose.tracker.kernels.noise import BINS, capped_square, robust_sigma
from keypose.tracker.kernels.pairs import CAP, scaled_lens
from keypose.tracker.kernels.robust import HUBER, LEAST_SQUARES, TUKEY
from keypose.tracker.kernels.seeing import pick, room, see
from keypose.tracker.kernels.sums import (
    BLOCK,
    GAIN_CENTRE,
    GAIN_SCALE,
    HUBER_WIDTH,
    TUKEY_WIDTH,
    gather,
    sum_points,
)
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.robust import Huber, Tukey
from keypose.tracker.solver.sigmas import FIRST_GREY
from keypose.tracker.solver.terms import Equations
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.video.pyramid import Picture

STRIDE = 2
"""One surface point of so many is followed, the one with the strongest gradient."""
COARSE_LEVEL = 2
"""From this level of the pyramid on, every second point is enough."""


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
    """Which surface points (S,) a pose shows in a picture of (height, width), and uvz (S,
    3).
    """
    HR, Ho, uvz, visible, depth, owner = room(scene.arrays, scene.visibility, size[1], size[0])[:6]
    place_parts(scene.arrays, *pose.writable(), HR, Ho)
    see(
        scene.arrays,
        HR,
        Ho,
        scene.lens,
        scene.visibility,
        size[1],
        size[0],
        uvz,
        visible,
        depth,
        owner,
    )
    return visible, uvz


def texture_of(scene: Scene, pictures: Sequence[Picture], pose: Pose, weight: float) -> Texture:
    """The texture of a frame, its pyramid `pictures` finest first, each (h, w, 4)."""
    visible, uvz = visible_points(scene, pictures[0].shape[:2], pose)
    chosen, grey, starts = [], [], []
    for level, picture in enumerate(pictures):
        points, brightness = (
            np.empty(len(visible) + 1, np.int32),
            np.empty(len(visible) + 1, np.float32),
        )
        first = np.empty(scene.skeleton.part_count + 1, np.int64)
        coarse = level >= COARSE_LEVEL
        stride, every = (1, 2) if coarse else (STRIDE, 1)
        lens = scaled_lens(scene.lens, 0.5**level)
        pick(
            scene.arrays,
            uvz,
            visible,
            picture,
            lens,
            0.5**level,
            stride,
            every,
            points,
            brightness,
            first,
        )
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


STATED_INFORMATION = 0.25
"""A point's information as a share of that between neighbouring frames: an error of a frame's pose
is common to all its textures."""


@dataclass(frozen=True, eq=False)
class Sums:
    """One texture's sums (P, 7, 7) at a pose, the histogram of its residuals, and their number."""

    N: Array
    histogram: NDArray[np.int32]
    points: int


@dataclass(frozen=True, eq=False)
class PlacedTextures:
    """Textures projected into one level of a frame's pyramid. seen (S,): visible points."""

    scene: Scene
    picture: Picture
    level: int
    textures: Sequence[Texture]
    seen: NDArray[np.uint8]

    def sums(
        self, posed: Posed, loss: int, widths: Sequence[float] | Array, gain: bool
    ) -> list[Sums]:
        """The sums of every texture at a pose."""
        HR, Ho = self.part_frames(posed)
        both = zip(self.textures, widths, strict=True)
        return [self._sum(texture, HR, Ho, loss, float(width), gain) for texture, width in both]

    def part_frames(self, posed: Posed) -> tuple[Array, Array]:
        """The parts in the camera frame. Twists are taken about the first one's origin."""
        parts = self.scene.skeleton.part_count
        HR, Ho = np.empty((parts, 3, 3)), np.empty((parts, 3))
        pose = Pose(posed.Rs_parent_part, posed.p_camera_root)
        place_parts(self.scene.arrays, *pose.writable(), HR, Ho)
        return HR, Ho

    def residuals(self, posed: Posed, texture: Texture) -> tuple[NDArray[np.int64], Array, Array]:
        """The part (M,) of every point that lands, its difference of brightness r (M,), and its
        brightness in the texture (M,)."""
        HR, Ho = (part.astype(np.float32) for part in self.part_frames(posed))
        lens, starts = scaled_lens(self.scene.lens, 0.5**self.level), texture.starts[self.level]
        chosen, grey = texture.chosen[self.level], texture.grey[self.level]
        parts, differences = [], []
        for i, (first, last) in enumerate(pairwise(starts.tolist())):
            rows, taps = (np.empty(s, np.float32) for s in ((9, last - first), (last - first, 4)))
            count, _ = gather(
                self.scene.arrays,
                chosen,
                grey,
                first,
                last,
                HR[i],
                Ho[i],
                self.picture,
                lens,
                self.seen,
                True,
                rows,
                taps,
            )
            parts.append(np.full(count, i))
            differences.append(np.stack([taps[:count, 0] - rows[4, :count], rows[4, :count]]))
        r, own = np.concatenate(differences, axis=1).astype(np.float64)
        return np.concatenate(parts), r, own

    def _sum(
        self, texture: Texture, HR: Array, Ho: Array, loss: int, width: float, gain: bool
    ) -> Sums:
        N, histogram = np.empty((len(HR), 7, 7)), np.empty(BINS, np.int32)
        level, lens = self.level, scaled_lens(self.scene.lens, 0.5**self.level)
        points = sum_points(
            self.scene.arrays,
            texture.chosen[level],
            texture.grey[level],
            texture.starts[level],
            HR,
            Ho,
            Ho[0].copy(),
            self.picture,
            lens,
            self.seen,
            True,
            loss,
            width,
            gain,
            N,
            histogram,
            np.empty((9, BLOCK), np.float32),
        )
        return Sums(N, histogram, int(points))


@dataclass(frozen=True, eq=False)
class TextureDifferences:
    """Differences of brightness to textures, in units of their noise: a term.

    fine: redescending weights, gain and bias for each part, for a pose that is nearly right.
    width, noise (K,): of each texture's kernel, and of its residuals, grey levels.
    made_at: the pose at which it was made, and the sums there.
    """

    placed: PlacedTextures
    fine: bool
    width: Array
    noise: Array
    made_at: tuple[Posed, Sequence[Sums]] | None = None

    @property
    def loss(self) -> int:
        return TUKEY if self.fine else HUBER

    def cost(self, posed: Posed) -> float:
        """The cost at the best gains and biases, where they are free."""
        every = zip(self.placed.textures, self.width, self._scales(), strict=True)
        return sum(self._cost(posed, texture, width) * scale for texture, width, scale in every)

    def _cost(self, posed: Posed, texture: Texture, width: float) -> float:
        """The cost of one texture, grey levels²."""
        part, r, own = self.placed.residuals(posed, texture)
        kernel = Tukey(width) if self.fine else Huber(width)
        total = float(kernel.loss(np.abs(r)).sum())
        if self.fine:
            weight, light = kernel.weight(np.abs(r)), (own - GAIN_CENTRE) * GAIN_SCALE
            for i in np.unique(part):
                at = part == i
                both = np.stack([light[at], np.ones(at.sum())])
                pull = both @ (weight[at] * r[at])
                normal = (both * weight[at]) @ both.T + 1e-3 * np.eye(2)
                total -= float(pull @ np.linalg.solve(normal, pull))
        return 0.5 * total

    def equations(self, posed: Posed) -> Equations:
        """Without the cost."""
        scene, total = self.placed.scene, self._total(posed)
        dofs = scene.skeleton.dof_count
        S, A, b = np.empty((dofs, 6)), np.empty((dofs, dofs)), np.empty(dofs)
        HR, Ho = self.placed.part_frames(posed)
        camera_twists(scene.arrays, HR, Ho - Ho[0], S)
        sum_subtrees(scene.arrays, total)
        normal_equations(scene.arrays, total, S, A, b)
        return Equations(A, b, np.nan)

    def _scales(self) -> list[float]:
        """What a squared grey level counts, by texture."""
        information = self.placed.scene.information(STRIDE) * STATED_INFORMATION
        both = zip(self.placed.textures, self.noise, strict=True)
        return [texture.weight * information / noise**2 for texture, noise in both]

    def _total(self, posed: Posed) -> Array:
        """(P, 7, 7) over all textures."""
        if self.made_at is not None and self.made_at[0] is posed:
            sums = self.made_at[1]
        else:
            sums = self.placed.sums(posed, self.loss, self.width, self.fine)
        total = np.zeros((self.placed.scene.skeleton.part_count, 7, 7))
        for texture_sums, scale in zip(sums, self._scales(), strict=True):
            total += texture_sums.N * scale
        return total


@dataclass(eq=False)
class TextureMatch:
    """A frame's pyramid beside the textures of others. Keeps the noise of the residuals."""

    scene: Scene
    pictures: Sequence[Picture]
    textures: Sequence[Texture]

    def __post_init__(self) -> None:
        self._seen = np.zeros(len(self.scene.points.points), np.uint8)
        self._sigma = np.full(len(self.textures), FIRST_GREY[0])

    def update_visibility(self, pose: Pose) -> None:
        """Find which points the pose shows."""
        self._seen = visible_points(self.scene, self.pictures[0].shape[:2], pose)[0]

    def reset_noise(self, level: int) -> None:
        """Forget the noise: a level of the pyramid begins."""
        self._sigma = np.full(len(self.textures), FIRST_GREY[min(level, len(FIRST_GREY) - 1)])

    def term(self, posed: Posed, level: int, fine: bool) -> TextureDifferences:
        """The differences about a pose, the noise learnt there."""
        placed, width = self._placed(level), (TUKEY_WIDTH if fine else HUBER_WIDTH) * self._sigma
        sums = placed.sums(posed, TUKEY if fine else HUBER, width, fine)
        self._sigma = np.array(
            [robust_sigma(texture_sums.histogram, texture_sums.points) for texture_sums in sums]
        )
        return TextureDifferences(placed, fine, width, self._sigma, (posed, sums))

    def score(self, pose: Pose) -> float:
        """Mean capped square of the differences, grey levels², over the visible points."""
        posed, total = Posed.of(self.scene.skeleton, pose), 0.0
        sums = self._placed(0).sums(posed, LEAST_SQUARES, np.ones(len(self.textures)), False)
        for texture, texture_sums in zip(self.textures, sums, strict=True):
            total += texture.weight * capped_square(
                texture_sums.histogram, texture_sums.points, CAP
            )
        return total / max(sum(texture.weight for texture in self.textures), 1e-12)

    def _placed(self, level: int) -> PlacedTextures:
        return PlacedTextures(self.scene, self.pictures[level], level, self.textures, self._seen)
