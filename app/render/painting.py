"""Paint the body over a picture, or on nothing, so that it can be composited over anything.

It is painted at twice its size and averaged down, so that edges are smooth; and only where the
body is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, reduce

import cv2
import numpy as np

from keypose.app.orders.drawing import Style
from keypose.app.render.palette import (
    SIDE_COLOURS,
    Canvas,
    Colour,
    CutOut,
    Picture,
    Side,
    part_colours,
    part_sides,
)
from keypose.app.render.shading import paint_solid, part_borders, shade, smooth_normal_maps
from keypose.app.render.strokes import BodyEdges, body_lines, paint_dots, paint_lines
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, apply_transform, frozen
from keypose.tracker.geometry.view import ViewCamera


@dataclass(frozen=True, eq=False)
class Form:
    """A body's triangles, their smooth normals, their edges, and the colours of the parts.

    side_colours: of the edges.
    """

    mesh: BodyMesh
    normal_maps: Array
    edges: BodyEdges
    colours: Array
    sides: tuple[Side, ...]
    side_colours: Mapping[Side, Colour] = field(default_factory=lambda: SIDE_COLOURS)


@dataclass(frozen=True, eq=False)
class Figure:
    """A body to be painted, and where its parts are: Ts_camera_part (P, 4, 4)."""

    form: Form
    Ts_camera_part: Array

    @property
    def points(self) -> Array:
        """(V, 3) the corners of its triangles in the camera frame."""
        return self.form.mesh.posed(self.Ts_camera_part)

    def depth(self, view: ViewCamera) -> float:
        """How far away it is as seen in a view, metres."""
        return float(
            apply_transform(view.T_view_camera, self.Ts_camera_part[:, :3, 3])[:, 2].mean()
        )


@lru_cache(maxsize=4)
def form_of(skeleton: Skeleton) -> Form:
    """The form of a skeleton, the same one for the same skeleton."""
    mesh = BodyMesh.of(skeleton)
    return Form(
        mesh,
        frozen(smooth_normal_maps(mesh)),
        BodyEdges.of(mesh),
        part_colours(skeleton.body),
        part_sides(skeleton.body),
    )


@lru_cache(maxsize=32)
def form_in(skeleton: Skeleton, colour: Colour) -> Form:
    """The form of a skeleton in one colour."""
    count = len(skeleton.body.parts)
    return replace(
        form_of(skeleton),
        colours=frozen(np.tile(np.array(colour, dtype=np.float64), (count, 1))),
        sides=tuple[Side, ...](["middle"] * count),
        side_colours={"middle": colour},
    )


FINE = 2
"""Painted this many times as large as wanted."""


def paint_figures(
    image: Picture, view: ViewCamera, figures: Sequence[Figure], style: Style, opacity: float
) -> Picture:
    """Bodies over an image of the view's size, the nearest one last."""
    picture = image if figures else image.copy()
    for figure in _farthest_first(figures, view):
        picture = paint_over(picture, view, figure.form, figure.Ts_camera_part, style, opacity)
    return picture


def cut_out_figures(
    view: ViewCamera, figures: Sequence[Figure], style: Style, opacity: float
) -> CutOut:
    """Bodies on nothing, the nearest one over the others."""
    layers = [
        cut_out(view, figure.form, figure.Ts_camera_part, style, opacity)
        for figure in _farthest_first(figures, view)
    ]
    return reduce(_composited, layers)


def _farthest_first(figures: Sequence[Figure], view: ViewCamera) -> list[Figure]:
    return sorted(figures, key=lambda figure: -figure.depth(view))


def _composited(below: CutOut, above: CutOut) -> CutOut:
    """One picture on nothing over another one, each colour as much as it covers."""
    a, b = (each[..., 3:].astype(np.float64) / 255.0 for each in (above, below))
    alpha = a + b * (1 - a)
    rgb = (above[..., :3] * a + below[..., :3] * b * (1 - a)) / np.maximum(alpha, 1e-3)
    return np.asarray(np.clip(np.rint(np.dstack([rgb, 255.0 * alpha])), 0, 255), np.uint8)


