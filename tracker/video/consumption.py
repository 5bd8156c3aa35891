"""Whether a packet of HEVC, H.264 or VP9 is decoded exactly to its end.

A decoder that misreads a packet often reports nothing: it makes garbage of the rest. But it then
ends at a wrong place, which can be tested. One packet is decoded by itself, its missing
references being grey. Bytes added behind its end must change nothing, else the decoder has read
beyond it; and other bytes in the place of the last ones must change something, else it has not
reached them. What changes is the picture or, where that is flat and patched up without a trace,
what the decoder says of it.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple, cast

import av
from av.codec.context import CodecContext, Flags
from av.video.codeccontext import VideoCodecContext

from keypose.tracker.video.container import PYAV_ERRORS
from keypose.tracker.video.vp9 import inner_tiles

_HEAD = 24
"""Bytes of a slice in which its header may lie: a shorter one is not judged."""
_TAIL = 8
_ADDED = 64
_TRIES = 24
"""Other endings, all of which must change nothing. One is enough in nearly every sound packet; in
one that is all but empty several may happen to mean the same picture."""

_PARAMETERS = 7
_KEY_SLICE = 5
_NEEDED = 0x60
"""Kinds of units of H.264, and the bits that say whether other pictures are built on one: on the
slice of a key they always are (ITU-T H.264, 7.4.1)."""
_BASELINE = 66
_EXTENDED = 88
"""Profiles of H.264 that may hold slices twice, of which the decoder passes over one."""


class Unit(NamedTuple):
    """A slice or tile in its packet: its first byte, the one behind its last, and how many bytes
    before it hold its length; none where units are separated by start codes."""

    start: int
    end: int
    length_bytes: int = 0


class _Picture(NamedTuple):
    """What a packet is decoded to: its planes, and whether the decoder patched them up."""

    planes: tuple[bytes, ...]
    is_patched: bool


@dataclass(frozen=True)
class Coding:
    """How packets are coded: FFmpeg's name of the codec, and its data before any packet."""

    codec: str
    extradata: bytes | None

    @property
    def length_bytes(self) -> int:
        """How many bytes hold a unit's length; 0 where start codes separate units."""
        data = self.extradata
        at = 21 if self.codec == "hevc" else 4
        return (data[at] & 3) + 1 if data is not None and len(data) > at and data[0] == 1 else 0

    def is_judged(self, packet: bytes, is_key: bool) -> bool:
        """Whether this packet, a key or not, can be judged by itself.

        The decoders of H.264 and VP9 cannot decode a packet without its references.
        """
        if self.codec == "h264":
            return is_key and self._profile(packet) not in (None, _BASELINE, _EXTENDED)
        return self.codec == "hevc" or (self.codec == "vp9" and is_key)

    def _profile(self, packet: bytes) -> int | None:
        """The profile of H.264 that the first set of parameters names."""
        data = self.extradata or b""
        if self.length_bytes:
            return data[1]
        source = data + packet
        heads = (source[unit.start : unit.start + 2] for unit in _start_code_units(source))
        return next((head[1] for head in heads if head[0] & 31 == _PARAMETERS), None)

    def without_stray(self, packet: bytes) -> bytes:
        """The packet without what is marked as a key's slice and cannot be one.

        Some programs that cut films write a note of the encoder without its first byte. Decoders
        pass over it, and the picture beside it is whole.
        """
        length = self.length_bytes
        if self.codec != "h264" or not length:
            return packet
        stray = [
            unit
            for unit in _length_prefixed_units(packet, length)
            if packet[unit.start] & 31 == _KEY_SLICE and not packet[unit.start] & _NEEDED
        ]
        for unit in reversed(stray):
            packet = packet[: unit.start - length] + packet[unit.end :]
        return packet

    def is_slice(self, head: bytes) -> bool:
        """Whether a unit that begins like this is part of the picture that is shown."""
        if self.codec == "h264":
            return head[0] & 31 in (1, 5)
        layer = (head[0] & 1) << 5 | head[1] >> 3
        return head[0] >> 1 & 63 < 32 and layer == 0  # further layers: another eye, or alpha


