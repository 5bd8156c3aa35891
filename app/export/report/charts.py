"""What tracking saw, over time: verdicts, rank, observability; scores per pass; joint angles."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from keypose.app.export.report.markup import Child, Html, element, joined
from keypose.app.export.report.plots import (
    Scale,
    area,
    band,
    curve,
    dots,
    drawing,
    nice_ticks,
    path,
    runs,
    steps,
    uprights,
)
from keypose.app.export.report.subject import Subject
from keypose.app.posing import angle_curve_deg, axis_labels, lanes, part_label
from keypose.app.posing.labels import number_text
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.storage.results import Span, observability, ranks, root_positions, rotations
from keypose.tracker.tracking.result import SegmentResult

HIDDEN_BELOW = 0.35
"""A part that is less visible than this is hatched, as on the page's timeline."""
LEAST_MOTION_DEG = 1.0
LEAST_MOTION_M = 0.005
"""An angle, a place that moves less than this gets no curve."""
AXES = ("x", "y", "z")


def over_time(subject: Subject) -> Html:
    """Verdicts, rank and observability of the groups of parts, one below the other, by frame."""
    scale = Scale(*subject.ends)
    rows = [_row("Segments", _strip(subject, scale), "strip")]
    if any(track.finished for track in subject.fitting.values()):
        rows += [*_rank_row(subject, scale), *_lane_rows(subject, scale)]
    rows.append(_row("Frame", _axis(scale), "axis"))
    return element("div", *rows, class_="time")


def timeline(rows: Iterable[tuple[str, Html]], scale: Scale) -> Html:
    """Strips by name, one below the other, above the frames."""
    strips = [_row(name, strip, "strip") for name, strip in rows]
    return element("div", *strips, _row("Frame", _axis(scale), "axis"), class_="time")


