"""Pictures of a media file by number, decoding forward as little as necessary."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TypeVar

import av
import numpy as np
from av.container import InputContainer
from av.video.stream import VideoStream

from keypose.tracker.errors import VideoError
from keypose.tracker.video.container import (
    PYAV_ERRORS,
    decode_packets,
    open_container,
    picture_stream,
    tags_of,
)
from keypose.tracker.video.damage import Examined, examine
from keypose.tracker.video.fingerprint import fingerprint_of_file
from keypose.tracker.video.index import FrameIndex, index_from_decoding, index_from_packets, rate_of
from keypose.tracker.video.info import VideoInfo, clock, lens_in, timecode_in
from keypose.tracker.video.picture import Deinterlacer, Picture, PictureMaker, orientation_of

T = TypeVar("T")

_INTERLACED = {2, 3, 4, 5}
"""FFmpeg's AVFieldOrder: which field of a frame comes first, and is shown first."""

# Going on forward is worth this many more frames than a seek would decode.
_SEEK_COST = 8


class IndexMismatch(Exception):
    """The pictures differ from the packets: the index must be made by decoding."""


@dataclass
class _Run:
    """One range of forward decoding."""

    frames: Iterator[tuple[int, av.VideoFrame]]
    origin: int  # which of the index's keys it began at
    at: int = -1  # number of the frame decoded last


class FileSource:
    """The pictures of one media file. Not for use by two threads at once."""

    def __init__(self, path: Path, deinterlace: bool = True) -> None:
        """Raises VideoError when the file holds no video that can be decoded."""
        self._path = path
        self._deinterlace = deinterlace
        self._maker = PictureMaker()
        self._container = open_container(path)
        try:
            self._stream = picture_stream(path, self._container)
            index = index_from_packets(self._container, self._stream)
            self._take(index or index_from_decoding(path))
        except BaseException:
            self._container.close()
            raise
        self._count_when_opened = self.info.frame_count

    def _take(self, index: FrameIndex) -> None:
        """Start again with this index."""
        self._index = index
        self._keys = frozenset(index.keys.tolist())
        self._run: _Run | None = None
        self._missing = set(index.missing)
        self._reopen()
        first = self._first_frame()
        self._orientation = orientation_of(first)
        self._stored_size = (first.width, first.height)
        self._held: dict[int, av.VideoFrame] = {}  # decoded last, of an interlaced film
        self._fields = Deinterlacer()
        self._facts = _describe(self._path, self._container, self._stream, first, index)
        self.deinterlace(self._deinterlace)

    @property
    def info(self) -> VideoInfo:
        return self._facts

    def deinterlace(self, wanted: bool) -> None:
        """Make interlaced frames progressive from now on, or leave their fields woven."""
        self._deinterlace = wanted
        self._facts = replace(self._facts, deinterlaced=wanted and self._facts.interlaced)

    def close(self) -> None:
        self._container.close()

    def fingerprint(self) -> str:
        return fingerprint_of_file(self._path, self._count_when_opened)

    def reindex(self) -> None:
        """Make the index again, by decoding. Numbers of frames already seen may change."""
        self._take(index_from_decoding(self._path, threaded=False))

    def approach(self, number: int, since: int) -> Iterator[tuple[int, Picture]]:
        """Decode up to frame `number`; gives the pictures met on the way from `since` on.

        The last one given is the frame itself. When it is not, the frame is missing, and
        `info.missing` says so from now on. Raises IndexMismatch when the index is wrong.
        """
        if self._facts.deinterlaced:
            return self._approach_progressive(number, since)
        return self._approach(number, since, self._picture)

    def _picture(self, frame: av.VideoFrame) -> Picture | None:
        return self._maker.picture_or_none(frame, self._orientation)

    def _approach_progressive(self, number: int, since: int) -> Iterator[tuple[int, Picture]]:
        """The same of an interlaced film: the frames beside one are decoded with it."""
        for wanted in range(max(number - 1, 0), min(number + 2, self._facts.frame_count)):
            if wanted in self._held or wanted in self._missing:
                continue
            for at, frame in self._approach(wanted, min(since, number) - 1, lambda frame: frame):
                self._held[at] = frame
                self._held = {n: f for n, f in self._held.items() if at - 2 <= n <= at}
                if since < at <= number and len(self._held) == 3:
                    yield from self._progressive(at - 1)
        if number in self._held:
            yield from self._progressive(number)

    def _progressive(self, number: int) -> Iterator[tuple[int, Picture]]:
        """The picture of a frame that is held, from its neighbours that are; else it is missing."""
        try:
            picture = self._picture(
                self._fields.frame(
                    number,
                    self._held.get(number - 1),
                    self._held[number],
                    self._held.get(number + 1),
                )
            )
        except PYAV_ERRORS:
            picture = None
        if picture is None:
            self._lose(number)
        else:
            yield number, picture

    def _approach(
        self, number: int, since: int, make: Callable[[av.VideoFrame], T | None]
    ) -> Iterator[tuple[int, T]]:
        """Decode up to frame `number`; gives what is made of the frames met on the way."""
        from_packets = not self._index.from_decoding
        for run in self._runs(number):
            self._run = run
            for at, frame in run.frames:
                run.at = at
                good = self._is_good(frame)
                if good and since <= at <= number:
                    made = make(frame)
                    good = made is not None
                    if made is not None:
                        yield at, made
                if good and at == number:
                    return
                if at >= number or (from_packets and not good):
                    break
        if from_packets:
            raise IndexMismatch
        self._lose(number)

    def _lose(self, number: int) -> None:
        self._missing.add(number)
        self._facts = replace(self._facts, missing=tuple(sorted(self._missing)))

    def examine(self, first: int, last: int) -> Iterator[Examined]:
        """Decode the frames first … last once more, strictly; yields what is known, in turn."""
        yield from examine(self._path, self._index, self._stored_size, first, last)

    def _runs(self, number: int) -> Iterator[_Run]:
        """Ranges of decoding that may reach a frame, the best first.

        A run that began earlier has more references, so a frame that is missing or damaged is
        tried again from the key before. When the index has seen the frame, the tries
        go back as far as the beginning of the file.
        """
        keys = self._index.keys
        key = int(np.searchsorted(keys, number, side="right")) - 1
        latest = key
        run = self._run
        if run is not None and run.at < number and int(keys[key]) <= run.at + _SEEK_COST:
            yield run
            latest = min(key, run.origin - 1)
        earliest = 0 if self._index.from_decoding else max(key - 1, 0)
        for origin in _earlier_keys(key, earliest):
            if origin <= latest:
                yield self._start(origin)

    def _start(self, origin: int) -> _Run:
        """Begin decoding at one of the index's keys; the file's beginning is reached by opening."""
        if origin > 0:
            try:
                self._container.seek(self._index.seek_pts(origin), stream=self._stream)
                return _Run(self._numbered(synced=False), origin)
            except PYAV_ERRORS:
                origin = 0  # a container that cannot seek is read from its beginning
        self._reopen()
        return _Run(self._numbered(synced=True), origin)

    def _reopen(self) -> None:
        self._container.close()
        self._container = open_container(self._path)
        self._stream = picture_stream(self._path, self._container, self._index.threaded)

    def _numbered(self, synced: bool) -> Iterator[tuple[int, av.VideoFrame]]:
        """Frames from here on with their numbers. Until `synced`, all before a key is ignored:
        right after a seek a decoder may show pictures built on others it has not seen."""
        index = self._index
        for count, frame in enumerate(decode_packets(self._path, self._container, self._stream)):
            if frame is None:
                continue
            number = index.number_of(frame.pts) if index.named else count
            synced = synced or number in self._keys
            if not synced:
                continue
            if number is not None:
                yield number, frame
            elif not index.from_decoding:
                raise IndexMismatch

    def _is_good(self, frame: av.VideoFrame) -> bool:
        return not frame.is_corrupt and (frame.width, frame.height) == self._stored_size

    def _first_frame(self) -> av.VideoFrame:
        """The first sound frame; a damaged one where there is no other."""
        damaged: av.VideoFrame | None = None
        for frame in decode_packets(self._path, self._container, self._stream):
            if frame is not None and not frame.is_corrupt:
                return frame
            damaged = damaged or frame
        if damaged is None:
            raise VideoError(
                f'No frame of "{self._path.name}" can be decoded: copy it again, or convert it '
                "to H.264 in MP4."
            )
        return damaged


