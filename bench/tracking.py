"""Tracking a case by every method, and what the methods are told by the truth."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from unittest.mock import patch

import numpy as np

from bench.table import Pair
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.tracking.initial.chains import follow
from keypose.tracker.tracking.method import FULL
from keypose.tracker.tracking.pool import PassFinished, TrackFinished, run
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.tracker import Tracker

Measure = Callable[[Trajectory], tuple[Array, ...]]
"""Errors of a trajectory, one array for each unit, at the frames strictly between its ends."""


@dataclass(frozen=True, eq=False)
class Tracked:
    """What tracking gave: the segments, and all trajectories tried in each."""

    segments: list[SegmentResult]
    tried: dict[int, list[Trajectory]] = field(default_factory=dict)

    @property
    def trajectories(self) -> list[Trajectory]:
        return [segment.trajectory for segment in self.segments]

    @property
    def closing_error(self) -> float:
        return max(segment.closing_error for segment in self.segments)

    @property
    def verdicts(self) -> str:
        """Such as "5 good 1 lost"."""
        kinds = Counter(segment.kind for segment in self.segments)
        return " ".join(f"{kinds[k]} {k}" for k in ("good", "check", "lost") if kinds[k])

    @property
    def kept(self) -> str:
        """Which candidates were kept, by their first letters: i, b, p, r."""
        steps = Counter(segment.steps[segment.best_pass][0] for segment in self.segments)
        return " ".join(f"{count}{step}" for step, count in sorted(steps.items()))


def keyframes_every(interval: int, first: int, last: int) -> list[int]:
    """Frames from first on, as far as whole intervals reach."""
    return list(range(first, last + 1, interval))


def track(tracker: Tracker, workers: int = 1, **settings: Any) -> Tracked:
    """Track all segments with these settings."""
    tried: dict[int, list[Trajectory]] = {}
    for event in run(tracker, TrackSettings(**settings), workers=workers):
        if isinstance(event, PassFinished):
            tried.setdefault(event.index, []).append(event.trajectory)
        if isinstance(event, TrackFinished):
            return Tracked(list(event.result.segments), tried)
    raise AssertionError("tracking ended without saying so")


def linear(tracker: Tracker) -> list[Trajectory]:
    """Interpolation of every segment's keyframes."""
    keyposes = tracker.keyposes
    return [interpolate(keyposes[a], keyposes[b], a, b) for a, b in tracker.spans]


def forward(tracker: Tracker) -> list[Trajectory]:
    """Followed from each segment's first keyframe alone; the second one has no say."""
    how = (FULL.stride, FULL.chain_inner, FULL.stop, FULL.finest)
    return [
        follow(
            scene_of(tracker, (a, b)),
            tracker.loader((a, b)).load(a, b),
            tracker.keyposes[a],
            a,
            b,
            *how,
        )
        for a, b in tracker.spans
    ]


def scene_of(tracker: Tracker, span: tuple[int, int], density: float = FULL.density) -> Scene:
    """The scene of one segment, as the tracker lays it out."""
    return tracker.scene(span, density)


@contextmanager
def noted_rounds() -> Iterator[list[int]]:
    """All rounds that drift correction needs meanwhile; −1 where no single X was to be had."""
    import keypose.tracker.tracking.cycle as segment

    rounds: list[int] = []
    correct = segment.correct_drift

    def noting(*arguments: Any) -> Any:
        closed = correct(*arguments)
        rounds.extend(closed.rounds.tolist())
        return closed

    with patch.object(segment, "correct_drift", noting):
        yield rounds


def against(skeleton: Skeleton, camera: Camera, truth: Trajectory) -> Measure:
    """Errors in cm and px, at all joints and landmarks, of trajectories whose truth is known."""
    joints = truth.joints(skeleton)

    def measure(found: Trajectory) -> tuple[Array, Array]:
        rows = slice(
            found.first_frame - truth.first_frame + 1, found.last_frame - truth.first_frame
        )
        ours, true = found.joints(skeleton)[1:-1], joints[rows]
        px = np.linalg.norm(camera.project(ours) - camera.project(true), axis=-1)
        return 100 * np.linalg.norm(ours - true, axis=-1), px

    return measure


def mean_errors(measure: Measure, trajectories: list[Trajectory]) -> Pair:
    """Mean cm and px over the segments' inner frames."""
    cm, px = zip(*(measure(trajectory) for trajectory in trajectories), strict=True)
    return Pair(float(np.mean(_flat(cm))), float(np.mean(_flat(px))), ("cm", "px"))


def best_tried(measure: Measure, tried: Mapping[int, list[Trajectory]]) -> Pair:
    """The same if the truth had chosen among each segment's candidates, by px."""
    chosen = [
        min(candidates, key=lambda t: float(np.nan_to_num(measure(t)[1].mean(), nan=np.inf)))
        for candidates in tried.values()
    ]
    return mean_errors(measure, chosen)


def _flat(errors: tuple[Array, ...]) -> Array:
    return np.concatenate([e.ravel() for e in errors])
