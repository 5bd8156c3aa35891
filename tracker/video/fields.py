"""One progressive frame of each interlaced one: FFmpeg's bwdif, given a frame and its neighbours.

A field's lines are filled in from the same frame, from the one before and from the one after, and
from nothing else: a frame is the same to the last bit however it was reached.
"""

from __future__ import annotations

from fractions import Fraction
from typing import cast

import av
import av.error
from av.filter import Graph

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
        given = [after]  # None: the end
        if graph is None or self._last != number:
            graph = _graph(frame)
            given = [frame, after] if before is None else [before, frame, after]
        made: list[av.VideoFrame] = []
        for each in given:
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
