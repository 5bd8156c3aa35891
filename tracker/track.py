"""Tracking between keyframes: the segments, side by side or in turn, as a stream of events."""

from __future__ import annotations

import queue
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass
from itertools import pairwise
from threading import Event
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tracker.camera import Camera
from tracker.drift import closing_error
from tracker.errors import SessionError
from tracker.geometry import Array
from tracker.initial import brought
from tracker.loading import MEMORY_BYTES, ClipLoader, WorkingSize, demand_short
from tracker.methods import Method, Paper, method_of
from tracker.need import expected_gain
from tracker.observe import observe, unobserved
from tracker.points import SurfacePoints, lay_points
from tracker.pose import Pose
from tracker.scene import Scene
from tracker.scoring import Pass
from tracker.segment import Outcome, track_segment
from tracker.settings import IgnoreMask, TrackSettings
from tracker.skeleton import Skeleton
from tracker.stretch import Segment
from tracker.trajectory import Trajectory, joined
from tracker.verdict import Verdict, judge
from tracker.video import Video


@dataclass(frozen=True, eq=False)
class SegmentResult:
    """The motion between two keyframes and all that was noticed on the way.

    trajectory: both keyframes included, N frames; the arrays below have a row for each of the
        n = N − 1 frame pairs and are explained in tracker.observe.
    scores: of the first trajectory and after every pass; comparable within the segment only.
    best_pass: which of them was kept.  closing_error: distance from the keyframes, must be ~0.
    notes: what could not be done as wished, in sentences for a person.
    need: (N,) what a keyframe at each frame would mend, see tracker.need; None where not known.
    missing: steps of the work that were not done, because it was left; 0 where all is done.
    """

    trajectory: Trajectory
    scores: tuple[float, ...]
    steps: tuple[str, ...]
    best_pass: int
    closing_error: float
    verdict: Verdict
    rank: NDArray[np.int64]
    singular_values: Array
    observability: Array
    residual: Array
    notes: tuple[str, ...] = ()
    need: Array | None = None
    missing: int = 0


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


@dataclass(frozen=True, eq=False)
class SegmentStarted:
    """Work on the session's segment `index` begins; `count` segments are to be tracked."""

    index: int
    count: int
    first_frame: int
    last_frame: int


@dataclass(frozen=True, eq=False)
class PassFinished:
    """One more trajectory of a segment; `of` is how many are to be expected."""

    index: int
    number: int
    of: int
    score: float
    trajectory: Trajectory


@dataclass(frozen=True, eq=False)
class SegmentFinished:
    """A segment is done."""

    index: int
    count: int
    result: SegmentResult


@dataclass(frozen=True, eq=False)
class TrackFinished:
    """All that was asked for is done, or what was finished when tracking was cancelled."""

    result: TrackResult
    cancelled: bool = False


Progress = SegmentStarted | PassFinished | SegmentFinished | TrackFinished


def never() -> bool:
    """Not cancelled."""
    return False


class Left(Exception):
    """Raised by who is told how it goes, to leave a segment unfinished."""


class SegmentTracker(Protocol):
    """What can track segments, whatever they are seen in."""

    @property
    def skeleton(self) -> Skeleton: ...

    @property
    def spans(self) -> Sequence[tuple[int, int]]:
        """First and last frame of every segment."""
        ...

    def expected_steps(self, index: int, settings: TrackSettings) -> int:
        """Numbers that `emit` is to be expected to count up to."""
        ...

    def run_segment(
        self, index: int, settings: TrackSettings, emit: Callable[[Pass, int], None]
    ) -> SegmentResult:
        """Track one segment; `emit` is told trajectories and may raise Left to stop the work, which
        comes out of here again unless a part of the result can be of use."""
        ...


class _Prepared:
    """The pictures of one video at every size they are worked on."""

    def __init__(
        self, video: Video, camera: Camera, masks: Sequence[IgnoreMask], static: bool, memory: int
    ) -> None:
        self._given = (masks, static, memory)
        self._video, self._camera, self._memory = video, camera, memory
        self._loaders: dict[WorkingSize, ClipLoader] = {}

    def loader(self, longest: int) -> ClipLoader:
        """The loader for segments of up to this many frames."""
        size = WorkingSize.for_camera(self._camera, longest, self._memory)
        if size not in self._loaders:
            self._loaders[size] = ClipLoader(self._video, self._camera, size, *self._given)
        return self._loaders[size]