def score_chart(track: SegmentResult) -> Html:
    """The score of every pass of a segment, the best one marked; lower is better."""
    finite = [(i, score) for i, score in enumerate(track.scores) if math.isfinite(score)]
    name = f"{track.first}–{track.last}"
    state = track.kind or "none"
    if not finite:
        none = element("p", "No pass has an error that is known.", class_="quiet")
        return element("figure", element("figcaption", element("b", name)), none, class_="multi")
    best = [number_text(score, 2) for i, score in finite if i == track.best_pass]
    ticks = [(_pass_scale(track).percent(i), str(i + 1)) for i in range(len(track.scores))]
    return element(
        "figure",
        _caption(name, [(state, f"best {words}") for words in best]),
        _plot(_score_line(track, finite), high=f"{max(score for _, score in finite):.3g}", low="0"),
        _ticks(ticks[:: -(-len(ticks) // 8)]),
        class_="multi",
    )


def _score_line(track: SegmentResult, finite: list[tuple[int, float]]) -> Html:
    state, scale = track.kind or "none", _pass_scale(track)
    points = {i: (scale.x(i), scale.y(score)) for i, score in finite}
    line = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points.values())
    words = ", ".join(f"{i + 1}: {score:.3g}" for i, score in finite)
    return drawing(
        path(line, f"score {state}"),
        path(dots(points.values()), f"dots {state}"),
        path(dots(at for i, at in points.items() if i == track.best_pass), f"dots best {state}"),
        words=f"Error per pass of segment {track.first}–{track.last}: {words}",
    )


def _pass_scale(track: SegmentResult) -> Scale:
    """Passes from left to right, scores from 0 up."""
    most = max((score for score in track.scores if math.isfinite(score)), default=1.0)
    return Scale(-0.3, max(len(track.scores) - 0.7, 1.3), 0.0, most * 1.08 or 1.0)


def angle_charts(subject: Subject) -> Iterator[Html]:
    """A small chart for every part that turns, and one for where the body goes."""
    fitting, first, count = _shifted(subject)
    if not fitting:
        return
    root = subject.session.subject.body.parts[0]
    positions = root_positions(fitting, count)
    places = dict(zip(AXES, ("right", "down", "away"), strict=True))
    yield from _multiple(
        subject, f"{part_label(root.name)}, metres", positions, first, places, LEAST_MOTION_M, " m"
    )
    for i, part in enumerate(subject.session.subject.body.parts):
        Rs = rotations(fitting, count, i)
        angles, rows = np.full((count, 3), np.nan), np.flatnonzero(np.isfinite(Rs[:, 0, 0]))
        keys = np.searchsorted(rows, np.intersect1d(np.subtract(subject.keys, first), rows))
        angles[rows] = angle_curve_deg(part, Rs[rows], keys, subject.session.world.up)
        words = {
            axis: word.lower()
            for axis, word in axis_labels(subject.session.subject.body, part.name).items()
        }
        yield from _multiple(
            subject, part_label(part.name), angles, first, words, LEAST_MOTION_DEG, "°"
        )


def _rank_row(subject: Subject, scale: Scale) -> Iterator[Html]:
    """Count the degrees of freedom that the picture decides at every step (DRIFT Fig. 10)."""
    fitting, first, count = _shifted(subject)
    rank = np.append(ranks(fitting, count), np.nan)
    if np.isnan(rank).all():
        return
    of, least = subject.dof_count, int(np.nanmin(rank))
    low = max(0, min(least, of - 4) - 1)
    values = Scale(scale.first, scale.last, low, of)
    short = np.where(rank < of, rank, np.nan)
    words = f"Rank of every step, {least} at least of {of} degrees of freedom"
    lines = [path(uprights(_inner_keys(subject), scale), "keys")]
    drawn = drawing(
        *lines,
        path(steps(rank, first, values), "rank"),
        path(steps(short, first, values), "rank short"),
        words=words,
    )
    yield _row("Rank", _plot(drawn, high=f"{of}", low=f"{low}"), "rankrow")


def _lane_rows(subject: Subject, scale: Scale) -> Iterator[Html]:
    """How well the picture determines every group of parts, hatched where too little."""
    fitting, first, count = _shifted(subject)
    body = subject.session.subject.body
    table = observability(fitting, count, len(body.parts))
    for label, parts in lanes(body):
        columns = table[:, [body.index(part) for part in parts]]
        has_values = np.isfinite(columns).any(axis=0)
        if not has_values.any():
            continue
        values = _together(columns[:, has_values])
        hidden = _hidden(values, first, scale)
        least = float(np.nanmin(values))
        drawn = drawing(
            path(uprights(_inner_keys(subject), scale), "keys"),
            path(area(values, first, scale), "lane"),
            words=f"Visibility of {label}, 0 to 1: {least:.2f} at least",
        )
        yield _row(label, joined([_plot(drawn), *hidden]), "lanerow")


def _together(columns: Array) -> Array:
    """Half the mean, half the worst: a limb whose hand is hidden is not seen well."""
    values = np.full(len(columns), np.nan)
    there = np.isfinite(columns).any(axis=1)
    known_columns = columns[there]
    values[there] = (np.nanmean(known_columns, axis=1) + np.nanmin(known_columns, axis=1)) / 2
    return values


def _hidden(values: Array, first: int, scale: Scale) -> Iterator[Html]:
    """The hatching."""
    for run in runs(np.where(values < HIDDEN_BELOW, values, np.nan), first):
        left = max(scale.percent(run[0].first - 0.5), 0.0)
        width = min(scale.percent(run[-1].last + 0.5), 100.0) - left
        place = f"left:{left:.2f}%;width:{width:.2f}%"
        title = f"{run[0].first}–{run[-1].last}"
        yield element("i", class_="hidden", style=place, title=f"Hidden {title}")


def _inner_keys(subject: Subject) -> tuple[int, ...]:
    """The keyframes where two segments meet."""
    first, last = subject.ends
    return tuple(key for key in subject.keys if first < key < last)


def _strip(subject: Subject, scale: Scale) -> Html:
    """The segments in the colours of their verdicts, and the keyframes between them."""
    pieces = []
    for span in subject.spans:
        left, right = scale.percent(span[0]), scale.percent(span[1])
        state = subject.states[span]
        place = f"left:{left:.2f}%;width:{right - left:.2f}%"
        title = f"{span[0]}–{span[1]}: {subject.words(span)}"
        pieces.append(element("i", class_=f"seg {state}", style=place, title=title))
    pieces += [
        element("i", class_="key", style=f"left:{scale.percent(key):.2f}%", title=f"Keyframe {key}")
        for key in subject.keys
    ]
    return joined(pieces)


def _axis(scale: Scale) -> Html:
    ticks = nice_ticks(scale.first, scale.last, 12)
    return _ticks([(scale.percent(tick), str(tick)) for tick in ticks])


def _multiple(
    subject: Subject,
    title: str,
    values: Array,
    first: int,
    words: Mapping[str, str],
    least: float,
    unit: str,
) -> Iterator[Html]:
    """Draw one small chart of up to three curves (N, 3); none where nothing moves."""
    moving = [k for k in range(3) if _span_of(values[:, k]) > least]
    if not moving:
        return
    shown = values[:, moving]
    low, high = float(np.nanmin(shown)), float(np.nanmax(shown))
    digits = 0 if unit == "°" else 2
    yield line_chart(
        _caption(title, [(AXES[k], words[AXES[k]]) for k in moving]),
        Scale(*subject.ends, low - 0.08 * (high - low), high + 0.08 * (high - low)),
        [Line(values[:, k], AXES[k], first, subject.keys) for k in moving],
        words=f"{title}: {', '.join(words[AXES[k]] for k in moving)}",
        high=number_text(high, digits) + unit,
        low=number_text(low, digits) + unit,
        uprights_at={"keys": subject.keys},
    )


def single_chart(subject: Subject, title: str, values: Array, first: int) -> Html:
    """Draw a small chart of one curve (N,) from frame `first` on, of values from 0 up."""
    high = float(np.nanmax(values))
    return line_chart(
        _caption(title, []),
        Scale(*subject.ends, 0.0, 1.08 * high or 1.0),
        [Line(values, "x", first)],
        words=f"{title}: {number_text(high, 2)} at most",
        high=number_text(high, 2),
        low="0",
        uprights_at={"keys": subject.keys},
    )


@dataclass(frozen=True, eq=False)
class Line:
    """A curve (N,) from frame `first` on, with dots at some frames; style: its classes.

    errors (N,): by which it is expected to be off, drawn as a band; None without one.  guess_from:
    where that is more the curve is a guess.
    """

    values: Array
    style: str
    first: int = 0
    dots_at: Sequence[int] = ()
    errors: Array | None = None
    guess_from: float = math.inf

    @property
    def around(self) -> tuple[Array, Array]:
        """(N,) the lower and the upper end of the band; the curve twice without one."""
        off = np.zeros(len(self.values)) if self.errors is None else np.nan_to_num(self.errors)
        return self.values - off, self.values + off

    def drawn(self, scale: Scale) -> Iterator[Html | None]:
        """The band, the curve, and what of it is a guess."""
        if self.errors is None:
            yield path(curve(self.values, self.first, scale), f"curve {self.style}")
            return
        yield path(band(*self.around, self.first, scale), f"band {self.style}")
        is_guess = np.nan_to_num(self.errors) > self.guess_from
        near = is_guess.copy()  # so that both lines meet
        near[1:] |= is_guess[:-1]
        near[:-1] |= is_guess[1:]
        guessed, sure = (np.where(which, self.values, np.nan) for which in (near, ~is_guess))
        yield path(curve(guessed, self.first, scale), "curve guess")
        yield path(curve(sure, self.first, scale), f"curve {self.style}")

    def dots(self, scale: Scale) -> str:
        at = (frame for frame in self.dots_at if 0 <= frame - self.first < len(self.values))
        values_at = ((frame, float(self.values[frame - self.first])) for frame in at)
        return dots((scale.x(x), scale.y(y)) for x, y in values_at if math.isfinite(y))


def line_chart(
    caption: Html,
    scale: Scale,
    lines: Sequence[Line],
    *,
    words: str,
    high: str,
    low: str,
    uprights_at: Mapping[str, Sequence[float]],
    ticks: tuple[str, ...] = (),
    has_zero: bool = False,
) -> Html:
    """Draw a small chart: curves with dots, lines from top to bottom by their style, a zero line.

    words: for those who cannot see it.  high, low: the figures of its ends.  ticks: words evenly
    below it; the first and the last frame where there are none.
    """
    drawn = drawing(
        path(f"M0 {scale.y(0.0):.1f}H1000", "zero") if has_zero else None,
        *(path(uprights(at, scale), style) for style, at in uprights_at.items()),
        *(piece for drawn_line in lines for piece in drawn_line.drawn(scale)),
        *(path(line.dots(scale), f"dots {line.style}") for line in lines),
        words=words,
    )
    below = ticks or (f"{scale.first:g}", f"{scale.last:g}")
    places = [(100.0 * i / (len(below) - 1), word) for i, word in enumerate(below)]
    return element(
        "figure", caption, _plot(drawn, high=high, low=low), _ticks(places), class_="multi"
    )


def _span_of(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(np.ptp(finite)) if len(finite) else 0.0


def _shifted(subject: Subject) -> tuple[dict[Span, SegmentResult], int, int]:
    """The results with frames counted from the first that has any; that frame; how many to the
    last. A table of them is as long as the motion, wherever in the video that lies."""
    fitting = subject.fitting
    if not fitting:
        return {}, 0, 0
    first, last = min(a for a, _ in fitting), max(b for _, b in fitting)
    shifted = {
        (a - first, b - first): _in_world(subject, track) for (a, b), track in fitting.items()
    }
    return shifted, first, last - first + 1


def _in_world(subject: Subject, track: SegmentResult) -> SegmentResult:
    """The motion as it is in the world, whatever the camera does."""
    if subject.session.camera_path is None:
        return track
    return replace(track, trajectory=subject.session.film_camera.motion_to_world(track.trajectory))


def _row(name: str, plot: Child, class_: str) -> Html:
    return element(
        "div",
        element("span", name, class_="name"),
        element("div", plot, class_="plotbox"),
        class_=f"row {class_}",
    )


def _plot(drawn: Html, high: str = "", low: str = "") -> Html:
    """A drawing with the figures of its upper and lower end."""
    ends = [
        element("i", words, class_=name) for words, name in ((high, "hi"), (low, "lo")) if words
    ]
    return element("div", drawn, *ends, class_="plot")


def _caption(title: str, legend: list[tuple[str, str]]) -> Html:
    names = [element("span", words, class_=f"name {kind}") for kind, words in legend]
    return element("figcaption", element("b", title), *names)


def _ticks(places: list[tuple[float, str]]) -> Html:
    marks = [element("i", words, style=f"left:{percent:.2f}%") for percent, words in places]
    return element("div", *marks, class_="ticks")
