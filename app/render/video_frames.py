"""The video's frames as JPEG, for the page: without the lens's distortion, each made once."""

from __future__ import annotations

import asyncio
import textwrap
from collections import OrderedDict
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np

from keypose.app.render.lettering import plate
from keypose.app.render.palette import Picture
from keypose.tracker.errors import VideoError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.video import MissingFrame, Video
from keypose.tracker.video.picture import shrunk

CACHE_BYTES = 192 * 2**20
QUALITY = 88


class Frames:
    """JPEGs by frame number; the decoder works in one thread, so that frames come in turn."""

    def __init__(self, video: Video) -> None:
        self._video = video
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="frames")
        self._made: OrderedDict[tuple[int, str, int], bytes] = OrderedDict()
        self._bytes = 0
        self._closed = False

    async def jpeg(self, index: int, camera: Camera, version: str, shrink: int = 1) -> bytes:
        """Frame `index` as this camera would have taken it with an ideal lens, with a pixel for
        every shrink × shrink.

        version: another one for another lens, of which a picture is kept.
        VideoError where the video has no such frame.
        """
        which = (index, version, shrink)
        kept_jpeg = self._made.get(which)
        if kept_jpeg is not None:
            self._made.move_to_end(which)
            return kept_jpeg
        loop = asyncio.get_running_loop()
        try:
            made = await loop.run_in_executor(self._pool, self._make, index, camera, shrink)
        except asyncio.CancelledError:
            if self._closed:
                raise VideoError("The video has been closed.") from None
            raise
        self._keep(which, made)
        return made

    def close(self) -> None:
        """End the thread; the video stays open."""
        self._closed = True
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _make(self, index: int, camera: Camera, shrink: int) -> bytes:
        if camera.is_distorted:  # its numbers are those of the whole picture
            picture = shrunk(camera.rectify(frame_or_grey(self._video, index)), shrink)
        else:
            picture = frame_or_grey(self._video, index, shrink)
        swapped = cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
        good, content = cv2.imencode(".jpg", swapped, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        assert good
        return content.tobytes()

    def _keep(self, key: tuple[int, str, int], made: bytes) -> None:
        if key in self._made:
            return
        self._made[key] = made
        self._bytes += len(made)
        while self._bytes > CACHE_BYTES:
            _, gone = self._made.popitem(last=False)
            self._bytes -= len(gone)


def frame_or_grey(video: Video, index: int, shrink: int = 1) -> Picture:
    """A frame, or a grey picture that says that it is missing; of a mesh, what is wrong with it.
    With a pixel for every shrink × shrink."""
    try:
        return video.frame(index, shrink)
    except MissingFrame as missing:
        info = video.info
        grey = np.full((info.height, info.width, 3), 96, dtype=np.uint8)
        letter_px = max(10.0, info.height / 24)
        if missing.reason:
            _plates(grey, missing.reason, 0.7 * letter_px)
        else:
            margin_px = round(letter_px)
            plate(grey, f"Frame {index} is damaged", margin_px, margin_px, letter_px)
        return shrunk(grey, shrink)


def _plates(picture: Picture, sentence: str, letter_px: float) -> None:
    """A sentence on as many plates, one below the other, as it takes."""
    columns = int(picture.shape[1] / letter_px)  # a letter is narrower than it is high
    for row, line in enumerate(textwrap.wrap(sentence, columns)):
        plate(picture, line, round(letter_px), round((1 + 2.4 * row) * letter_px), letter_px)
