"""Read a folder of images as the frames of a video."""

from __future__ import annotations

import io
import math
import re
import struct
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import av
import numpy as np

from keypose.tracker.errors import VideoError, listed, numbers_listed
from keypose.tracker.files import open_regular
from keypose.tracker.video.container import (
    CONVERT_IMAGES,
    PYAV_ERRORS,
    UNREAD_IMAGES,
    demux,
    not_permitted,
    tags_of,
)
from keypose.tracker.video.damage import Examined
from keypose.tracker.video.fingerprint import fingerprint_of_images
from keypose.tracker.video.info import Timecode, VideoInfo, clock, lens_in
from keypose.tracker.video.picture import (
    Orientation,
    Picture,
    PictureMaker,
    depth_of,
    orientation_of,
)
from keypose.tracker.video.repeats import Changes


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


SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".ppm", ".pgm")
FPS = Fraction(30)  # a folder keeps no time; this is what is assumed
MOST_LOOKED_AT = 32
"""Images of a folder in which is looked for how many bits are used."""


class FolderSource:
    """The images of one folder in natural order: frame_2 before frame_10."""

    def __init__(self, path: Path) -> None:
        """Raises VideoError when there are no images, or they are not all of one size."""
        self._files = _images_in(path)
        self._missing: set[int] = set()
        self._same_stored_size()
        for number in range(len(self._files)):
            frame = self._decode(number)
            if frame is not None:
                break
        else:
            raise VideoError(
                f'No image in the folder "{path.name}" can be read: export them again as PNG.'
            )
        self._pattern = number
        self._depth = depth_of([frame]) and depth_of(self._looked_at())
        self._maker = PictureMaker(self._depth)
        self._facts = self._describe(path, frame)

    @property
    def info(self) -> VideoInfo:
        return self._facts

    def close(self) -> None:
        """Nothing stays open between two images."""

    def fingerprint(self) -> str:
        return fingerprint_of_images(self._files)

    def reindex(self) -> None:
        """The names in the folder are the index, which never changes."""

    def approach(self, number: int, since: int) -> Iterator[tuple[int, Picture]]:
        """Gives frame `number`, or nothing when it is missing: `info.missing` then says so.

        Raises VideoError when the image stands on its side and the others do not.
        """
        frame = self._decode(number)
        if frame is None:
            self._lose(number)
            return
        picture = self._maker.picture_or_none(frame, orientation_of(frame))
        if picture is None:
            self._lose(number)
            return
        if picture.shape[:2] != (self._facts.height, self._facts.width):
            height, width = picture.shape[:2]
            sizes = ((self._facts.width, self._facts.height), (width, height))
            raise self._sizes_differ((self._pattern, number), sizes)
        yield number, picture

    def examine(self, first: int, last: int) -> Iterator[Examined]:
        """Decodes the images one by one; none is built on another."""
        changes = Changes()
        for number in range(max(first - 1, 0), last + 1):
            frame = self._decode(number)
            if frame is None:
                self._lose(number)
            change = None if frame is None else changes.to(number, frame)
            if number >= first:
                change_here = {} if change is None else {number: change}
                yield Examined(number, number, frozenset(), number, change_here)

    def _lose(self, number: int) -> None:
        self._missing.add(number)
        self._facts = replace(self._facts, missing=tuple(sorted(self._missing)))

    def _decode(self, number: int) -> av.VideoFrame | None:
        """One image; None, and counted as missing, when it cannot be decoded."""
        content = _read(self._files[number])
        try:
            # From memory, so that the name cannot be mistaken for a pattern of many images.
            with demux(io.BytesIO(content)) as container:
                frame = next(container.decode(video=0), None)
        except PYAV_ERRORS:  # IndexError among them: there is no picture in it
            frame = None
        if frame is None or frame.is_corrupt:
            self._missing.add(number)
            return None
        return frame

    def _looked_at(self) -> Iterator[av.VideoFrame]:
        """Some frames, spread over all of them."""
        last = len(self._files) - 1
        numbers = np.unique(np.linspace(0, last, MOST_LOOKED_AT).round().astype(int))
        for number in numbers.tolist():
            frame = self._decode(number)
            if frame is not None:
                yield frame

    def _same_stored_size(self) -> None:
        first: tuple[int, tuple[int, int]] | None = None
        for number, file in enumerate(self._files):
            size = stored_size(_read(file, 64 * 1024))
            if size is None:
                continue  # an unknown header: decoding will show the size
            first = first or (number, size)
            if size != first[1]:
                raise self._sizes_differ((first[0], number), (first[1], size))

    def _sizes_differ(
        self, numbers: tuple[int, int], sizes: tuple[tuple[int, int], tuple[int, int]]
    ) -> VideoError:
        (first, second), (size, other_size) = numbers, sizes
        return VideoError(
            f'"{self._files[first].name}" is {size[0]} × {size[1]} and '
            f'"{self._files[second].name}" is {other_size[0]} × {other_size[1]} pixels: '
            "all images of a folder must be of one size."
        )

    def _describe(self, path: Path, frame: av.VideoFrame) -> VideoInfo:
        pts = np.arange(len(self._files), dtype=np.int64)
        pts.setflags(write=False)
        timing = clock(pts, 1 / FPS, FPS)
        orientation: Orientation = orientation_of(frame)
        width, height = frame.width, frame.height
        if orientation.transpose:
            width, height = height, width
        numbers = [_number_in(file.stem) for file in self._files]
        return VideoInfo(
            path=path,
            container="images",
            codec=self._files[self._pattern].suffix.lower().lstrip("."),
            width=width,
            height=height,
            frame_count=len(pts),
            time_base=1 / FPS,
            pts=pts,
            times_s=timing.times_s,
            fps=timing.fps,
            variable_rate=False,
            rotation_deg=orientation.rotation_deg,
            mirrored=orientation.mirrored,
            interlaced=False,
            pixel_aspect=Fraction(1),
            missing=tuple(sorted(self._missing)),
            lens=lens_in((tags_of(frame),)),
            timecode=Timecode.of_numbers(numbers, timing.fps),
            depth=self._depth,
            file_numbers=_ascending(numbers),
            numbering=_unevenness(numbers),
        )


