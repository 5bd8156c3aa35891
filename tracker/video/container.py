"""Opening a media file, and its pictures in the order they are shown.

Decoder errors become a VideoError of one sentence, or a missing picture.
"""

from __future__ import annotations

import io
import stat
from collections.abc import Iterator
from pathlib import Path

import av
import av.error
from av.container import InputContainer
from av.video.stream import VideoStream

from keypose.tracker.errors import VideoError
from keypose.tracker.files import read_head

# Only demuxers that read one local file. Playlists (HLS, DASH, concat) and numbered image
# patterns would let a file name other files, or addresses on the network.
_DEMUXERS = (
    "mov,matroska,webm,avi,mpegts,mpeg,mpegvideo,m4v,h263,h264,hevc,vvc,vc1,dirac,ivf,obu,av1,"
    "flv,asf,ogg,gif,apng,mjpeg,mjpeg_2000,yuv4mpegpipe,mxf,dv,nut,rm,wtv,swf,"
    "png_pipe,jpeg_pipe,bmp_pipe,tiff_pipe,webp_pipe,ppm_pipe,pgm_pipe"
)
SUFFIXES = (
    *(".mp4", ".mov", ".m4v", ".qt", ".3gp", ".3g2", ".f4v", ".mkv", ".webm", ".avi"),
    *(".ts", ".mts", ".m2ts", ".mpg", ".mpeg", ".m2v", ".vob", ".flv", ".wmv", ".asf", ".ogv"),
    *(".gif", ".apng", ".mjpeg", ".mjpg", ".y4m", ".mxf", ".dv", ".nut", ".rm", ".wtv"),
    *(".h264", ".hevc", ".ivf", ".obu"),
)
"""What the files that these read are called: those that are offered to be opened. A file of any
other name is read all the same when it is named."""

UNREAD_IMAGES = {
    ".exr": "OpenEXR",
    ".dpx": "DPX",
    ".cin": "Cineon",
    ".hdr": "Radiance",
    ".tga": "TGA",
    ".heic": "HEIC",
    ".heif": "HEIF",
    ".avif": "AVIF",
    ".jxl": "JPEG XL",
    ".jp2": "JPEG 2000",
    ".j2k": "JPEG 2000",
    ".j2c": "JPEG 2000",
    ".psd": "Photoshop",
    ".sgi": "SGI",
    **dict.fromkeys((".dng", ".cr2", ".cr3", ".nef", ".arw", ".raf", ".orf", ".rw2"), "raw"),
}
"""Kinds of image files that are not read, by how they end."""
CONVERT_IMAGES = "convert them to PNG, or to TIFF of 16 bits, in the colours of a screen (sRGB)"

_OPTIONS = {"format_whitelist": _DEMUXERS, "protocol_whitelist": "file"}

PYAV_ERRORS = (av.error.FFmpegError, ValueError, ArithmeticError, LookupError, RuntimeError)
"""What PyAV raises on what a file says: FFmpeg's errors, and those of turning the file's numbers
and texts into Python's (UnicodeDecodeError, OverflowError …). To be caught around calls of PyAV
alone, where none of our own code runs."""

# What a decoder hides in a damaged picture depends on how many threads share it. The number is
# fixed so that every machine sees the same pictures.
_THREADS = 4


def open_container(path: Path) -> InputContainer:
    """The file at `path`, opened. Raises VideoError when it is no readable media file."""
    _check_file(path)
    try:
        return demux(f"file:{path}")
    except PermissionError as error:
        raise not_permitted(path) from error
    except PYAV_ERRORS as error:
        raise VideoError(_unreadable(path)) from error


def demux(file: str | io.BytesIO) -> InputContainer:
    """A media file opened by PyAV, whose errors (PYAV_ERRORS) are the caller's to catch.

    Titles and artists are ignored: many are not UTF-8, and none may prevent opening a film.
    """
    return av.open(file, "r", options=_OPTIONS, metadata_errors="replace")


def picture_stream(path: Path, container: InputContainer, threaded: bool = True) -> VideoStream:
    """The first stream of moving pictures. Raises VideoError when there is none to decode."""
    try:
        return _picture_stream(path, container, threaded)
    except PYAV_ERRORS as error:
        raise VideoError(_undecodable(path)) from error


