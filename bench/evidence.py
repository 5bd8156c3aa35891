"""What tracking saw of each joint, against how far the joint is off: is the expected error true,
and are the verdicts.

Another way to weigh the evidence is a matter of seconds. What is fitted is fitted on all clips but
one and judged on that one. What marks are off themselves is taken out in quadrature. A segment is
right whose joints are at most 5 px off in the mean, on a person 400 px tall; a joint is wrong that
is more than 10 px off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.calibration import auroc, bands, even, fitted, median_weights, without_marks
from bench.evidence_seen import FILMED, MARK_PX, RENDERED, Evidence, kept_evidence
from bench.measures import FAR_PX, TALL_PX
from bench.table import Expected, Report, Table
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.tracking.cues.joint_evidence import LEAST, UNKNOWN

WRONG = FAR_PX / TALL_PX
RIGHT_PX = 5.0
FITTED_BY: tuple[tuple[str, ...], ...] = (
    ("apart", "drift", "away"),
    ("apart", "drift", "away", "distance"),
    ("apart", "drift", "away", "visibility"),
)
"""Evidence that is weighed anew, the first as the product does."""
JUDGED_FROM_PX = 3.0
"""Smaller predicted errors are not judged."""
FEWEST = 60
"""Joints in a band of which anything is said."""
GOOD_OFTEN = 0.70
GOOD_TRUE = 0.97
AUROC = 0.80
NAMED = 0.70
MISCALIBRATED = 0.25
"""Shares of right segments that are called good, and of good ones that are right; area under the
curve of wrong joints; share of segments with a wrong joint whose named part is among the two worst;
by how much the median measured may miss the predicted one."""


def evidence(report: Report) -> None:
    """The whole group."""
    seen = kept_evidence()
    known = [name for name in (*FILMED, *RENDERED) if (seen.clips == name).any()]
    rows = seen.of_joints(seen.predicted)
    left_out = _left_out(rows, FITTED_BY[0], known)
    _calibrated(report, "as predicted", rows.column("expected"), rows)
    _calibrated(report, "predicted by weights of the other clips", left_out, rows, MISCALIBRATED)
    columns = (rows.column(name) for name in FITTED_BY[0])
    weights = fitted(*columns, rows.error, rows.clip_of_joint)
    report.note(f"fitted on all: {', '.join(f'{k} {v:.4g}' for k, v in weights._asdict().items())}")
    _areas(report, rows, known)
    _verdicts(report, seen, known)


def _calibrated(
    report: Report, title: str, expected: Array, seen: Evidence, most: float | None = None
) -> None:
    """The median measured by bands of the predicted error; most: by how much both may differ."""
    table = report.table(title, "joints", "predicted", "measured", "off by less")
    for band in bands(expected, seen.error, FEWEST):
        wanted = []
        if most is not None and band.predicted_px > JUDGED_FROM_PX:
            wanted = [Expected("miscalibrated", band.miscalibration, most)]
        row = band.count, band.predicted_px, band.measured_px, f"{band.under:.0%}"
        table.row(band.name, *row, expected=wanted)


def _areas(report: Report, seen: Evidence, known: Sequence[str]) -> None:
    """By clip how well wrong joints are told from right ones, as predicted and by other clips."""
    ways = {"as predicted": seen.column("expected")}
    ways |= {f"+ {names[-1]}": _left_out(seen, names, known) for names in FITTED_BY}
    table = report.table("area under the curve of wrong joints", *ways)
    wrong, clips = seen.error > WRONG, seen.clip_of_joint
    found = np.array(
        [
            [auroc(wrong[clips == name], way[clips == name]) for way in ways.values()]
            for name in known
        ]
    )
    for name, row in zip(known, found.tolist(), strict=True):
        table.row(name, *row)
    means = np.nanmean(found, axis=0).tolist()
    table.row("all", *means, expected=[Expected("short of", AUROC - means[0], 0.0)])


def _left_out(seen: Evidence, columns: Sequence[str], known: Sequence[str]) -> Array:
    """(J,) error expected by weights fitted on the other clips."""
    expected, clips = np.full(len(seen.of), np.nan), seen.clip_of_joint
    values = [seen.column(name) for name in columns]
    rows = np.stack([np.ones(len(clips)), *(_log(seen, name) for name in columns)], axis=1)
    for name in known:
        here, others = clips == name, clips != name
        if tuple(columns) == FITTED_BY[0]:
            weights = fitted(*(v[others] for v in values), seen.error[others], clips[others])
            expected[here] = weights.median(*(v[here] for v in values))
        else:
            true = np.log(np.maximum(seen.error[others], LEAST))
            expected[here] = np.exp(
                rows[here] @ median_weights(rows[others], true, even(clips[others], 0.5))
            )
    return expected


def _log(seen: Evidence, name: str) -> Array:
    values = seen.column(name)
    if name == "away":
        return np.log(values + 1)
    if name == "visibility":
        return np.log(1 - values + LEAST)
    return np.log(np.nan_to_num(values, nan=UNKNOWN) + LEAST)


def _verdicts(report: Report, seen: Evidence, known: Sequence[str]) -> None:
    """Whether *good* is said and true, the part named is wrong, and what is lost is off."""
    table = report.table(
        "verdicts, of segments",
        "segments",
        "right",
        "said good",
        "good right",
        "lost",
        "off person",
        "so said",
        "wrong",
        "part named",
    )
    figures = _Segments.of(seen)
    for name in known:
        _verdict_row(table, name, figures, seen.clips == name)
    _verdict_row(table, "all", figures, np.ones(len(seen.clips), np.bool_))


@dataclass(frozen=True, eq=False)
class _Segments:
    """Of G segments, each (G,): right; said to be good, lost; a keyframe off the person; with a
    wrong joint; the named part among those that carry the two worst."""

    right: NDArray[np.bool_]
    good: NDArray[np.bool_]
    lost: NDArray[np.bool_]
    off: NDArray[np.bool_]
    wrong: NDArray[np.bool_]
    named: NDArray[np.bool_]

    @classmethod
    def of(cls, seen: Evidence) -> _Segments:
        count, error = len(seen.clips), seen.error
        right, wrong, named = np.zeros((3, count), np.bool_)
        part, raw = seen.column("part").astype(int), seen.column("wrong_by")
        for k in range(count):
            at = seen.of == k
            mark = MARK_PX.get(str(seen.clips[k]), 0.0) / TALL_PX
            mean = without_marks(raw[at].mean(), np.array(mark))
            right[k] = mean * TALL_PX <= RIGHT_PX
            by_part = {p: float(error[at & (part == p)].mean()) for p in set(part[at].tolist())}
            two = sorted(by_part, key=lambda p: -by_part[p])[:2]
            wrong[k] = by_part[two[0]] > WRONG
            named[k] = int(seen.part[k]) in two
        return cls(right, seen.kinds == "good", seen.kinds == "lost", seen.off, wrong, named)


def _verdict_row(table: Table, name: str, of: _Segments, rows: NDArray[np.bool_]) -> None:
    good, on = _share(of.good, rows & of.right), rows & ~of.off
    true, named = _share(of.right, rows & of.good), _share(of.named, on & of.wrong & ~of.good)
    expected = []
    if name == "all":
        expected = [
            Expected("not said", 1 - good, 1 - GOOD_OFTEN),
            Expected("wrongly said", 1 - true, 1 - GOOD_TRUE),
            Expected("another part", 1 - named, 1 - NAMED),
        ]
    table.row(
        name,
        int(rows.sum()),
        f"{_share(of.right, rows):.0%}",
        f"{good:.0%}",
        f"{true:.0%}",
        int((of.lost & on).sum()),
        int((rows & of.off).sum()),
        int((rows & of.off & of.lost).sum()),
        int((on & of.wrong).sum()),
        f"{named:.0%}",
        expected=expected,
    )


def _share(of: NDArray[np.bool_], rows: NDArray[np.bool_]) -> float:
    """The share of some segments; all of none."""
    return float(of[rows].mean()) if rows.any() else 1.0
