"""The background of a film whose camera stands still: every pixel's median, and what differs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

Grey: TypeAlias = NDArray[np.float32]

DIFFERENCE = 8.0
"""Grey levels by which a pixel must differ from the background to count as moving."""
SMOOTHING_PX = 1.2


def smooth(grey: NDArray[np.uint8] | Grey) -> Grey:
    """A grey picture freed of most of its noise."""
    blurred = cv2.GaussianBlur(grey.astype(np.float32), (0, 0), SMOOTHING_PX)
    return np.asarray(blurred, dtype=np.float32)


def background(pictures: Sequence[NDArray[Any]]) -> Grey:
    """Every pixel's median over grey pictures (H, W)."""
    return np.asarray(np.median(np.stack(pictures), axis=0), dtype=np.float32)


def moving(picture: Grey, plate: Grey) -> NDArray[np.bool_]:
    """Pixels (H, W) of a smoothed picture that do not look as the empty scene does."""
    return np.asarray(np.abs(picture - plate) >= DIFFERENCE)
