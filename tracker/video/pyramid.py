"""Pictures made ready for the loops: brightness, its gradient, and what may be used, by level."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

LEVELS = 3
BLUR_PX = 0.8
USABLE, TARGET_ONLY, IGNORED = 1.0, 0.5, 0.0

Picture = NDArray[np.float32]


def prepare(grey: NDArray[np.uint8], usable: Picture | None, levels: int) -> list[Picture]:
    """Pyramid of one picture: level k is (h / 2^k, w / 2^k, 4) float32 of [E, E_u, E_v, use].

    grey: (h, w) brightness. usable: (h, w) USABLE, TARGET_ONLY (not a source: the background) or
    IGNORED, or None where all is. E is blurred a little, the gradient is Scharr's, per pixel.
    Around what is ignored a rim is ignored too, as wide as blur and gradient reach.
    """
    current = _float(cv2.GaussianBlur(grey.astype(np.float32), (0, 0), BLUR_PX))
    use = np.ones_like(current) if usable is None else _with_rim(usable)
    pyramid = []
    for level in range(levels):
        if level:
            current = _float(cv2.pyrDown(current))
            use = _with_rim(use)[::2, ::2] if usable is not None else np.ones_like(current)
        gradients = (cv2.Scharr(current, cv2.CV_32F, du, 1 - du, scale=1 / 32.0) for du in (1, 0))
        pyramid.append(_float(cv2.merge([current, *gradients, np.ascontiguousarray(use)])))
    return pyramid


def level_sizes(width: int, height: int, levels: int) -> list[tuple[int, int]]:
    """(height, width) of every level, as cv2.pyrDown makes them."""
    sizes = [(height, width)]
    for _ in range(levels - 1):
        h, w = sizes[-1]
        sizes.append(((h + 1) // 2, (w + 1) // 2))
    return sizes


def _float(image: ArrayLike) -> Picture:
    """OpenCV's result with its exact type, which its own signatures lack."""
    return np.asarray(image, np.float32)


def _with_rim(usable: Picture) -> Picture:
    """The same with a rim of four pixels ignored as well.

    Blur, gradient and interpolation reach that far together.
    """
    ignored = (usable == IGNORED).astype(np.uint8)
    near = cv2.dilate(ignored, np.ones((9, 9), np.uint8)) > 0
    return np.where(near, np.float32(IGNORED), usable)


@dataclass(frozen=True, eq=False)
class Clip:
    """Prepared pictures of consecutive frames.

    levels: one array (n, h, w, 4) float32 for each pyramid level, finest first.
    damaged: the frames whose pictures are missing or damaged; all of them is IGNORED.
    """

    first_frame: int
    levels: tuple[Picture, ...]
    damaged: frozenset[int] = frozenset()

    def __len__(self) -> int:
        return len(self.levels[0])

    def slots(self, first_frame: int, last_frame: int) -> NDArray[np.int64]:
        """Return where the frames first_frame … last_frame lie in the arrays; IndexError beyond
        them.
        """
        if first_frame < self.first_frame or last_frame >= self.first_frame + len(self):
            raise IndexError(f"frames {first_frame} to {last_frame} are not all in the clip")
        return np.arange(first_frame - self.first_frame, last_frame - self.first_frame + 1)
