"""What a rig's cameras took, and whether those that see a place agree on it (ZNCC).

On phantom volume, and where a surface was reconstructed badly, they do not.  SURFACE §3.2
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Literal, Self, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import SurfaceError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.patches import correlate
from keypose.tracker.kernels.raster import PERSPECTIVE, fill
from keypose.tracker.surface.cameras.hull import Silhouette
from keypose.tracker.surface.cameras.rig import Grey, Lenses, Rig, RigCamera, View, stack_pictures
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.video import MissingFrame, Video

SPACING_PX = 1.0
"""Between the samples of a patch, which so is 7 pixels wide."""

SLACK_PX = 3.0
"""A vertex this far behind what a view sees first is still seen: the depth of a slanted face
changes by about as much within a pixel."""

LEAST_COSINE = 0.35
"""Of the angle between a surface's normal and the way to a camera that is compared."""

NEAR_M = 0.01


@dataclass(frozen=True, eq=False)
class Agreement:
    """How well the cameras agree on each vertex.

    zncc:    (V,) mean zero-mean normalised cross correlation over all pairs that see it; −1 where
             fewer than two do.
    seen_by: (V,) number of cameras that see it.
    """

    zncc: Array
    seen_by: NDArray[np.int64]


def consistency(mesh: SurfaceMesh, views: Sequence[View], pictures: Sequence[Grey]) -> Array:
    """Mean ZNCC (V,) of a mesh in the views' world; pictures (H, W) as an ideal lens takes them."""
    return agreement(mesh, views, pictures).zncc


def agreement(mesh: SurfaceMesh, views: Sequence[View], pictures: Sequence[Grey]) -> Agreement:
    """The same with the number of views."""
    zncc, seen_by = np.full(len(mesh.vertices), -1.0), np.zeros(len(mesh.vertices), np.int64)
    if views:
        lenses, stack = Lenses.of(views), stack_pictures(pictures, 0)
        correlate(
            np.ascontiguousarray(mesh.vertices),
            np.ascontiguousarray(mesh.normals),
            lenses.Ts,
            lenses.lenses,
            lenses.sizes,
            stack,
            _nearness(mesh, views, stack.shape),
            SPACING_PX,
            SLACK_PX,
            LEAST_COSINE,
            zncc,
            seen_by,
        )
    return Agreement(zncc, seen_by)


def _nearness(
    mesh: SurfaceMesh, views: Sequence[View], shape: tuple[int, ...]
) -> NDArray[np.float32]:
    """(K, H, W) 1/z of the mesh's first face in every pixel, −inf where there is none."""
    nearness = np.full(shape, -np.inf, np.float32)
    shown = np.empty(shape[1:], np.int32)
    for view, buffer in zip(views, nearness, strict=True):
        shown.fill(-1)
        c = view.camera
        projection = np.array([PERSPECTIVE, c.fx, c.fy, c.cx, c.cy, 1.0])
        p_view = np.ascontiguousarray(view.of_view(mesh.vertices))
        fill(p_view, mesh.faces, projection, NEAR_M, buffer, shown)
    return nearness


What: TypeAlias = Literal["images", "silhouettes"]

Shown: TypeAlias = Callable[[str, NDArray[np.uint8]], Grey | None]
"""Of a camera's name and its picture (H, W, 3), RGB, how much of each pixel belongs to the thing;
None where the thing is not found."""


@dataclass(frozen=True, eq=False)
class _CameraVideo:
    """A view, without the lens's distortion, and its video."""

    view: View
    lens: Camera
    video: Video


