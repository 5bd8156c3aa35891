"""Draw a session at any size and from anywhere, over the video or on nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import cv2
import numpy as np

from keypose.app.orders.drawing import Paint, Size, Style, Tint, View
from keypose.app.posing import view_rotations
from keypose.app.render.lettering import plate, written_width
from keypose.app.render.painting import (
    Figure,
    Form,
    cut_out_figures,
    form_of,
    paint_figures,
)
from keypose.app.render.palette import GAP, CutOut, Picture
from keypose.app.render.pictures import (
    OPACITY,
    FourViewLayout,
    Framing,
    Rotations,
    four_views,
    framing_of,
    orthographic,
    overlay,
    parallel_view,
    with_posed,
)
from keypose.app.render.surfaces import SurfaceLayer, SurfaceLayers, draw_surface
from keypose.app.render.viewpoints import Ground, floor_picture
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera, ViewName
from keypose.tracker.session.schema import Session
from keypose.tracker.video import MissingFrame, Video


@dataclass(frozen=True)
class ViewStyle:
    """Which view, and how the body is drawn over the video. tint: of observed surfaces."""

    view: View = "main"
    style: Style = "both"
    opacity: float = OPACITY
    tint: Tint = "clay"


def snapshot(
    session: Session,
    video: Video | None,
    frame: int,
    pose: Pose,
    look: ViewStyle,
    beside: Sequence[Figure] = (),
) -> Picture:
    """The picture (H, W, 3) RGB of a pose at a frame, and of bodies beside it; its height is the
    video's.

    Where the video has lost the frame, its place is grey and a plate says so. The views from the
    top, the side and the front need no video; with observed surfaces at hand they show them.
    """
    skeleton = Skeleton.of(session.subject.body)
    studio = Studio.of(session, skeleton).at(frame)
    camera, Rs = studio.camera, studio.Rs
    size = (camera.width, camera.height)
    layers = SurfaceLayers.of(session, video, look.tint)
    surface = None if layers is None or look.view == "main" else layers.at(frame, pose)
    if look.view != "main" and look.view != "all":
        return orthographic(
            skeleton, pose, look.view, size, Rs_view_camera=Rs, surface=surface, beside=beside
        )
    image = background(session, video, layers, frame, pose)
    label = f"Frame {frame}" + (" is missing" if image is None else "")
    ground = ground_of(camera, image)
    if look.view == "main":
        picture = overlay(ground, camera, skeleton, pose, look.style, look.opacity, beside)
        return picture if image is not None else labelled(picture, frame)
    return four_views(
        ground,
        camera,
        skeleton,
        pose,
        look.style,
        look.opacity,
        camera.height,
        label,
        Rs,
        surface=surface,
        beside=beside,
    )


def ground_of(camera: Camera, image: Picture | None) -> Picture:
    """The image, or grey where there is none."""
    if image is not None:
        return image
    return np.full((camera.height, camera.width, 3), 128, dtype=np.uint8)


def labelled(picture: Picture, frame: int) -> Picture:
    """The picture of a frame that the video has lost, saying so."""
    return _with_plate(picture, f"Frame {frame} is missing")


def png(picture: Picture | CutOut) -> bytes:
    """The picture as a PNG file, with how much it covers where that is known; grey (H, W) too."""
    smaller = [cv2.IMWRITE_PNG_COMPRESSION, 6]
    if picture.ndim == 3:
        order = cv2.COLOR_RGB2BGR if picture.shape[2] == 3 else cv2.COLOR_RGBA2BGRA
        picture = np.asarray(cv2.cvtColor(picture, order), np.uint8)
    good, content = cv2.imencode(".png", picture, smaller)
    if not good:
        raise FormatError("The picture cannot be written as PNG.")
    return content.tobytes()


def background(
    session: Session,
    video: Video | None,
    layers: SurfaceLayers | None,
    frame: int,
    pose: Pose | None,
) -> Picture | None:
    """What the camera sees behind the body: of observed surfaces the tinted one; None where
    the frame is lost.
    """
    if layers is None or layers.is_clay:
        return rectified(session, video, frame)
    return layers.picture(frame, pose)


def rectified(session: Session, video: Video | None, frame: int) -> Picture | None:
    """The video's frame without the lens's distortion; None when the video has lost it."""
    if video is None:
        return None
    try:
        return session.view.camera.rectify(video.frame(frame))
    except MissingFrame:
        return None


def _with_plate(picture: Picture, words: str) -> Picture:
    height, width = picture.shape[:2]
    widest = 0.9 * width / (2.2 + written_width(words, 100.0) / 100.0)  # with what is around it
    height_px = min(max(10.0, height / 40), widest)
    plate(picture, words, *(round(0.8 * height_px),) * 2, height_px)
    return picture


SOLID = Paint("solid", 1.0)
Others: TypeAlias = Callable[[int], tuple[Figure, ...]]
"""The bodies beside the posed one at a frame."""


def _nobody(_frame: int) -> tuple[Figure, ...]:
    return ()


@dataclass(frozen=True, eq=False)
class Studio:
    """Where a session's pictures are made. camera: with an ideal lens. Rs: the level views, in the
    camera frame; before a camera that moves they are those of the film's first frame, the world.
    others: bodies beside the posed one at a frame.  beside: those of the frame it is made for.
    """

    session: Session
    camera: Camera
    skeleton: Skeleton
    form: Form
    Rs: Rotations
    others: Others = _nobody
    beside: tuple[Figure, ...] = ()

    @classmethod
    def of(cls, session: Session, skeleton: Skeleton, others: Others = _nobody) -> Studio:
        camera, Rs = session.view.camera.without_distortion(), view_rotations(session.world.up)
        return cls(session, camera, skeleton, form_of(skeleton), Rs, others)

    def at(self, frame: int) -> Studio:
        """The same as the camera sees it at a frame; itself where that stands still and nobody is
        beside the body."""
        beside, path = self.others(frame), self.session.camera_path
        if beside or self.beside:
            self = replace(self, beside=beside)
        if path is None:
            return self
        R = path.Ts_camera_world[frame, :3, :3]
        camera = self.session.film_camera.at(frame).without_distortion()
        return replace(self, camera=camera, Rs={name: own @ R.T for name, own in self.Rs.items()})

    def main(
        self, image: Picture | None, frame: int, pose: Pose | None, size: Size, paint: Paint
    ) -> Picture:
        """The body over the rectified frame, as large as it fits, on a dark sheet of that size.

        image: None where the video has lost the frame.
        """
        inner = _fitting((self.camera.width, self.camera.height), size)
        view = ViewCamera.of(self.camera).resized(*inner)
        picture = _resized(ground_of(self.camera, image), inner)
        figures = self._figures(pose)
        picture = paint_figures(picture, view, figures, paint.style, paint.opacity)
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
            ground_of(self.camera, image),
            self.camera,
            self.skeleton,
            pose,
            paint.style,
            paint.opacity,
            self.height_of_four(size),
            label,
            self.Rs,
            framing,
            surface,
            self.beside,
        )
        return _on_sheet(picture, size)

    def parallel(
        self,
        view: ViewName,
        pose: Pose | None,
        size: Size,
        framing: Framing | None = None,
        surface: SurfaceLayer | None = None,
    ) -> Picture:
        """Draw from the top, the side or the front."""
        framing = framing or Framing()
        centre, across = framing.centre_m, framing.metres_across
        return orthographic(
            self.skeleton, pose, view, size, centre, across, self.Rs, surface, self.beside
        )

    def perspective(
        self,
        view: ViewCamera,
        ground: Ground,
        p_camera_centre: Array,
        pose: Pose | None,
        surface: SurfaceLayer | None = None,
    ) -> Picture:
        """Draw from a new viewpoint, on a floor."""
        Ts = None if pose is None else pose_transforms(self.skeleton, pose)
        picture = floor_picture(view, ground, p_camera_centre, self.form, Ts)
        figures = self._figures(pose)
        picture = paint_figures(picture, view, figures, SOLID.style, SOLID.opacity)
        return picture if surface is None else draw_surface(picture, view, surface, self.form, Ts)

    def cut_out_by(self, view: ViewCamera, pose: Pose, paint: Paint = SOLID) -> CutOut:
        """The body, and those beside it, on nothing."""
        return cut_out_figures(view, self._figures(pose), paint.style, paint.opacity)

    def _figures(self, pose: Pose | None) -> tuple[Figure, ...]:
        return with_posed(self.skeleton, pose, self.beside)

    def points(self, pose: Pose | None) -> Array:
        """(N, 3) the corners of all bodies in the camera frame."""
        return np.concatenate([figure.points for figure in self._figures(pose)])

    def main_cut_out(self, pose: Pose, size: Size, paint: Paint) -> CutOut:
        """The body of `main` on nothing."""
        inner = _fitting((self.camera.width, self.camera.height), size)
        view = ViewCamera.of(self.camera).resized(*inner)
        return _on_sheet(self.cut_out_by(view, pose, paint), size)

    def parallel_cut_out(self, view: ViewName, pose: Pose, size: Size) -> CutOut:
        """The body of `parallel` on nothing."""
        view_camera = parallel_view(self.points(pose), view, size, Framing(Rs=self.Rs))
        return self.cut_out_by(view_camera, pose)

    def four_cut_out(self, pose: Pose, size: Size, paint: Paint) -> CutOut:
        """The four bodies of `four` on nothing, each in its place."""
        places = FourViewLayout.of(self.camera, self.height_of_four(size))
        main = self.main_cut_out(pose, places.main, paint)
        if not places.small:
            return _on_sheet(main, size)
        sheet = np.zeros((places.main[1], places.width, 4), dtype=np.uint8)
        sheet[:, : places.main[0]] = main
        framing = framing_of(self.points(pose), places.views, self.Rs)
        top, left = 0, places.main[0] + places.gap
        for view, small in places.views.items():
            view_camera = parallel_view(self.points(pose), view, small, framing)
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
