"""Which frames a file holds, by number: read from its packets, or found by decoding it once.

Written here because PyAV seeks by time and numbers no frames, and OpenCV guesses the numbers where
rates vary.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import av
import numpy as np
from av.container import InputContainer
from av.video.stream import VideoStream
from numpy.typing import NDArray

from keypose.tracker.video.container import (
    PYAV_ERRORS,
    decode,
    open_container,
    packets,
    picture_stream,
)

# Containers whose packets say which frames will be shown, and when.
_TRUSTED = {"mov", "matroska", "webm"}
_DEFAULT_RATE = Fraction(30)
_MOST_REORDERED = 16
"""Frames that H.264 and HEVC may hold back until they are shown."""


@dataclass(frozen=True, eq=False)
class FrameIndex:
    """The numbered frames of a file."""

    pts: NDArray[np.int64]  # (frames,) strictly increasing, read-only
    time_base: Fraction  # seconds per unit of pts
    keys: NDArray[np.int64]  # (keys,) numbers of frames to start decoding from; the first is 0
    missing: frozenset[int]
    named: bool  # frames are known by their pts; otherwise by counting from the first
    from_decoding: bool  # every frame was decoded; otherwise read from the packets
    threaded: bool  # False: damaged, so decoded by one thread, always with the same outcome
    is_cut: bool = False  # the file holds frames before the first that are not shown

    def seek_pts(self, origin: int) -> int:
        """The pts to seek for one of the keys.

        Of a film that was cut, FFmpeg goes to the key before for that of the key itself, and for
        those of the next frames, as many as are shown in another order than they are decoded in
        (PyAV 18.1).
        """
        key = int(self.keys[origin])
        beyond = int(self.keys[origin + 1]) if origin + 1 < len(self.keys) else len(self.pts)
        return int(self.pts[min(key + _MOST_REORDERED, beyond - 1) if self.is_cut else key])

    def number_of(self, pts: int | None) -> int | None:
        """The number of the frame with this pts, or None."""
        if pts is None:
            return None
        number = int(np.searchsorted(self.pts, pts))
        return number if number < len(self.pts) and self.pts[number] == pts else None


def rate_of(stream: VideoStream) -> Fraction:
    """The header's rate, frames per second; 30 where it has none."""
    return stream.average_rate or stream.guessed_rate or _DEFAULT_RATE


def index_from_packets(container: InputContainer, stream: VideoStream) -> FrameIndex | None:
    """The index from the packets, without decoding; None when they are not reliable.

    They are when the container is of the kind that keeps time well, every packet has a pts of its
    own, which is not negative where it is shown, none is damaged, and the header counts the same.
    What is before the beginning of a film that was cut without being encoded anew is not shown.
    """
    if not _TRUSTED & set(container.format.name.split(",")):
        return None
    pts: list[int] = []
    keys: list[int] = []
    hidden = 0
    try:
        for packet in container.demux(stream):
            if not packet.size:
                continue
            if packet.is_discard:
                hidden += 1
                continue
            if packet.pts is None or packet.pts < 0 or packet.is_corrupt:
                return None
            pts.append(packet.pts)
            if packet.is_keyframe:
                keys.append(packet.pts)
    except PYAV_ERRORS:
        return None  # decoding will show how far the file can be read
    ordered = np.unique(np.asarray(pts, dtype=np.int64))
    if hidden and len(stream.index_entries) > stream.frames > 0:
        return None  # of several pieces: their frames are not in the order of their times
    is_whole = _header_count(container, stream) in (0, len(pts) + hidden)
    if len(ordered) != len(pts) or not is_whole or stream.time_base is None or not pts:
        return None
    return FrameIndex(
        pts=_frozen(ordered),
        time_base=stream.time_base,
        keys=_starts(np.searchsorted(ordered, np.unique(keys))),
        missing=frozenset(),
        named=True,
        from_decoding=False,
        threaded=True,
        is_cut=hidden > 0 or stream.frames > len(pts),
    )


def _header_count(container: InputContainer, stream: VideoStream) -> int:
    """How many packets the header counts; 0 where it does not. Of a film that was cut it counts
    those from the last key before the cut on."""
    if "mov" in container.format.name.split(","):
        return len(stream.index_entries)
    return stream.frames


