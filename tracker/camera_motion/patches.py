"""Patches: what landmarks look like, by which they are found again when they come back into view.

A patch is cut from the picture of the landmark's anchor, the keyframe in which it was picked. To
find it in a later picture it is warped to how it should look there, laid beside the part of the
picture where it should be, and registered to a fraction of a pixel; all landmarks at once, as
tiles of one tall picture. Patches alone are kept, no pictures, and only a number that is bounded.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.points import Grey
from keypose.tracker.geometry.rotations import Array

PATCH_PX = 45
"""Side of a patch, and of the tile in which it is looked for; odd."""
REACH = PATCH_PX // 2
"""Pixels from a patch's middle to its edge."""
BORDER_PX = 12.0
"""Nearer to the edge of the picture looked at no landmark is looked for."""
MOST_KEPT = 6_000
"""Patches: a bound on memory, 12 MB."""
LIKENESS = 0.75
"""Least correlation of a patch and the place where it was found."""
MOST_OFF_PX = 12.0
"""Farther from where it is expected no landmark is looked for."""
_STAGES = (((15, 15), 1), ((21, 21), 0))
"""Windows and halvings of the two registrations."""
_ENOUGH = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 15, 0.01)
_CORE = 8
"""Half of the side over which likeness is asked, less one."""


