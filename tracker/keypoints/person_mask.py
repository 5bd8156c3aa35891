"""How likely each place of the square that a network looked at shows the person it follows."""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.keypoints.region import Region

MASK_SIDE: Final = 256
"""Pixels along a side."""
FULL_LEVEL: Final = 15
"""Of certainty; 0 is none. With so few levels an outline lies where it does with all."""


@dataclass(frozen=True)
class PersonMask:
    """A person in a square. region: the square. packed: its levels, compressed, some 2 KB."""

    region: Region
    packed: bytes

    @classmethod
    def of(cls, region: Region, share: Array) -> PersonMask:
        """Of probabilities (256, 256) in the square looked at."""
        levels = np.round(np.nan_to_num(share) * FULL_LEVEL).astype(np.uint8)
        return cls(region, zlib.compress(levels.tobytes()))

    def outlined(self) -> PersonMask:
        """The mask with what is more likely the person than not for certain: its outline
        stays to a part of a pixel, and a third of the bytes."""
        likely = (self.levels() > FULL_LEVEL / 2) * np.uint8(FULL_LEVEL)
        return replace(self, packed=zlib.compress(likely.tobytes()))

    def without(self, area: NDArray[np.bool_]) -> PersonMask:
        """The mask but for an area (H, W) of the picture."""
        in_square = cv2.warpAffine(
            area.astype(np.float32),
            self.region.to_picture(MASK_SIDE),
            (MASK_SIDE, MASK_SIDE),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        )
        left = np.where(np.asarray(in_square) > 0.5, np.uint8(0), self.levels())
        return replace(self, packed=zlib.compress(left.tobytes()))

    def steadied(self, steady: SteadyCamera, frame: int) -> PersonMask:
        """The mask in the picture that a steady camera would have taken of a frame."""
        region = self.region
        up = (np.sin(region.turn_rad), -np.cos(region.turn_rad))
        ends = np.array([region.x, region.y]) + np.outer([0.0, 0.5 * region.side], up)
        (x, y), top = steady.pixels(ends, frame)
        to_top = top - (x, y)
        return replace(
            self,
            region=Region(
                float(x),
                float(y),
                2 * float(np.hypot(*to_top)),
                float(np.arctan2(to_top[0], -to_top[1])),
            ),
        )

    def levels(self) -> NDArray[np.uint8]:
        """(256, 256) from 0 to `FULL_LEVEL`; ValueError where what is packed is none."""
        unpack = zlib.decompressobj()
        try:
            content = unpack.decompress(self.packed, MASK_SIDE**2 + 1)
        except zlib.error as error:
            raise ValueError(str(error)) from None
        levels = np.frombuffer(content, np.uint8)
        if len(levels) != MASK_SIDE**2 or levels.max() > FULL_LEVEL or not unpack.eof:
            raise ValueError("it holds no mask")
        return levels.reshape(MASK_SIDE, MASK_SIDE)

    def in_picture(self, width: int, height: int) -> NDArray[np.float32]:
        """Probabilities (H, W) in the whole picture, 0 outside the square."""
        to_picture = self.region.to_picture(MASK_SIDE)
        share = self.levels().astype(np.float32) / np.float32(FULL_LEVEL)
        drawn = cv2.warpAffine(share, to_picture, (width, height), flags=cv2.INTER_LINEAR)
        return np.asarray(drawn, np.float32)
