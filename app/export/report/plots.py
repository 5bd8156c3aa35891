"""Curves, areas and steps as inline SVG that stretches to the width it is given.

A plot's own coordinates run from 0 to WIDTH and, downward, from 0 to HEIGHT; lines keep their
thickness however it is stretched, and words stand beside the drawing as text of the page.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from keypose.app.export.report.markup import Child, Html, element
from keypose.tracker.geometry.rotations import Array

WIDTH = 1000.0
HEIGHT = 100.0
MOST_COLUMNS = 500
"""A curve of more frames is drawn by the lowest and the highest value of every column."""


@dataclass(frozen=True)
class Scale:
    """Where frames and values lie in a plot; the lowest value at its bottom."""

    first: float
    last: float
    low: float = 0.0
    high: float = 1.0

    def x(self, frame: float) -> float:
        return WIDTH * (frame - self.first) / max(self.last - self.first, 1e-9)

    def y(self, value: float) -> float:
        share = (value - self.low) / max(self.high - self.low, 1e-9)
        return HEIGHT * (1.0 - min(max(share, 0.0), 1.0))

    def percent(self, frame: float) -> float:
        """The share from the left."""
        return self.x(frame) / WIDTH * 100


@dataclass(frozen=True)
class PlotColumn:
    """The lowest and the highest of the values from frame `first` to `last`."""

    first: int
    last: int
    low: float
    high: float

    @property
    def middle(self) -> float:
        return (self.first + self.last) / 2


def runs(values: Array, first: int) -> list[list[PlotColumn]]:
    """Values (N,) from frame `first` on as runs without gaps, thinned to MOST_COLUMNS."""
    each = max(1, -(-len(values) // MOST_COLUMNS))
    plot_runs: list[list[PlotColumn]] = [[]]
    for start in range(0, len(values), each):
        finite = values[start : start + each]
        finite = finite[np.isfinite(finite)]
        if not len(finite):
            plot_runs.append([])
            continue
        end = min(start + each, len(values)) - 1
        plot_runs[-1].append(
            PlotColumn(first + start, first + end, float(finite.min()), float(finite.max()))
        )
    return [run for run in plot_runs if run]


def curve(values: Array, first: int, scale: Scale) -> str:
    """Path data of a line through values (N,)."""
    return "".join("M" + "L".join(_through(run, scale)) for run in runs(values, first))


def area(values: Array, first: int, scale: Scale) -> str:
    """Path data of what lies under values (N,); half a frame wider than they are on both sides."""
    pieces = []
    for run in runs(values, first):
        start, end = scale.x(run[0].first - 0.5), scale.x(run[-1].last + 0.5)
        top = "L".join(_at(scale.x(c.middle), scale.y(c.low)) for c in run)
        ends = _at(start, scale.y(run[0].low)), _at(end, scale.y(run[-1].low))
        pieces.append(f"M{_at(start, HEIGHT)}L{ends[0]}L{top}L{ends[1]}V{HEIGHT:g}Z")
    return "".join(pieces)


def band(low: Array, high: Array, first: int, scale: Scale) -> str:
    """Path data of what lies between two lines (N,) that end at the same frames."""
    pieces = []
    for below, above in zip(runs(low, first), runs(high, first), strict=True):
        there = "L".join(_at(scale.x(c.middle), scale.y(c.high)) for c in above)
        back = "L".join(_at(scale.x(c.middle), scale.y(c.low)) for c in reversed(below))
        pieces.append(f"M{there}L{back}Z")
    return "".join(pieces)


def steps(values: Array, first: int, scale: Scale) -> str:
    """Path data of a line of level steps; value j holds from frame first + j to the one after."""
    pieces = []
    for run in runs(values, first):
        levels = (
            f"L{_at(scale.x(c.first), scale.y(c.low))}H{scale.x(c.last + 1):.1f}" for c in run
        )
        pieces.append("M" + "".join(levels)[1:])
    return "".join(pieces)


def dots(points: Iterable[tuple[float, float]]) -> str:
    """Path data of round dots, drawn with a thick line with round ends."""
    return "".join(f"M{_at(x, y)}h0" for x, y in points)


def uprights(frames: Iterable[float], scale: Scale) -> str:
    """Path data of lines from top to bottom."""
    return "".join(f"M{scale.x(frame):.1f} 0V{HEIGHT:g}" for frame in frames)


def path(data: str, class_: str) -> Html | None:
    return element("path", d=data, class_=class_) if data else None


def drawing(*pieces: Child, words: str) -> Html:
    """The stretching picture; `words` describe it to those who cannot see it."""
    return element(
        "svg",
        element("title", words),
        *pieces,
        viewBox=f"0 0 {WIDTH:g} {HEIGHT:g}",
        preserveAspectRatio="none",
        role="img",
    )


def nice_ticks(first: float, last: float, most: int) -> Sequence[int]:
    """At most so many round whole numbers from first to last."""
    width = max(last - first, 1.0)
    powers = [10**k for k in range(10)]
    sizes = (digit * power for power in powers for digit in (1, 2, 5))
    step = next(size for size in sizes if width / size < most)
    return range(int(-(-first // step)) * step, int(last) + 1, step)


def _through(run: list[PlotColumn], scale: Scale) -> Iterable[str]:
    for column in run:
        x = scale.x(column.middle)
        yield _at(x, scale.y(column.high))
        if column.low != column.high:
            yield _at(x, scale.y(column.low))


def _at(x: float, y: float) -> str:
    return f"{x:.1f} {y:.1f}"