@dataclass(eq=False)
class Patches:
    """The patches of L landmarks in the order in which they were kept.

    ids (L,): of the landmarks.  anchor (L,): number of the keyframe of each.  uv (L, 2): where it
    is there, pixels of the film.  inside (L, 2): where it is in its patch.  grey (L, side, side).
    """

    ids: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    anchor: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    uv: Array = field(default_factory=lambda: np.zeros((0, 2)))
    inside: Array = field(default_factory=lambda: np.zeros((0, 2)))
    grey: Grey = field(default_factory=lambda: np.zeros((0, PATCH_PX, PATCH_PX), np.uint8))

    def __len__(self) -> int:
        return len(self.ids)

    def keep(
        self, picture: Grey, anchor: int, ids: NDArray[np.int64], uv: Array, at: Array
    ) -> None:
        """Keep the patches of landmarks (K,) that were picked in a keyframe. Beyond the most, every
        second of the older half is given up, as often as need be.

        Args:
            picture: of the keyframe, at the size looked at.
            anchor: the keyframe's number.
            ids: (K,) of the landmarks.
            uv: (K, 2) where they are, pixels of the film.
            at: (K, 2) the same, pixels of the picture.
        """
        patches, first = tiles(picture, at)
        self.ids = np.concatenate([self.ids, ids])
        self.anchor = np.concatenate([self.anchor, np.full(len(ids), anchor)])
        self.uv = np.concatenate([self.uv, uv])
        self.inside = np.concatenate([self.inside, at - first])
        self.grey = np.concatenate([self.grey, patches])
        while len(self) > MOST_KEPT:
            kept = np.ones(len(self), bool)
            kept[: len(self) // 2 : 2] = False
            self.ids, self.anchor, self.uv = self.ids[kept], self.anchor[kept], self.uv[kept]
            self.inside, self.grey = self.inside[kept], self.grey[kept]

    def register(
        self, chosen: NDArray[np.int64], picture: Grey, at: Array, warps: Array
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Where landmarks are in a picture (K, 2), and which of them (K,) were found.

        Args:
            chosen: (K,) rows of their patches.
            picture: at the size looked at.
            at: (K, 2) where they are expected, pixels of this picture.
            warps: (K, 2, 2) by which an offset in the anchor's picture becomes one in this.
        """
        if not len(chosen):
            return np.zeros((0, 2)), np.zeros(0, bool)
        wanted = _warped(self.grey[chosen], self.inside[chosen], warps)
        shown, first = tiles(picture, at)
        there, followed = _registered(wanted, _as_bright(shown, wanted), at - first)
        near = np.linalg.norm(there - (at - first), axis=1) < MOST_OFF_PX
        followed &= near & (np.abs(there - REACH) < REACH - _CORE).all(axis=1)
        there = np.where(followed[:, None], there, REACH)
        return first + there, followed & (_likeness(wanted, shown, there) > LIKENESS)


def tiles(picture: Grey, at: Array) -> tuple[Grey, Array]:
    """The squares (K, side, side) of a picture about places (K, 2), and the places (K, 2)
    of their first pixels.
    """
    padded = np.pad(picture, REACH + 1, mode="edge")
    height, width = padded.shape
    corner = np.rint(at).astype(int) + 1
    column = np.clip(corner[:, 0], 0, width - PATCH_PX)
    row = np.clip(corner[:, 1], 0, height - PATCH_PX)
    windows = np.lib.stride_tricks.sliding_window_view(padded, (PATCH_PX, PATCH_PX))
    first = np.stack([column, row], axis=1) - REACH - 1
    return np.ascontiguousarray(windows[row, column], np.uint8), first.astype(float)


_STEPS = np.stack(np.meshgrid(*[np.arange(PATCH_PX) - REACH] * 2), axis=-1).astype(float)
"""(side, side, 2) offsets of a tile's pixels from its middle."""


def _warped(patches: Grey, inside: Array, warps: Array) -> Grey:
    """Tiles (K, side, side) whose middles show the landmarks, as another picture shows them."""
    back = np.linalg.inv(warps).astype(np.float32)[:, None, None]
    u, v = (_STEPS[None, ..., axis].astype(np.float32) for axis in range(2))
    at = np.empty((len(patches), PATCH_PX, PATCH_PX, 2), np.float32)
    for axis in range(2):
        own = back[..., axis, 0] * u + back[..., axis, 1] * v + inside[:, None, None, axis]
        np.clip(own, 0, PATCH_PX - 1, out=at[..., axis], casting="same_kind")
    at[..., 1] += PATCH_PX * np.arange(len(patches), dtype=np.float32)[:, None, None]
    return _sampled(patches, at)


def _sampled(patches: Grey, at: Array | NDArray[np.float32]) -> Grey:
    """Patches' grey levels at places (K, y, x, 2) of all patches, one below the other."""
    tall = patches.reshape(-1, PATCH_PX)
    flat = at.reshape(len(patches), -1, 2).astype(np.float32, copy=False)
    shown = cv2.remap(tall, flat, None, cv2.INTER_LINEAR)  # type: ignore[call-overload]
    return np.asarray(shown, np.uint8).reshape(at.shape[:-1])


def _as_bright(tiles_: Grey, others: Grey) -> Grey:
    """Tiles (K, side, side) with the mean and spread of others."""
    own, wanted = tiles_.astype(np.float32), others.astype(np.float32)
    axes = (1, 2)
    spread = wanted.std(axis=axes) / np.maximum(own.std(axis=axes), 1.0)
    gain = np.clip(spread, 0.5, 2.0)[:, None, None]
    mean = own.mean(axis=axes, keepdims=True), wanted.mean(axis=axes, keepdims=True)
    levels = np.clip(np.rint((own - mean[0]) * gain + mean[1]), 0, 255)
    return np.asarray(levels, dtype=np.uint8)


def _registered(wanted: Grey, shown: Grey, guess: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Where in tiles (K, side, side) the middles of others are seen (K, 2), and which are."""
    down = np.stack([np.zeros(len(wanted)), PATCH_PX * np.arange(len(wanted))], axis=1)
    tall_wanted, tall_shown = wanted.reshape(-1, PATCH_PX), shown.reshape(-1, PATCH_PX)
    start = (down + REACH).astype(np.float32)[:, None]
    there = (down + guess).astype(np.float32)[:, None]
    followed = np.ones(len(wanted), bool)
    for window, halvings in _STAGES:
        moved, status, _ = cv2.calcOpticalFlowPyrLK(
            tall_wanted,
            tall_shown,
            start,
            there.copy(),
            winSize=window,
            maxLevel=halvings,
            criteria=_ENOUGH,
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        )
        there = np.asarray(moved, np.float32)
        followed &= np.asarray(status)[:, 0] > 0
    return np.asarray(there[:, 0] - down, float), followed


def _likeness(wanted: Grey, shown: Grey, there: Array) -> Array:
    """The correlation (K,) of the middles of tiles and where they were found in others."""
    core = slice(REACH - _CORE, REACH + _CORE + 1)
    at = _STEPS[core, core] + there[:, None, None]
    at[..., 1] += PATCH_PX * np.arange(len(shown))[:, None, None]
    own = wanted[:, core, core].reshape(len(wanted), -1).astype(float)
    there_seen = _sampled(shown, at).reshape(len(shown), -1).astype(float)
    own -= own.mean(axis=1, keepdims=True)
    there_seen -= there_seen.mean(axis=1, keepdims=True)
    power = np.sqrt((own**2).sum(axis=1) * (there_seen**2).sum(axis=1))
    return np.asarray((own * there_seen).sum(axis=1) / np.maximum(power, 1e-9))