def index_from_decoding(path: Path, threaded: bool = True) -> FrameIndex:
    """The index found by decoding the whole file once; twice when it turns out damaged.

    In a damaged file the result of several threads depends on their timing. One thread always gives
    the same.
    """
    decoded = _decode_through(path, threaded)
    if threaded and decoded.suspicious:
        decoded = _decode_through(path, threaded=False)
    return decoded.by_name() if decoded.names_are_good else decoded.by_count()


@dataclass
class _Seen:
    """What one pass through the decoder found, in order."""

    time_base: Fraction | None
    rate: Fraction
    threaded: bool
    size: tuple[int, int] | None = None  # of the first sound frame
    shown_packets: int = 0
    packet_pts: set[int] = field(default_factory=set)
    pts: list[int | None] = field(default_factory=list)  # per frame; None also for a lost one
    is_key: list[bool] = field(default_factory=list)
    is_good: list[bool] = field(default_factory=list)
    is_lost: list[bool] = field(default_factory=list)  # the decoder gave up: there is no frame

    @property
    def damaged(self) -> bool:
        return not all(self.is_good)

    @property
    def suspicious(self) -> bool:
        return self.damaged or len(self.pts) < self.shown_packets

    @property
    def names_are_good(self) -> bool:
        """True when every frame has a pts and they only ever grow."""
        pts = [p for p, lost in zip(self.pts, self.is_lost, strict=True) if not lost]
        pts_known = [p for p in pts if p is not None]
        grows = all(a < b for a, b in pairwise(pts_known))
        return len(pts_known) == len(pts) and grows and self.time_base is not None

    def add(self, frame: av.VideoFrame | None) -> None:
        self.pts.append(None if frame is None else frame.pts)
        self.is_key.append(frame is not None and frame.key_frame)
        self.is_good.append(frame is not None and self._fits(frame))
        self.is_lost.append(frame is None)

    def _fits(self, frame: av.VideoFrame) -> bool:
        """True when the frame is sound and of the same size as those before."""
        if frame.is_corrupt:
            return False
        self.size = self.size or (frame.width, frame.height)
        return self.size == (frame.width, frame.height)

    def by_name(self) -> FrameIndex:
        """Frames numbered by pts. A packet without a frame is a missing one only in a damaged
        file: in a sound one it is the second field of a frame, or was never meant to be shown."""
        good = {p: good for p, good in zip(self.pts, self.is_good, strict=True) if p is not None}
        slots = set(good)
        if self.damaged and slots <= self.packet_pts:
            slots |= self.packet_pts
        pts = np.array(sorted(slots), dtype=np.int64)
        keys = [p for p, key in zip(self.pts, self.is_key, strict=True) if key and p is not None]
        return FrameIndex(
            pts=_frozen(pts),
            time_base=self.time_base or 1 / self.rate,
            keys=_starts(np.searchsorted(pts, np.unique(np.array(keys, dtype=np.int64)))),
            missing=frozenset(n for n, p in enumerate(pts.tolist()) if not good.get(p, False)),
            named=True,
            from_decoding=True,
            threaded=self.threaded,
        )

    def by_count(self) -> FrameIndex:
        """Frames numbered in the order they are decoded, at an even rate."""
        return FrameIndex(
            pts=_frozen(np.arange(len(self.pts), dtype=np.int64)),
            time_base=1 / self.rate,
            keys=_starts(np.empty(0, dtype=np.int64)),
            missing=frozenset(n for n, good in enumerate(self.is_good) if not good),
            named=False,
            from_decoding=True,
            threaded=self.threaded,
        )


def _decode_through(path: Path, threaded: bool) -> _Seen:
    with open_container(path) as container:
        stream = picture_stream(path, container, threaded)
        decoded = _Seen(stream.time_base, rate_of(stream), threaded)
        for packet in packets(path, container, stream):
            decoded.shown_packets += not packet.is_discard
            if packet.pts is not None and not packet.is_discard:
                decoded.packet_pts.add(packet.pts)
            for frame in decode(stream, packet):
                decoded.add(frame)
        for frame in decode(stream, None):
            decoded.add(frame)
    return decoded


def _starts(keys: NDArray[np.integer]) -> NDArray[np.int64]:
    """The key frames' numbers with 0 before them: the file's beginning is always a start."""
    return _frozen(np.union1d(np.zeros(1, dtype=np.int64), keys).astype(np.int64))


def _frozen(array: NDArray[np.int64]) -> NDArray[np.int64]:
    array.setflags(write=False)
    return array
