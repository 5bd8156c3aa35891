"""The size in an image's header, so that a folder of thousands is checked quickly."""

from __future__ import annotations

import struct


def stored_size(head: bytes) -> tuple[int, int] | None:
    """(width, height) as stored, of a PNG, BMP or JPEG that begins with `head`; None otherwise."""
    try:
        if head.startswith(b"\x89PNG\r\n\x1a\n"):
            width, height = struct.unpack_from(">II", head, 16)
            return width, height
        if head.startswith(b"BM"):
            width, height = struct.unpack_from("<ii", head, 18)
            return width, abs(height)  # negative: rows run from the top
        if head.startswith(b"\xff\xd8"):
            return _jpeg_size(head)
    except struct.error:
        return None  # the header is cut off
    return None


def _jpeg_size(head: bytes) -> tuple[int, int] | None:
    """Walks the segments to the one that begins the frame."""
    at = 2
    while True:
        mark, kind, length = struct.unpack_from(">BBH", head, at)
        if mark != 0xFF:
            return None
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack_from(">HH", head, at + 5)
            return width, height
        at += 1 if kind == 0xFF else 2 + length  # marks may be padded with 0xFF
