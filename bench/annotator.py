"""How many keyframes someone must set until a motion is right, by every way to fill in the rest.

A simulated annotator poses both ends of a rendered motion, looks at what comes of it, and poses one
frame more until the mean error of all joints over all frames is small enough. Whoever poses errs: a
frame's error is the same for all rivals, since it follows from the motion's name and the frame.

What is posed wrongly is wrong between the keyframes, too: 1° at every angle and 0.5 cm at the root
put the joints of these bodies 2 cm and 2–3 px off, by way of trunk and limbs, and 3° and 1.5 cm
three times as far. So the bounds are for what is added to that: a motion is right when its mean
error is below √(floor² + added²), the floor being the mean error of all frames were each one posed.
At the exact level the floor is none.
"""

from __future__ import annotations

import zlib
from bisect import insort
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from threadpoolctl import threadpool_limits

from bench.keeping import Absent
from bench.sequences import Sequence as Shown
from bench.sequences import sequence
from bench.table import Expected, Report, Table
from bench.tracking import track
from keypose.app.editor.advice import suggestion
from keypose.tracker.body.pose import moved
from keypose.tracker.body.trajectory import Trajectory, interpolate, joined
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.settings import MethodName
from keypose.tracker.storage.results import Span
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.tracker import Tracker

MOTIONS = ("walk", "jump", "wash", "pirouette", "jumping_jacks", "throw", "speech")
GIVE_UP_FRAMES = 3
"""With a keyframe in so many frames, the annotator gives up."""
HALF, SEVENTY = 0.5, 0.7
"""Most keyframes of ours, as shares of the paper's, and of ours keyed in the middle."""


@dataclass(frozen=True)
class Level:
    """How well the annotator poses, and what tracking may add to that.

    turn_deg, shift_cm: standard deviations at every tracked angle, and of the root along each axis.
    """

    name: str
    turn_deg: float
    shift_cm: float
    added_cm: float
    added_px: float


LEVELS = (
    Level("exact", 0.0, 0.0, 2.0, 2.0),
    Level("1°, 0.5 cm", 1.0, 0.5, 2.0, 2.0),
    Level("3°, 1.5 cm", 3.0, 1.5, 3.0, 3.0),
)


@dataclass(frozen=True, eq=False)
class Task:
    """One motion and one annotator.

    posed: (every frame) as the annotator would pose it.  floor, bound: cm and px, means over all
    joints and frames.  kept: results by method and span, for keyframes never change.
    """

    name: str
    shown: Shown
    posed: Trajectory
    floor: Array
    bound: Array
    tracker: Tracker
    kept: dict[tuple[MethodName, Span], SegmentResult] = field(default_factory=dict)

    @classmethod
    def of(cls, name: str, level: Level) -> Task:
        shown = sequence(name)
        posed = posed_by_hand(name, shown, level)
        floor = _errors(shown, posed).mean(axis=0)
        bound = np.hypot(floor, [level.added_cm, level.added_px])
        ends = {frame: posed.pose(frame) for frame in (0, len(posed) - 1)}
        tracker = Tracker(shown.video(), shown.camera, shown.skeleton, ends)
        return cls(name, shown, posed, floor, bound, tracker)

    def errors(self, trajectory: Trajectory) -> Array:
        """(N, 2) cm and px of every frame, means over all joints and landmarks."""
        return _errors(self.shown, trajectory)

    def interpolated(self, span: Span) -> Trajectory:
        first, last = span
        return interpolate(self.posed.pose(first), self.posed.pose(last), first, last)

    def tracked(self, method: MethodName, span: Span) -> SegmentResult:
        """The segment between two of the annotator's poses, at full quality."""
        if (method, span) not in self.kept:
            poses = {frame: self.posed.pose(frame) for frame in span}
            found = track(self.tracker.renewed(self.shown.skeleton, poses), method=method)
            self.kept[method, span] = found.segments[0]
        return self.kept[method, span]


@dataclass(frozen=True, eq=False)
class Seen:
    """What an annotator has before the eyes when choosing the next frame."""

    task: Task
    keys: Sequence[int]
    tracks: dict[Span, SegmentResult]
    errors: Array

    @property
    def worst(self) -> int:
        """The frame that is further from the truth than any other, and no keyframe yet."""
        over = (self.errors / self.task.bound).max(axis=1)
        over[list(self.keys)] = -np.inf
        return int(over.argmax())

    @property
    def middle(self) -> int:
        """The middle of the longest interval, the first of those."""
        first, last = max(pairwise(self.keys), key=lambda span: span[1] - span[0])
        return (first + last) // 2

    @property
    def suggested(self) -> int | None:
        """The keyframe that the page asks for, if it does."""
        count, parts = len(self.errors), self.task.shown.skeleton.body.names
        found = suggestion(self.keys, count, self.tracks, parts)
        return found.frame if found.kind == "key" else None


@dataclass(frozen=True)
class Rival:
    """A way to fill in the rest, and where the next keyframe is set.

    method: None interpolates.  choose: None where the annotator is to decide, who takes the middle.
    """

    name: str
    method: MethodName | None
    choose: Callable[[Seen], int | None]


