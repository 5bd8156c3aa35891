"""The empty scene as a camera that turns shows it: one picture, put together from frames.

Every frame is laid on a sphere by its exact turn; what most frames show at a place is the
background there, as it is the median before a camera that stands still. Frames are brought to one
exposure, by a gain each.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, transpose

MOST_PIXELS = 24_000_000
"""A panorama that would be larger is coarser than the film."""
TILE = 256
"""Pixels along each side of what is put together at once."""
FEWEST_SEEN = 3
"""Frames that a place must be seen in for a median."""
MOST_GAIN = 2.0
SAME_EXPOSURE = 0.01
"""Gains that are nearer to 1 than this are noise."""
RIM_PX = 2.0
"""From a picture's edge, where interpolation and the lens leave less than a pixel's worth."""


@dataclass(frozen=True, eq=False)
class Shown:
    """A frame: its picture (H, W) or (H, W, 3) at the panorama's focal length, where it is one
    (H, W), and how the camera is turned, R_camera_world (3, 3)."""

    picture: NDArray[np.uint8]
    known: NDArray[np.bool_]
    R_camera_world: Array


@dataclass(frozen=True, eq=False)
class Panorama:
    """A picture all around, (h, w) or (h, w, 3), 0 where it is not known (h, w).

    A column is a longitude and a row a latitude, `step` radians apart, the first at `corner`, in
    a frame of its own: R_pano_world.
    """

    camera: Camera
    picture: NDArray[np.uint8]
    known: NDArray[np.bool_]
    R_pano_world: Array
    corner: tuple[float, float]
    step: float

    def seen(self, R_camera_world: Array) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
        """The picture that a camera turned so would take of it, and where it is known."""
        rays = _rays(self.camera) @ (R_camera_world @ self.R_pano_world.T)
        x, y, z = np.moveaxis(rays, -1, 0)
        lon = (np.arctan2(x, z) - self.corner[0]) % (2 * np.pi)
        lat = np.arctan2(y, np.hypot(x, z)) - self.corner[1]
        column, row = (np.asarray(a / self.step, np.float32) for a in (lon, lat))
        picture = cv2.remap(self.picture, column, row, cv2.INTER_LINEAR)
        weight = cv2.remap(self.known.astype(np.uint8), column, row, cv2.INTER_LINEAR)
        return np.asarray(picture, np.uint8), np.asarray(weight > 0)


def panorama_of(camera: Camera, frames: Sequence[Shown]) -> Panorama:
    """Put a panorama together from frames of a camera that turns.

    camera: that took the pictures, without distortion.
    """
    R_pano_world = _frame_of(np.stack([frame.R_camera_world for frame in frames]))
    (lon, lat), step = _extent(camera, frames, R_pano_world)
    size = [max(int(np.ceil((span[1] - span[0]) / step)) + 1, 2) for span in (lat, lon)]
    gains = np.ones(len(frames))
    for gains_known in (False, True):
        picture, is_known = _median(
            camera, frames, gains, R_pano_world, (lon[0], lat[0]), step, (size[0], size[1])
        )
        panorama = Panorama(camera, picture, is_known, R_pano_world, (lon[0], lat[0]), step)
        if gains_known:
            break
        gains = np.array(
            [exposure_of(frame.picture, *panorama.seen(frame.R_camera_world)) for frame in frames]
        )
        if np.abs(gains - 1).max() < SAME_EXPOSURE:
            break
    return panorama


def exposure_of(
    picture: NDArray[np.uint8], plate: NDArray[np.uint8], is_known: NDArray[np.bool_]
) -> float:
    """How much brighter a picture is than the plate behind it; 1 where that is not known."""
    use = is_known[::4, ::4]
    own, behind = (np.asarray(x[::4, ::4][use], np.float64) for x in (picture, plate))
    bright = behind > 16
    if bright.sum() < 100:
        return 1.0
    return float(np.clip(np.median(own[bright] / behind[bright]), 1 / MOST_GAIN, MOST_GAIN))


def _rays(camera: Camera) -> Array:
    """(H, W, 3) directions of the pixels, z = 1."""
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    x, y = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    return np.stack([x, y, np.ones_like(x)], axis=-1)


def _frame_of(Rs_camera_world: Array) -> Array:
    """R_pano_world (3, 3): ahead is where the camera usually looks, down what it turns about."""
    views = Rs_camera_world[:, 2]
    ahead = views.sum(axis=0)
    usual = Rs_camera_world[:, 1].sum(axis=0)
    if np.linalg.norm(ahead) < 1e-3 * len(views):
        ahead = views[0]
    ahead = ahead / np.linalg.norm(ahead)
    down = usual - (usual @ ahead) * ahead
    down = down / np.linalg.norm(down)
    return np.stack([np.cross(down, ahead), down, ahead])


def _extent(
    camera: Camera, frames: Sequence[Shown], R_pano_world: Array
) -> tuple[tuple[tuple[float, float], tuple[float, float]], float]:
    """The longitudes and latitudes that are seen, radians, and the step from pixel to pixel."""
    edge = _rays(camera)[:: max(camera.height // 8, 1), :: max(camera.width // 8, 1)]
    edge = np.concatenate([edge.reshape(-1, 3), _rays(camera)[[0, -1]].reshape(-1, 3)])
    lows, highs = [], []
    for frame in frames:
        x, y, z = (edge @ (frame.R_camera_world @ R_pano_world.T)).T
        angles = np.stack([np.arctan2(x, z), np.arctan2(y, np.hypot(x, z))])
        lows.append(angles.min(axis=1))
        highs.append(angles.max(axis=1))
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    step = max(1 / camera.fx, float(np.sqrt(np.prod(high - low) / MOST_PIXELS)))
    return ((low[0], high[0]), (low[1], high[1])), step


def _median(
    camera: Camera,
    frames: Sequence[Shown],
    gains: Array,
    R_pano_world: Array,
    corner: tuple[float, float],
    step: float,
    size: tuple[int, int],
) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Every place's median over the frames that show it, and where enough do, tile by tile."""
    picture = np.zeros((*size, *frames[0].picture.shape[2:]), np.uint8)
    is_known = np.zeros(size, np.bool_)
    for rows, columns in _tiles(size):
        lon = corner[0] + step * np.arange(columns.start, columns.stop)
        lat = corner[1] + step * np.arange(rows.start, rows.stop)[:, None]
        rays = np.stack(
            [np.cos(lat) * np.sin(lon), np.sin(lat) + 0 * lon, np.cos(lat) * np.cos(lon)], axis=-1
        )
        stack = [
            tile
            for frame, gain in zip(frames, gains, strict=True)
            if (tile := _on_tile(camera, frame, gain, rays @ R_pano_world)) is not None
        ]
        if len(stack) < FEWEST_SEEN:
            continue
        values = np.stack(stack)
        values.sort(axis=0)  # what is unknown is infinite, so last
        count = np.isfinite(values).sum(axis=0)
        middle = [np.clip(k, 0, len(stack) - 1)[None] for k in ((count - 1) // 2, count // 2)]
        both = [np.take_along_axis(values, k, axis=0)[0] for k in middle]
        enough = count >= FEWEST_SEEN
        flat = np.where(enough, 0.5 * (both[0] + both[1]), 0.0)
        picture[rows, columns] = np.clip(np.rint(flat), 0, 255).astype(np.uint8)
        is_known[rows, columns] = enough if enough.ndim == 2 else enough.all(axis=-1)
    return picture, is_known


def _on_tile(
    camera: Camera, frame: Shown, gain: float, rays_world: Array
) -> NDArray[np.float32] | None:
    """What a frame shows in directions (h, w, 3), infinite where nothing; None where nowhere."""
    x, y, z = np.moveaxis(rays_world @ frame.R_camera_world.T, -1, 0)
    ahead = z > 1e-3
    z = np.where(ahead, z, 1.0)
    u, v = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
    inside = ahead & (u > RIM_PX) & (u < camera.width - 1 - RIM_PX)
    inside &= (v > RIM_PX) & (v < camera.height - 1 - RIM_PX)
    if not inside.any():
        return None
    u, v = np.asarray(u, np.float32), np.asarray(v, np.float32)
    inside &= np.asarray(cv2.remap(frame.known.astype(np.uint8), u, v, cv2.INTER_NEAREST)) > 0
    light = np.asarray(cv2.remap(frame.picture, u, v, cv2.INTER_LINEAR), np.float32)
    light /= np.float32(gain)
    light[~inside] = np.inf
    return light


def _tiles(size: tuple[int, int]) -> Iterator[tuple[slice, slice]]:
    for row in range(0, size[0], TILE):
        for column in range(0, size[1], TILE):
            yield slice(row, min(row + TILE, size[0])), slice(column, min(column + TILE, size[1]))


def sampled(Rs_camera_world: Array, most: int) -> list[int]:
    """At most so many frames, spread evenly over the film and over its turns (F, 3, 3)."""
    R = Rs_camera_world
    cosine = (np.trace(R[1:] @ transpose(R[:-1]), axis1=1, axis2=2) - 1) / 2
    turned = np.arccos(np.clip(cosine, -1.0, 1.0))
    steps = 1 / max(len(turned), 1) + turned / max(turned.sum(), 1e-9)
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.linspace(0, travelled[-1], most)
    return [int(frame) for frame in np.unique(np.searchsorted(travelled, wanted - 1e-12))]
