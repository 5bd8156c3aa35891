"""Draw and cache small pictures of sessions and files."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.app.document.library.recents import id_of, middle_frame
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeyposeError
from keypose.tracker.files import read_own
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.atomic import make_folder, write_file
from keypose.tracker.storage.files import load_session, open_video_of
from keypose.tracker.video import Video
from keypose.tracker.video.glimpse import first_picture
from keypose.tracker.video.picture import Picture

WIDTH = 192
HEIGHT = 112
"""Pixels."""
QUALITY = 82
"""Of a JPEG, from 0 to 100."""
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
    camera = session.film_camera.at(frame)
    everything = np.array([camera.width / 2, camera.height / 2]), float(camera.height)
    posed = [k for k in (*session.subject.keyframes, *session.subject.drafts) if k.frame == frame]
    if not posed:
        return everything
    skeleton = Skeleton.of(session.subject.body)
    Ts_camera_part = pose_transforms(skeleton, posed[0].pose(skeleton))
    uv = camera.project(Ts_camera_part[:, :3, 3])
    if not np.isfinite(uv).all():
        return everything
    return uv.mean(axis=0), float(np.ptp(uv[:, 1]))


MOST = 500
"""Pictures; beyond so many the oldest are removed, and made anew when they are asked for."""
_LARGEST_BYTES = 4 * 2**20
"""Of a picture that is kept."""


class ThumbCache:
    """folder: where they are kept."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def get(self, name: str, make: Callable[[], bytes | None]) -> bytes | None:
        """The picture of this name, made where it is not kept yet; None where there is none."""
        cached = self._folder / f"{name}.jpg"
        with suppress(OSError):
            return read_own(cached, _LARGEST_BYTES)
        content = make()
        if content is not None:
            with suppress(KeyposeError):  # then it is made anew the next time
                make_folder(self._folder)
                write_file(cached, content, overwrite=True)
                self._tidy()
        return content

    def of_file(self, path: Path) -> bytes | None:
        """The picture of a session, a video or a folder of images, as it is now. OSError
        where there is nothing.
        """
        facts = path.stat()
        identity = f"{path.absolute()}\0{facts.st_mtime_ns}\0{facts.st_size}"
        make = of_session if path.suffix.lower() == ".json" else _of_film
        return self.get(f"file-{id_of(identity)}", lambda: make(path))

    def _tidy(self) -> None:
        """Remove the oldest pictures beyond so many."""
        with suppress(OSError):  # what is left over does no harm
            kept = list(self._folder.glob("*.jpg"))
            if len(kept) > MOST:
                for old in sorted(kept, key=lambda f: f.stat().st_mtime)[:-MOST]:
                    old.unlink()


def of_session(path: Path) -> bytes | None:
    """The body in the middle keyframe; None where that cannot be had."""

    try:
        session = load_session(path)
        with open_video_of(session, path) as video:
            return thumbnail(session, video)
    except KeyposeError:
        return None


def _of_film(path: Path) -> bytes | None:

    try:
        return glimpse(path)
    except (KeyposeError, ValueError):
        return None
