"""Small clips whose every picture tells its own number, and a reader of that number."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
ROWS = 3
COLUMNS = 4
BITS = ROWS * COLUMNS - 2  # the first cell is always bright, the last always dark


def numbered_picture(number: int, width: int = 64, height: int = 48) -> Picture:
    """A picture of 3 × 4 cells, bright where `number` has a one. (height, width, 3) uint8."""
    bits = [(number >> bit) & 1 for bit in range(BITS)]
    cells = np.array([1, *bits, 0], dtype=np.uint8).reshape(ROWS, COLUMNS) * 150 + 50
    rows = np.arange(height) * ROWS // height
    columns = np.arange(width) * COLUMNS // width
    return np.repeat(cells[rows][:, columns][..., None], 3, axis=2)


def number_in(picture: Picture) -> int:
    """The number a picture tells; fails when it is not one of ours, the right way up."""
    height, width = picture.shape[:2]
    rows = (np.arange(ROWS) * 2 + 1) * height // (2 * ROWS)
    columns = (np.arange(COLUMNS) * 2 + 1) * width // (2 * COLUMNS)
    middle = [picture[r - 1 : r + 2, c - 1 : c + 2].mean() for r in rows for c in columns]
    bright = [bool(value > 125) for value in middle]
    assert (bright[0], bright[-1]) == (True, False), "the picture does not stand as it should"
    return sum(1 << bit for bit, on in enumerate(bright[1:-1]) if on)


@contextmanager
def scheduling_kept() -> Iterator[None]:
    """Afterwards the process is scheduled as before: where root runs it, SVT-AV1 makes the thread
    that encodes, and so every later browser and server of a test, a real-time one, before which
    everything else on the computer must wait."""
    if not hasattr(os, "sched_getscheduler"):
        yield
        return
    policy, parameter = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        yield
    finally:
        os.sched_setscheduler(0, policy, parameter)


def write_clip(
    path: Path,
    pictures: Sequence[Picture],
    *,
    codec: str = "libx264",
    pixels: str = "yuv420p",
    rate: int = 30,
    options: dict[str, str] | None = None,
    pts: Sequence[int] | None = None,
    time_base: Fraction | None = None,
    container_format: str | None = None,
    turn: tuple[Any, ...] | None = None,
    tags: dict[str, str] | None = None,
) -> Path:
    """Write `pictures` as a video; `turn` is what the file asks to be done before showing."""
    with scheduling_kept(), av.open(str(path), "w", format=container_format) as container:
        container.metadata.update(tags or {})
        stream: Any = container.add_stream(codec, rate=rate, options=options or {})
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = pixels
        if time_base is not None:
            stream.codec_context.time_base = time_base
        if turn is not None:
            stream.set_display_rotation(*turn)
        for number, picture in enumerate(pictures):
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            if pts is not None:
                frame.pts, frame.time_base = pts[number], time_base or Fraction(1, rate)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def write_numbered(path: Path, count: int, **how: Any) -> Path:
    """A clip of `count` numbered pictures; `how` as in `write_clip`."""
    return write_clip(path, [numbered_picture(number) for number in range(count)], **how)


def write_cut(path: Path, whole: Path, count: int) -> Path:
    """A clip without its first frames, as phones cut it: they are in the file and are not shown."""
    how = {"avoid_negative_ts": "disabled"}
    with av.open(str(whole)) as source, av.open(str(path), "w", options=how) as cut:
        before: Any = source.streams.video[0]
        stream = cut.add_stream_from_template(before)
        away = round(count / before.average_rate / before.time_base)
        for packet in source.demux(before):
            if packet.dts is not None and packet.pts is not None:
                packet.pts, packet.dts = packet.pts - away, packet.dts - away
                packet.stream = stream
                cut.mux(packet)
    return path


_HOLDING_EDITS = (b"moov", b"trak", b"edts")


def write_pieces(path: Path, whole: Path, pieces: Sequence[tuple[int, int]]) -> Path:
    """An MP4 that shows pieces of a clip at 30 frames a second: (first frame, frames) of each."""
    data = whole.read_bytes()
    movie, media = (
        struct.unpack(">I", data[at + 16 : at + 20])[0]
        for at in (data.index(b"mvhd"), data.index(b"mdhd"))
    )
    begins = struct.unpack(">i", data[(at := data.index(b"elst")) + 16 : at + 20])[0]
    edits = [
        struct.pack(">iihh", count * movie // 30, begins + first * media // 30, 1, 0)
        for first, count in pieces
    ]

    def copied(rest: bytes) -> bytes:
        out = b""
        while rest:
            size, kind = struct.unpack(">I4s", rest[:8])
            box, rest = rest[8:size], rest[size:]
            if kind == b"elst":
                box = struct.pack(">II", 0, len(edits)) + b"".join(edits)
            elif kind in _HOLDING_EDITS:
                box = copied(box)
            out += struct.pack(">I4s", len(box) + 8, kind) + box
        return out

    path.write_bytes(copied(data))
    return path


def write_sound(path: Path) -> Path:
    """A file with a tenth of a second of silence and no pictures."""
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream("aac", rate=48000, layout="mono")
        silence = np.zeros((1, 4800), dtype=np.float32)
        frame = av.AudioFrame.from_ndarray(silence, format="fltp", layout="mono")
        frame.sample_rate = 48000
        container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def write_image(path: Path, picture: Picture, codec: str = "png", pixels: str = "rgb24") -> Path:
    """One still image, whatever the name of the file."""
    encoder: Any = av.CodecContext.create(codec, "w")
    encoder.height, encoder.width = picture.shape[:2]
    encoder.pix_fmt, encoder.time_base = pixels, Fraction(1, 30)
    frame = av.VideoFrame.from_ndarray(picture, format="rgb24").reformat(format=pixels)
    path.write_bytes(b"".join(bytes(p) for p in [*encoder.encode(frame), *encoder.encode(None)]))
    return path


def ask_for_turn(jpeg: Path, orientation: int) -> Path:
    """Give a JPEG the note cameras leave: how the picture must be laid to stand upright."""
    entry = struct.pack(">HHIHH", 0x0112, 3, 1, orientation, 0)
    exif = b"Exif\0\0" + b"MM\0\x2a" + struct.pack(">IH", 8, 1) + entry + bytes(4)
    segment = b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif
    content = jpeg.read_bytes()
    jpeg.write_bytes(content[:2] + segment + content[2:])
    return jpeg


def damage_packet(path: Path, number: int) -> None:
    """Overwrite one packet of a file with what no decoder takes for a picture."""
    with av.open(str(path)) as container:
        packets = [bytes(packet) for packet in container.demux(video=0) if packet.size]
    content = path.read_bytes()
    assert content.count(packets[number]) == 1
    path.write_bytes(content.replace(packets[number], b"\x55" * len(packets[number])))


def decoded_plainly(path: Path) -> list[Picture]:
    """Every picture as stored, from one pass through the decoder with one thread."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        stream.thread_type = "NONE"
        frames = [f.to_ndarray(format="rgb24", threads=1) for f in container.decode(stream)]
    return [np.asarray(frame, dtype=np.uint8) for frame in frames]


def write_with_foreign_tags(path: Path, count: int, **how: Any) -> Path:
    """A sound film of numbered pictures whose title and artist are Latin-1, not UTF-8."""
    tags = {"title": "Cafe# au lait", "artist": "Jose# Muller"}
    write_numbered(path, count, tags=tags, **how)
    content = path.read_bytes()
    for text in tags.values():
        assert text.encode() in content
        foreign = text.replace("e#", "é ").encode("latin-1")  # as long as before
        content = content.replace(text.encode(), foreign)
    path.write_bytes(content)
    return path


def flip_bit(path: Path, packet: int, byte: int, bit: int = 0) -> None:
    """Turn one bit of one packet of a file, as a worn disk does."""
    with av.open(str(path)) as container:
        packets = [bytes(packet) for packet in container.demux(video=0) if packet.size]
    content = bytearray(path.read_bytes())
    start = content.index(packets[packet])
    content[start + byte] ^= 1 << bit
    path.write_bytes(content)
