"""Find the contour of a posed body before its background, by colour models of both.

A part's colours are those seen well inside it, in all keyframes together; the background's those
around it. Where the camera stands still, the empty scene is known as well.

Across the contour, pixels inside look like the part, pixels outside like what is around it. Where
one turns into the other is found first from what the pixels look like, then finely from how much of
each lies between.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera

BINS = (16, 32, 32)
"""Of lightness and of the two colour axes of CIE Lab."""
CORE_PX = 2.5
COLOURS_NEAR_PX = 8.0
AROUND_PX = 40.0
"""How deep inside a part its colours are learnt, and from where to where outside the body those of
the background."""
LEAST_PIXELS = 40
MOST = 2.5
"""The most one pixel counts, log odds."""
FEWEST_FOR_PLATE = 5
TEMPER = 0.5
"""Neighbouring pixels are not independent."""

Picture = NDArray[np.uint8]
Map = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class ColourModels:
    """K pictures, and the log odds that their pixels show each of G groups of parts.

    rgb: (h, w, 3) each. usable: (h, w) each. cells: (h, w) index of each pixel's colour.
    group_of (P,): the group of every part. odds_of (G, C): log odds of each colour.
    plates: log odds by the empty scene, (h, w) each; trusted (K, G): where these may be used.
    """

    rgb: Sequence[Picture]
    usable: Sequence[NDArray[np.bool_]]
    cells: Sequence[NDArray[np.int32]]
    group_of: NDArray[np.int64]
    odds_of: Map
    plates: Sequence[Map]
    trusted: NDArray[np.bool_]

    def odds(self, frame: int, parts: NDArray[np.int64], uv: Array) -> Array:
        """(M, T) log odds that pixels uv (M, T, 2) show the part (M,)."""
        height, width = self.cells[frame].shape
        column, row = np.round(uv).astype(np.int64).transpose(2, 0, 1)
        within = (column >= 0) & (row >= 0) & (column < width) & (row < height)
        column, row = np.clip(column, 0, width - 1), np.clip(row, 0, height - 1)
        groups = self.group_of[parts]
        odds = self.odds_of[groups[:, None], self.cells[frame][row, column]]
        plate = self.plates[frame][row, column]
        odds = odds + np.where(self.trusted[frame, groups][:, None], plate, 0.0)
        odds = TEMPER * np.clip(odds, -MOST, MOST)
        return np.where(within & self.usable[frame][row, column], odds, np.nan)

    def sample(self, frame: int, uv: Array, normals: Array, offsets: Array) -> tuple[Array, Array]:
        """t (T,) pixels and colours (M, T, 3) there, about the places `offsets` (M,) outward."""
        t = np.arange(-3.5, 3.6, 0.25)
        at = np.nan_to_num(offsets)[:, None] + t
        place = (uv[:, None] + at[..., None] * normals[:, None]).astype(np.float32)
        if not len(place):
            return t, np.zeros((0, len(t), 3))
        colours = cv2.remap(
            self.rgb[frame].astype(np.float32),
            place[..., 0],
            place[..., 1],
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        return t, np.asarray(colours, dtype=np.float64)


def colour_cells(rgb: Picture) -> NDArray[np.int32]:
    """(h, w) index of each pixel's colour among coarse ones."""
    lab = cv2.cvtColor(cv2.GaussianBlur(rgb, (0, 0), 0.7), cv2.COLOR_RGB2LAB).astype(np.int32)
    light, a, b = (lab[..., k] * BINS[k] // 256 for k in range(3))
    return np.asarray((light * BINS[1] + a) * BINS[2] + b, dtype=np.int32)


def learn_colours(
    rgb: Sequence[Picture],
    usable: Sequence[NDArray[np.bool_]],
    cells: Sequence[NDArray[np.int32]],
    shown: Sequence[NDArray[np.int16]],
    group_of: NDArray[np.int64],
    plates: Sequence[Map],
) -> ColourModels:
    """The models, given the part (h, w) that each pose shows at each pixel."""
    groups, size = int(group_of.max()) + 1, int(np.prod(BINS))
    figure, ground = np.zeros((groups, size)), np.zeros((groups, size))
    trusted = np.zeros((len(rgb), groups), dtype=np.bool_)
    for k, (cell, use, part) in enumerate(zip(cells, usable, shown, strict=True)):
        outside = use & (_distance(part < 0) > COLOURS_NEAR_PX)
        for g in range(groups):
            own = np.isin(part, np.flatnonzero(group_of == g))
            if own.sum() < LEAST_PIXELS:
                continue
            near = _window(own)
            core = use[near] & (_distance(own[near]) > CORE_PX)
            around = outside[near] & (_distance(~own[near]) < AROUND_PX)
            figure[g] += np.bincount(cell[near][core], minlength=size)
            ground[g] += np.bincount(cell[near][around], minlength=size)
            trusted[k, g] = core.any() and np.median(plates[k][near][core]) > 0
    odds_of = np.stack([_odds(f, g) for f, g in zip(figure, ground, strict=True)])
    return ColourModels(rgb, usable, cells, group_of, odds_of.astype(np.float32), plates, trusted)


def _window(own: NDArray[np.bool_]) -> tuple[slice, slice]:
    """What lies around a part, as far as it matters."""
    margin = int(AROUND_PX) + 1
    spans = (np.flatnonzero(own.any(axis=1 - axis)) for axis in (0, 1))
    rows, columns = (slice(max(0, s[0] - margin), s[-1] + margin + 1) for s in spans)
    return rows, columns


def _distance(inside: NDArray[np.bool_]) -> Map:
    """How deep every pixel lies inside, pixels."""
    return np.asarray(cv2.distanceTransform(inside.astype(np.uint8), cv2.DIST_L2, 3), np.float32)


def _odds(figure: Array, ground: Array) -> Array:
    """(C,) log odds of every colour; 0 where too little was seen."""
    if figure.sum() < LEAST_PIXELS or ground.sum() < LEAST_PIXELS:
        return np.zeros_like(figure)
    figure_share, ground_share = (_spread(counts) for counts in (figure, ground))
    least = 0.02 * max(float(figure_share.max()), float(ground_share.max()))
    return np.asarray(np.log((figure_share + least) / (ground_share + least)))


def _spread(counts: Array) -> Array:
    """Counts as shares, each colour a little of its neighbours' as well."""
    cube = counts.reshape(BINS) / counts.sum()
    for axis in range(3):
        padded = np.pad(cube, [(1, 1) if k == axis else (0, 0) for k in range(3)])
        low, middle, high = (np.moveaxis(padded, axis, 0)[k : k - 2 or None] for k in range(3))
        cube = np.moveaxis(0.25 * low + 0.5 * middle + 0.25 * high, 0, axis)
    return np.asarray(cube.ravel())


def plate_odds(rgb: Sequence[Picture], others: Sequence[Picture]) -> list[Map]:
    """Log odds (h, w) by the empty scene, for every picture; 0 unless the camera stands still.

    The empty scene is every pixel's median over all the pictures. It holds where most of the
    pictures agree with it; where the body never leaves a place, it is in the plate itself, which
    `learn_colours` notices.
    """
    every = np.stack([*rgb, *others])
    plate = np.median(every, axis=0)
    apart = [np.abs(picture - plate).max(axis=2) for picture in rgb]
    noise = max(2.0, 1.4826 * float(np.median(np.stack(apart))))
    moving = noise > 8.0 or np.mean([(a > 4 * noise).mean() for a in apart]) > 0.3
    if len(every) < FEWEST_FOR_PLATE or moving:
        return [np.zeros(a.shape, np.float32) for a in apart]
    return [np.clip(0.5 * (a / noise) ** 2 - 4.0, -MOST, MOST).astype(np.float32) for a in apart]


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
    is_known = np.isfinite(odds)
    odds = np.where(is_known, odds, 0.0) * STEP_PX
    inside = np.cumsum(odds, axis=1)
    score = 2 * inside - inside[:, -1:] - 0.5 * (t / 6.0) ** 2
    edge = int(2 / STEP_PX)
    room = is_known & np.roll(is_known, edge, axis=1) & np.roll(is_known, -edge, axis=1)
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
    t, sampled = colours
    figure = sampled[:, t < -NEAR_PX].mean(axis=1)
    ground = sampled[:, t > NEAR_PX].mean(axis=1)
    contrast = figure - ground
    length = np.linalg.norm(contrast, axis=1)
    between = np.abs(t) <= NEAR_PX
    share = np.einsum("mtc,mc->mt", sampled[:, between] - ground[:, None], contrast)
    share = np.clip(share / np.maximum(length, 1e-3)[:, None] ** 2, 0, 1).mean(axis=1)
    fine = coarse + (2 * share - 1) * NEAR_PX
    return np.where(length > LEAST_CONTRAST * np.sqrt(3), fine, np.nan)
