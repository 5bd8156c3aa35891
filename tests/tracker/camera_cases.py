"""Films of a turning, zooming or moving camera, rendered with known truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation

Grey = NDArray[np.uint8]

SMALL = Camera(width=320, height=180, fx=456.0, fy=456.0, cx=159.5, cy=89.5)


@cache
def texture(seed: int, height: int = 1000, width: int = 2400) -> Grey:
    """Noise of several sizes, with patches that have corners."""
    rng = np.random.default_rng(seed)
    sum_ = np.zeros((height, width), np.float32)
    for size in (2, 5, 12, 30, 80):
        shape = (height // size + 2, width // size + 2)
        noise = rng.normal(0, 1, shape).astype(np.float32)
        sum_ += cv2.resize(noise, (width, height), interpolation=cv2.INTER_CUBIC) * size**0.45
    sum_ = (sum_ - sum_.mean()) / sum_.std() * 36 + 120
    for x, y, side, grey in zip(
        *(rng.integers(0, most, 400) for most in (width, height, 60, 230)), strict=True
    ):
        cv2.rectangle(sum_, (int(x), int(y)), (int(x + side), int(y + side)), float(grey), -1)
    return np.clip(sum_, 0, 255).astype(np.uint8)


def rendered(camera: Camera, R: Array, zoom: float = 1.0, seed: int = 0) -> Grey:
    """The picture of a far cylinder that a camera takes, turned R from the world."""
    zoomed, around = camera.zoomed(zoom), texture(seed)
    uv = np.stack(np.meshgrid(np.arange(camera.width), np.arange(camera.height)), axis=-1)
    x, y, z = np.moveaxis(zoomed.back_project(uv.astype(float), 1.0) @ R, -1, 0)
    scale, (height, width) = 1.1 * camera.fx, around.shape
    at = scale * np.arctan2(x, z) + width / 2, scale * y / np.hypot(x, z) + height / 2
    return np.asarray(
        cv2.remap(
            around, *(c.astype(np.float32) for c in at), cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REFLECT,
        ),
        np.uint8,
    )  # fmt: skip


def turned(pan_deg: float = 0.0, tilt_deg: float = 0.0, roll_deg: float = 0.0) -> Array:
    """The rotation from the world into a camera that is turned by roll after tilt after pan."""
    about = np.radians(np.diag([tilt_deg, pan_deg, roll_deg]))
    x, y, z = exp_rotation(about)
    return np.asarray(z @ x @ y)


def wandering(count: int) -> tuple[list[Array], Array]:
    """A hand-held pan there and back with a zoom: rotations and zooms (count,)."""
    t = np.arange(count) / max(count - 1, 1)
    R = [
        turned(9 * np.sin(np.pi * s), 2 * np.sin(2 * np.pi * s) + 0.1 * np.sin(40 * s), 1.5 * s)
        for s in t
    ]
    return [r @ R[0].T for r in R], np.exp(0.15 * np.sin(np.pi * t))


def film(
    camera: Camera, rotations: Sequence[Array], zooms: Array | None = None, noise: float = 2.0
) -> list[Grey]:
    rng = np.random.default_rng(0)
    zooms = np.ones(len(rotations)) if zooms is None else zooms
    return [
        noisy(rendered(camera, R, zoom), rng, noise)
        for R, zoom in zip(rotations, zooms, strict=True)
    ]


def noisy(picture: Grey, rng: np.random.Generator, sigma: float = 2.0) -> Grey:
    noise = rng.normal(0.0, sigma, picture.shape)
    return np.clip(np.rint(picture + noise), 0, 255).astype(np.uint8)


def with_mover(pictures: Sequence[Grey], share: float = 0.25) -> tuple[list[Grey], list[Grey]]:
    """The same with something textured that goes through the picture, and where it is."""
    shown, where = [], []
    for frame, picture in enumerate(pictures):
        height, width = picture.shape
        w, h = int(width * share), int(height * 0.8)
        x, y = int((width - w) * frame / max(len(pictures) - 1, 1)), height - h
        shown.append(picture.copy())
        shown[-1][y : y + h, x : x + w] = texture(7)[:h, :w]
        where.append(np.zeros(picture.shape, np.uint8))
        where[-1][y : y + h, x : x + w] = 1
    return shown, where


def planes(camera: Camera, R: Array, p_camera: Array) -> Grey:
    """A wall, a pillar before it and a floor, as a camera at p_camera (metres) sees them."""
    uv = np.stack(np.meshgrid(np.arange(camera.width), np.arange(camera.height)), axis=-1)
    ray = camera.back_project(uv.astype(float), 1.0) @ R
    shown, nearest = np.zeros(uv.shape[:2], np.float32), np.full(uv.shape[:2], np.inf)
    for axis, at, left, right, seed in (
        (2, 12.0, -99.0, 99.0, 1), (2, 5.0, -1.0, 0.0, 2), (2, 8.0, 0.7, 1.6, 3),
        (1, 1.4, -99.0, 99.0, 4),
    ):  # fmt: skip
        along = ray[..., axis]
        t = (at - p_camera[axis]) / np.where(along > 1e-4, along, np.inf)
        p = p_camera + t[..., None] * ray
        seen = (t > 0) & (t < nearest) & (p[..., 0] > left) & (p[..., 0] < right)
        a, b = (120 * p[..., k] + 500 for k in (0, 3 - axis))
        picture = cv2.remap(
            texture(seed), a.astype(np.float32) + 700, b.astype(np.float32), cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REFLECT,
        )  # fmt: skip
        shown, nearest = np.where(seen, picture, shown), np.where(seen, t, nearest)
    return np.clip(shown, 0, 255).astype(np.uint8)


def read_by_rows(
    camera: Camera, at: Callable[[float], Array], count: int, share: float
) -> list[Grey]:
    """A film whose rows are read one after another, over a share of the time between frames."""
    band = 6
    return [np.concatenate(list(_bands(camera, at, frame, share, band))) for frame in range(count)]


def _bands(
    camera: Camera, at: Callable[[float], Array], frame: int, share: float, band: int
) -> Iterator[Grey]:
    for top in range(0, camera.height, band):
        update = {"height": band, "cy": camera.cy - top}
        time = frame + share * ((top + band / 2) / camera.height - 0.5)
        yield rendered(camera.model_copy(update=update), at(time))


def off_deg(Ts: Array, rotations: Sequence[Array]) -> Array:
    """By how much (N,) the rotations of transforms differ from the true ones, degrees."""
    miss = Ts[:, :3, :3] - np.stack(rotations)
    return np.asarray(np.degrees(np.linalg.norm(miss, axis=(1, 2)) / np.sqrt(2)))
