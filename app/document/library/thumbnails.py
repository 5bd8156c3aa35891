"""Small pictures of sessions: the middle keyframe's frame, cut to the body in it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.app.document.library.recents import middle_frame
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session.schema import Session
from keypose.tracker.video import Video
from keypose.tracker.video.glimpse import first_picture
from keypose.tracker.video.picture import Picture

WIDTH, HEIGHT = 192, 112
QUALITY = 82
ROOM = 1.2
"""The picture's height over the body's, where the video is large enough."""


def thumbnail(session: Session, video: Video) -> bytes:
    """A JPEG of WIDTH × HEIGHT pixels. VideoError when the frame cannot be decoded."""
    frame = middle_frame(session)
    picture = video.frame(frame)
    height, width = picture.shape[:2]
    (u, v), extent = _body(session, frame)
    largest = min(width / WIDTH, height / HEIGHT)
    scale = float(np.clip(ROOM * extent / HEIGHT, min(1.0, largest), largest))
    wide, high = int(WIDTH * scale), int(HEIGHT * scale)
    left = int(np.clip(u - wide / 2, 0, width - wide))
    top = int(np.clip(v - high / 2, 0, height - high))
    return _jpeg(picture[top : top + high, left : left + wide])


def glimpse(path: Path) -> bytes:
    """The same size of the first picture of a film or a folder of images, its middle. VideoError
    when there is none."""
    picture = first_picture(path)
    height, width = picture.shape[:2]
    scale = min(width / WIDTH, height / HEIGHT)
    wide, high = max(1, int(WIDTH * scale)), max(1, int(HEIGHT * scale))
    left, top = (width - wide) // 2, (height - high) // 2
    return _jpeg(picture[top : top + high, left : left + wide])


def _jpeg(cut: Picture) -> bytes:
    small = cv2.resize(cut, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    fine, content = cv2.imencode(
        ".jpg", cv2.cvtColor(small, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
    )
    if not fine:
        raise ValueError("the picture cannot be coded")
    return content.tobytes()


def _body(session: Session, frame: int) -> tuple[NDArray[np.float64], float]:
    """(2,) where the joints lie on average, and how far they reach in v; without a pose all."""
    camera = session.camera
    everything = np.array([camera.width / 2, camera.height / 2]), float(camera.height)
    posed = [k for k in (*session.keyframes, *session.drafts) if k.frame == frame]
    if not posed:
        return everything
    skeleton = Skeleton.of(session.body)
    Ts_camera_part = pose_transforms(skeleton, posed[0].pose(skeleton))
    uv = camera.project(Ts_camera_part[:, :3, 3])
    if not np.isfinite(uv).all():
        return everything
    return uv.mean(axis=0), float(np.ptp(uv[:, 1]))