def _picture_stream(path: Path, container: InputContainer, threaded: bool) -> VideoStream:
    streams = [s for s in container.streams.video if not _is_cover(s)]
    if not streams:
        holds = "sound but no pictures" if container.streams.audio else "no pictures"
        raise VideoError(f'"{path.name}" holds {holds}: choose a video with at least one frame.')
    stream = streams[0]
    # Without a decoder there is no context, whatever the annotation says.
    if getattr(stream, "codec_context", None) is None:
        raise VideoError(_undecodable(path))
    stream.thread_type = "AUTO" if threaded else "NONE"
    stream.codec_context.thread_count = _THREADS if threaded else 1
    return stream


def decode(
    stream: VideoStream, packet: av.Packet[VideoStream] | None
) -> list[av.VideoFrame | None]:
    """The decoder's frames for one packet (None: the end); None where it failed."""
    try:
        return list(stream.codec_context.decode(packet))
    except av.error.MemoryError:
        raise
    except PYAV_ERRORS:
        return [None]


def packets(
    path: Path, container: InputContainer, stream: VideoStream
) -> Iterator[av.Packet[VideoStream]]:
    """The packets of the stream from here on, as far as the container can be read.

    Raises VideoError when the file can no longer be read.
    """
    try:
        for packet in container.demux(stream):
            if packet.size:  # the last one is empty and marks the end
                yield packet
    except av.error.InvalidDataError:
        return  # what follows the damage cannot be distinguished from noise
    except PYAV_ERRORS as error:
        raise VideoError(
            f'"{path.name}" could not be read to its end: check the disk or connection it is on.'
        ) from error


def decode_packets(
    path: Path, container: InputContainer, stream: VideoStream
) -> Iterator[av.VideoFrame | None]:
    """Frames from here on in the order they are shown, None where the decoder gave up on one."""
    for packet in packets(path, container, stream):
        yield from decode(stream, packet)
    yield from decode(stream, None)


def tags_of(frame: av.VideoFrame) -> dict[str, str]:
    """What a picture says of itself, such as its EXIF tags; nothing where that cannot be
    read.
    """
    try:
        return dict(frame.metadata)
    except PYAV_ERRORS:
        return {}


def not_permitted(path: Path) -> VideoError:
    """The error for a file or folder without permission to read."""
    return VideoError(
        f'"{path.name}" may not be read: give yourself permission, or choose a copy you may read.'
    )


def _check_file(path: Path) -> None:
    """Raises VideoError where a look at the file is enough to refuse it."""
    try:
        status = path.stat()
    except PermissionError as error:
        raise not_permitted(path) from error
    except (OSError, ValueError) as error:
        raise VideoError(f'There is no file "{path}": check the name and the folder.') from error
    if not stat.S_ISREG(status.st_mode):
        raise VideoError(f'"{path.name}" is neither a file nor a folder: choose a video file.')
    if status.st_size == 0:
        raise VideoError(f'"{path.name}" is empty: copy it again, or choose another video.')


def _is_cover(stream: VideoStream) -> bool:
    """True for cover art, which is no video."""
    return av.stream.Disposition.attached_pic in stream.disposition


def _undecodable(path: Path) -> str:
    return f'"{path.name}" is coded in a way Keypose cannot decode: convert it to H.264 in MP4.'


def _unreadable(path: Path) -> str:
    kind = UNREAD_IMAGES.get(path.suffix.lower())
    if kind is not None:
        return (
            f'"{path.name}" is an image of a kind that is not read, {kind}: put all images of the '
            f"film into a folder, {CONVERT_IMAGES}, and open the folder."
        )
    try:
        head = read_head(path, 12)
    except OSError:
        return f'"{path.name}" can no longer be read: put it back, or choose another video.'
    if head[4:8] == b"ftyp":
        return (
            f'"{path.name}" is incomplete, its table of frames is absent or damaged: '
            "copy it again from where it was recorded."
        )
    return (
        f'"{path.name}" is not a video that Keypose can read: '
        "choose a video file, or convert this one to H.264 in MP4."
    )