class Tracker:
    """A video, a camera, a body and its keyposes, made ready to be tracked.

    Keep it to track again after a keyframe has changed: pictures stay prepared. Raises SessionError
    with fewer than two keyposes. `first_motion` is one to start from, wherever it reaches.
    """

    def __init__(
        self,
        video: Video,
        camera: Camera,
        skeleton: Skeleton,
        keyposes: Mapping[int, Pose],
        masks: Sequence[IgnoreMask] = (),
        static_camera: bool = False,
        memory: int = MEMORY_BYTES,
        first_motion: Trajectory | None = None,
    ) -> None:
        self._first_motion = first_motion
        self._prepared = _Prepared(video, camera, masks, static_camera, memory)
        self._laid: dict[float, SurfacePoints] = {}
        self._pose(skeleton, keyposes)

    def _pose(self, skeleton: Skeleton, keyposes: Mapping[int, Pose]) -> None:
        """Take keyposes of a body; the size worked at is what their longest segment allows."""
        _demand_two(keyposes)
        frames = sorted(keyposes)
        for first, last in pairwise(frames):
            demand_short(first, last)
        longest = max(b - a for a, b in pairwise(frames)) + 1
        self.skeleton = skeleton
        self.keyposes = {frame: keyposes[frame] for frame in frames}
        self.loader = self._prepared.loader(longest)
        self.size = self.loader.size
        self.camera = self.size.camera(self.loader.camera)

    def renewed(
        self,
        skeleton: Skeleton,
        keyposes: Mapping[int, Pose],
        first_motion: Trajectory | None = None,
    ) -> Tracker:
        """A tracker of other keyposes, or of another body, before the same video.

        Prepared pictures are shared between the two, and what was laid out for the body where it is
        the same object. Both may be in use at the same time.
        """
        other = copy(self)
        other._first_motion = first_motion
        if skeleton is not self.skeleton:
            other._laid = {}
        other._pose(skeleton, keyposes)
        return other

    def scene(self, span: tuple[int, int], density: float) -> Scene:
        """The scene of one segment, laid out for its own two keyposes."""
        poses = [self.keyposes[frame] for frame in span]
        return Scene.of(self.skeleton, self.camera, poses, density, self._lay)

    def _lay(self, skeleton: Skeleton, spacing_m: float) -> SurfacePoints:
        """Surface points, laid once for a spacing."""
        if spacing_m not in self._laid:
            self._laid[spacing_m] = lay_points(skeleton, spacing_m)
        return self._laid[spacing_m]

    @property
    def spans(self) -> list[tuple[int, int]]:
        """First and last frame of every segment."""
        return list(pairwise(self.keyposes))

    def expected_steps(self, index: int, settings: TrackSettings) -> int:
        """Trajectories that `run_segment` is to be expected to tell."""
        return expected_steps(settings)

    def move_keyframe(self, frame: int, pose: Pose) -> None:
        """Give an existing keyframe another pose."""
        if frame not in self.keyposes:
            raise SessionError(f"Frame {frame} has no keyframe; add it to the session first.")
        self.keyposes[frame] = pose

    def run_segment(
        self, index: int, settings: TrackSettings, emit: Callable[[Pass, int], None]
    ) -> SegmentResult:
        """Track one segment; `emit` is told every trajectory and may raise Left to stop it."""
        first, last = self.spans[index]
        start, end = self.keyposes[first], self.keyposes[last]
        imported = None
        if self._first_motion is not None:
            imported = brought(self._first_motion, start, end, first, last)
        segment = Segment(first, last, start, end, self.loader.load(first, last), imported)
        method = method_of(settings)
        scene = self.scene((first, last), method.density)
        work, number = track_segment(scene, segment, method), 0
        while True:
            try:
                step = next(work)
            except StopIteration as done:
                return _result(scene, segment, done.value, method)
            emit(step, number)
            number += 1


