"""A picture of one frame: the page and the command line draw it here, hence alike."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import cv2
import numpy as np

from keypose.app.posing import view_rotations
from keypose.app.render.lettering import plate, written_width
from keypose.app.render.painting import Style
from keypose.app.render.palette import CutOut, Picture
from keypose.app.render.pictures import OPACITY, four_views, orthographic, overlay
from keypose.app.render.surfaces import SurfaceLayers
from keypose.app.render.tints import Tint
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session.schema import Session
from keypose.tracker.video import MissingFrame, Video

View: TypeAlias = Literal["main", "top", "side", "front", "all"]


@dataclass(frozen=True)
class Look:
    """Which view, and how the body is drawn over the video. tint: of observed surfaces."""

    view: View = "main"
    style: Style = "both"
    opacity: float = OPACITY
    tint: Tint = "clay"


def snapshot(session: Session, video: Video | None, frame: int, pose: Pose, look: Look) -> Picture:
    """The picture (H, W, 3) RGB of a pose at a frame; its height is the video's.

    Where the video has lost the frame, its place is grey and a plate says so. The views from the
    top, the side and the front need no video; with observed surfaces at hand they show them.
    """
    camera, skeleton = session.camera.without_distortion(), Skeleton.of(session.body)
    size = (camera.width, camera.height)
    Rs = view_rotations(session.up_camera or (0.0, -1.0, 0.0))
    layers = SurfaceLayers.of(session, video, look.tint)
    surface = None if layers is None or look.view == "main" else layers.at(frame, pose)
    if look.view != "main" and look.view != "all":
        return orthographic(skeleton, pose, look.view, size, Rs_view_camera=Rs, surface=surface)
    image = background(session, video, layers, frame, pose)
    label = f"Frame {frame}" + (" is missing" if image is None else "")
    ground = ground_of(camera, image)
    if look.view == "main":
        picture = overlay(ground, camera, skeleton, pose, look.style, look.opacity)
        return picture if image is not None else labelled(picture, frame)
    return four_views(
        ground, camera, skeleton, pose, look.style, look.opacity, camera.height, label, Rs,
        surface=surface,
    )  # fmt: skip


def ground_of(camera: Camera, image: Picture | None) -> Picture:
    """The image, or grey where there is none."""
    if image is not None:
        return image
    return np.full((camera.height, camera.width, 3), 128, dtype=np.uint8)


def labelled(picture: Picture, frame: int) -> Picture:
    """The picture of a frame that the video has lost, saying so."""
    return _with_plate(picture, f"Frame {frame} is missing")


def png(picture: Picture | CutOut) -> bytes:
    """The picture as a PNG file, with how much it covers where that is known."""
    smaller = [cv2.IMWRITE_PNG_COMPRESSION, 6]
    order = cv2.COLOR_RGB2BGR if picture.shape[2] == 3 else cv2.COLOR_RGBA2BGRA
    good, content = cv2.imencode(".png", cv2.cvtColor(picture, order), smaller)
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
    """What the camera sees behind the body: of observed surfaces the tinted one; None where the
    frame is lost."""
    if layers is None or layers.is_clay:
        return rectified(session, video, frame)
    return layers.picture(frame, pose)


def rectified(session: Session, video: Video | None, frame: int) -> Picture | None:
    """The video's frame without the lens's distortion; None when the video has lost it."""
    if video is None:
        return None
    try:
        return session.camera.rectify(video.frame(frame))
    except MissingFrame:
        return None


def _with_plate(picture: Picture, words: str) -> Picture:
    height, width = picture.shape[:2]
    widest = 0.9 * width / (2.2 + written_width(words, 100.0) / 100.0)  # with what is around it
    height_px = min(max(10.0, height / 40), widest)
    plate(picture, words, *(round(0.8 * height_px),) * 2, height_px)
    return picture
