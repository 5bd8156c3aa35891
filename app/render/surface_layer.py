"""An observed surface over the body that stands in it, seen from anywhere: one translucent sheet.

It is the nearest layer of the surface, as on the page: where that lies before the body, the body
shines through it; where the body comes out, it is bare.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.app.render.form import Form
from keypose.app.render.painting import FINE, box_of
from keypose.app.render.palette import INK, Canvas, Picture
from keypose.tracker.body.raster import raster
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.painting import Colours, Layer, layer

Depth: TypeAlias = NDArray[np.float32]

OPACITY = 0.42
"""Over the body, as on the page …"""
OPACITY_OVER_PAPER = 0.75
"""… and where nothing stands in it: on the page that is dark, and clay is as bright as paper."""
RIM = 0.35
"""Strength of the line around it."""


@dataclass(frozen=True, eq=False)
class SurfaceLayer:
    """A step's surface (camera frame, metres) and the colours (V, 3) of its vertices."""

    mesh: SurfaceMesh
    colours: Colours


def draw_surface(
    picture: Picture,
    view: ViewCamera,
    surface: SurfaceLayer,
    form: Form,
    Ts_camera_part: Array | None,
) -> Picture:
    """The surface over a picture of the view's size that shows the body solid, or None."""
    result = picture.copy()
    left, top, right, bottom = box_of(
        apply_transform(view.T_view_camera, surface.mesh.vertices), view
    )
    if right <= left or bottom <= top:
        return result
    width, height = right - left, bottom - top
    fine = view.cropped(left, top, width, height).resized(FINE * width, FINE * height)
    seen = layer(surface.mesh, fine, surface.colours)
    below = picture[top:bottom, left:right].astype(np.float32)
    canvas = below.repeat(FINE, axis=0).repeat(FINE, axis=1)
    _lay(canvas, seen, _body_depth(form, Ts_camera_part, fine))
    small = cv2.resize(canvas, (width, height), interpolation=cv2.INTER_AREA)
    result[top:bottom, left:right] = np.clip(np.rint(small), 0, 255)
    return result


def _body_depth(form: Form, Ts_camera_part: Array | None, view: ViewCamera) -> Depth:
    if Ts_camera_part is None:
        return np.full((view.height, view.width), np.inf, dtype=np.float32)
    return raster(form.mesh, Ts_camera_part, view).depth


def _lay(canvas: Canvas, seen: Layer, body: Depth) -> None:
    """The layer over a canvas in place, where it lies before the body; its rim is a fine line."""
    there = np.isfinite(seen.depth)
    shown = there & (seen.depth <= body)
    share = np.where(np.isfinite(body), OPACITY, OPACITY_OVER_PAPER)[shown].astype(np.float32)
    canvas[shown] += share[:, None] * (seen.rgb[shown] - canvas[shown])
    inner = cv2.erode(there.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    rim = shown & ~inner
    canvas[rim] += np.float32(RIM) * (np.array(INK, dtype=np.float32) - canvas[rim])
