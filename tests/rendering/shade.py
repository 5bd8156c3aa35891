"""The compiled loop that turns samples of face and depth into light."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.kernels import compiled

Floats = NDArray[np.float64]


@compiled
def shade(
    face: NDArray[np.int32],
    depth: NDArray[np.float32],
    lens: Floats,
    samples: int,
    face_part: NDArray[np.int64],
    normal_maps: Floats,
    to_texture: Floats,
    volume: NDArray[np.float32],
    colours: Floats,
    contrast: float,
    to_light: Floats,
    ambient: float,
    light: NDArray[np.float32],
    covered: NDArray[np.float32],
) -> None:
    """Sum the body's light (h, w, 3) and coverage (h, w) over `samples`² samples of each pixel.

    face, depth: (h samples, w samples), what each sample shows.
    lens:        fx, fy, cx, cy of the samples, and the one distance of parallel rays, or 0.
    normal_maps: (F, 3, 4) a face's normal at a point of the eye's frame.
    to_texture:  (P, 3, 4) from the eye's frame to each part's place in the volume, in voxels.
    """
    for row in range(face.shape[0]):
        for column in range(face.shape[1]):
            k = face[row, column]
            if k < 0:
                continue
            z = float(depth[row, column])
            reach = z if lens[4] == 0.0 else lens[4]
            x, y = (column - lens[2]) / lens[0] * reach, (row - lens[3]) / lens[1] * reach
            part = face_part[k]
            grain = _noise_at(to_texture[part], x, y, z, volume)
            lit = _lit(normal_maps[k], x, y, z, to_light, ambient, lens[4] == 0.0)
            pixel_row, pixel_column = row // samples, column // samples
            covered[pixel_row, pixel_column] += 1.0
            for channel in range(3):
                colour = colours[part, channel]
                value = (colour + contrast * (0.5 + 0.004 * colour) * grain) * lit
                light[pixel_row, pixel_column, channel] += value


@compiled
def _noise_at(M: Floats, x: float, y: float, z: float, volume: NDArray[np.float32]) -> float:
    """The volume at M @ [x, y, z, 1], linear between its voxels, repeated without end."""
    side = volume.shape[0]
    a = M[0, 0] * x + M[0, 1] * y + M[0, 2] * z + M[0, 3]
    b = M[1, 0] * x + M[1, 1] * y + M[1, 2] * z + M[1, 3]
    c = M[2, 0] * x + M[2, 1] * y + M[2, 2] * z + M[2, 3]
    fa, fb, fc = math.floor(a), math.floor(b), math.floor(c)
    a, b, c = a - fa, b - fb, c - fc
    total = 0.0
    for i in range(2):
        for j in range(2):
            for k in range(2):
                share = (a if i else 1 - a) * (b if j else 1 - b) * (c if k else 1 - c)
                total += share * volume[(fa + i) % side, (fb + j) % side, (fc + k) % side]
    return total


@compiled
def _lit(
    M: Floats, x: float, y: float, z: float, to_light: Floats, ambient: float, perspective: bool
) -> float:
    """Lambert's share of light at a point whose normal is M @ [x, y, z, 1], either side."""
    nx = M[0, 0] * x + M[0, 1] * y + M[0, 2] * z + M[0, 3]
    ny = M[1, 0] * x + M[1, 1] * y + M[1, 2] * z + M[1, 3]
    nz = M[2, 0] * x + M[2, 1] * y + M[2, 2] * z + M[2, 3]
    toward = nx * x + ny * y + nz * z if perspective else nz
    turned = 1.0 if toward < 0 else -1.0
    cosine = nx * to_light[0] + ny * to_light[1] + nz * to_light[2]
    cosine *= turned / max(math.sqrt(nx * nx + ny * ny + nz * nz), 1e-9)
    return ambient + (1.15 - ambient) * max(cosine, 0.0)
