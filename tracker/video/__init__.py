"""Decode the frames of a video or a folder of images by exact number; nothing else decodes.

    with Video.open("jump.mp4") as video:
        picture = video.frame(12)                       # (height, width, 3) uint8 RGB
        for number, picture in video.frames(0, 30):     # picture is None where one is missing
            ...

A frame's number is its place in the order of presentation. It never shifts: a frame that cannot
be decoded keeps its number and is reported missing. One that can, but shows something wrong
because it is built on what is lost, is reported damaged once it has been examined:
`sound_frames` leaves such frames out.

What a picture is:

- upright: rotation and mirroring asked for by the file are applied here, once;
- progressive: an interlaced frame is made one (`VideoInfo.deinterlaced`), unless its two fields are
  to stay woven;
- as stored otherwise: pixels that are not square stay so (`VideoInfo.pixel_aspect`);
- 8-bit RGB without alpha, whatever the depth and colour model of the file; of images of 16 bits
  that use fewer, those that are used (`VideoInfo.depth`).
"""

from __future__ import annotations

from keypose.tracker.video.damage import Examined
from keypose.tracker.video.info import MissingFrame, VideoInfo
from keypose.tracker.video.video import READ_AGAIN_BYTES, READ_ONCE_BYTES, Video

__all__ = ["READ_AGAIN_BYTES", "READ_ONCE_BYTES", "Examined", "MissingFrame", "Video", "VideoInfo"]
