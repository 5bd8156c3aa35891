"""The tracked motion of one segment, with the key of what it was tracked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracker.body.trajectory import Trajectory
from tracker.geometry.rotations import Array, frozen
from tracker.session.settings import Quality
from tracker.session.verdict import Kind, Verdict

if TYPE_CHECKING:
    from tracker.tracking.pool import SegmentResult

RANK = {"preview": 0, "fast": 1, "full": 2}
"""Of two results with one key, the one found with more care stays."""


@dataclass(frozen=True, eq=False)
class SegmentTrack:
    """The motion between the keyframes at `first` and `last`.

    finished: False for a trajectory on the way: it has no verdict and no diagnostics (n = 0 rows).
    verdict: None for a trajectory on the way.
    scores, steps: of the trajectories on the way, and what each was; NaN where nothing was judged.
    observability, residual: (n, P) of the n = last − first steps, as in `observability`; so are
        rank (n,) and singular_values (n, D). All read-only.
    notes: what could not be done as wished, in sentences.
    need: (n + 1,) what a keyframe at each frame would mend, see `expected_gain`; None if unknown.
    missing: steps of the work that were not done, because it was stopped; 0 where all is done.
    unreached: the first and last frame that have no pose of their own then: see `tracked`.
    """

    first: int
    last: int
    key: str
    quality: Quality
    trajectory: Trajectory
    verdict: Verdict | None
    scores: tuple[float, ...]
    steps: tuple[str, ...]
    best_pass: int
    closing_error: float
    rank: NDArray[np.int64]
    singular_values: Array
    observability: Array
    residual: Array
    need: Array | None = None
    notes: tuple[str, ...] = ()
    missing: int = 0
    unreached: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        for name in ("singular_values", "observability", "residual"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        if self.need is not None:
            object.__setattr__(self, "need", frozen(self.need))
        rank = np.array(self.rank, dtype=np.int64)
        rank.setflags(write=False)
        object.__setattr__(self, "rank", rank)

    @classmethod
    def of(cls, key: str, quality: Quality, result: SegmentResult) -> SegmentTrack:
        """A finished segment as the tracker hands it over."""
        path = result.trajectory
        return cls(
            path.first_frame, path.last_frame, key, quality, path, result.verdict,
            result.scores, result.steps, result.best_pass, result.closing_error,
            result.rank, result.singular_values, result.observability, result.residual,
            result.need, result.notes, result.missing, result.unreached,
        )  # fmt: skip

    @classmethod
    def on_the_way(cls, key: str, quality: Quality, path: Trajectory, score: float) -> SegmentTrack:
        """A trajectory after one of the passes."""
        nothing, unranked = np.empty((0, path.Rs_parent_part.shape[1])), np.empty(0, np.int64)
        return cls(
            path.first_frame, path.last_frame, key, quality, path, None,
            (score,), ("pass",), 0, np.nan, unranked, np.empty((0, 0)), nothing, nothing,
        )  # fmt: skip

    @property
    def finished(self) -> bool:
        """Whether it can be used: judged, though perhaps stopped before all was done."""
        return self.verdict is not None

    @property
    def tracked(self) -> NDArray[np.bool_]:
        """(N,) True for the frames that have a pose of their own."""
        there = np.ones(len(self.trajectory), dtype=np.bool_)
        if self.unreached is not None:
            there[self.unreached[0] - self.first : self.unreached[1] + 1 - self.first] = False
        return there

    @property
    def span(self) -> tuple[int, int]:
        return self.first, self.last

    @property
    def kind(self) -> Kind | None:
        """Good, check or lost; None where there is no verdict yet."""
        return None if self.verdict is None else self.verdict.kind

    @property
    def go(self) -> int | None:
        """The frame to go to, where the verdict names one."""
        return None if self.verdict is None else self.verdict.go

    def supersedes(self, other: SegmentTrack) -> bool:
        """Whether this is to stand where `other` of the same key stood.

        What is finished yields only to what is finished, lacks no more of the work, and was done
        with no less care.
        """
        mine, its = ((t.finished, -t.missing, RANK[t.quality]) for t in (self, other))
        return mine >= its
