"""Whether an HEVC packet is decoded to its very end, neither less nor more.

FFmpeg's HEVC decoder does not say when it has lost its way: it makes garbage of what is left. But
it then ends at a wrong place, which shows from outside. One packet is decoded by itself, its
missing references being grey. Bytes added behind its end must change nothing, else the decoder has
read on beyond it; and other bytes in the place of the last ones must change something, else it
never came so far.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import cast

import av
from av.codec.context import CodecContext, Flags
from av.video.codeccontext import VideoCodecContext

from tracker.video.container import PYAV_ERRORS

CODEC = "hevc"
_SLICES = 32
"""Types of units below this are slices: they hold pictures."""
_HEAD = 24
"""Bytes of a slice in which its header may lie: a shorter one is not judged."""
_TAIL = 8
_ADDED = 64
_TRIES = 24
"""Other endings, all of which must change nothing. One is enough in nearly every sound packet; in
one that is all but empty several may happen to mean the same picture."""

Unit = tuple[int, int]  # where a slice begins and ends in the packet


def strays(packet: bytes, extradata: bytes | None) -> bool:
    """Whether the decoder loses its way in this packet; False where that cannot be judged."""
    slices = [unit for unit in _slices(packet, extradata) if unit[1] - unit[0] > _HEAD + _TAIL]
    if not slices:
        return False
    picture = _decoded(packet, extradata)
    if picture is None:
        return False
    chance = random.Random(len(packet))
    length = _length_bytes(extradata)
    longer = packet
    for unit in reversed(slices):
        longer = _with_ending(longer, unit, b"", _noise(chance, _ADDED), length)
    if _decoded(longer, extradata) != picture:
        return True
    return any(not _is_reached(packet, unit, extradata, picture, chance) for unit in slices)


def _is_reached(
    packet: bytes,
    unit: Unit,
    extradata: bytes | None,
    picture: tuple[bytes, ...],
    chance: random.Random,
) -> bool:
    """Whether the last bytes of a slice mean something to the decoder."""
    length = _length_bytes(extradata)
    for _ in range(_TRIES):
        other = _with_ending(packet, unit, _noise(chance, _TAIL), b"", length)
        if _decoded(other, extradata) != picture:
            return True
    return False


def _with_ending(packet: bytes, unit: Unit, last: bytes, added: bytes, length: int) -> bytes:
    """The packet with other last bytes in one slice, and some added behind it."""
    start, end = unit
    head = packet[:start]
    if length:  # the slice is preceded by its length
        size = int.from_bytes(packet[start - length : start], "big") + len(added)
        head = packet[: start - length] + size.to_bytes(length, "big")
    return head + packet[start : end - len(last)] + last + added + packet[end:]


def _noise(chance: random.Random, count: int) -> bytes:
    """Bytes that mean nothing, without zeros: these would begin another unit."""
    return bytes(chance.randrange(4, 256) for _ in range(count))


def _decoded(packet: bytes, extradata: bytes | None) -> tuple[bytes, ...] | None:
    """The planes of the packet's picture, or None where there is none."""
    decoder = cast(VideoCodecContext, CodecContext.create(CODEC, "r"))
    decoder.extradata, decoder.thread_count, decoder.thread_type = extradata, 1, "NONE"
    decoder.flags |= Flags.output_corrupt  # so is all that is built on missing references
    try:
        frames = [*decoder.decode(av.Packet(packet)), *decoder.decode(None)]
    except PYAV_ERRORS:
        return None
    return tuple(bytes(plane) for frame in frames for plane in frame.planes) or None


def _length_bytes(extradata: bytes | None) -> int:
    """How many bytes tell a unit's length; 0 where units are parted by start codes."""
    is_boxed = extradata is not None and len(extradata) > 21 and extradata[0] == 1
    return (extradata[21] & 3) + 1 if is_boxed and extradata is not None else 0


def _slices(packet: bytes, extradata: bytes | None) -> Iterator[Unit]:
    length = _length_bytes(extradata)
    units = _boxed_units(packet, length) if length else _parted_units(packet)
    for start, end in units:
        if (packet[start] >> 1) & 63 < _SLICES:
            yield start, _end_of_data(packet, start, end)


def _boxed_units(packet: bytes, length: int) -> Iterator[Unit]:
    at = 0
    while at + length < len(packet):
        size = int.from_bytes(packet[at : at + length], "big")
        at += length
        if not 0 < size <= len(packet) - at:
            return
        yield at, at + size
        at += size


def _parted_units(packet: bytes) -> Iterator[Unit]:
    mark = b"\0\0\1"
    start = packet.find(mark)
    while start >= 0:
        start += len(mark)
        stop = packet.find(mark, start)
        end = len(packet) if stop < 0 else stop
        if end > start:
            yield start, end
        start = stop


def _end_of_data(packet: bytes, start: int, end: int) -> int:
    """Where a slice ends without the words that only fill it up."""
    while (
        end > start and packet[end - 1] in (0, 3) and packet[start:end].endswith((b"\0", b"\0\0\3"))
    ):
        end -= 1 if packet[end - 1] == 0 else 3
    return end
