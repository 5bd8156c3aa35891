"""Read exact frames by number, from a file or a folder of images."""

from __future__ import annotations

import threading
from collections import OrderedDict, deque
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self, TypeAlias

from keypose.tracker.errors import VideoError
from keypose.tracker.session.references import Repeats
from keypose.tracker.video.damage import Examined
from keypose.tracker.video.decode import FileSource, IndexMismatch
from keypose.tracker.video.findings import KNOWN, FileKey, Findings, file_key
from keypose.tracker.video.folder import FolderSource
from keypose.tracker.video.info import MissingFrame, VideoInfo
from keypose.tracker.video.picture import Picture, shrunk
from keypose.tracker.video.repeats import repeats_of

_Which: TypeAlias = tuple[int, int]
"""Number of a frame, and by how much its picture is shrunk."""


class PictureCache:
    """Keeps the pictures put or got last. The newest is kept even when it alone is too large."""

    def __init__(self, byte_limit: int) -> None:
        self._byte_limit = byte_limit
        self._bytes = 0
        self._pictures: OrderedDict[_Which, Picture] = OrderedDict()

    def get(self, which: _Which) -> Picture | None:
        picture = self._pictures.get(which)
        if picture is not None:
            self._pictures.move_to_end(which)
        return picture

    def put(self, which: _Which, picture: Picture) -> None:
        old = self._pictures.pop(which, None)
        self._bytes += picture.nbytes - (0 if old is None else old.nbytes)
        self._pictures[which] = picture
        while self._bytes > self._byte_limit and len(self._pictures) > 1:
            _, dropped = self._pictures.popitem(last=False)
            self._bytes -= dropped.nbytes

    def clear(self) -> None:
        self._pictures.clear()
        self._bytes = 0


CACHE_BYTES = 256 * 2**20
"""Of decoded pictures, where a person goes to and fro."""
READ_ONCE_BYTES = 32 * 2**20
"""The same, for work that goes through them once."""
READ_AGAIN_BYTES = 128 * 2**20
"""The same, for a draft, which comes back to frames near by."""
MOST_BEHIND = 64
"""Most frames on the way to a wanted one whose pictures are kept: to make pictures of all that is
decoded before it would take longer than to decode it."""


class _Source(Protocol):
    """Where pictures come from, see `FileSource`.

    approach: up to a frame, the pictures met on the way from `since` on.  reindex: number the
    frames anew.  examine: find which of these frames are damaged.
    """

    @property
    def info(self) -> VideoInfo: ...
    def approach(self, number: int, since: int) -> Iterator[tuple[int, Picture]]: ...
    def reindex(self) -> None: ...
    def examine(self, first: int, last: int) -> Iterator[Examined]: ...
    def fingerprint(self) -> str: ...
    def close(self) -> None: ...