def _result(scene: Scene, segment: Segment, outcome: Outcome, method: Method) -> SegmentResult:
    judged = isinstance(method, Paper) or method.judged
    seen = (observe if judged else unobserved)(scene, segment.clip, outcome.trajectory)
    return SegmentResult(
        trajectory=outcome.trajectory,
        scores=tuple(_score_of(step) for step in outcome.passes),
        steps=tuple(step.what for step in outcome.passes),
        best_pass=outcome.best,
        closing_error=max(
            outcome.gap, closing_error(outcome.trajectory, segment.start, segment.end)
        ),
        verdict=judge(scene, segment, outcome, seen),
        rank=seen.rank,
        singular_values=seen.singular_values,
        observability=seen.observability,
        residual=seen.residual,
        notes=outcome.notes,
        need=expected_gain(scene, outcome, seen),
    )


def _score_of(step: Pass) -> float:
    return np.nan if step.score is None else step.score


def run(
    tracker: SegmentTracker,
    settings: TrackSettings,
    segments: Sequence[int] | None = None,
    workers: int = 1,
    cancelled: Callable[[], bool] = never,
) -> Iterator[Progress]:
    """Track segments (all, or those of these indices) and tell how it goes.

    `workers` segments run side by side; the result does not depend on it. Cancelling takes effect
    within one pass and keeps what is finished. Raises VideoError where the video cannot be
    read.
    """
    chosen = list(range(len(tracker.spans))) if segments is None else sorted(set(segments))
    events: queue.Queue[Progress | BaseException | None] = queue.Queue()
    closing = Event()

    def work(index: int) -> None:
        try:
            _one_segment(tracker, settings, index, len(chosen), events, closing)
        except Left:
            events.put(None)
        except BaseException as error:  # noqa: BLE001 — raised again in the caller's thread
            events.put(error)

    done: dict[int, SegmentResult] = {}
    errors: list[BaseException] = []
    stopped = False
    with ThreadPoolExecutor(max(1, workers)) as pool:
        waiting = [pool.submit(work, index) for index in chosen]
        try:
            for _ in range(len(chosen)):
                for event in _until_finished(events, cancelled, closing, errors):
                    if isinstance(event, SegmentFinished):
                        done[event.index] = event.result
                    yield event
                stopped = stopped or closing.is_set()
        finally:
            closing.set()
            for future in waiting:
                future.cancel()
    if errors:  # told last, so that what is finished has been handed over
        raise errors[0]
    result = TrackResult(tracker.skeleton, settings, tuple(done[k] for k in sorted(done)))
    yield TrackFinished(result, cancelled=stopped)


def _one_segment(
    tracker: SegmentTracker, settings: TrackSettings, index: int, count: int,
    events: queue.Queue[Progress | BaseException | None], closing: Event,
) -> None:  # fmt: skip
    if closing.is_set():
        raise Left
    expected = tracker.expected_steps(index, settings)
    first, last = tracker.spans[index]
    events.put(SegmentStarted(index, count, first, last))

    def emit(step: Pass, number: int) -> None:
        if closing.is_set():
            raise Left
        events.put(PassFinished(index, number, expected, _score_of(step), step.trajectory))

    result = tracker.run_segment(index, settings, emit)
    events.put(SegmentFinished(index, count, result))


def _until_finished(
    events: queue.Queue[Progress | BaseException | None],
    cancelled: Callable[[], bool],
    closing: Event,
    errors: list[BaseException],
) -> Iterator[Progress]:
    """Events up to the end of one segment, whichever ends first; an error ends the others too."""
    while True:
        if cancelled():
            closing.set()
        try:
            event = events.get(timeout=0.05)
        except queue.Empty:
            continue
        if event is None:
            return
        if isinstance(event, BaseException):
            errors.append(event)
            closing.set()
            return
        yield event
        if isinstance(event, SegmentFinished):
            return


def expected_steps(settings: TrackSettings) -> int:
    """Trajectories a segment is expected to yield: starts, passes, refinement."""
    method = method_of(settings)
    if isinstance(method, Paper):
        return method.passes + 1
    return method.passes + 3 + method.templates


def _demand_two(keyposes: Mapping[int, Pose]) -> None:
    if len(keyposes) < 2:
        have = f"one, at frame {next(iter(keyposes))}" if keyposes else "none"
        raise SessionError(
            f"keyframes: at least two are needed to track between, and the session has {have}."
        )
