"""A session drawn at any size and from anywhere, over the video or on nothing."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from keypose.app.posing import view_rotations
from keypose.app.render.floor import floor_picture
from keypose.app.render.form import Form, form_of
from keypose.app.render.painting import Style, cut_out, paint_over
from keypose.app.render.palette import GAP, CutOut, Picture
from keypose.app.render.pictures import (
    FourViewLayout,
    Framing,
    Rotations,
    four_views,
    framing_of,
    orthographic,
    parallel_view,
    posed_points,
)
from keypose.app.render.snapshots import ground_of, labelled
from keypose.app.render.surface_layer import SurfaceLayer, draw_surface
from keypose.app.render.viewpoints import Ground
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera, ViewName
from keypose.tracker.session.schema import Session

Size = tuple[int, int]
"""Width and height, pixels."""


@dataclass(frozen=True)
class Paint:
    """How the body is drawn over the video."""

    style: Style
    opacity: float


SOLID = Paint("solid", 1.0)


@dataclass(frozen=True, eq=False)
class Studio:
    """Where a session's pictures are made. camera: with an ideal lens. Rs: the level views."""

    session: Session
    camera: Camera
    skeleton: Skeleton
    form: Form
    Rs: Rotations

    @classmethod
    def of(cls, session: Session, skeleton: Skeleton) -> Studio:
        up = session.up_camera or (0.0, -1.0, 0.0)
        camera = session.camera.without_distortion()
        return cls(session, camera, skeleton, form_of(skeleton), view_rotations(up))

    def main(
        self, image: Picture | None, frame: int, pose: Pose | None, size: Size, paint: Paint
    ) -> Picture:
        """The body over the rectified frame, as large as it fits, on a dark sheet of that size.

        image: None where the video has lost the frame.
        """
        inner = _fitting((self.camera.width, self.camera.height), size)
        view = ViewCamera.of(self.camera).resized(*inner)
        picture = _resized(ground_of(self.camera, image), inner)
        if pose is not None:
            Ts = pose_transforms(self.skeleton, pose)
            picture = paint_over(picture, view, self.form, Ts, paint.style, paint.opacity)
        return _on_sheet(labelled(picture, frame) if image is None else picture, size)

    def four(
        self,
        image: Picture | None,
        frame: int,
        pose: Pose | None,
        size: Size,
        paint: Paint,
        framing: Framing | None = None,
        surface: SurfaceLayer | None = None,
    ) -> Picture:
        """All four views, as large as they fit, on a dark sheet of that size; `surface`, a surface
        that was observed, in the three small ones."""
        label = f"Frame {frame}" + (" is missing" if image is None else "")
        picture = four_views(
            ground_of(self.camera, image), self.camera, self.skeleton, pose, paint.style,
            paint.opacity, self.height_of_four(size), label, self.Rs, framing, surface,
        )  # fmt: skip
        return _on_sheet(picture, size)

    def parallel(
        self,
        view: ViewName,
        pose: Pose | None,
        size: Size,
        framing: Framing | None = None,
        surface: SurfaceLayer | None = None,
    ) -> Picture:
        """From the top, the side or the front."""
        framing = framing or Framing()
        centre, across = framing.centre_m, framing.metres_across
        return orthographic(self.skeleton, pose, view, size, centre, across, self.Rs, surface)

    def perspective(
        self,
        view: ViewCamera,
        ground: Ground,
        p_camera_centre: Array,
        pose: Pose | None,
        surface: SurfaceLayer | None = None,
    ) -> Picture:
        """From a new viewpoint, on a floor."""
        Ts = None if pose is None else pose_transforms(self.skeleton, pose)
        picture = floor_picture(view, ground, p_camera_centre, self.form, Ts)
        if Ts is not None:
            picture = paint_over(picture, view, self.form, Ts, SOLID.style, SOLID.opacity)
        return picture if surface is None else draw_surface(picture, view, surface, self.form, Ts)

    def cut_out_by(self, view: ViewCamera, pose: Pose, paint: Paint = SOLID) -> CutOut:
        """The body on nothing."""
        Ts = pose_transforms(self.skeleton, pose)
        return cut_out(view, self.form, Ts, paint.style, paint.opacity)

    def main_cut_out(self, pose: Pose, size: Size, paint: Paint) -> CutOut:
        """The body of `main` on nothing."""
        inner = _fitting((self.camera.width, self.camera.height), size)
        view = ViewCamera.of(self.camera).resized(*inner)
        return _on_sheet(self.cut_out_by(view, pose, paint), size)

    def parallel_cut_out(self, view: ViewName, pose: Pose, size: Size) -> CutOut:
        """The body of `parallel` on nothing."""
        view_camera = parallel_view(self.skeleton, pose, view, size, Framing(Rs=self.Rs))
        return self.cut_out_by(view_camera, pose)

    def four_cut_out(self, pose: Pose, size: Size, paint: Paint) -> CutOut:
        """The four bodies of `four` on nothing, each in its place."""
        places = FourViewLayout.of(self.camera, self.height_of_four(size))
        main = self.main_cut_out(pose, places.main, paint)
        if not places.small:
            return _on_sheet(main, size)
        sheet = np.zeros((places.main[1], places.width, 4), dtype=np.uint8)
        sheet[:, : places.main[0]] = main
        framing = framing_of(posed_points(self.skeleton, pose), places.views, self.Rs)
        top, left = 0, places.main[0] + places.gap
        for view, small in places.views.items():
            view_camera = parallel_view(self.skeleton, pose, view, small, framing)
            sheet[top : top + small[1], left:] = self.cut_out_by(view_camera, pose)
            top += small[1] + places.gap
        return _on_sheet(sheet, size)

    def height_of_four(self, size: Size) -> int:
        """The largest height at which all four views fit into a picture of that size."""
        height = size[1]
        while height > 1 and (excess := FourViewLayout.of(self.camera, height).width - size[0]) > 0:
            height -= max(1, int(excess * height / (size[0] + excess) / 2))
        return height


def _fitting(inner: Size, outer: Size) -> Size:
    """`inner` as large as it fits into `outer`, its shape kept."""
    scale = min(outer[0] / inner[0], outer[1] / inner[1])
    width, height = (
        max(1, min(round(side * scale), most)) for side, most in zip(inner, outer, strict=True)
    )
    return width, height


def _resized(picture: Picture, size: Size) -> Picture:
    """Itself where it has that size already."""
    height, width = picture.shape[:2]
    if (width, height) == size:
        return picture
    smooth = cv2.INTER_CUBIC if size[1] > height else cv2.INTER_AREA
    return np.asarray(cv2.resize(picture, size, interpolation=smooth), np.uint8)


def _on_sheet(picture: Picture, size: Size) -> Picture:
    """The picture in the middle of a sheet: dark, or nothing under what is on nothing."""
    height, width, channels = picture.shape
    if (width, height) == size:
        return picture
    colour = GAP if channels == 3 else (0, 0, 0, 0)
    sheet = np.full((size[1], size[0], channels), colour, dtype=np.uint8)
    left, top = (size[0] - width) // 2, (size[1] - height) // 2
    sheet[top : top + height, left : left + width] = picture
    return sheet
