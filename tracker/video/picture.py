"""Turn a decoded frame into the picture handed out: deinterlaced, upright, 8-bit RGB, read-only.

A field's lines are filled in from the same frame, from the one before and from the one after, and
from nothing else: a frame is the same to the last bit however it was reached.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal, TypeAlias, cast

import av
import av.error
import cv2
import numpy as np
from av.filter import Graph
from av.sidedata.sidedata import Type as SideDataType
from av.video.reformatter import VideoReformatter
from numpy.typing import NDArray

from keypose.tracker.video.container import PYAV_ERRORS

_BWDIF = "mode=send_frame:parity=auto:deint=interlaced"
"""As many frames as come in; those not marked as interlaced stay as they are."""


_ANY = Fraction(1, 1000)
"""Seconds per unit of pts: times decide nothing here, and some frames have none."""


class Deinterlacer:
    """Makes frames progressive; quickest one after the other, as they are numbered."""

    def __init__(self) -> None:
        self._graph: Graph | None = None
        self._last = -1  # number of the frame that the graph was given last

    def frame(
        self,
        number: int,
        before: av.VideoFrame | None,
        frame: av.VideoFrame,
        after: av.VideoFrame | None,
    ) -> av.VideoFrame:
        """The frame of this number; before, after: its neighbours, None where there is none.

        PYAV_ERRORS where FFmpeg cannot do it.
        """
        graph, self._graph = self._graph, None
        frames = [after]  # None: the end
        if graph is None or self._last != number:
            graph = _graph(frame)
            frames = [frame, after] if before is None else [before, frame, after]
        made: list[av.VideoFrame] = []
        for each in frames:
            graph.push(each)
            made += _ready(graph)
        if after is not None:
            self._graph, self._last = graph, number + 1
        return made[-1]


def _graph(frame: av.VideoFrame) -> Graph:
    graph = Graph()
    source = graph.add_buffer(
        width=frame.width,
        height=frame.height,
        format=frame.format,
        time_base=_ANY,
    )
    bwdif, sink = graph.add("bwdif", _BWDIF), graph.add("buffersink")
    source.link_to(bwdif)
    bwdif.link_to(sink)
    graph.configure()
    return graph


def _ready(graph: Graph) -> list[av.VideoFrame]:
    """The frames that the graph has made."""
    made: list[av.VideoFrame] = []
    while True:
        try:
            made.append(cast(av.VideoFrame, graph.pull()))
        except (av.error.BlockingIOError, av.error.EOFError):
            return made


Picture = NDArray[np.uint8]  # (height, width, 3) RGB


Mirrored: TypeAlias = Literal["", "left to right", "top to bottom"]


@dataclass(frozen=True)
class Orientation:
    """How the stored picture is made upright: transposed first, then flipped."""

    transpose: bool = False
    flip_rows: bool = False
    flip_columns: bool = False

    @property
    def rotation_deg(self) -> int:
        """Degrees counter-clockwise; a mirrored picture is turned, then mirrored."""
        if self.transpose:
            return 90 if self.flip_rows else 270
        return 180 if self.flip_rows and self.flip_columns else 0

    @property
    def mirrored(self) -> Mirrored:
        """How the turned picture is mirrored."""
        if self.transpose == (self.flip_rows != self.flip_columns):
            return ""
        return "top to bottom" if self.flip_rows and not self.transpose else "left to right"

    def apply(self, stored: Picture) -> Picture:
        """The upright picture; a view where that is possible."""
        upright = stored.transpose(1, 0, 2) if self.transpose else stored
        if self.flip_rows:
            upright = upright[::-1]
        if self.flip_columns:
            upright = upright[:, ::-1]
        return upright


# By quarter turns counter-clockwise.
_TURNS = (
    Orientation(),
    Orientation(transpose=True, flip_rows=True),
    Orientation(flip_rows=True, flip_columns=True),
    Orientation(transpose=True, flip_columns=True),
)


def orientation_of(frame: av.VideoFrame) -> Orientation:
    """The orientation the frame's display matrix asks for, to the nearest quarter turn.

    The matrix sends (x, y) to (a x + c y, b x + d y), in units of 1/65536.
    """
    try:
        attached: Any = frame.side_data  # annotated as less than it is
    except ValueError:
        # PyAV refuses the whole list when it holds a kind it has no name for, as photographs do.
        # The rotation is still known; a mirror is not.
        return _TURNS[round(frame.rotation / 90) % 4]
    matrices = [data for data in attached if data.type == SideDataType.DISPLAYMATRIX]
    if not matrices:
        return Orientation()
    a, b, _, c, d = np.frombuffer(bytes(matrices[0]), dtype=np.int32)[:5].tolist()
    if abs(b) > abs(a):
        return Orientation(transpose=True, flip_rows=b < 0, flip_columns=c < 0)
    return Orientation(flip_rows=d < 0, flip_columns=a < 0)


_SIXTEEN_BITS = {"gray16be", "gray16le", "rgb48be", "rgb48le", "rgba64be", "rgba64le"}
_DEPTHS = (10, 12, 14)


def depth_of(frames: Iterable[av.VideoFrame]) -> int | None:
    """How many bits the brightest value of pictures of sixteen bits needs: 10, 12 or 14, as
    cameras have them; None where it needs more, or the pictures have not sixteen.
    """
    brightest = max((_values(f)[..., :3].max() for f in frames if _is_deep(f)), default=0xFFFF)
    return next((depth for depth in _DEPTHS if brightest < 1 << depth), None)


def _is_deep(frame: av.VideoFrame) -> bool:
    return frame.format.name in _SIXTEEN_BITS


def _values(frame: av.VideoFrame) -> NDArray[np.uint16]:
    """(height, width, channels) of a deep frame."""
    values = np.asarray(frame.to_ndarray(), dtype=np.uint16)
    return values.reshape(*values.shape[:2], -1)


def shrunk(picture: Picture, by: int) -> Picture:
    """The picture with a pixel for every by × by, their mean, read-only; itself where by is 1."""
    if by == 1:
        return picture
    height, width = picture.shape[:2]
    size = (max(width // by, 1), max(height // by, 1))
    small = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
    small.setflags(write=False)
    return small


class PictureMaker:
    """Makes pictures of frames. Keeps the conversion tables between frames: making them again,
    and threads to share the work, takes many times longer than the conversion itself.

    depth: the bits that are used where frames have sixteen, as `depth_of` finds them.
    """

    def __init__(self, depth: int | None = None) -> None:
        self._reformatter = VideoReformatter()
        self._depth = depth

    def picture(self, frame: av.VideoFrame, orientation: Orientation) -> Picture:
        """The frame as an upright (height, width, 3) uint8 RGB picture, read-only."""
        if self._depth is not None and _is_deep(frame):
            frame = self._spread(frame, self._depth)
        rgb = self._reformatter.reformat(frame, format="rgb24", threads=1)
        stored = np.asarray(rgb.to_ndarray(), dtype=np.uint8)
        picture = np.ascontiguousarray(orientation.apply(stored))
        picture.setflags(write=False)
        return picture

    def picture_or_none(self, frame: av.VideoFrame, orientation: Orientation) -> Picture | None:
        """The same; None where the frame is in colours or sizes that cannot be converted."""
        try:
            return self.picture(frame, orientation)
        except PYAV_ERRORS:
            return None

    @staticmethod
    def _spread(frame: av.VideoFrame, depth: int) -> av.VideoFrame:
        """The frame with the values of so many bits spread over sixteen."""
        used = np.minimum(_values(frame), (1 << depth) - 1)
        values = (used << (16 - depth)).astype(np.uint16)
        grey = values.shape[2] == 1
        return av.VideoFrame.from_ndarray(values[..., 0] if grey else values, frame.format.name)
