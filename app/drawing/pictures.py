"""Posed body → picture, without a window: over the video, from the top, the side and the front.

Everything is painted at twice its size and averaged down, so that edges are smooth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, TypeAlias

import cv2
import numpy as np

from app.drawing.lettering import axes, plate, round_length, scale_bar, write_name
from app.drawing.palette import (
    GAP,
    GRID,
    GRID_MIDDLE,
    PAPER,
    Canvas,
    Picture,
    part_colours,
    part_sides,
)
from app.drawing.shading import paint_solid, part_borders, shaded
from app.drawing.strokes import body_lines, paint_dots, paint_lines
from tracker.camera import Camera
from tracker.eye import Eye, ViewName
from tracker.geometry import Array, apply_transform
from tracker.pose import Pose, pose_transforms
from tracker.raster import BodyMesh, raster
from tracker.skeleton import Skeleton

Style: TypeAlias = Literal["wire", "solid", "both"]
Rotations: TypeAlias = Mapping[ViewName, Array]
"""R_view_camera (3, 3) of the three views, where up is not the camera's own up."""

OPACITY = 0.5

FINE = 2
"""Painted this many times as large as wanted."""

MOST_GRID_LINES = 40
LEAST_HEIGHT_OF_FOUR = 24
"""In a lower picture the three small views would show nothing."""

VIEW_NAMES: tuple[ViewName, ...] = ("top", "side", "front")
_AXES: dict[ViewName, tuple[str, str]] = {
    "top": ("x", "z"),
    "side": ("z", "-y"),
    "front": ("x", "-y"),
}


def overlay(
    image_rgb: Picture,
    camera: Camera,
    skeleton: Skeleton,
    pose: Pose,
    style: Style = "both",
    opacity: float = OPACITY,
) -> Picture:
    """The body over the rectified video frame (H, W, 3), which must have the camera's size.

    "solid" shows shaded parts, "wire" their outlines and rings, hidden ones fainter; opacity, 0 to
    1, is that of the solid parts. Pixels away from the body stay as they are.
    """
    if image_rgb.shape != (camera.height, camera.width, 3):
        raise ValueError(
            f"the picture is {image_rgb.shape[1]}×{image_rgb.shape[0]} but the camera takes "
            f"{camera.width}×{camera.height}"
        )
    return _over(image_rgb, Eye.of(camera), skeleton, pose, style, opacity)


def orthographic(
    skeleton: Skeleton,
    pose: Pose,
    view: ViewName = "front",
    size: tuple[int, int] = (480, 480),
    centre_m: Array | None = None,
    metres_across: float | None = None,
    Rs_view_camera: Rotations | None = None,
) -> Picture:
    """A true orthographic view of the solid body, `size` = (width, height), on a grid.

    "front" looks along the camera's +z (x right, y down), "top" looks down along +y (x right, z,
    away from the camera, up), "side" looks along −x (z right, y down). centre_m (3,) is the point
    of the camera frame in the middle, metres_across the picture's width; left out, the body fits.
    Grid lines lie at multiples of the scale bar's length in the camera frame: a round one that
    suits the picture's width, 0.5 m for a person. What finds no room is not lettered.
    """
    p_camera = BodyMesh.of(skeleton).posed(pose_transforms(skeleton, pose))
    centre = _middle(p_camera) if centre_m is None else np.asarray(centre_m, dtype=np.float64)
    R = Rs_view_camera[view] if Rs_view_camera else None
    eye = Eye.orthographic(view, centre, 1.0, size, R)
    if metres_across is None:
        metres_across = _width_to_fit(apply_transform(eye.T_eye_camera, p_camera), size)
    eye = Eye.orthographic(view, centre, size[0] / metres_across, size, R)
    step_m = round_length(metres_across)
    picture = _over(_grid(eye, step_m), eye, skeleton, pose, "solid", 1.0)
    letter_px = _letter_px(size[1])
    write_name(picture, view.capitalize(), letter_px)
    bar_end = scale_bar(picture, step_m, eye.focal[0], letter_px)
    axes(picture, *_AXES[view], letter_px, bar_end)
    return picture


