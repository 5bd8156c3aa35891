"""Posed body → picture, without a window: over the video, from the top, the side and the front."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np

from keypose.app.orders.drawing import Style
from keypose.app.render.lettering import axes, plate, round_length, scale_bar, write_name
from keypose.app.render.painting import Figure, form_of, paint_figures
from keypose.app.render.palette import GAP, GRID, GRID_MIDDLE, PAPER, Picture
from keypose.app.render.surfaces import SurfaceLayer, draw_surface
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.geometry.view import ViewCamera, ViewName

Rotations: TypeAlias = Mapping[ViewName, Array]
"""R_view_camera (3, 3) of the three views, where up is not the camera's own up."""

OPACITY = 0.5

MOST_GRID_LINES = 40
LEAST_HEIGHT_OF_FOUR = 24
"""In a lower picture the three small views would show nothing."""

VIEW_NAMES: tuple[ViewName, ...] = ("top", "side", "front")
_AXES: dict[ViewName, tuple[str, str]] = {
    "top": ("x", "z"),
    "side": ("z", "-y"),
    "front": ("x", "-y"),
}


@dataclass(frozen=True, eq=False)
class Framing:
    """What views along parallel rays show; what is None is made to fit the body.

    centre_m: (3,) the point of the camera frame in the middle. metres_across: a picture's width.
    Rs: the views' directions, where up is not the camera's own up.
    """

    centre_m: Array | None = None
    metres_across: float | None = None
    Rs: Rotations | None = None