class Video:
    """The frames of one video. May be used by several threads; they take turns."""

    def __init__(
        self, source: _Source, cache_bytes: int = CACHE_BYTES, file: FileKey | None = None
    ) -> None:
        """file: the key by which whoever opens the same file shares what is found of it; None where
        nobody does."""
        self._source = source
        self._cache_bytes = cache_bytes
        self._cache = PictureCache(cache_bytes)
        self._lock = threading.RLock()
        self._closed = False
        self._found = Findings() if file is None else KNOWN.of(file)
        self._numbering = 0  # how often the frames were numbered anew
        # what the source says, the damaged frames, and what it says with them
        self._with_damaged: tuple[VideoInfo, frozenset[int], VideoInfo] | None = None

    @classmethod
    def open(
        cls, path: str | Path, cache_bytes: int = CACHE_BYTES, *, deinterlace: bool = True
    ) -> Self:
        """Open a video file, or a folder of images in natural order.

        A file is indexed from its packets where they are reliable, which takes under a second
        per hour of video; otherwise it is decoded once. Raises VideoError when it is no video.
        deinterlace: whether interlaced frames are made progressive.
        """
        path = Path(path)
        try:
            is_folder = path.is_dir()
        except OSError:
            is_folder = False  # opening it as a file will report what is wrong
        if is_folder:
            return cls(FolderSource(path), cache_bytes)
        source = FileSource(path, deinterlace)
        return cls(source, cache_bytes, file_key(path))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def info(self) -> VideoInfo:
        """What is known now. `missing` may grow while frames are read; and a file whose
        frames differ from its packets is indexed anew, which may change everything.
        `damaged` grows with what is examined."""
        info = self._source.info
        found_damaged = self._found.damaged
        if not found_damaged:
            return info
        with_damaged = self._with_damaged  # once: another thread may be examining
        if (
            with_damaged is None
            or with_damaged[0] is not info
            or with_damaged[1] is not found_damaged
        ):
            damaged = tuple(sorted(found_damaged.difference(info.missing)))
            self._with_damaged = with_damaged = info, found_damaged, replace(info, damaged=damaged)
        return with_damaged[2]

    @property
    def missing(self) -> tuple[int, ...]:
        """Numbers of the frames known so far to be undecodable, ascending."""
        return self.info.missing

    @property
    def is_closed(self) -> bool:
        """Whether it is closed."""
        return self._closed

    def frame(self, index: int, shrink: int = 1) -> Picture:
        """Frame `index` as (height, width, 3) uint8 RGB, read-only; with a pixel for every
        shrink × shrink.

        Frames decoded on the way are cached. Raises MissingFrame when
        this frame cannot be decoded, VideoError when there is no such frame.
        """
        with self._lock:
            room = self._cache_bytes * shrink**2 // (3 * self.info.width * self.info.height)
            picture = self._get(index, min(index, index - min(room, MOST_BEHIND) + 1), shrink)
        if picture is None:
            raise MissingFrame(
                f'Frame {index} of "{self.info.path.name}" is damaged and cannot be decoded: '
                "use a frame beside it."
            )
        return picture

    def frames(self, start: int, stop: int, step: int = 1) -> Iterator[tuple[int, Picture | None]]:
        """(number, picture) of frames start, start + step … before stop; None for a missing one.

        Decoded forward, once. `frame` may be called in between. Raises VideoError at once when
        the range is not within the video.
        """
        if step < 1:
            raise VideoError(f"A step of {step} frames leads nowhere: choose 1 or more.")
        if start != stop:
            self._check(start)
            self._check(stop - 1)
        return self._walk(start, stop, step)

    def sound_frames(self, start: int, stop: int) -> Iterator[tuple[int, Picture | None]]:
        """The same as `frames`, with None for damaged ones too; what is not examined yet is
        examined.
        """
        for number, picture in self.frames(start, stop):
            if not self._found.is_examined(number):
                deque(self.examine(number, stop - 1), maxlen=0)
            yield number, None if number in self._found.damaged else picture

    def examine(self, first: int, last: int) -> Iterator[int]:
        """Find which of the frames first … last (both included) are damaged; `info` then says so.

        They are decoded once more, strictly, with what they are built on; those examined before
        are left out. Yields each frame reached. Other threads may go on reading; where that shows
        that the frames are numbered otherwise, it begins again.
        VideoError when there are no such frames, or the video is closed meanwhile.
        """
        self._check(first)
        self._check(last)
        while unknown := self._found.unknown(self._numbers(first, last)):
            numbering = self._numbering
            for examined in self._source.examine(unknown[0], unknown[-1]):
                with self._lock:
                    if numbering != self._numbering:
                        break
                    self._check(examined.reached)
                    self._found.add(examined)
                yield examined.reached
            else:
                return

    def repeats(self) -> Repeats:
        """Find the repeated frames among those examined so far."""
        with self._lock:
            return repeats_of(self._found.changes(), self.info.frame_count)

    def _numbers(self, first: int, last: int) -> range:
        return range(first, min(last + 1, self.info.frame_count))

    def deinterlace(self, wanted: bool) -> None:
        """Make interlaced frames progressive from now on, or leave their fields woven."""
        with self._lock:
            if isinstance(self._source, FileSource) and not self._closed:
                self._source.deinterlace(wanted)
                self._cache.clear()
                self._with_damaged = None

    def note(self, index: int) -> str | None:
        """What is known to be wrong with a frame's own file, in a sentence: nothing of a video's,
        see `SurfaceVideo` for what meshes say."""
        return None

    def fingerprint(self) -> str:
        """ "sha256:…" of the content, quick to make: equal for copies of the same video."""
        return self._source.fingerprint()

    def close(self) -> None:
        """Close the file and drop the pictures; frames can no longer be read."""
        with self._lock:
            self._closed = True
            self._cache.clear()
            self._source.close()

    def _walk(self, start: int, stop: int, step: int) -> Iterator[tuple[int, Picture | None]]:
        number = start
        # Read each time: the count may change when the index had to be made again.
        while number < min(stop, self.info.frame_count):
            with self._lock:
                picture = self._get(number, since=number)
            yield number, picture
            number += step

    def _get(self, number: int, since: int, shrink: int = 1) -> Picture | None:
        """The picture, or None when missing; those met on the way from `since` on are kept."""
        self._check(number)
        picture = self._cache.get((number, shrink))
        if picture is not None or number in self.missing:
            return picture
        try:
            for met, picture in self._source.approach(number, since):
                self._cache.put((met, shrink), shrunk(picture, shrink))
        except IndexMismatch:
            self._source.reindex()
            self._cache.clear()
            # the numbers of frames may be others now
            self._numbering += 1
            self._found, self._with_damaged = Findings(), None
            return self._get(number, since, shrink)
        return self._cache.get((number, shrink))

    def _check(self, number: int) -> None:
        name, count = self.info.path.name, self.info.frame_count
        if self._closed:
            raise VideoError(f'"{name}" has been closed: open it again to read frames.')
        if not 0 <= number < count:
            raise VideoError(
                f'"{name}" has no frame {number}: choose one between 0 and {count - 1}.'
            )