def first_image(folder: Path) -> Path:
    """The first image of a folder, in the order of their numbers; VideoError when it has none."""
    return _images_in(folder)[0]


def _images_in(path: Path) -> list[Path]:
    try:
        entries = list(path.iterdir())
    except PermissionError as error:
        raise not_permitted(path) from error
    files = [
        entry
        for entry in entries
        # Hidden ones are what a file manager leaves beside an image, not images.
        if entry.suffix.lower() in SUFFIXES and not entry.name.startswith(".") and entry.is_file()
    ]
    if not files:
        unread = _unread(entries)
        if unread:
            raise VideoError(
                f'The folder "{path.name}" holds images that are not read, {unread}: '
                f"{CONVERT_IMAGES}."
            )
        raise VideoError(
            f'The folder "{path.name}" holds no images (PNG, JPEG, BMP, TIFF, WebP) and no meshes '
            "(PLY, OBJ, OFF, GLB): choose the folder that they lie in, or a video file."
        )
    return sorted(files, key=lambda file: natural(file.name))


def _unread(entries: Sequence[Path]) -> str:
    """How many images are of kinds that are not read: "24 of OpenEXR"; empty where there are
    none."""
    kinds = [UNREAD_IMAGES.get(e.suffix.lower()) for e in entries if not e.name.startswith(".")]
    counted = Counter(kind for kind in kinds if kind is not None)
    return listed([f"{count} of {kind}" for kind, count in sorted(counted.items())])


def natural(name: str) -> tuple[list[tuple[int, str]], str]:
    """A key that orders the numbers in a name by value; the name itself settles ties."""
    pieces = re.findall(r"[0-9]+|[^0-9]+", name.casefold())
    return [(int(p), "") if p[0] in "0123456789" else (-1, p) for p in pieces], name


def _number_in(stem: str) -> int | None:
    """The last number in the name of a file, as sequences of images count; None without one."""
    digits = re.findall(r"[0-9]+", stem)
    return int(digits[-1]) if digits else None


def _ascending(numbers: Sequence[int | None]) -> tuple[int, ...] | None:
    """The numbers where every file has one, higher than the one before; else None."""
    there = tuple(number for number in numbers if number is not None)
    ascend = len(there) == len(numbers) and all(before < after for before, after in pairwise(there))
    return there if ascend else None


def _unevenness(numbers: Sequence[int | None]) -> str:
    """Which numbers in the names of the images are missing or doubled, in a sentence; empty
    where none is, or where most would be: then they do not count images, but are times, say.
    """
    counted = Counter(number for number in numbers if number is not None)
    there = sorted(counted)
    if len(there) < 2 or counted.total() < len(numbers):
        return ""
    step = math.gcd(*(after - number for number, after in pairwise(there)))
    are_counts = there[-1] - there[0] < 2 * step * len(there)
    missing = set(range(there[0], there[-1], step)) - counted.keys() if are_counts else set()
    doubled = {number for number, times in counted.items() if times > 1}
    irregular = {"missing": missing, "doubled": doubled}
    words = ", ".join(f"{numbers_listed(of, step)} {kind}" for kind, of in irregular.items() if of)
    return f"Image numbers {words}: the images are read as consecutive frames." if words else ""


def _read(path: Path, length: int = -1) -> bytes:
    try:
        with open_regular(path) as file:
            return file.read(length)
    except PermissionError as error:
        raise not_permitted(path) from error
    except OSError as error:
        raise VideoError(
            f'"{path.name}" can no longer be read: put it back, or open the folder again.'
        ) from error