def paint_over(
    image: Picture,
    view: ViewCamera,
    form: Form,
    Ts_camera_part: Array,
    style: Style,
    opacity: float,
) -> Picture:
    """The body over an image of the view's size; only the pixels around it are touched."""
    result = image.copy()
    left, top, right, bottom = box_of(form.mesh.posed(view.T_view_camera @ Ts_camera_part), view)
    if right <= left or bottom <= top:
        return result
    ground = image[top:bottom, left:right].astype(np.float32)
    canvas = ground.repeat(FINE, axis=0).repeat(FINE, axis=1)
    _paint_body(canvas, (left, top), view, form, Ts_camera_part, style, opacity)
    small = cv2.resize(canvas, (right - left, bottom - top), interpolation=cv2.INTER_AREA)
    result[top:bottom, left:right] = np.clip(np.rint(small), 0, 255)
    return result


def cut_out(
    view: ViewCamera, form: Form, Ts_camera_part: Array, style: Style, opacity: float
) -> CutOut:
    """The body on nothing: composited over an image by its alpha, it looks as painted on it."""
    result = np.zeros((view.height, view.width, 4), dtype=np.uint8)
    left, top, right, bottom = box_of(form.mesh.posed(view.T_view_camera @ Ts_camera_part), view)
    if right <= left or bottom <= top:
        return result
    canvas = np.zeros((FINE * (bottom - top), FINE * (right - left), 4), dtype=np.float32)
    _paint_body(canvas, (left, top), view, form, Ts_camera_part, style, opacity)
    small = cv2.resize(canvas, (right - left, bottom - top), interpolation=cv2.INTER_AREA)
    alpha = small[..., 3:]
    rgb = small[..., :3] * (255.0 / np.maximum(alpha, 1e-3))
    result[top:bottom, left:right] = np.clip(np.rint(np.dstack([rgb, alpha])), 0, 255)
    return result


def _paint_body(
    canvas: Canvas,
    corner: tuple[int, int],
    view: ViewCamera,
    form: Form,
    Ts_camera_part: Array,
    style: Style,
    opacity: float,
) -> None:
    """Paint onto a canvas FINE times as large as the piece of the picture it begins at."""
    height, width = canvas.shape[:2]
    fine = view.cropped(*corner, width // FINE, height // FINE).resized(width, height)
    stroke = max(1, round(FINE * view.height / 420))
    body_raster = raster(form.mesh, Ts_camera_part, fine)
    if style != "wire":
        rgb, mask = shade(
            form.mesh, form.normal_maps, form.colours, Ts_camera_part, fine, body_raster
        )
        paint_solid(canvas, rgb, mask, opacity, part_borders(body_raster))
    if style != "solid":
        lines = body_lines(form.mesh, form.edges, Ts_camera_part, fine, body_raster)
        paint_lines(canvas, lines, form.sides, stroke, form.side_colours)
        p_eye = apply_transform(fine.T_view_camera, Ts_camera_part[:, :3, 3])
        paint_dots(canvas, fine.project(p_eye), 1.1 * stroke)


def box_of(p_eye: Array, view: ViewCamera) -> tuple[int, int, int, int]:
    """Left, top, right, bottom of the pixels that a thing with these corners (V, 3) can touch,
    right and bottom left out."""
    margin = 4 + view.height // 100
    uv = view.project(p_eye)
    if np.isnan(uv).all():
        return 0, 0, 0, 0
    if np.isnan(uv).any():  # partly behind the camera: its outline may go anywhere
        return 0, 0, view.width, view.height
    limits = (view.width, view.height)
    low = np.clip(np.floor(uv.min(axis=0)) - margin, 0, limits).astype(int)
    high = np.clip(np.ceil(uv.max(axis=0)) + 1 + margin, 0, limits).astype(int)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])