RIVALS = (
    Rival("linear worst", None, lambda seen: seen.worst),
    Rival("paper middle", "paper", lambda seen: seen.middle),
    Rival("middle", "keypose", lambda seen: seen.middle),
    Rival("suggested", "keypose", lambda seen: seen.suggested),
    Rival("worst", "keypose", lambda seen: seen.worst),
)
"""The first and the last one know the truth, and key where the motion is furthest from it."""


@dataclass(frozen=True)
class Course:
    """The keyframes in the order they were set, and the errors with each number of them.

    cm, px: with the first two keyframes, the first three, and so on.
    unasked: how many of them the page did not ask for, though the motion was not right yet.
    """

    keyed: tuple[int, ...]
    cm: tuple[float, ...]
    px: tuple[float, ...]
    reached: bool
    unasked: int

    @property
    def count(self) -> int:
        return len(self.keyed)

    def __str__(self) -> str:
        unasked = f" ({self.unasked})" if self.unasked else ""
        return f"{'' if self.reached else '> '}{self.count}{unasked}"


def course(task: Task, rival: Rival) -> Course:
    """Pose frame after frame until the motion is right, or it is given up."""
    count = len(task.posed)
    keyed, keys = [0, count - 1], [0, count - 1]
    mean_errors: list[Array] = []
    unasked = 0
    while True:
        tracks, trajectory = _filled(task, rival.method, keys)
        errors = task.errors(trajectory)
        mean_errors.append(errors.mean(axis=0))
        reached = bool((mean_errors[-1] < task.bound).all())
        if reached or len(keys) >= count // GIVE_UP_FRAMES:
            cm, px = np.round(mean_errors, 3).T.tolist()
            return Course(tuple(keyed), tuple(cm), tuple(px), reached, unasked)
        seen = Seen(task, keys, tracks, errors)
        asked = rival.choose(seen)
        unasked += asked is None
        keyed.append(seen.middle if asked is None else asked)
        insort(keys, keyed[-1])


def posed_by_hand(name: str, shown: Shown, level: Level) -> Trajectory:
    """Every frame of a motion as the annotator would pose it."""
    skeleton, poses = shown.skeleton, []
    sigma = np.where(
        skeleton.dof_turns == 1, np.radians(level.turn_deg), level.shift_cm / 100
    )  # fmt: skip
    for frame in range(len(shown.truth)):
        random = np.random.default_rng([zlib.crc32(name.encode()), frame])
        error = random.normal(size=skeleton.dof_count) * sigma
        poses.append(moved(skeleton, shown.truth.pose(frame), error))
    return Trajectory(
        0, np.stack([p.Rs_parent_part for p in poses]), np.stack([p.p_camera_root for p in poses])
    )


def annotator(report: Report) -> None:
    """The whole group."""
    report.note("keyframes set until the mean joint error of all frames is small enough; posing")
    report.note("error and what may be added, in squares, stand in each table's name. In brackets:")
    report.note("so many the page did not ask for, and the middle was taken")
    with threadpool_limits(1):
        for level in LEVELS:
            added = f"{level.added_cm:.0f} cm and {level.added_px:.0f} px"
            title = f"posed within {level.name}, to add {added}"
            measured(report.table(title, *(rival.name for rival in RIVALS), "bound"), level)


def measured(table: Table, level: Level, motions: Sequence[str] = MOTIONS) -> None:
    """The courses of all motions and rivals at one level, and their sums."""
    counts = []
    for name in motions:
        try:
            task = Task.of(name, level)
        except Absent:
            continue
        courses = [course(task, rival) for rival in RIVALS]
        counts.append([found.count for found in courses])
        table.row(name, *courses, "{:.1f}/{:.1f}".format(*task.bound))
    sums = np.sum(counts, axis=0).tolist()
    if not counts:
        raise Absent("every motion")
    at = {rival.name: total for rival, total in zip(RIVALS, sums, strict=True)}
    expected = [
        Expected("suggested", at["suggested"], HALF * at["paper middle"], "half of paper"),
        Expected("", at["suggested"], SEVENTY * at["middle"], "70 % of middle"),
    ]
    table.row("sum", *sums, "", expected=expected)
    table.row("share of paper middle", *(s / at["paper middle"] for s in sums), "")


def _errors(shown: Shown, trajectory: Trajectory) -> Array:
    ours, true = (path.joints(shown.skeleton) for path in (trajectory, shown.truth))
    px = np.linalg.norm(shown.camera.project(ours) - shown.camera.project(true), axis=-1)
    cm = 100 * np.linalg.norm(ours - true, axis=-1)
    return np.stack([cm.mean(axis=1), px.mean(axis=1)], axis=1)


def _filled(
    task: Task, method: MethodName | None, keys: Sequence[int]
) -> tuple[dict[Span, SegmentResult], Trajectory]:
    """Every segment's result, none for interpolation, and the whole motion."""
    spans = list(pairwise(keys))
    if method is None:
        return {}, joined([task.interpolated(span) for span in spans])
    tracks = {span: task.tracked(method, span) for span in spans}
    return tracks, joined([track.trajectory for track in tracks.values()])
