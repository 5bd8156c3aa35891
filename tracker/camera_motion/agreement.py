"""Compare a camera that somebody says with the background of its film, in a few pairs of pictures.

Points of the background are followed over a second or so, from a picture to later ones, at a few
places of the film. Where they move as one body, the camera that is said shows them where they went,
but for what it cannot know, how far each is away. Nothing here needs a lens but to foretell that,
so that a wrong one is found as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.points import Background, Grey, PointFollower
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array

STEP: Final = 2
"""Frames from one look to the next."""
FEWEST: Final = 20
"""Points of a pair."""
MOST: Final = 80
"""Points of a pair that are compared."""
RIGID_SHARE: Final = {"turns": 0.6, "moves": 0.75}
"""Share of the points that move as one, as before a camera that turns or that goes somewhere."""
RIGID_PX: Final = 1.5
"""Within which a point moves as one with others."""
FEWEST_PAIRS: Final = 2
"""That tell anything of a camera."""
USUAL_PERCENT: Final = 75
"""Of the pairs' errors the one that is said: a camera that is wrong is so where it moves."""


@dataclass(frozen=True, eq=False)
class Pair:
    """The same points of the background in two frames, (K, 2) each, the film's pixels.

    kind: whether a camera that only turns explains them, or one that goes somewhere.
    """

    one: int
    other: int
    uv_one: Array
    uv_other: Array
    kind: Literal["turns", "moves"]

    @property
    def way_px(self) -> float:
        """How far the points usually went."""
        return float(np.median(np.linalg.norm(self.uv_other - self.uv_one, axis=1)))


def followed_pairs(
    pictures: Callable[[int, int, int], Iterable[tuple[int, Grey | None]]],
    size: tuple[int, int],
    spans: Sequence[tuple[int, int]],
    background: Background,
) -> list[Pair]:
    """Points that were followed over some spans of a film, from the first frame of each on.

    Args:
        pictures: (number, picture) from a frame to before another one, at a step.
        size: width and height of the pictures.
        spans: first and last frames.
        background: of a frame, the pixels (H, W) that may be background; None for all.
    """
    followed = (_followed(pictures(a, b + 1, STEP), size, background) for a, b in spans)
    return [pair for pairs in followed for pair in pairs]


def _followed(
    pictures: Iterable[tuple[int, Grey | None]], size: tuple[int, int], background: Background
) -> list[Pair]:
    """The pairs of the first picture with one that is half as far as the last, and with the last
    in which enough of its points are seen."""
    follower = PointFollower(width=size[0], height=size[1])
    tracked: list[tuple[int, Array, NDArray[np.bool_]]] = []
    first = -1
    for number, picture in pictures:
        if picture is None or picture.shape != (size[1], size[0]):
            break
        rough, _ = follower.look(picture)
        if follower.keyframe is None:
            usable = background(number)
            keyframe = follower.pick(usable, np.zeros(0, np.int64), np.zeros((0, 2)))
            first, start = number, keyframe.uv
            if len(start) < FEWEST:
                return []
            continue
        uv, is_found = follower.refine(rough, background(number))
        if is_found.sum() < FEWEST:
            break
        tracked.append((number, uv, is_found))
    if not tracked:
        return []
    chosen = [tracked[-1]] if len(tracked) < 2 else [tracked[len(tracked) // 2 - 1], tracked[-1]]
    pairs = (_pair((first, number), start[ok], uv[ok]) for number, uv, ok in chosen)
    return [pair for pair in pairs if pair is not None]


def _pair(frames: tuple[int, int], uv_one: Array, uv_other: Array) -> Pair | None:
    """The points (K, 2) of two frames that move as one; None where too few do."""
    cv2.setRNGSeed(0)  # the same pictures tell the same
    _, flat = cv2.findHomography(uv_one, uv_other, cv2.RANSAC, RIGID_PX)
    cv2.setRNGSeed(0)
    _, deep = cv2.findFundamentalMat(uv_one, uv_other, cv2.FM_RANSAC, RIGID_PX, 0.999, 1000)
    kinds: tuple[tuple[Literal["turns", "moves"], object], ...] = (("turns", flat), ("moves", deep))
    for kind, mask in kinds:
        good = np.zeros(len(uv_one), bool) if mask is None else np.ravel(np.asarray(mask)) > 0
        if good.sum() >= FEWEST and good.mean() >= RIGID_SHARE[kind]:
            rows = np.flatnonzero(good)
            rows = rows[np.linspace(0, len(rows) - 1, min(MOST, len(rows))).astype(int)]
            return Pair(frames[0], frames[1], uv_one[rows], uv_other[rows], kind)
    return None


def error_px(pairs: Sequence[Pair], camera: Camera, path: CameraPath) -> float | None:
    """By how much points usually lie off where a camera shows them, pixels; None where too few
    pairs tell.

    path: of the camera at the first and the second frame of each pair in turn.
    """
    errors = [
        _error(pair, camera, path, 2 * k)
        for k, pair in enumerate(pairs)
        if pair.kind == "turns" or path.moves
    ]
    finite = [error for error in errors if np.isfinite(error)]
    return None if len(finite) < FEWEST_PAIRS else float(np.percentile(finite, USUAL_PERCENT))


def _error(pair: Pair, camera: Camera, path: CameraPath, row: int) -> float:
    """The usual distance of the points of a pair from where the camera shows them, pixels; of one
    that goes somewhere, each at the distance that suits it best.

    Args:
        pair: the points.
        camera: its lens at zoom 1.
        path: of the camera.
        row: of the path at which the pair's one frame is; the other's follows.
    """
    lens = Lens.of(camera)
    zoom_one, zoom_other = (float(z) for z in path.zoom[row : row + 2])
    T_one, T_other = path.Ts_camera_world[row : row + 2]
    R = T_other[:3, :3] @ T_one[:3, :3].T
    t = T_other[:3, 3] - R @ T_one[:3, 3]
    rays = lens.directions(pair.uv_one, zoom_one) @ R.T
    if t.any():
        q = lens.flat(pair.uv_other, zoom_other) / zoom_other
        p, g = rays[:, :2] - q * rays[:, 2:], t[:2] - q * t[2]
        nearness = -(p * g).sum(axis=1) / np.maximum((g * g).sum(axis=1), 1e-18)
        rays = rays + np.maximum(nearness, 0.0)[:, None] * t
    there = lens.pixels(rays, zoom_other)
    off = np.linalg.norm(there - pair.uv_other, axis=1)
    return float(np.median(np.where(np.isfinite(off), off, np.inf)))
