"""The floor under a body seen from a new viewpoint: a grid that fades away, and a soft shadow."""

from __future__ import annotations

import cv2
import numpy as np

from keypose.app.render.lettering import length_name, write
from keypose.app.render.painting import Form
from keypose.app.render.palette import INK, PAPER, Colour, Picture
from keypose.app.render.strokes import SHIFT
from keypose.app.render.viewpoints import Ground
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.geometry.view import ViewCamera

LINE: Colour = (168, 176, 188)
BANDS = 6
"""The grid fades in so many steps."""
SHADE = 0.17
MOST_CELLS = 24
"""From the centre to where the grid has faded."""


def floor_picture(
    view: ViewCamera,
    ground: Ground,
    p_camera_centre: Array,
    form: Form,
    Ts_camera_part: Array | None,
) -> Picture:
    """The scene without the body: paper, the grid around the centre (3,), the body's shadow.

    Lines lie at multiples of a round length, which is written in the corner.
    """
    picture = np.full((view.height, view.width, 3), PAPER, dtype=np.uint8)
    _paint_grid(picture, view, ground, p_camera_centre)
    if Ts_camera_part is not None:
        _paint_shadow(picture, view, ground, form, Ts_camera_part)
    _write_step(picture, ground.step_m)
    return picture


def _paint_grid(picture: Picture, view: ViewCamera, ground: Ground, p_camera_centre: Array) -> None:
    """Lines cut into pieces of one cell, each the fainter the farther it is from the centre."""
    centre, step = (ground.R_level_camera @ p_camera_centre)[[0, 2]], ground.step_m
    p_eye_centre = apply_transform(view.T_view_camera, p_camera_centre)
    reach = min(max(1.6 * float(np.linalg.norm(p_eye_centre)), 4 * step), MOST_CELLS * step)
    count = int(np.ceil(reach / step))
    nodes = (np.arange(-count, count + 1)[:, None] + np.round(centre / step)) * step
    x, z = np.meshgrid(nodes[:, 0], nodes[:, 1], indexing="ij")
    p_level = np.stack([x, np.full_like(x, ground.floor_m), z], axis=-1)
    across = np.stack([p_level[:-1], p_level[1:]], axis=2).reshape(-1, 2, 3)
    along = np.stack([p_level[:, :-1], p_level[:, 1:]], axis=2).reshape(-1, 2, 3)
    pieces = np.concatenate([across, along])
    far = np.linalg.norm(pieces.mean(axis=1)[:, [0, 2]] - centre, axis=1)
    strength = np.clip(1.0 - far / reach, 0.0, 1.0)
    uv = view.project(apply_transform(view.T_view_camera, pieces @ ground.R_level_camera))
    visible = np.isfinite(uv).all(axis=(1, 2)) & (np.abs(uv) < 30_000).all(axis=(1, 2))
    band = np.ceil(strength * BANDS).astype(int)
    for k in range(1, BANDS + 1):
        chosen = np.rint(uv[visible & (band == k)] * 2**SHIFT).astype(np.int32)
        colour = _between(PAPER, LINE, (k - 0.3) / BANDS)
        thickness = max(1, round(view.height / 700))
        cv2.polylines(picture, list(chosen), False, colour, thickness, cv2.LINE_AA, SHIFT)


def _paint_shadow(
    picture: Picture, view: ViewCamera, ground: Ground, form: Form, Ts_camera_part: Array
) -> None:
    """The parts let down to the floor, blurred."""
    p_level = form.mesh.posed(Ts_camera_part) @ ground.R_level_camera.T
    p_level[:, 1] = ground.floor_m
    uv = view.project(apply_transform(view.T_view_camera, p_level @ ground.R_level_camera))
    if not np.isfinite(uv).all() or np.abs(uv).max() > 30_000:
        return
    low = np.clip(np.floor(uv.min(axis=0)).astype(int), 0, (view.width, view.height))
    high = np.clip(np.ceil(uv.max(axis=0)).astype(int) + 1, 0, (view.width, view.height))
    margin = max(3, view.height // 40)
    left, top = np.maximum(low - margin, 0)
    right, bottom = np.minimum(high + margin, (view.width, view.height))
    if right - left < 2 or bottom - top < 2:
        return
    mask = np.zeros((bottom - top, right - left), np.uint8)
    for part in range(len(Ts_camera_part)):
        points = uv[form.mesh.vertex_part == part] - (left, top)
        hull = cv2.convexHull(np.rint(points * 2**SHIFT).astype(np.int32))
        cv2.fillConvexPoly(mask, hull, 255, cv2.LINE_AA, SHIFT)
    soft = cv2.GaussianBlur(mask, (0, 0), margin / 3).astype(np.float32)
    below = picture[top:bottom, left:right]
    share = (SHADE / 255.0) * soft[..., None]
    below[:] = np.rint(below + share * (np.array(INK, dtype=np.float32) - below))


def _write_step(picture: Picture, step: float) -> None:
    size = float(np.clip(picture.shape[0] / 30, 8, 18))
    words = f"Grid {length_name(step)}"
    if picture.shape[0] >= 12 * size and picture.shape[1] >= 12 * size:
        write(picture, words, round(1.1 * size), picture.shape[0] - round(1.1 * size), size)


def _between(one: Colour, other: Colour, share: float) -> Colour:
    r, g, b = (round(a + share * (c - a)) for a, c in zip(one, other, strict=True))
    return r, g, b
