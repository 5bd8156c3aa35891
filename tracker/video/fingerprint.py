"""A short name for the content of a video: quick to make, and different for different videos.

Only the ends and the middle are read, so it distinguishes two recordings; it is no proof against
someone who edits a file on purpose.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from keypose.tracker.files import open_regular

_CHUNK = 64 * 1024
_IMAGE_CHUNK = 4 * 1024


def fingerprint_of_file(path: Path, frame_count: int) -> str:
    """ "sha256:…" of the size, the frame count, and the head, middle and tail of the file."""
    digest = hashlib.sha256()
    size = path.stat().st_size
    digest.update(f"{size} bytes, {frame_count} frames\n".encode())
    for offset in (0, (size - _CHUNK) // 2, size - _CHUNK):
        digest.update(_chunk(path, max(offset, 0), _CHUNK))
    return f"sha256:{digest.hexdigest()}"


def fingerprint_of_images(paths: Sequence[Path]) -> str:
    """ "sha256:…" of the name, size, head and tail of every image, in order."""
    digest = hashlib.sha256()
    for path in paths:
        size = path.stat().st_size
        digest.update(f"{path.name}\n{size} bytes\n".encode(errors="surrogateescape"))
        digest.update(_chunk(path, 0, _IMAGE_CHUNK))
        digest.update(_chunk(path, max(size - _IMAGE_CHUNK, 0), _IMAGE_CHUNK))
    return f"sha256:{digest.hexdigest()}"


def _chunk(path: Path, offset: int, length: int) -> bytes:
    with open_regular(path) as file:
        file.seek(offset)
        return file.read(length)
