"""What tracking found for the segments between keyframes: one type, from the tracker to the disk.

A new array of the diagnostics is one field of `Diagnostics`, declared with its layout: its copies,
its place in the tracks file and its rows among those of other segments follow from that. A new
fact of a segment is a field of `SegmentResult`, and one of the same name in
`keypose.tracker.session.results.SegmentSummary` where it is to be saved.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import Field, dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Pass, Trajectory, joined

if TYPE_CHECKING:
    from keypose.tracker.body.skeleton import Skeleton
    from keypose.tracker.geometry.rotations import Array
    from keypose.tracker.session.settings import Quality, TrackSettings
    from keypose.tracker.session.verdict import Kind, Verdict


class Column(NamedTuple):
    """The layout of an array of the diagnostics.

    rows: for every frame, or for every step from a frame to the next.
    width: of a row: a number, one of each part, or one of each degree of freedom.
    unknown: what stands in rows of which nothing is known.
    """

    name: str
    stored_as: str
    rows: Literal["step", "frame"]
    width: Literal["", "part", "dof"]
    dtype: str
    optional: bool

    @classmethod
    def of(cls, declared: Field[Any]) -> Column:
        """The column as a field of `Diagnostics` declares it."""
        layout = dict(declared.metadata)
        return cls(declared.name, layout.pop("stored_as") or declared.name, **layout)

    @property
    def unknown(self) -> float:
        return -1 if self.dtype == "<i8" else np.nan

    def shape(self, frames: int, parts: int, dofs: int) -> tuple[int, ...]:
        """The shape of the whole array."""
        width = {"": (), "part": (parts,), "dof": (dofs,)}[self.width]
        return (frames - (self.rows == "step"), *width)


def _layout(
    rows: Literal["step", "frame"],
    width: Literal["", "part", "dof"] = "",
    *,
    dtype: str = "<f8",
    stored_as: str = "",
    optional: bool = False,
) -> dict[str, Any]:
    """What a field of `Diagnostics` declares of its array, see `Column`."""
    return {
        "rows": rows,
        "width": width,
        "dtype": dtype,
        "stored_as": stored_as,
        "optional": optional,
    }


def side_by_side(
    pieces: Iterable[tuple[int, NDArray[Any]]],
    count: int,
    width: tuple[int, ...] = (),
    unknown: float = np.nan,
    dtype: str = "<f8",
) -> NDArray[Any]:
    """(count, *width) rows of pieces, each from its own first row on; `unknown` elsewhere.

    A piece may begin before row 0 or reach beyond the last: those rows are left out. Where two
    pieces overlap, the later one stands.
    """
    whole = np.full((count, *width), unknown, dtype)
    for start, rows in pieces:
        begin, end = max(start, 0), min(start + len(rows), count)
        if begin < end:
            whole[begin:end] = rows[begin - start : end - start]
    return whole


@dataclass(frozen=True, eq=False)
class Diagnostics:
    """The diagnostics of a motion of N frames, so of n = N − 1 steps. Arrays are read-only.

    rank: (n,) singular values above the cut, see
        `keypose.tracker.tracking.diagnostics.observability`;
        −1 where nothing was measured.
    singular_values: (n, D), largest first.
    observability: (n, P) 0 to 1, NaN where nothing is tracked.
    residual: (n, P) grey levels, of surfaces metres; NaN where unseen.
    expected_gain: (N,) of a keyframe at each frame, see
        `keypose.tracker.tracking.diagnostics.expected_gain`; None where that is not known of any.
    expected_error: (N, P) pixels of the video by which the joint at a part's far end is expected to
        be off, see `keypose.tracker.tracking.cues.joint_evidence`; NaN where no keypoint was seen.
    expected_depth: (N, P) metres along the view, from the middle of the hips, the same; NaN where
        no depth was lifted.
    """

    rank: NDArray[np.int64] = field(metadata=_layout("step", dtype="<i8"))
    singular_values: Array = field(metadata=_layout("step", "dof"))
    observability: Array = field(metadata=_layout("step", "part"))
    residual: Array = field(metadata=_layout("step", "part"))
    expected_gain: Array | None = field(
        default=None, metadata=_layout("frame", stored_as="need", optional=True)
    )
    expected_error: Array | None = field(
        default=None, metadata=_layout("frame", "part", optional=True)
    )
    expected_depth: Array | None = field(
        default=None, metadata=_layout("frame", "part", optional=True)
    )

    def __post_init__(self) -> None:
        for column, rows in self.arrays():
            copy = np.array(rows, dtype=column.dtype, order="C")
            copy.setflags(write=False)
            object.__setattr__(self, column.name, copy)

    @classmethod
    def side_by_side(
        cls, pieces: Sequence[tuple[int, Diagnostics]], frames: int, parts: int, dofs: int
    ) -> Diagnostics:
        """Pieces, each from its own first frame on; unknown between them."""
        arrays = {}
        for column in COLUMNS:
            present = [
                (at, rows) for at, piece in pieces if (rows := piece.rows(column)) is not None
            ]
            if present or not column.optional:
                shape = column.shape(frames, parts, dofs)
                arrays[column.name] = side_by_side(
                    present, shape[0], shape[1:], column.unknown, column.dtype
                )
        return cls(**arrays)

    def arrays(self) -> Iterator[tuple[Column, NDArray[Any]]]:
        """The arrays that are there."""
        for column in COLUMNS:
            rows = self.rows(column)
            if rows is not None:
                yield column, rows

    def rows(self, column: Column) -> NDArray[Any] | None:
        """The array of a column; None where that is not known."""
        return getattr(self, column.name)  # type: ignore[no-any-return]

    def between(self, first: int, last: int) -> Diagnostics:
        """Cut to the frames first to last, counted from this one's first; unknown beyond
        its ends.
        """
        parts, dofs = self.observability.shape[1], self.singular_values.shape[1]
        return Diagnostics.side_by_side([(-first, self)], last - first + 1, parts, dofs)

    def complete(self) -> Diagnostics:
        """Without the optional arrays that are not known of every row."""
        return Diagnostics(
            **{
                column.name: rows
                for column, rows in self.arrays()
                if not column.optional or _every_row_has_a_value(rows)
            }
        )


def _every_row_has_a_value(rows: NDArray[Any]) -> bool:
    """Whether something is known of every row."""
    return bool(np.isfinite(rows).reshape(len(rows), -1).any(axis=1).all())


COLUMNS = tuple(Column.of(each) for each in fields(Diagnostics))


@dataclass(frozen=True, eq=False)
class SegmentResult:
    """The motion of one segment, with its verdict and diagnostics.

    trajectory: of the frames from one keyframe to the next, both included.
    verdict: None for an intermediate trajectory.
    scores, steps: of the first trajectory and after every pass, comparable within the segment only,
        and what each was; NaN where nothing was judged.
    best_pass: which of them was chosen.  closing_error: distance from the keyframes, must be ~0.
    notes: sentences for a person about what could not be done as asked.
    missing: steps of the work that were not done, because it was stopped; 0 where all is done.
    unreached: the first and last frame that therefore have no pose of their own; the nearest one's
        stands there.
    key: of what it was tracked for, see `keypose.tracker.storage.fingerprints`; empty where not
        known.
    quality: what it was found with.
    body: the id of the body that it is of; empty where not known.
    before_space: the trajectory as tracked, where `trajectory` is that of the last solve in space.
    """

    trajectory: Trajectory
    verdict: Verdict | None
    diagnostics: Diagnostics
    scores: tuple[float, ...] = ()
    steps: tuple[str, ...] = ()
    best_pass: int = 0
    closing_error: float = np.nan
    notes: tuple[str, ...] = ()
    missing: int = 0
    unreached: tuple[int, int] | None = None
    key: str = ""
    quality: Quality = "full"
    body: str = ""
    before_space: Trajectory | None = None

    @classmethod
    def on_the_way(cls, step: Pass, key: str = "", quality: Quality = "full") -> SegmentResult:
        """A trajectory after one of the passes: nothing has been measured yet."""
        path, score = step.trajectory, step.score_or_nan
        unknown = Diagnostics.side_by_side((), len(path), path.Rs_parent_part.shape[1], 0)
        return cls(path, None, unknown, (score,), (step.what,), key=key, quality=quality)

    @property
    def first(self) -> int:
        """The first keyframe's frame."""
        return self.trajectory.first_frame

    @property
    def last(self) -> int:
        """The second keyframe's frame."""
        return self.trajectory.last_frame

    @property
    def span(self) -> tuple[int, int]:
        return self.first, self.last

    @property
    def finished(self) -> bool:
        """Whether it can be used: judged, though perhaps stopped before all was done."""
        return self.verdict is not None

    @property
    def kind(self) -> Kind | None:
        """Good, check or lost; None where there is no verdict yet."""
        return None if self.verdict is None else self.verdict.kind

    @property
    def go(self) -> int | None:
        """The frame to go to, where the verdict names one."""
        return None if self.verdict is None else self.verdict.go

    def in_space(self, motion: Trajectory) -> SegmentResult:
        """The same with its frames of the last solve."""
        rows = slice(self.first - motion.first_frame, self.last + 1 - motion.first_frame)
        path = Trajectory(self.first, motion.Rs_parent_part[rows], motion.ps_camera_root[rows])
        return replace(self, trajectory=path, before_space=self.trajectory)

    @property
    def as_tracked(self) -> SegmentResult:
        """The same before the last solve."""
        if self.before_space is None:
            return self
        return replace(self, trajectory=self.before_space, before_space=None)

    @property
    def tracked(self) -> NDArray[np.bool_]:
        """(N,) True for the frames that have a pose of their own."""
        there = np.ones(len(self.trajectory), dtype=np.bool_)
        if self.unreached is not None:
            there[self.unreached[0] - self.first : self.unreached[1] + 1 - self.first] = False
        return there

    def where_tracked(self, rows: NDArray[Any]) -> NDArray[Any]:
        """Rows of the N frames, NaN where a frame has no pose of its own."""
        if self.unreached is None:
            return rows
        return np.where(self.tracked.reshape(-1, *(1,) * (rows.ndim - 1)), rows, np.nan)


@dataclass(frozen=True, eq=False)
class TrackResult:
    """The segments that were tracked, in order."""

    skeleton: Skeleton
    settings: TrackSettings
    segments: tuple[SegmentResult, ...]

    @property
    def trajectory(self) -> Trajectory:
        """One trajectory over all segments; they must be neighbours."""
        return joined([segment.trajectory for segment in self.segments])
