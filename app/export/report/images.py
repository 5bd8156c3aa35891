"""Pictures of a session inside the page: small overlays, and all four views where a look is due."""

from __future__ import annotations

import base64

import cv2

from keypose.app.export.report.markup import Html, element
from keypose.app.export.report.subject import Subject
from keypose.app.render.palette import Picture
from keypose.app.render.studio import ViewStyle, snapshot
from keypose.tracker.errors import FormatError
from keypose.tracker.video import MissingFrame, Video

QUALITY = 86
"""Of JPEG; a thumbnail of 320 pixels takes about 15 kB."""


def thumbnail(
    subject: Subject,
    video: Video | None,
    frame: int,
    width_px: int = 320,
    look: ViewStyle | None = None,
) -> Html | None:
    """The body over the video's frame, and those beside it, at most this wide; None where nothing
    can be shown."""
    pose = subject.poses.pose(frame)
    if pose is None or video is None:
        return None
    try:
        video.frame(frame)
    except MissingFrame:
        return None
    beside = subject.poses.figures_beside(frame)
    picture = snapshot(subject.session, video, frame, pose, look or ViewStyle(), beside)
    return embedded(_no_wider(picture, width_px), f"Frame {frame} with the body")


def embedded(picture: Picture, words: str) -> Html:
    """A picture inside the page."""
    height, width = picture.shape[:2]
    content = base64.b64encode(jpeg(picture)).decode()
    return element(
        "img",
        src=f"data:image/jpeg;base64,{content}",
        width=width,
        height=height,
        alt=words,
    )


def jpeg(picture: Picture) -> bytes:
    """The picture as a JPEG file."""
    settings = [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
    good, content = cv2.imencode(".jpg", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), settings)
    if not good:
        raise FormatError("A picture of the report is too large for JPEG.")
    return content.tobytes()


def _no_wider(picture: Picture, width_px: int) -> Picture:
    height, width = picture.shape[:2]
    if width <= width_px:
        return picture
    size = (width_px, max(1, round(height * width_px / width)))
    small: Picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)  # type: ignore[assignment]
    return small
