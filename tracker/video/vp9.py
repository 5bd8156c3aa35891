"""Whether a packet of VP9 is a key frame, and where its tiles lie, read from the uncompressed
header."""

from __future__ import annotations

_FRAME_MARKER = 2
_SYNC_CODE = 0x498342
_RGB = 7
_MIN_TILE_BLOCKS = 4
_MAX_TILE_BLOCKS = 64
"""Columns of blocks of 64 × 64 samples that one tile has, at least and at most."""
_SEGMENTS = 8
_FEATURE_BITS = ((8, True), (6, True), (2, False), (0, False))
"""Of what may differ from segment to segment: the bits of its value, and whether it has a sign."""
_TILE_SIZE_BYTES = 4

Span = tuple[int, int]  # first byte, and the one behind the last


def inner_tiles(packet: bytes) -> list[Span]:
    """The tiles of a key frame but the last, each preceded by its size in four bytes.

    None when the packet is another frame, holds several frames, or does not hold together.
    """
    if not packet or packet[-1] & 0xE0 == 0xC0:  # an index of several frames comes last
        return []
    bits = _Bits(packet)
    try:
        tiles, first = _tile_count(bits)
    except IndexError:
        return []
    spans = []
    for _ in range(tiles - 1):
        start = first + _TILE_SIZE_BYTES
        end = start + int.from_bytes(packet[first:start], "big")
        if end >= len(packet):
            return []
        spans.append((start, end))
        first = end
    return spans


def begins_with_key(packet: bytes) -> bool:
    """Whether the first frame of a packet is a key frame: built on nothing before it."""
    try:
        return _key_head(_Bits(packet)) is not None
    except IndexError:
        return False


class _Bits:
    """Reads a header bit by bit; IndexError at its end."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    def read(self, count: int) -> int:
        value = 0
        for _ in range(count):
            value = value << 1 | self._data[self._at >> 3] >> (7 - (self._at & 7)) & 1
            self._at += 1
        return value

    def flag(self) -> bool:
        return self.read(1) == 1

    def skip_if_flagged(self, count: int) -> None:
        """A value that a flag says is there."""
        if self.flag():
            self.read(count)

    def next_byte(self) -> int:
        return (self._at + 7) >> 3


def _key_head(bits: _Bits) -> tuple[int, bool] | None:
    """Profile of a key frame, and whether it is resilient to errors; None of another frame."""
    marker, low, high = bits.read(2), bits.read(1), bits.read(1)
    profile = low + 2 * high
    if marker != _FRAME_MARKER or (profile == 3 and bits.flag()):
        return None
    if bits.flag() or bits.flag():  # shows a frame again, or is built on others
        return None
    bits.flag()  # whether it is shown
    is_resilient = bits.flag()
    return (profile, is_resilient) if bits.read(24) == _SYNC_CODE else None


def _tile_count(bits: _Bits) -> tuple[int, int]:
    """How many tiles a key frame has, and the byte where they begin; else 0."""
    head = _key_head(bits)
    if head is None:
        return 0, 0
    profile, is_resilient = head
    _pass_colors(bits, profile)
    width = bits.read(16) + 1
    bits.read(16)
    bits.skip_if_flagged(32)  # another size to show it at
    bits.read(2 if is_resilient else 4)  # which probabilities are kept
    _pass_loop_filter(bits)
    _pass_quantization(bits)
    if bits.flag():
        _pass_segmentation(bits)
    tiles = _columns(bits, width) * _rows(bits)
    header = bits.read(16)
    return tiles, bits.next_byte() + header


def _pass_colors(bits: _Bits, profile: int) -> None:
    if profile >= 2:
        bits.flag()  # 10 or 12 bits a sample
    is_rgb = bits.read(3) == _RGB
    if not is_rgb:
        bits.flag()  # range
    if profile in (1, 3):
        bits.read(1 if is_rgb else 3)  # subsampling


def _pass_loop_filter(bits: _Bits) -> None:
    bits.read(6 + 3)
    if bits.flag() and bits.flag():
        for _ in range(4 + 2):  # per reference and per mode
            bits.skip_if_flagged(7)


def _pass_quantization(bits: _Bits) -> None:
    bits.read(8)
    for _ in range(3):
        bits.skip_if_flagged(5)


def _pass_segmentation(bits: _Bits) -> None:
    if bits.flag():  # a map of segments
        for _ in range(7):
            bits.skip_if_flagged(8)
        if bits.flag():
            for _ in range(3):
                bits.skip_if_flagged(8)
    if bits.flag():  # what differs from segment to segment
        bits.flag()
        for _ in range(_SEGMENTS):
            for count, is_signed in _FEATURE_BITS:
                bits.skip_if_flagged(count + is_signed)


def _columns(bits: _Bits, width: int) -> int:
    blocks = (width + 63) // 64
    shift = 0
    while _MAX_TILE_BLOCKS << shift < blocks:
        shift += 1
    while blocks >> (shift + 1) >= _MIN_TILE_BLOCKS and bits.flag():
        shift += 1
    return 1 << shift


def _rows(bits: _Bits) -> int:
    return 1 << (1 + bits.read(1) if bits.flag() else 0)
