"""Band-limited noise as texture: a volume the body is carved from, a wall behind it."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

VOLUME_SIDE_M = 0.6
"""The noise volume repeats after this length."""

WALL = np.array([118.0, 127.0, 130.0])
FLOOR = np.array([141.0, 129.0, 115.0])
HORIZON = 0.80


@cache
def noise_volume(seed: int, side: int = 128) -> NDArray[np.float32]:
    """(side, side, side) noise of mean 0 and deviation 1 that continues at its borders.

    Coarse and fine grain together, none finer than 1.3 cm, which a pixel of the usual scene shows
    without aliasing.
    """
    k = np.fft.fftfreq(side, 1 / side)
    radius = np.sqrt(
        k[:, None, None] ** 2 + k[None, :, None] ** 2 + k[None, None, : side // 2 + 1] ** 2
    )
    amplitude = np.maximum(radius, 5.0) ** -1.8 * np.exp(-((radius / 45) ** 2)) * (radius > 2)
    white = np.random.default_rng(seed).standard_normal((side, side, side))
    return _standardised(
        np.fft.irfftn(np.fft.rfftn(white) * amplitude, s=white.shape, axes=(0, 1, 2))
    )


@cache
def backdrop(width: int, height: int, contrast: float, seed: int) -> NDArray[np.float32]:
    """(height, 2 width, 3) a textured wall and floor, RGB, that continues to the sides."""
    rng = np.random.default_rng(seed)
    grain = _flat_noise(2 * width, height, rng)
    tint = np.stack([_flat_noise(2 * width, height, rng) for _ in range(3)], axis=-1)
    rows = np.arange(height)[:, None, None] / height
    floor = 1 / (1 + np.exp(-(rows - HORIZON) * height / 2))
    ground = WALL * (0.86 + 0.22 * rows) * (1 - floor) + FLOOR * (1.18 - 0.25 * (1 - rows)) * floor
    return (ground + contrast * (grain[..., None] + 0.12 * tint)).astype(np.float32)


def _flat_noise(width: int, height: int, rng: np.random.Generator) -> NDArray[np.float32]:
    """(height, width) noise of deviation 1; its finest waves are 3 pixels long."""
    fy, fx = np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)[None]
    frequency = np.hypot(fy, fx)
    amplitude = np.maximum(frequency, 1 / 130) ** -1.3 * np.exp(-((frequency / 0.22) ** 2))
    amplitude[0, 0] = 0.0
    white = rng.standard_normal((height, width))
    return _standardised(np.fft.irfft2(np.fft.rfft2(white) * amplitude, s=white.shape))


def _standardised(values: NDArray[np.float64]) -> NDArray[np.float32]:
    return ((values - values.mean()) / values.std()).astype(np.float32)
