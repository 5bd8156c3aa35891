"""Which frames are damaged: found by decoding once more, strictly, without making pictures.

Most frames are built on others. Where one is missing, lost or patched up by the decoder, all that
is decoded after it may be garbage, although the decoder says nothing more about it. So everything
from there on counts as damaged, up to the next sound key frame: one that is built on nothing
before it, and neither are the frames shown after it.

One thread decodes, so that an error belongs to the packet just decoded, and results are the same
every time.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import cast

import av
import av.error
import numpy as np
from av.codec.context import CodecContext, Flags
from av.container import InputContainer
from av.video.codeccontext import VideoCodecContext
from av.video.frame import PictureType
from av.video.stream import VideoStream

from keypose.tracker.video.consumption import Coding, is_misread
from keypose.tracker.video.container import PYAV_ERRORS, open_container, packets, picture_stream
from keypose.tracker.video.index import FrameIndex
from keypose.tracker.video.repeats import Changes
from keypose.tracker.video.vp9 import begins_with_key

_STRICTER = {"vp9": "libvpx-vp9"}
"""Decoders that notice damage FFmpeg's own pass over, by codec. They tell of no frame that it is a
key: its packet does."""
_CHECKS = {"mpeg4": "bitstream+buffer"}
"""What FFmpeg's decoders check only when they are asked to, by codec: of MPEG-4 the range of its
values, and where the first frames end."""
_ONE_LATE = {"av1"}
"""Codecs whose decoder (dav1d) reports a damaged packet when it is given the next one."""
_GUESSED = {"avi"}
"""Containers that hold no times: FFmpeg guesses which frame a packet is from the kinds of those
around it, and does so wrongly beside damage."""
_REPORT_EVERY = 16
"""Frames after which progress is reported."""
_REORDERED = 16
"""Frames that may be shown before one that was decoded ahead of them, at most."""


@dataclass(frozen=True)
class Examined:
    """Of the frames first … last (both included) it is known now which are damaged.

    None of them, last being before first, where only so much has been decoded: up to `reached`.
    changes: mean grey levels by which frames differ from the one before, as far as it was decoded.
    """

    first: int
    last: int
    damaged: frozenset[int]
    reached: int
    changes: Mapping[int, float] = field(default_factory=dict)


@dataclass(frozen=True)
class _Step:
    """One packet given to the decoder, or one frame got back.

    order: the packet's place in the order of decoding.  number: the frame's, where it is known.
    kind: "lost" when the decoder gave up on the packet.  change: from the frame before.
    """

    kind: str  # "packet", "lost" or "frame"
    order: int
    number: int | None
    sound: bool = True
    key: bool = False
    change: float | None = None


@dataclass
class _Section:
    """What is known of the frames from one sound key frame to the next."""

    first: int
    came: dict[int, int] = field(default_factory=dict)  # packet by frame, of frames that came
    given: dict[int, int] = field(default_factory=dict)  # packet by frame, of all that should come
    faults: dict[int, int | None] = field(default_factory=dict)  # frame, where known, by packet
    changes: dict[int, float] = field(default_factory=dict)  # by frame

    def damaged(self, stop: int) -> frozenset[int]:
        """The damaged frames of first … before stop."""
        absent = [n for n in range(self.first, stop) if n not in self.came]
        faults = [*self.faults, *(self.given[n] for n in absent if n in self.given)]
        earliest = min(faults, default=None)
        wrong = [n for n, at in self.came.items() if earliest is not None and at >= earliest]
        return frozenset(range(min([*absent, *wrong], default=stop), stop))

    def after(self, key: int) -> _Section:
        """The next section, which the frame `key` begins."""
        at = self.came[key]
        return _Section(
            key,
            {n: p for n, p in self.came.items() if n >= key},
            {n: p for n, p in self.given.items() if n >= key},
            {p: n for p, n in self.faults.items() if p >= at and (n is None or n >= key)},
            {n: change for n, change in self.changes.items() if n >= key},
        )

    def examined(self, stop: int) -> Examined:
        """All that is known of first … before stop."""
        changes = {n: change for n, change in self.changes.items() if n < stop}
        return Examined(self.first, stop - 1, self.damaged(stop), stop - 1, changes)


def examine(
    path: Path, index: FrameIndex, size: tuple[int, int], first: int, last: int
) -> Iterator[Examined]:
    """Decode the frames first … last and those they are built on; yields what is known, in turn.

    size: (width, height) of sound frames as stored. VideoError when the file cannot be read.
    """
    key = int(np.searchsorted(index.keys, first, side="right")) - 1
    key = key if _starts_with_key(path, index, size, key) else 0
    start = int(index.keys[key])
    for examined in _examined(path, index, size, key, last):
        if key > 0 and examined.first == start and examined.damaged:
            break  # perhaps only because decoding began here, which may drop frames
        yield examined
    else:
        return
    before = key - 1 if _starts_with_key(path, index, size, key - 1) else 0
    for examined in _examined(path, index, size, before, last):
        if before == 0 or examined.first > int(index.keys[before]):
            yield examined


def _examined(
    path: Path, index: FrameIndex, size: tuple[int, int], origin: int, last: int
) -> Iterator[Examined]:
    """The findings of one pass from a key on to the frame `last`."""
    steps = _steps(path, index, size, origin)
    section = _Section(int(index.keys[origin]))
    reached = section.first
    for step in steps:
        if step.number is not None and step.number < section.first:
            continue
        _note(section, step)
        if step.kind != "frame" or step.number is None:
            continue
        reached = max(reached, step.number)
        if step.key and step.sound and step.number > section.first:
            stop = step.number
            examined = section.examined(stop)
            yield replace(examined, reached=min(examined.reached, last))
            section = section.after(stop)
        elif reached % _REPORT_EVERY == 0:
            yield Examined(section.first, section.first - 1, frozenset(), min(reached, last))
        if section.first > last or reached > last + _REORDERED:
            break
    else:
        reached = len(index.pts) - 1
    if section.first <= last:
        yield section.examined(min(last, reached) + 1)


def _note(section: _Section, step: _Step) -> None:
    if step.kind == "packet":
        if step.number is not None:
            section.given[step.number] = step.order
        return
    if step.kind == "lost" or not step.sound:
        section.faults[step.order] = step.number
    if step.kind == "frame" and step.number is not None:
        section.came[step.number] = step.order
        if step.change is not None:
            section.changes[step.number] = step.change


def _starts_with_key(path: Path, index: FrameIndex, size: tuple[int, int], origin: int) -> bool:
    """Whether a decoder that is put before this key begins with it, and it is one; or the
    file's beginning, which always is.

    Some files call frames keys that are built on others: pictures refreshed bit by bit.
    """
    start = int(index.keys[origin])
    if origin == 0:
        return True
    for step in _steps(path, index, size, origin):
        if step.kind == "frame" and step.number is not None and step.number >= start:
            return step.key and step.number == start
    return False


def _steps(path: Path, index: FrameIndex, size: tuple[int, int], origin: int) -> Iterator[_Step]:
    """The decoder's packets and frames, from one of the index's keys on."""
    with open_container(path) as container:
        stream = picture_stream(path, container, threaded=False)
        decoder = _decoder(stream) if index.named else stream.codec_context
        if origin > 0:
            try:
                container.seek(index.seek_pts(origin), stream=stream)
            except PYAV_ERRORS:
                return  # a container that cannot seek is read from its beginning
        yield from _Reading(index, size, decoder).steps(path, container, stream)


def _decoder(stream: VideoStream) -> VideoCodecContext:
    """The strictest decoder there is for the stream, decoding with one thread."""
    own = stream.codec_context
    checks = _CHECKS.get(own.codec.canonical_name)
    if checks is not None:
        own.options = {**own.options, "err_detect": checks}
    name = _STRICTER.get(own.codec.canonical_name)
    if name is None or name not in av.codecs_available:
        return own
    stricter = cast(VideoCodecContext, CodecContext.create(name, "r"))
    stricter.extradata, stricter.thread_count = own.extradata, 1
    return stricter


class _Reading:
    """One pass through a decoder, keeping count of packets and frames."""

    def __init__(
        self, index: FrameIndex, size: tuple[int, int], decoder: VideoCodecContext
    ) -> None:
        self._index, self._size, self._decoder = index, size, decoder
        self._decoder.flags |= Flags.copy_opaque  # a frame then says which packet it was
        self._coding = Coding(decoder.codec.canonical_name, decoder.extradata)
        self._late = decoder.codec.canonical_name in _ONE_LATE
        self._order, self._count = -1, -1
        self._tells_keys = decoder.name not in _STRICTER.values()
        self._keys: set[int] = set()  # packets the container calls keys
        self._changes = Changes()

    def steps(self, path: Path, container: InputContainer, stream: VideoStream) -> Iterator[_Step]:
        is_timed = self._index.named and container.format.name not in _GUESSED
        for packet in packets(path, container, stream):
            self._order += 1
            packet.opaque = self._order
            if packet.is_keyframe and (self._tells_keys or begins_with_key(bytes(packet))):
                self._keys.add(self._order)
            packet = self._without_stray(packet)
            number = self._number_of(packet.pts) if is_timed else None
            yield _Step("packet", self._order, number)
            if packet.is_corrupt or self._is_misread(packet):
                yield _Step("lost", self._order, number)
            yield from self._decoded(packet, number)
        yield from self._decoded(None, None)

    def _without_stray(self, packet: av.Packet[VideoStream]) -> av.Packet[VideoStream]:
        content = bytes(packet)
        data = self._coding.without_stray(content)
        if len(data) == len(content):
            return packet
        rest = cast("av.Packet[VideoStream]", av.Packet(data))
        rest.pts, rest.dts, rest.time_base = packet.pts, packet.dts, packet.time_base
        rest.is_keyframe, rest.opaque = packet.is_keyframe, packet.opaque
        return rest

    def _is_misread(self, packet: av.Packet[VideoStream]) -> bool:
        data = bytes(packet)
        return self._coding.is_judged(data, packet.is_keyframe) and is_misread(data, self._coding)

    def _decoded(
        self, packet: av.Packet[VideoStream] | None, number: int | None
    ) -> Iterator[_Step]:
        try:
            frames = self._decoder.decode(packet)
        except av.error.MemoryError:
            raise
        except PYAV_ERRORS:
            self._count += 1
            if self._late and packet is not None:
                yield _Step("lost", max(self._order - 1, 0), None)
            else:
                yield _Step("lost", self._order, number if self._index.named else self._count)
            return
        for frame in frames:
            self._count += 1
            order = frame.opaque if isinstance(frame.opaque, int) else self._order
            sound = not frame.is_corrupt and (frame.width, frame.height) == self._size
            told = frame.key_frame and frame.pict_type == PictureType.I
            key = order in self._keys and (told or not self._tells_keys)
            number = self._number_of(frame.pts)
            change = None if number is None else self._changes.to(number, frame)
            yield _Step("frame", order, number, sound, key, change)

    def _number_of(self, pts: int | None) -> int | None:
        return self._index.number_of(pts) if self._index.named else self._count
