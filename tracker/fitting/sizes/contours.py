"""The contour of a posed body before its background, and how far off the picture shows it.

Across the contour, pixels inside look like the part, pixels outside like what is around it. Where
one turns into the other is found first from what the pixels look like, then finely from how much of
each lies between.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.fitting.sizes.colours import ColourModels
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera

FINE = 3
"""The contour is drawn so many times finer than the picture."""
APART_PX = 2.0
STEP_PX = 0.5
MARGIN = 2.0
"""By how much, log odds, a place must beat all others for a contour."""
SURE = 0.25
"""Least log odds of pixels just inside and just outside."""
LEAST_CONTRAST = 8.0
"""Grey levels between inside and outside below which a contour is not seen."""
NEAR_PX = 1.5


@dataclass(frozen=True, eq=False)
class Contour:
    """M points where a posed body ends before the background.

    parts (M,), points (M, 3) in the parts' frames, metres; uv, normals (M, 2) pixels, outward.
    shown (h, w): index of the part at every pixel of the picture, −1 for none.
    """

    parts: NDArray[np.int64]
    points: Array
    uv: Array
    normals: Array
    shown: NDArray[np.int16]


def contour_of(mesh: BodyMesh, Ts_camera_part: Array, camera: Camera) -> Contour:
    """The outer contours, and those of gaps between limbs, of parts at Ts_camera_part (P, 4, 4)."""
    view = ViewCamera.of(camera)
    shown = np.full((camera.height, camera.width), -1, np.int16)
    left, top, width, height = _bounding_box(view.project(mesh.posed(Ts_camera_part)), camera)
    if width < 3 or height < 3:
        nothing = np.zeros((0, 2))
        return Contour(np.zeros(0, np.int64), np.zeros((0, 3)), nothing, nothing, shown)
    fine = view.cropped(left, top, width, height).resized(FINE * width, FINE * height)
    drawn = raster(mesh, Ts_camera_part, fine)
    shown[top : top + height, left : left + width] = drawn.part[
        FINE // 2 :: FINE, FINE // 2 :: FINE
    ]
    column, row, normals = _rim_pixels(drawn.part >= 0)
    parts = drawn.part[row, column].astype(np.int64)
    place = np.column_stack([column, row]).astype(np.float64)
    p = fine.back_project(place, drawn.depth[row, column].astype(np.float64))
    T = Ts_camera_part[parts]
    points = np.einsum("mba,mb->ma", T[:, :3, :3], p - T[:, :3, 3])
    uv = (place + 0.5 + 0.5 * normals) / FINE - 0.5 + (left, top)
    return Contour(parts, points, uv, normals, shown)


def _bounding_box(uv: Array, camera: Camera) -> tuple[int, int, int, int]:
    """Left, top, width and height of what the body covers of the picture."""
    uv = uv[np.isfinite(uv).all(-1)].reshape(-1, 2)
    if not len(uv):
        return 0, 0, 0, 0
    size = np.array([camera.width, camera.height])
    low = np.clip(np.floor(uv.min(0)) - 3, 0, size)
    high = np.clip(np.ceil(uv.max(0)) + 4, 0, size)
    return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])


def _rim_pixels(
    inside: NDArray[np.bool_],
) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Columns, rows (M,) and outward normals (M, 2) of pixels on the rim, APART_PX apart."""
    lines, _ = cv2.findContours(inside.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    step = round(APART_PX * FINE)
    rim = np.concatenate([line[step // 2 :: step, 0] for line in lines] or [np.zeros((0, 2))])
    column, row = rim.astype(np.int64).T
    smooth = cv2.GaussianBlur(inside.astype(np.float32), (0, 0), FINE)
    across = [
        np.asarray(cv2.Sobel(smooth, cv2.CV_32F, du, 1 - du), np.float64)[row, column]
        for du in (1, 0)
    ]
    normals = -np.stack(across, axis=-1)
    length = np.linalg.norm(normals, axis=1)
    height, width = inside.shape
    within = (column > 0) & (row > 0) & (column < width - 1) & (row < height - 1)
    kept = within & (length > 1e-6)
    return column[kept], row[kept], normals[kept] / length[kept, None]


def offsets(contour: Contour, colour_models: ColourModels, frame: int, reach_px: float) -> Array:
    """(M,) pixels outward from each contour point to where the picture shows the body's end.

    NaN where it does not: inside and outside look alike, or another limb lies there.
    """
    t = np.arange(-reach_px, reach_px + STEP_PX / 2, STEP_PX)
    uv = contour.uv[:, None] + t[:, None] * contour.normals[:, None]
    odds = colour_models.odds(frame, contour.parts, uv)
    odds = np.where(_is_unobstructed(contour, uv, t), odds, np.nan)
    best = _find_edges(odds, t)
    return _refine_edges(colour_models.sample(frame, contour.uv, contour.normals, best), best)


def _is_unobstructed(contour: Contour, uv: Array, t: Array) -> NDArray[np.bool_]:
    """(M, T) whether, on the way from the contour, nothing but the part and background is met."""
    height, width = contour.shown.shape
    column, row = np.round(uv).astype(np.int64).transpose(2, 0, 1)
    within = (column >= 1) & (row >= 1) & (column < width - 1) & (row < height - 1)
    part = contour.shown[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
    good = np.where(t > 1.0, part < 0, np.where(t < -1.0, part >= 0, True)) & within
    middle = len(t) // 2
    inward = np.logical_and.accumulate(good[:, middle::-1], axis=1)[:, ::-1]
    outward = np.logical_and.accumulate(good[:, middle:], axis=1)
    return np.concatenate([inward[:, :-1], outward], axis=1)


def _find_edges(odds: Array, t: Array) -> Array:
    """(M,) where what looks like the part turns into what looks like background; NaN if nowhere."""
    known = np.isfinite(odds)
    odds = np.where(known, odds, 0.0) * STEP_PX
    inside = np.cumsum(odds, axis=1)
    score = 2 * inside - inside[:, -1:] - 0.5 * (t / 6.0) ** 2
    edge = int(2 / STEP_PX)
    room = known & np.roll(known, edge, axis=1) & np.roll(known, -edge, axis=1)
    room[:, :edge] = room[:, -edge:] = False
    score = np.where(room, score, -np.inf)
    k = score.argmax(axis=1)
    m = np.arange(len(k))
    far = np.abs(t[None, :] - t[k][:, None]) > 2.5
    second = np.where(far, score, -np.inf).max(axis=1, initial=-np.inf)
    sure = room[m, k] & (score[m, k] > second + MARGIN)
    for side in (-1, 1):  # what is just inside, and just outside, must look so
        near = [odds[m, np.clip(k + side * j, 0, len(t) - 1)] for j in range(1, edge + 1)]
        sure &= -side * np.mean(near, axis=0) > SURE * STEP_PX
    return np.where(sure, t[k] + STEP_PX / 2, np.nan)


def _refine_edges(colours: tuple[Array, Array], coarse: Array) -> Array:
    """The place to a share of a pixel: what lies between inside and outside is a mixture of both.

    colours: t (T,) about the coarse place and what is seen there (M, T, 3).
    """
    t, seen = colours
    figure = seen[:, t < -NEAR_PX].mean(axis=1)
    ground = seen[:, t > NEAR_PX].mean(axis=1)
    contrast = figure - ground
    length = np.linalg.norm(contrast, axis=1)
    between = np.abs(t) <= NEAR_PX
    share = np.einsum("mtc,mc->mt", seen[:, between] - ground[:, None], contrast)
    share = np.clip(share / np.maximum(length, 1e-3)[:, None] ** 2, 0, 1).mean(axis=1)
    fine = coarse + (2 * share - 1) * NEAR_PX
    return np.where(length > LEAST_CONTRAST * np.sqrt(3), fine, np.nan)