def is_misread(packet: bytes, coding: Coding) -> bool:
    """Whether the decoder misreads this packet; False where that cannot be tested."""
    units = list(_slices(packet, coding))
    slices = [unit for unit in units if unit.end - unit.start > _HEAD + _TAIL]
    if not slices:
        return False
    picture = _decoded(packet, coding)
    if picture is None:
        return False
    chance = random.Random(len(packet))
    longer = packet
    for unit in reversed(units[-1:] if coding.codec == "h264" else slices):
        # bits left in another slice of H.264's variable-length codes are its next blocks
        longer = _with_ending(longer, unit, b"", _noise(chance, _ADDED))
    if _decoded(longer, coding) != picture:
        return True
    return any(not _is_reached(packet, unit, coding, picture, chance) for unit in slices)


def _is_reached(
    packet: bytes,
    unit: Unit,
    coding: Coding,
    picture: _Picture,
    chance: random.Random,
) -> bool:
    """Whether the last bytes of a slice affect the decoded picture."""
    for _ in range(_TRIES):
        altered = _with_ending(packet, unit, _noise(chance, _TAIL), b"")
        if _decoded(altered, coding) != picture:
            return True
    return False


def _with_ending(packet: bytes, unit: Unit, last: bytes, added: bytes) -> bytes:
    """The packet with other last bytes in one slice, and some added behind it."""
    start, end, length = unit
    head = packet[:start]
    if length:
        size = int.from_bytes(packet[start - length : start], "big") + len(added)
        head = packet[: start - length] + size.to_bytes(length, "big")
    return head + packet[start : end - len(last)] + last + added + packet[end:]


def _noise(chance: random.Random, count: int) -> bytes:
    """Bytes that mean nothing, without zeros: these would begin another unit."""
    return bytes(chance.randrange(4, 256) for _ in range(count))


def _decoded(packet: bytes, coding: Coding) -> _Picture | None:
    """The packet's picture, or None where there is none."""
    decoder = cast(VideoCodecContext, CodecContext.create(coding.codec, "r"))
    decoder.extradata = coding.extradata
    decoder.thread_count, decoder.thread_type = 1, "NONE"
    decoder.flags |= Flags.output_corrupt  # so is all that is built on missing references
    try:
        frames = [*decoder.decode(av.Packet(packet)), *decoder.decode(None)]
    except PYAV_ERRORS:
        return None
    if not frames:
        return None
    planes = tuple(bytes(plane) for frame in frames for plane in frame.planes)
    return _Picture(planes, any(frame.is_corrupt for frame in frames))


def _slices(packet: bytes, coding: Coding) -> Iterator[Unit]:
    if coding.codec == "vp9":
        for start, end in inner_tiles(packet):  # zeros at a tile's end are read, no padding
            yield Unit(start, end, 4)
        return
    length = coding.length_bytes
    units = _length_prefixed_units(packet, length) if length else _start_code_units(packet)
    for start, end, length_bytes in units:
        if end - start > 2 and coding.is_slice(packet[start : start + 2]):
            yield Unit(start, _end_of_data(packet, start, end), length_bytes)


def _length_prefixed_units(packet: bytes, length: int) -> Iterator[Unit]:
    at = 0
    while at + length < len(packet):
        size = int.from_bytes(packet[at : at + length], "big")
        at += length
        if not 0 < size <= len(packet) - at:
            return
        yield Unit(at, at + size, length)
        at += size


def _start_code_units(packet: bytes) -> Iterator[Unit]:
    mark = b"\0\0\1"
    start = packet.find(mark)
    while start >= 0:
        start += len(mark)
        stop = packet.find(mark, start)
        end = len(packet) if stop < 0 else stop
        if end > start:
            yield Unit(start, end)
        start = stop


def _end_of_data(packet: bytes, start: int, end: int) -> int:
    """Where a slice ends without its padding."""
    while (
        end > start and packet[end - 1] in (0, 3) and packet[start:end].endswith((b"\0", b"\0\0\3"))
    ):
        end -= 1 if packet[end - 1] == 0 else 3
    return end
