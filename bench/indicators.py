"""What a result says about its own errors, compared with the errors: how good is the verdict?

A joint is wrong when it is more than 10 px off on a person 400 px tall. An indicator is any number
that is larger the less the result trusts a joint; how well it orders joints is its AUROC, and how
well it can be read as a probability is measured by calibrating it on all clips but one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit
from scipy.stats import rankdata

from bench.clips import Clip, place
from bench.measures import FAR_PX, VERY_FAR_PX, marks_between
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.tracking.result import SegmentResult

Indicator = Callable[[SegmentResult, int, int, Skeleton], float]
"""Of a segment, a frame, and the joint where a part begins: how little the result trusts it."""

SMALL_PX = 5.0
"""A segment is right when its marks are less than that off in the mean, in the film or on a person
400 px tall: in a smaller film marks are good to no less, in a larger one they are no finer."""
BINS = 10


def of_segment(segment: SegmentResult, frame: int, part: int, skeleton: Skeleton) -> float:
    """The verdict on the whole segment."""
    return float({"good": 0, "check": 1, "lost": 2, None: 1}[segment.kind])


def of_named_part(segment: SegmentResult, frame: int, part: int, skeleton: Skeleton) -> float:
    """The same, a half more where the verdict names this part at this frame."""
    verdict, whole = segment.verdict, of_segment(segment, frame, part, skeleton)
    if verdict is None or verdict.part != skeleton.body.names[part] or verdict.frames is None:
        return whole
    return whole + 0.5 * (verdict.frames[0] <= frame <= verdict.frames[1])


def of_observability(segment: SegmentResult, frame: int, part: int, skeleton: Skeleton) -> float:
    """How little the pictures decided of the part in the step that leads to the frame; of a part
    that is not tracked, as of the whole body in the mean; where nothing was measured, 1."""
    row = segment.diagnostics.observability[max(frame - segment.first - 1, 0)]
    known = row[[part]] if np.isfinite(row[part]) else row[np.isfinite(row)]
    return 1.0 - (float(known.mean()) if known.size else 0.0)


def of_expected_error(segment: SegmentResult, frame: int, part: int, skeleton: Skeleton) -> float:
    """Of the part that ends in the joint; where nothing is expected of it, of the whole body."""
    expected = segment.diagnostics.expected_error
    if expected is None:
        return 0.0
    row = expected[frame - segment.first]
    own = float(row[skeleton.parents[part]])
    return own if np.isfinite(own) else float(np.nanmean(row))


INDICATORS: dict[str, Indicator] = {
    "verdict": of_segment,
    "verdict and part": of_named_part,
    "observability": of_observability,
    "expected error": of_expected_error,
}
"""All that are compared; a result that carries more adds a line."""


@dataclass(frozen=True)
class Record:
    """A joint at a frame: how far it is off, scaled, and its indicators."""

    clip: str
    row: str
    way: str
    jitter: int
    span: tuple[int, int]
    kind: str
    frame: int
    joint: str
    px: float
    scaled_px: float
    indicators: Mapping[str, float]

    @property
    def wrong(self) -> bool:
        return self.scaled_px > FAR_PX

    @property
    def segment(self) -> tuple[str, str, int, tuple[int, int]]:
        return self.row, self.way, self.jitter, self.span

    def as_json(self) -> dict[str, Any]:
        return asdict(self)


def records(
    clip: Clip, skeleton: Skeleton, segments: Sequence[SegmentResult], row: str, way: str,
    jitter: int,
) -> list[Record]:  # fmt: skip
    """One record for each mark strictly between keyframes."""
    found = []
    for segment in segments:
        for mark in marks_between(clip, skeleton, segment.trajectory, segment.span):
            part = place(skeleton.body, mark.joint)[0][0]
            where = (segment, mark.frame, part, skeleton)
            values = {name: of(*where) for name, of in INDICATORS.items()}
            given = (row, way, jitter, segment.span, str(segment.kind))
            off = mark.px, mark.scaled_px
            found.append(Record(clip.name, *given, mark.frame, mark.joint, *off, values))
    return found


def auroc(values: Array, wrong: NDArray[np.bool_]) -> float:
    """The share of pairs, one wrong and one right, of which the wrong one's value is larger; ties
    count half (Mann and Whitney 1947). NaN where all are wrong or all are right."""
    bad, good = int(wrong.sum()), int((~wrong).sum())
    if not bad or not good:
        return np.nan
    ranks = rankdata(values)[wrong].sum()
    return float((ranks - bad * (bad + 1) / 2) / (bad * good))


@dataclass(frozen=True)
class Quality:
    """How well an indicator orders joints.

    auroc: over all clips.  The others are of probabilities by a curve fitted to the other clips.
    left_out: AUROC within the clip that was left out, the mean over clips.
    very_far: the same of joints that are further off than `VERY_FAR_PX`.
    brier: mean squared error.  calibration: mean distance, over ten equal groups, of the mean
    probability from the share that is wrong.
    """

    auroc: float
    left_out: float
    very_far: float
    brier: float
    calibration: float


def judged(some: Sequence[Record], name: str) -> Quality:
    """How well one indicator orders some records; NaN where fewer than two clips are there."""
    values = np.array([r.indicators[name] for r in some])
    wrong, clips = np.array([r.wrong for r in some]), np.array([r.clip for r in some])
    overall = auroc(values, wrong)
    logits = left_out(values, wrong, clips)
    if not np.isfinite(logits).all():
        return Quality(overall, np.nan, np.nan, np.nan, np.nan)
    p, lost = np.asarray(expit(logits)), np.array([r.scaled_px > VERY_FAR_PX for r in some])
    return Quality(
        overall,
        _within(logits, wrong, clips),
        _within(logits, lost, clips),
        float(((p - wrong) ** 2).mean()),
        miscalibration(p, wrong),
    )


def _within(logits: Array, wrong: NDArray[np.bool_], clips: NDArray[np.str_]) -> float:
    """The mean AUROC of those clips that have right joints and wrong ones."""
    within = [auroc(logits[clips == clip], wrong[clips == clip]) for clip in np.unique(clips)]
    known = [one for one in within if np.isfinite(one)]
    return float(np.mean(known)) if known else np.nan


def left_out(values: Array, wrong: NDArray[np.bool_], clips: NDArray[np.str_]) -> Array:
    """Of each record the log odds that it is wrong, by a curve fitted to the other clips."""
    logits = np.full(len(values), np.nan)
    for clip in np.unique(clips):
        others = clips != clip
        if others.any():
            a, b = logistic(values[others], wrong[others])
            logits[~others] = a + b * values[~others]
    return logits


def logistic(values: Array, wrong: NDArray[np.bool_]) -> tuple[float, float]:
    """Offset and slope of the likeliest logistic curve; a weak prior keeps the slope finite."""

    def loss(curve: Array) -> float:
        z = curve[0] + curve[1] * values
        return float(np.logaddexp(0, np.where(wrong, -z, z)).sum() + 0.005 * curve[1] ** 2)

    a, b = minimize(loss, np.zeros(2)).x
    return float(a), float(b)


def miscalibration(p: Array, wrong: NDArray[np.bool_]) -> float:
    """Over ten groups of equal number, by probability: how far it is from what is wrong."""
    groups = np.array_split(np.argsort(p, kind="stable"), BINS)
    apart = [len(g) * abs(p[g].mean() - wrong[g].mean()) for g in groups if len(g)]
    return float(sum(apart) / len(p))


@dataclass(frozen=True)
class Segments:
    """Of segments: how many are right, of these the share called good, and of those called good
    the share that is right."""

    count: int
    right: int
    called_good: float
    good_is_right: float


def by_segment(some: Sequence[Record]) -> Segments:
    """The verdicts on whole segments."""
    errors: dict[Any, list[tuple[float, float]]] = {}
    kinds: dict[Any, str] = {}
    for record in some:
        errors.setdefault(record.segment, []).append((record.px, record.scaled_px))
        kinds[record.segment] = record.kind
    right = np.array([np.mean(px, axis=0).min() < SMALL_PX for px in errors.values()])
    good = np.array([kinds[segment] == "good" for segment in errors])
    both = float((right & good).sum())
    return Segments(
        len(right), int(right.sum()), both / right.sum() if right.any() else np.nan,
        both / good.sum() if good.any() else np.nan,
    )  # fmt: skip
