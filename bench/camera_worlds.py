"""What stands behind a filmed person, and how a camera that moves sees it, exactly.

A panorama is infinitely far: it shows how a camera turns and zooms. A room has a floor, walls and
boxes, each at its place: it also shows how a camera moves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.raster import PERSPECTIVE, fill

Floats = NDArray[np.float32]

SIDE = 2048
TEXEL_M = 0.005
"""Of the square texture, repeated without end: texels, and the metres of one."""
PANORAMA_F = 1600.0
"""Focal length of the panorama, texels: as fine as the longest lens sees it."""


@cache
def texture(seed: int = 0, side: int = SIDE, patches: int = 900) -> Floats:
    """(side, side) of brightness about 1: grain of all sizes, posters and lines with sharp edges;
    what leaves at one border comes in at the other."""
    rng = np.random.default_rng(seed)
    frequency = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.rfftfreq(side)[None])
    amplitude = np.maximum(frequency, 1 / 400) ** -1.3 * np.exp(-((frequency / 0.25) ** 2))
    amplitude[0, 0] = 0.0
    white = np.fft.rfft2(rng.standard_normal((side, side)))
    grain = np.fft.irfft2(white * amplitude, s=(side, side))
    picture = 1 + 0.10 * grain / grain.std()
    for _ in range(patches):
        width, height = np.exp(rng.uniform(np.log(8), np.log(side / 10), 2)).astype(int)
        rows = (rng.integers(side) + np.arange(height)) % side
        columns = (rng.integers(side) + np.arange(width)) % side
        picture[np.ix_(rows, columns)] += rng.uniform(-0.22, 0.22)
    return np.asarray(np.clip(picture, 0.15, 1.75), np.float32)


@dataclass(frozen=True, eq=False)
class Panorama:
    """A picture (H, W, 3) on a plane at infinity, straight ahead of the first camera."""

    picture: Floats

    @classmethod
    def of(cls, seed: int = 0, width: int = 4200, height: int = 3000) -> Panorama:
        grey = np.tile(texture(seed), (2, 3))[:height, :width]
        tint = cv2.resize(texture(seed + 1, 256, 60), (width, height))
        colour = np.array([118.0, 127.0, 122.0]) + (tint[..., None] - 1) * (40.0, -10.0, -45.0)
        return cls((grey[..., None] * colour).astype(np.float32))

    def seen(self, camera: Camera, T_camera_world: Array) -> Floats:
        """(H, W, 3) RGB as a camera sees it that is turned so."""
        height, width = self.picture.shape[:2]
        centre = ((width - 1) / 2, (height - 1) / 2)
        K = np.array([[PANORAMA_F, 0, centre[0]], [0, PANORAMA_F, centre[1]], [0, 0, 1.0]])
        H = camera.K @ T_camera_world[:3, :3] @ np.linalg.inv(K)
        size = (camera.width, camera.height)
        return np.asarray(cv2.warpPerspective(self.picture, H, size, flags=cv2.INTER_LINEAR))


@dataclass(frozen=True, eq=False)
class Room:
    """Q rectangles, each textured.

    corners (Q, 4, 3): metres in the world, one after the other. colours (Q, 3): RGB.
    offsets (Q, 2): where in the texture the first corner lies, texels.
    """

    corners: Array
    colours: Array
    offsets: Array
    samples: int = 2

    @classmethod
    def of(cls, boxes: int = 14, seed: int = 0) -> Room:
        """A hall 16 m wide, from 5 m behind the camera to 14 m before it, its floor 1.4 m below
        the world's origin; boxes stand 1.5 to 9 m about a place 3 m ahead, which stays free."""
        rng = np.random.default_rng([seed, 7])
        floor_y = 1.4
        rectangles = _box((-8, -4, -5), (8, floor_y, 14))
        placed = list[tuple[float, float, float]]()
        while len(placed) < boxes:
            x, z = rng.uniform(-7, 7), rng.uniform(3.5, 12.5)
            half = rng.uniform(0.25, 0.8)
            free = math.hypot(x, z - 2.8) > 1.4 + 1.5 * half
            if free and all(math.hypot(x - a, z - b) > 1.5 * (half + c) for a, b, c in placed):
                placed.append((x, z, half))
                top = floor_y - rng.uniform(0.5, 2.6)
                low, high = (x - half, top, z - half), (x + half, floor_y, z + half)
                rectangles += _box(low, high)
        corners = np.array(rectangles, np.float64)
        colours = rng.uniform(70, 165, (len(corners), 3))
        return cls(corners, colours, rng.uniform(0, SIDE, (len(corners), 2)))

    def seen(self, camera: Camera, T_camera_world: Array) -> Floats:
        """(H, W, 3) RGB as a camera there sees it."""
        n = self.samples
        view = ViewCamera.of(camera).resized(n * camera.width, n * camera.height)
        count = len(self.corners)
        p_eye = apply_transform(T_camera_world, self.corners.reshape(-1, 3))
        faces = (4 * np.arange(count)[:, None, None] + [[0, 1, 2], [0, 2, 3]]).reshape(-1, 3)
        nearness = np.full((view.height, view.width), -np.inf, np.float32)
        face = np.full((view.height, view.width), -1, np.int32)
        lens = np.array([PERSPECTIVE, *view.focal, *view.centre, 1.0])
        fill(np.ascontiguousarray(p_eye), faces.astype(np.int64), lens, 0.05, nearness, face)
        light = np.zeros((camera.height, camera.width, 3), np.float32)
        _paint(face, nearness, lens, n, self._maps(p_eye), self.colours, *_levels(), light)
        return light

    def _maps(self, p_eye: Array) -> Array:
        """(Q, 2, 4) from the eye's frame to texels of every rectangle."""
        quads = p_eye.reshape(-1, 4, 3)
        sides = quads[:, [1, 3]] - quads[:, :1]
        along = sides / np.linalg.norm(sides, axis=-1, keepdims=True) / TEXEL_M
        shift = self.offsets - np.einsum("qka,qa->qk", along, quads[:, 0])
        return np.concatenate([along, shift[..., None]], axis=-1)


