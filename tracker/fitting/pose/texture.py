"""What one frame, whose pose is known, shows of the body: the brightness of its surface points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.kernels.chain import place_parts
from keypose.tracker.kernels.seeing import pick, room, see
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
    """Which surface points (S,) a pose shows in a picture of (height, width), and uvz (S, 3)."""
    HR, Ho, uvz, seen, depth, owner = room(scene.arrays, scene.visibility, size[1], size[0])[:6]
    place_parts(scene.arrays, *pose.writable(), HR, Ho)
    see(
        scene.arrays, HR, Ho, scene.lens, scene.visibility, size[1], size[0],
        uvz, seen, depth, owner,
    )  # fmt: skip
    return seen, uvz


def texture_of(scene: Scene, pictures: Sequence[Picture], pose: Pose, weight: float) -> Texture:
    """The texture of a frame, its pyramid `pictures` finest first, each (h, w, 4)."""
    seen, uvz = visible_points(scene, pictures[0].shape[:2], pose)
    chosen, grey, starts = [], [], []
    for level, picture in enumerate(pictures):
        points, brightness = np.empty(len(seen) + 1, np.int32), np.empty(len(seen) + 1, np.float32)
        first = np.empty(scene.skeleton.part_count + 1, np.int64)
        coarse = level >= COARSE_LEVEL
        stride, every = (1, 2) if coarse else (STRIDE, 1)
        pick(scene.arrays, uvz, seen, picture, 0.5**level, stride, every, points, brightness, first)
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