@dataclass(frozen=True)
class FourViewLayout:
    """The sizes (width, height) of the large picture and of the three beside it, which a very low
    picture has no room for."""

    main: tuple[int, int]
    small: tuple[tuple[int, int], ...]
    gap: int

    @classmethod
    def of(cls, camera: Camera, height: int) -> FourViewLayout:
        """Lay out a picture so many pixels high."""
        main = (max(1, round(height * camera.width / camera.height)), height)
        gap = max(2, height // 240)
        if height < LEAST_HEIGHT_OF_FOUR:
            return cls(main, (), gap)
        heights = np.diff(np.rint(np.linspace(0, height + gap, 4)).astype(int)) - gap
        return cls(main, tuple((int(1.3 * height / 3), int(h)) for h in heights), gap)

    @property
    def views(self) -> dict[ViewName, tuple[int, int]]:
        """What the small ones show, from the top to the bottom, and their sizes."""
        return dict(zip(VIEW_NAMES, self.small, strict=False))

    @property
    def width(self) -> int:
        """The width of the whole picture."""
        return self.main[0] + (self.gap + self.small[0][0] if self.small else 0)


def overlay(
    image_rgb: Picture,
    camera: Camera,
    skeleton: Skeleton,
    pose: Pose,
    style: Style = "both",
    opacity: float = OPACITY,
    beside: Sequence[Figure] = (),
) -> Picture:
    """The body, and others beside it, over the rectified video frame (H, W, 3), which must have the
    camera's size.

    "solid" shows shaded parts, "wire" their outlines and rings, hidden ones fainter; opacity, 0 to
    1, is that of the solid parts. Pixels away from the body stay as they are.
    """
    if image_rgb.shape != (camera.height, camera.width, 3):
        raise ValueError(
            f"the picture is {image_rgb.shape[1]}×{image_rgb.shape[0]} but the camera takes "
            f"{camera.width}×{camera.height}"
        )
    return _body_over_image(
        image_rgb, ViewCamera.of(camera), skeleton, pose, style, opacity, beside
    )


def orthographic(
    skeleton: Skeleton,
    pose: Pose | None,
    view: ViewName = "front",
    size: tuple[int, int] = (480, 480),
    centre_m: Array | None = None,
    metres_across: float | None = None,
    Rs_view_camera: Rotations | None = None,
    surface: SurfaceLayer | None = None,
    beside: Sequence[Figure] = (),
) -> Picture:
    """A true orthographic view of the solid body and those beside it, `size` = (width, height), on
    a grid; `surface`, the surface observed at that moment, lies over it as a sheet.

    "front" looks along the camera's +z (x right, y down), "top" looks down along +y (x right, z,
    away from the camera, up), "side" looks along −x (z right, y down). centre_m (3,) is the point
    of the camera frame in the middle, metres_across the picture's width; left out, the body fits.
    Grid lines lie at multiples of the scale bar's length in the camera frame: a round one that
    suits the picture's width, 0.5 m for a person. What finds no room is not lettered.
    """
    frame = Framing(centre_m, metres_across, Rs_view_camera)
    view_camera = parallel_view(_points(skeleton, pose, beside), view, size, frame)
    step_m = round_length(size[0] / view_camera.focal[0])
    picture = _body_over_image(
        _grid(view_camera, step_m), view_camera, skeleton, pose, "solid", 1.0, beside
    )
    if surface is not None:
        picture = draw_surface(
            picture, view_camera, surface, form_of(skeleton), _posed(skeleton, pose)
        )
    letter_px = _letter_px(size[1])
    write_name(picture, view.capitalize(), letter_px)
    bar_end = scale_bar(picture, step_m, view_camera.focal[0], letter_px)
    axes(picture, *_AXES[view], letter_px, bar_end)
    return picture


def four_views(
    image_rgb: Picture,
    camera: Camera,
    skeleton: Skeleton,
    pose: Pose | None,
    style: Style = "both",
    opacity: float = OPACITY,
    height: int = 720,
    label: str = "Camera",
    Rs_view_camera: Rotations | None = None,
    framing: Framing | None = None,
    surface: SurfaceLayer | None = None,
    beside: Sequence[Figure] = (),
) -> Picture:
    """The overlay, large, and the three orthographic views, all at one scale, stacked beside it.

    The picture is `height` pixels high; its width follows from the camera's shape. One less
    than LEAST_HEIGHT_OF_FOUR pixels high is the overlay alone.
    """
    layout = FourViewLayout.of(camera, height)
    width = layout.main[0]
    enlarged = cv2.INTER_CUBIC if height > camera.height else cv2.INTER_AREA
    frame = np.asarray(cv2.resize(image_rgb, (width, height), interpolation=enlarged), np.uint8)
    main = _body_over_image(
        frame, ViewCamera.of(camera).resized(width, height), skeleton, pose, style, opacity, beside
    )
    letter_px = _letter_px(height // 3)
    plate(main, label, *(round(0.8 * letter_px),) * 2, letter_px)
    if not layout.small:
        return main
    if framing is None:
        framing = framing_of(_points(skeleton, pose, beside), layout.views, Rs_view_camera)
    centre, across = framing.centre_m, framing.metres_across
    small = [
        orthographic(skeleton, pose, view, size, centre, across, framing.Rs, surface, beside)
        for view, size in layout.views.items()
    ]
    column = _stacked(small, layout.gap, axis=0)
    return _stacked([main, column], layout.gap, axis=1)


def parallel_view(
    p_camera: Array, view: ViewName, size: tuple[int, int], framing: Framing
) -> ViewCamera:
    """The camera of one of the three views, of points (N, 3) as far as the framing leaves open what
    is shown."""
    centre = middle(p_camera) if framing.centre_m is None else np.asarray(framing.centre_m, float)
    R = framing.Rs[view] if framing.Rs else None
    across = framing.metres_across
    if across is None:
        view_camera = ViewCamera.orthographic(view, centre, 1.0, size, R)
        across = width_to_fit(apply_transform(view_camera.T_view_camera, p_camera), size)
    return ViewCamera.orthographic(view, centre, size[0] / across, size, R)


def framing_of(
    p_camera: Array, sizes: Mapping[ViewName, tuple[int, int]], Rs: Rotations | None
) -> Framing:
    """The framing that shows points (N, 3) at one scale in views of these sizes."""
    centre, across = middle(p_camera), 0.0
    for view, size in sizes.items():
        view_camera = ViewCamera.orthographic(view, centre, 1.0, size, Rs[view] if Rs else None)
        fit = width_to_fit(apply_transform(view_camera.T_view_camera, p_camera), size)
        across = max(across, fit)
    return Framing(centre, across, Rs)


def _body_over_image(
    image: Picture,
    view: ViewCamera,
    skeleton: Skeleton,
    pose: Pose | None,
    style: Style,
    opacity: float,
    beside: Sequence[Figure],
) -> Picture:
    """The body and those beside it over an image of the view's size; the image itself without."""
    figures = with_posed(skeleton, pose, beside)
    return paint_figures(image, view, figures, style, opacity)


def with_posed(
    skeleton: Skeleton, pose: Pose | None, beside: Sequence[Figure]
) -> tuple[Figure, ...]:
    """The bodies to paint: those beside, and the one that is posed where it has a pose."""
    if pose is None:
        return tuple(beside)
    return *beside, Figure(form_of(skeleton), pose_transforms(skeleton, pose))


def _posed(skeleton: Skeleton, pose: Pose | None) -> Array | None:
    return None if pose is None else pose_transforms(skeleton, pose)


def posed_points(skeleton: Skeleton, pose: Pose) -> Array:
    """The corners (V, 3) of the body's triangles in the camera frame."""
    return form_of(skeleton).mesh.posed(pose_transforms(skeleton, pose))


def _points(skeleton: Skeleton, pose: Pose | None, beside: Sequence[Figure]) -> Array:
    points = [figure.points for figure in with_posed(skeleton, pose, beside)]
    return np.concatenate(points) if points else np.zeros((1, 3))


def middle(points: Array) -> Array:
    """Middle (3,) of the box around points (N, 3)."""
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2)


def width_to_fit(p_eye: Array, size: tuple[int, int]) -> float:
    """Metres across a picture of that size in which points around the centre fit with a margin."""
    half = np.abs(p_eye[:, :2]).max(axis=0)
    return float(max(2 * half[0], 2 * half[1] * size[0] / size[1]) * 1.22)


def _letter_px(height: int) -> float:
    return float(np.clip(height / 22, 8, 18))


def _grid(view: ViewCamera, step_m: float) -> Picture:
    """The empty sheet of an orthographic view with grid lines at multiples of step_m.

    Those through 0 are darker. In a very long picture lines are left out evenly.
    """
    sheet = np.full((view.height, view.width, 3), PAPER, dtype=np.uint8)
    step_px = view.focal[0] * step_m
    step_px *= np.ceil((view.width + view.height) / step_px / (MOST_GRID_LINES - 2))
    if step_px < 4:
        return sheet
    for across, limit in enumerate((view.width, view.height)):
        zero_px = view.centre[across] + view.focal[across] * view.T_view_camera[across, 3]
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