def _box(low: tuple[float, ...], high: tuple[float, ...]) -> list[list[tuple[float, ...]]]:
    """The six rectangles of a box, each as four corners."""
    sides = []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for end in (low, high):
            ring = []
            for p, q in ((low, low), (high, low), (high, high), (low, high)):
                corner = [0.0] * 3
                corner[axis], corner[a], corner[b] = end[axis], p[a], q[b]
                ring.append(tuple(corner))
            sides.append(ring)
    return sides


@cache
def _levels() -> tuple[Floats, NDArray[np.int64]]:
    """The texture at full, half … size, one after the other, and where each begins."""
    levels = [texture()]
    while len(levels[-1]) > 32:
        one = levels[-1]
        levels.append(one.reshape(len(one) // 2, 2, -1, 2).mean(axis=(1, 3)).astype(np.float32))
    starts = np.cumsum([0, *(one.size for one in levels)])
    return np.concatenate([one.ravel() for one in levels]), starts


@compiled
def _paint(
    face: NDArray[np.int32],
    nearness: Floats,
    lens: Array,
    samples: int,
    maps: Array,
    colours: Array,
    levels: Floats,
    starts: NDArray[np.int64],
    light: Floats,
) -> None:
    """Average the samples of every pixel; a texture is as coarse as what a sample covers."""
    for row in range(face.shape[0]):
        for column in range(face.shape[1]):
            k = face[row, column]
            if k < 0:
                continue
            quad = k // 2
            z = 1.0 / nearness[row, column]
            x, y = (column - lens[3]) / lens[1] * z, (row - lens[4]) / lens[2] * z
            M = maps[quad]
            u = M[0, 0] * x + M[0, 1] * y + M[0, 2] * z + M[0, 3]
            v = M[1, 0] * x + M[1, 1] * y + M[1, 2] * z + M[1, 3]
            wide = z / lens[1] * math.sqrt(M[0, 0] ** 2 + M[0, 1] ** 2 + M[0, 2] ** 2) * 1.4
            exact = min(max(math.log2(max(wide, 1e-6)), 0.0), len(starts) - 2.001)
            level = int(exact)
            share = exact - level
            value = (1 - share) * _at(levels, starts, level, u, v)
            if share > 0:
                value += share * _at(levels, starts, level + 1, u, v)
            for channel in range(3):
                lit = colours[quad, channel] * value / samples**2
                light[row // samples, column // samples, channel] += lit


@compiled
def _at(levels: Floats, starts: NDArray[np.int64], level: int, u: float, v: float) -> float:
    """The texture of a level at texels (u, v) of the finest, linear between its own."""
    side = SIDE >> level
    scale = 1.0 / (1 << level)
    a, b = (u + 0.5) * scale - 0.5, (v + 0.5) * scale - 0.5
    i, j = math.floor(a), math.floor(b)
    a, b = a - i, b - j
    i0, j0 = i % side, j % side
    i1, j1 = (i0 + 1) % side, (j0 + 1) % side
    first = starts[level]
    top = (1 - a) * levels[first + j0 * side + i0] + a * levels[first + j0 * side + i1]
    low = (1 - a) * levels[first + j1 * side + i0] + a * levels[first + j1 * side + i1]
    return (1 - b) * top + b * low