class Footage:
    """The opened images or silhouettes of a rig, beside its views. Close it, or use `with`."""

    def __init__(self, rig: Rig, kind: What, p_camera_surface: Array) -> None:
        """SurfaceError where fewer than two cameras have any, or they do not fit together."""
        self._what = kind
        self._open = ExitStack()
        try:
            self._taken = self._open_videos(rig, p_camera_surface)
            self.frame_count = _common_count(self._taken, kind)
        except BaseException:
            self._open.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the videos."""
        self._open.close()

    @property
    def views(self) -> tuple[View, ...]:
        """The views that have pictures, with ideal lenses."""
        return tuple(taken.view for taken in self._taken)

    def pictures(self, step: int) -> tuple[list[View], list[Grey]]:
        """The views whose picture of this step can be read, and these pictures (H, W)."""
        taken_pictures = self._each(step, _grey)
        pictures = [taken.lens.rectify(grey) for taken, grey in taken_pictures]
        return [taken.view for taken, _ in taken_pictures], pictures

    def silhouettes(
        self, step: int, shown: Shown | None = None
    ) -> tuple[list[View], list[Silhouette]]:
        """The same of silhouettes: what is brighter than half belongs to the thing.

        shown: makes them from images, of those views where it finds the thing.
        """
        taken_pictures = self._each(step, shown or _grey)
        return [taken.view for taken, _ in taken_pictures], [
            _silhouette(t.lens, g) for t, g in taken_pictures
        ]

    def rate(self, mesh: SurfaceMesh, step: int) -> SurfaceMesh:
        """A mesh in the views' world, with its photo-consistency at a step."""
        views, pictures = self.pictures(step)
        return replace(mesh, consistency=consistency(mesh, views, pictures))

    def _open_videos(self, rig: Rig, p_camera_surface: Array) -> list[_CameraVideo]:
        taken = []
        for camera, view in zip(rig.cameras, rig.views(p_camera_surface), strict=True):
            name = camera.images if self._what == "images" else camera.silhouettes
            if name is None:
                continue
            # One picture each: the steps are gone through once.
            video = self._open.enter_context(Video.open(rig.folder / name, cache_bytes=0))
            _require_size(camera, video, self._what)
            ideal = replace(view, camera=view.camera.without_distortion())
            taken.append(_CameraVideo(ideal, view.camera, video))
        if len(taken) < 2:
            advice = "" if self._what == "images" else ", or --person finds a person in the images"
            raise SurfaceError(
                f"Only {len(taken)} of the {len(rig.cameras)} cameras have {self._what}: at least "
                f"two must name theirs{advice}."
            )
        return taken

    def _each(self, step: int, shown: Shown) -> list[tuple[_CameraVideo, Grey]]:
        """What is made of the pictures of a step, where they can be read and it is found."""
        taken_pictures = []
        for taken in self._taken:
            try:
                grey = shown(taken.view.name, taken.video.frame(step))
            except MissingFrame:
                continue
            if grey is not None:
                taken_pictures.append((taken, grey))
        return taken_pictures


def _grey(_name: str, picture: NDArray[np.uint8]) -> Grey:
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), np.uint8)


def _silhouette(lens: Camera, grey: Grey) -> Silhouette:
    mask = np.where(grey > 127, np.uint8(255), np.uint8(0))
    if not lens.is_distorted:
        return Silhouette(mask > 0)
    # An ideal lens would show more than was taken: that is unknown.
    is_known = lens.rectify(np.full_like(mask, 255)) > 254
    return Silhouette((lens.rectify(mask) > 127) & is_known, is_known)


def _require_size(camera: RigCamera, video: Video, kind: What) -> None:
    width, height = video.info.width, video.info.height
    if (width, height) != (camera.width, camera.height):
        raise SurfaceError(
            f"The {kind} of camera {camera.name!r} have {width}×{height} pixels instead of the "
            f"{camera.width}×{camera.height} it was calibrated for."
        )


def _common_count(taken: Sequence[_CameraVideo], kind: What) -> int:
    counts: dict[int, str] = {}
    for camera_video in taken:
        counts.setdefault(camera_video.video.info.frame_count, camera_video.view.name)
    if len(counts) > 1:
        (first_count, first), (second_count, second) = list(counts.items())[:2]
        raise SurfaceError(
            f"Camera {first!r} has {first_count} {kind} and camera {second!r} "
            f"{second_count}: every camera needs one for every step."
        )
    return next(iter(counts))