def four_views(
    image_rgb: Picture,
    camera: Camera,
    skeleton: Skeleton,
    pose: Pose,
    style: Style = "both",
    opacity: float = OPACITY,
    height: int = 720,
    label: str = "Camera",
    Rs_view_camera: Rotations | None = None,
) -> Picture:
    """The overlay, large, and the three orthographic views, all at one scale, stacked beside it.

    The picture is `height` pixels high; its width follows from the camera's shape. One less
    than LEAST_HEIGHT_OF_FOUR pixels high is the overlay alone.
    """
    width = max(1, round(height * camera.width / camera.height))
    enlarged = cv2.INTER_CUBIC if height > camera.height else cv2.INTER_AREA
    frame = np.asarray(cv2.resize(image_rgb, (width, height), interpolation=enlarged), np.uint8)
    main = _over(frame, Eye.of(camera).resized(width, height), skeleton, pose, style, opacity)
    letter_px = _letter_px(height // 3)
    plate(main, label, *(round(0.8 * letter_px),) * 2, letter_px)
    if height < LEAST_HEIGHT_OF_FOUR:
        return main
    gap = max(2, height // 240)
    heights = np.diff(np.rint(np.linspace(0, height + gap, 4)).astype(int)) - gap
    sizes = [(int(1.3 * height / 3), int(h)) for h in heights]
    small = _three_views(skeleton, pose, sizes, Rs_view_camera)
    column = _stacked(small, gap, axis=0)
    return _stacked([main, column], gap, axis=1)


def contact_sheet(
    images: Sequence[Picture], columns: int, labels: Sequence[str] | None = None
) -> Picture:
    """Pictures in rows of `columns`, each resampled to the first one's size and named."""
    if not images:
        raise ValueError("a contact sheet needs at least one picture")
    height, width = images[0].shape[:2]
    cells = [
        np.array(cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)
        for image in images
    ]
    for cell, words in zip(cells, labels or [], strict=bool(labels)):
        plate(cell, words, 4, 4, _letter_px(height))
    gap = max(2, height // 120)
    blank = np.full_like(cells[0], GAP)
    cells += [blank] * (-len(cells) % columns)
    rows = [_stacked(cells[i : i + columns], gap, axis=1) for i in range(0, len(cells), columns)]
    return _stacked(rows, gap, axis=0)


def _three_views(
    skeleton: Skeleton,
    pose: Pose,
    sizes: Sequence[tuple[int, int]],
    Rs_view_camera: Rotations | None,
) -> list[Picture]:
    p_camera = BodyMesh.of(skeleton).posed(pose_transforms(skeleton, pose))
    centre = _middle(p_camera)
    across = 0.0
    for view, size in zip(VIEW_NAMES, sizes, strict=True):
        R = Rs_view_camera[view] if Rs_view_camera else None
        eye = Eye.orthographic(view, centre, 1.0, size, R)
        fit = _width_to_fit(apply_transform(eye.T_eye_camera, p_camera), size)
        across = max(across, fit)
    return [
        orthographic(skeleton, pose, view, size, centre, across, Rs_view_camera)
        for view, size in zip(VIEW_NAMES, sizes, strict=True)
    ]


def _over(
    image: Picture, eye: Eye, skeleton: Skeleton, pose: Pose, style: Style, opacity: float
) -> Picture:
    """Paint the body over an image of the eye's size; only the pixels around it are touched."""
    result = image.copy()
    mesh, Ts_camera_part = BodyMesh.of(skeleton), pose_transforms(skeleton, pose)
    left, top, right, bottom = _box(mesh.posed(eye.T_eye_camera @ Ts_camera_part), eye)
    if right <= left or bottom <= top:
        return result
    width, height = right - left, bottom - top
    fine = eye.cropped(left, top, width, height).resized(FINE * width, FINE * height)
    ground = image[top:bottom, left:right].astype(np.float32)
    canvas = ground.repeat(FINE, axis=0).repeat(FINE, axis=1)
    stroke = max(1, round(FINE * eye.height / 420))
    _paint_body(canvas, fine, skeleton, mesh, Ts_camera_part, style, opacity, stroke)
    small = cv2.resize(canvas, (width, height), interpolation=cv2.INTER_AREA)
    result[top:bottom, left:right] = np.clip(np.rint(small), 0, 255)
    return result


def _paint_body(
    canvas: Canvas,
    eye: Eye,
    skeleton: Skeleton,
    mesh: BodyMesh,
    Ts_camera_part: Array,
    style: Style,
    opacity: float,
    stroke: int,
) -> None:
    seen = raster(mesh, Ts_camera_part, eye)
    if style != "wire":
        rgb, mask = shaded(mesh, part_colours(skeleton.body), Ts_camera_part, eye, seen)
        paint_solid(canvas, rgb, mask, opacity, part_borders(seen))
    if style != "solid":
        lines = body_lines(mesh, Ts_camera_part, eye, seen)
        paint_lines(canvas, lines, part_sides(skeleton.body), stroke)
        p_eye = apply_transform(eye.T_eye_camera, Ts_camera_part[:, :3, 3])
        paint_dots(canvas, eye.project(p_eye), 1.1 * stroke)


def _box(p_eye: Array, eye: Eye) -> tuple[int, int, int, int]:
    """Left, top, right, bottom of the pixels a body can touch, right and bottom left out."""
    margin = 4 + eye.height // 100
    uv = eye.project(p_eye)
    if np.isnan(uv).all():
        return 0, 0, 0, 0
    if np.isnan(uv).any():  # partly behind the camera: its outline may go anywhere
        return 0, 0, eye.width, eye.height
    limits = (eye.width, eye.height)
    low = np.clip(np.floor(uv.min(axis=0)) - margin, 0, limits).astype(int)
    high = np.clip(np.ceil(uv.max(axis=0)) + 1 + margin, 0, limits).astype(int)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def _middle(points: Array) -> Array:
    """Middle (3,) of the box around points (N, 3)."""
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2)


def _width_to_fit(p_eye: Array, size: tuple[int, int]) -> float:
    """Metres across a picture of that size in which points around the centre fit with a margin."""
    half = np.abs(p_eye[:, :2]).max(axis=0)
    return float(max(2 * half[0], 2 * half[1] * size[0] / size[1]) * 1.22)


def _letter_px(height: int) -> float:
    return float(np.clip(height / 22, 8, 18))


def _grid(eye: Eye, step_m: float) -> Picture:
    """The empty sheet of an orthographic eye with grid lines at multiples of step_m.

    Those through 0 are darker. In a very long picture lines are left out evenly.
    """
    sheet = np.full((eye.height, eye.width, 3), PAPER, dtype=np.uint8)
    step_px = eye.focal[0] * step_m
    step_px *= np.ceil((eye.width + eye.height) / step_px / (MOST_GRID_LINES - 2))
    if step_px < 4:
        return sheet
    for across, limit in enumerate((eye.width, eye.height)):
        zero_px = eye.centre[across] + eye.focal[across] * eye.T_eye_camera[across, 3]
        first, last = np.ceil(-zero_px / step_px), np.floor((limit - 1 - zero_px) / step_px)
        for step in np.arange(first, last + 1):
            place = (slice(None), round(zero_px + step * step_px))[:: 1 - 2 * across]
            sheet[place] = np.minimum(sheet[place], GRID_MIDDLE if step == 0 else GRID)
    return sheet


def _stacked(pictures: Sequence[Picture], gap: int, axis: int) -> Picture:
    """Pictures in a row (axis 1) or column (axis 0), a dark gap between them."""
    shape = list(pictures[0].shape)
    shape[axis] = gap
    line = np.full(shape, GAP, dtype=np.uint8)
    parts = [piece for picture in pictures for piece in (line, picture)][1:]
    return np.concatenate(parts, axis=axis)
