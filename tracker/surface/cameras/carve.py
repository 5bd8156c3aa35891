"""Photo hulls: a hull without what the pictures show that cameras see through.

For every view a depth is sought along the rays of its pixels, within the hull, where the other
views agree best. A depth counts where another view's depth confirms it. What two views so see
through is taken away; what no two can see stays as the silhouettes left it.  SURFACE §3.2, §5.1
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.sweeping import sweep
from keypose.tracker.surface.cameras.nets import CORNERS, Field
from keypose.tracker.surface.cameras.views import Grey, Lenses, View, stack_pictures

Depths = NDArray[np.float32]

STRIDE = 2
"""Depths are sought for every other pixel."""
NEIGHBOURS = 4
LEAST_ANGLE_DEG = 8.0
"""Views from nearly the same side show no depth."""
LEAST_SCORE = 0.6
STEP_PX = 1.0
"""Steps along a ray, in pixels' sizes at the thing's distance."""
THROUGH_PX = 4.0
"""A place is seen through where what is seen lies farther by this, in the same measure."""


def carve_field(field: Field, views: Sequence[View], pictures: Sequence[Grey]) -> Field:
    """The field without what the pictures (H, W) show to be empty."""
    if len(views) < 3 or not (field.depths > 0).any():
        return field
    maps = depth_maps(field, views, pictures)
    return carve_seen_through(field, views, maps, STRIDE, THROUGH_PX * _footprint(field, views))


def carve_seen_through(
    field: Field, views: Sequence[View], maps: Sequence[Depths], stride: int, through_m: float
) -> Field:
    """The field without what at least two views see through.

    maps: of each view the depth (h, w) of every `stride`-th pixel, not finite where none is known.
    through_m: a place must lie before what is seen by this much.
    """
    places = np.argwhere(field.depths > 0)
    p = field.p_origin + field.voxel_m * places
    behind = np.full((2, len(p)), np.inf)
    for view, depths in zip(views, maps, strict=True):
        p_view = view.of_view(p)
        depth = p_view[:, 2] - _depths_at(depths, view.camera.project(p_view) / stride)
        depth[~np.isfinite(depth)] = np.inf
        behind = np.sort(np.vstack([behind, depth]), axis=0)[:2]
    depths = field.depths.copy()
    at = tuple(places.T)
    least = field.depths.min()
    depths[at] = np.clip(behind[1] + through_m, least, depths[at])
    return replace(field, depths=depths)


def depth_maps(field: Field, views: Sequence[View], pictures: Sequence[Grey]) -> list[Depths]:
    """Of each view the depth (h, w) of every STRIDE-th pixel, where another view confirms it."""
    step_m = STEP_PX * _footprint(field, views)
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        maps = list(
            threads.map(
                lambda k: _sweep_depths(k, field, views, pictures, step_m), range(len(views))
            )
        )
    return [_confirm_depths(k, views, maps, 3 * step_m) for k in range(len(views))]


def _sweep_depths(
    k: int, field: Field, views: Sequence[View], pictures: Sequence[Grey], step_m: float
) -> Depths:
    view, chosen = views[k], _neighbours(k, field, views)
    lenses = Lenses.of([views[m] for m in chosen])
    stack = stack_pictures([pictures[m] for m in chosen], 0)
    T_world_view = np.linalg.inv(view.T_view_world)
    Ts_other_view = np.stack([views[m].T_view_world for m in chosen]) @ T_world_view
    Ks = np.stack([views[m].camera.K for m in chosen])
    As = np.ascontiguousarray(Ks @ Ts_other_view[:, :3, :3] @ np.linalg.inv(view.camera.K))
    bs = np.ascontiguousarray((Ks @ Ts_other_view[:, :3, 3:])[..., 0])
    camera = view.camera
    shape = ((camera.height + STRIDE - 1) // STRIDE, (camera.width + STRIDE - 1) // STRIDE)
    depth, score = np.empty(shape, np.float32), np.empty(shape, np.float32)
    sweep(
        np.array(pictures[k]), np.array([camera.fx, camera.fy, camera.cx, camera.cy]),
        np.ascontiguousarray(T_world_view[:3]), stack, lenses.sizes, As, bs,
        np.array(field.p_origin), field.voxel_m, field.depths > 0,
        STRIDE, _reach(field, view), step_m, depth, score,
    )  # fmt: skip
    depth[~(score >= LEAST_SCORE)] = 0.0
    middle = np.asarray(cv2.medianBlur(depth, 3), np.float32)
    return np.where((depth > 0) & (middle > 0), middle, np.float32(np.nan))


def _confirm_depths(
    k: int, views: Sequence[View], maps: Sequence[Depths], tolerance_m: float
) -> Depths:
    """The depths of a view at whose places another view has found nearly the same."""
    depths, view = maps[k], views[k]
    rows, columns = np.nonzero(np.isfinite(depths))
    uv = STRIDE * np.stack([columns, rows], axis=1).astype(np.float64)
    p = view.camera.back_project(uv, depths[rows, columns].astype(np.float64))
    p = (p - view.T_view_world[:3, 3]) @ view.T_view_world[:3, :3]
    agreed = np.zeros(len(p), bool)
    for other in range(len(views)):
        if other == k:
            continue
        p_other = views[other].of_view(p)
        found = _depths_at(maps[other], views[other].camera.project(p_other) / STRIDE)
        agreed |= np.abs(found - p_other[:, 2]) < tolerance_m
    kept = np.full_like(depths, np.nan)
    kept[rows[agreed], columns[agreed]] = depths[rows[agreed], columns[agreed]]
    return kept


def _depths_at(depths: Depths, uv: Array) -> Array:
    """The depths (N,) at the pixels (N, 2) of a map; NaN beside it."""
    columns, rows = np.rint(uv).T
    there = (columns >= 0) & (rows >= 0) & (columns < depths.shape[1]) & (rows < depths.shape[0])
    found = np.full(len(uv), np.nan)
    found[there] = depths[rows[there].astype(np.int64), columns[there].astype(np.int64)]
    return found


def _neighbours(k: int, field: Field, views: Sequence[View]) -> list[int]:
    """The views nearest in direction, without those from the same side."""
    towards = np.stack([view.p_world_view for view in views]) - _centre(field)
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    angles = np.degrees(np.arccos(np.clip(towards @ towards[k], -1, 1)))
    order = [int(m) for m in np.argsort(angles) if m != k]
    apart = [m for m in order if angles[m] >= LEAST_ANGLE_DEG]
    return (apart or order)[:NEIGHBOURS]


def _centre(field: Field) -> Array:
    return np.asarray(field.p_origin + field.voxel_m * np.array(field.depths.shape) / 2)


def _footprint(field: Field, views: Sequence[View]) -> float:
    """The size of a pixel at the thing's middle, in the mean of the views, metres."""
    middle = _centre(field)
    return float(np.mean([view.of_view(middle)[2] / view.camera.fx for view in views]))


def _reach(field: Field, view: View) -> Array:
    """Nearest and farthest z of the grid in a view."""
    size = field.voxel_m * np.array(field.depths.shape)
    z = view.of_view(field.p_origin + CORNERS * size)[:, 2]
    return np.array([max(z.min(), 0.01), z.max()])