def _earlier_keys(key: int, earliest: int) -> Iterator[int]:
    """`key`, the one before, then in steps that double, ending with `earliest`."""
    back = 0
    while key - back > earliest:
        yield key - back
        back = 2 * back + 1
    yield earliest


def _describe(
    path: Path,
    container: InputContainer,
    stream: VideoStream,
    first: av.VideoFrame,
    index: FrameIndex,
) -> VideoInfo:
    orientation = orientation_of(first)
    aspect = stream.sample_aspect_ratio or Fraction(1)
    width, height = first.width, first.height
    if orientation.transpose:
        width, height, aspect = height, width, 1 / aspect
    timing = clock(index.pts, index.time_base, rate_of(stream))
    return VideoInfo(
        path=path,
        container=container.format.name.split(",")[0],
        codec=stream.codec_context.codec.canonical_name,
        width=width,
        height=height,
        frame_count=len(index.pts),
        time_base=index.time_base,
        pts=index.pts,
        times_s=timing.times_s,
        fps=timing.fps,
        variable_rate=timing.variable,
        rotation_deg=orientation.rotation_deg,
        mirrored=orientation.mirrored,
        interlaced=first.interlaced_frame or stream.codec_context.field_order in _INTERLACED,
        pixel_aspect=aspect,
        missing=tuple(sorted(index.missing)),
        lens=lens_in((container.metadata, stream.metadata, tags_of(first))),
        timecode=timecode_in(_all_tags(container, stream), timing.fps),
    )


def _all_tags(container: InputContainer, stream: VideoStream) -> list[dict[str, str]]:
    """The tags of the pictures, of the file, and of its other streams, one of which may be a
    timecode's."""
    return [stream.metadata, container.metadata, *(each.metadata for each in container.streams)]
