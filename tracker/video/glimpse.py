"""The first picture of a video, without reading the file to its end: to be recognised by."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

from keypose.tracker.errors import VideoError
from keypose.tracker.video.container import decode_packets, open_container, picture_stream
from keypose.tracker.video.folder import first_image
from keypose.tracker.video.picture import Picture, PictureMaker, depth_of, orientation_of

MOST_FRAMES = 60
"""Decoded until one is whole: a recorder may begin in the middle of a group of pictures."""


def first_picture(path: Path) -> Picture:
    """The first picture (H, W, 3) RGB, upright, of a video file or a folder of images; VideoError
    where there is none."""
    if path.is_dir():
        path = first_image(path)
    with open_container(path) as container:
        stream = picture_stream(path, container, threaded=False)
        for frame in islice(decode_packets(path, container, stream), MOST_FRAMES):
            if frame is not None and not frame.is_corrupt:
                picture = PictureMaker(depth_of([frame])).picture_or_none(
                    frame, orientation_of(frame)
                )
                if picture is not None:
                    return picture
    raise VideoError(f'"{path.name}" has no picture near its beginning.')
