"""Follow the body from one keyframe, forward or backward, as far as the evidence carries.

Everything that follows a body counts steps: step 0 is the keyframe, and the larger the step, the
farther from it. What is before a keyframe is thus followed by the same code as what is after it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.errors import SessionError
from keypose.tracker.session.annotations import Direction, Stop, StopCause
from keypose.tracker.tracking.ahead.forward_pass import ForwardPass, by_brightness, by_keypoints
from keypose.tracker.tracking.ahead.stop_reasons import Stopped, pictures_end, stopped
from keypose.tracker.tracking.cues.anchors import Anchors, anchors_of
from keypose.tracker.tracking.method import FULL, Keypose, method_of
from keypose.tracker.tracking.pool import Cancelled
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.tracking.tracker import LOOKS_BETWEEN_REPORTS, NO_KEYPOINTS, Tracker
from keypose.tracker.video.pyramid import Clip

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from keypose.tracker.body.pose import Pose
    from keypose.tracker.keypoints.keypoints import Keypoints
    from keypose.tracker.session.settings import TrackSettings
    from keypose.tracker.tracking.cues.sources import KeypointSource
    from keypose.tracker.tracking.scene import Scene


@dataclass(frozen=True)
class DirectedFrames:
    """The frames from a keyframe on in one direction."""

    frame: int
    direction: Direction

    @property
    def sign(self) -> int:
        """What one step adds to the frame."""
        return 1 if self.direction == "forward" else -1

    def frame_at(self, step: int) -> int:
        """The frame of a step."""
        return self.frame + self.sign * step

    def span(self, steps: int) -> tuple[int, int]:
        """First and last frame of so many steps."""
        ends = self.frame, self.frame_at(steps)
        return min(ends), max(ends)

    def clip(self, clip: Clip, steps: int) -> Clip:
        """The pictures of so many steps, by step."""
        first, last = self.span(steps)
        slots = clip.slots(first, last)[:: self.sign]
        damaged = frozenset(abs(n - self.frame) for n in clip.damaged if first <= n <= last)
        return _Steps(clip, damaged, slots)

    def keypoints(self, detections: Keypoints, steps: int) -> Keypoints:
        """The keypoints of so many steps, by step."""
        over = detections.over(*self.span(steps))
        rows = slice(None, None, self.sign)
        depth = None if over.p_hips is None else over.p_hips[rows]
        by_hand = None if over.by_hand is None else over.by_hand[rows]
        uv, visibility = over.uv[rows], over.visibility[rows]
        return replace(
            over, first_frame=0, uv=uv, visibility=visibility, p_hips=depth, by_hand=by_hand
        )

    def motion(self, steps: Trajectory) -> Trajectory:
        """A motion by steps as one by frames."""
        rows = slice(None, None, self.sign)
        first, _ = self.span(len(steps) - 1)
        return Trajectory(first, steps.Rs_parent_part[rows], steps.ps_camera_root[rows])


class _Steps(Clip):
    """Pictures by step, of a clip of whole pictures. places: where each step's lie in it."""

    def __init__(self, clip: Clip, damaged: frozenset[int], places: NDArray[np.int64]) -> None:
        super().__init__(0, clip.levels, damaged, clip.overview)
        self.places = places

    def __len__(self) -> int:
        return len(self.places)

    def slots(self, first_frame: int, last_frame: int) -> NDArray[np.int64]:
        """Where these steps lie in the arrays; IndexError beyond them."""
        if first_frame < 0 or last_frame >= len(self):
            raise IndexError(f"steps {first_frame} to {last_frame} are not all in the clip")
        return np.ascontiguousarray(self.places[first_frame : last_frame + 1])


LONGEST: Final = 64
"""Steps that are followed at most: a keyframe is due then anyway."""
BLOCK: Final = 32
"""Steps that are added at a time. As many are kept together of what a network has seen."""

Emit: TypeAlias = Callable[[Trajectory], None]
"""Is given the motion on the way, by frame, the keyframe's pose included; may raise Cancelled."""


@dataclass(frozen=True, eq=False)
class FoundAhead:
    """What was followed from a keyframe.

    motion: by frame, from the keyframe to the last frame that can be trusted, both included; one
        frame where none can.
    notes: sentences about what could not be done as asked.
    """

    frame: int
    direction: Direction
    motion: Trajectory
    stop: Stop
    notes: tuple[str, ...] = ()

    @property
    def to_frame(self) -> int:
        """The last frame that can be trusted."""
        forward = self.direction == "forward"
        return self.motion.last_frame if forward else self.motion.first_frame


def follow_ahead(
    tracker: Tracker,
    frame: int,
    direction: Direction,
    settings: TrackSettings,
    emit: Emit,
    longest: int = LONGEST,
) -> FoundAhead:
    """Follow the body from its keypose at a frame, at most to just before the next keyframe.

    What `emit` raises as Cancelled ends the work, and what was found until then is kept.
    SessionError where there is nothing to follow.
    """
    if frame not in tracker.keyposes:
        raise SessionError(f"Frame {frame} has no keyframe; pose it first.")
    work = _AheadRun(tracker, DirectedFrames(frame, direction), settings, emit)
    steps, end = _reach(tracker, work.line, longest)
    if steps < 1:
        raise SessionError(_NOWHERE[end].format(frame=frame, where=_WHERE[direction]))
    return work.run(steps, end)


_NOWHERE: Final = {
    "clip_end": "Frame {frame} is the video's {where}: there is nothing to track from it.",
    "keyframe": "The keyframe next to frame {frame} leaves nothing to track between them.",
}
_WHERE: Final = {"forward": "last", "backward": "first"}


def _reach(tracker: Tracker, line: DirectedFrames, longest: int) -> tuple[int, StopCause]:
    """How many steps may be followed, and what ends them."""
    last = tracker.frame_count - 1
    to_end = last - line.frame if line.direction == "forward" else line.frame
    others = [line.sign * (key - line.frame) for key in tracker.keyposes]
    to_key = min((away - 1 for away in others if away > 0), default=to_end)
    ends: list[tuple[int, StopCause]] = [(to_end, "clip_end"), (longest, "limit")]
    if to_key < to_end:
        ends.insert(0, (to_key, "keyframe"))
    return min(ends, key=lambda end: end[0])


@dataclass(eq=False)
class _AheadRun:
    """One keyframe's way, grown block by block."""

    tracker: Tracker
    line: DirectedFrames
    settings: TrackSettings
    emit: Emit
    trusted: Trajectory | None = None
    """By step, as far as it was trusted last."""
    meanwhile: Trajectory | None = None
    """The same by brightness alone, while keypoints are looked for."""
    notes: tuple[str, ...] = ()

    def run(self, steps: int, end: StopCause) -> FoundAhead:
        try:
            return self._found(*self._follow(steps, end))
        except Cancelled:
            return self._found(self.meanwhile or self._so_far(), Stop(cause="cancelled"))

    def _follow(self, steps: int, end: StopCause) -> tuple[Trajectory, Stop]:
        for count in [*range(BLOCK, steps, BLOCK), steps]:
            clip = self._pictures(count, steps)
            edge = pictures_end(clip)
            reach = count if edge is None else edge.step
            if reach > 0:
                halt = self._grow(reach, steps, is_last=edge is not None or count == steps)
                if halt is not None:
                    return self._so_far(), halt
            if edge is not None:
                return self._so_far(), edge.stop
        return self._so_far(), Stop(cause=end)

    def _grow(self, count: int, steps: int, *, is_last: bool) -> Stop | None:
        """Follow all of the first `count` steps of so many; why not all of them can be trusted."""
        ways, scene = self._block(count, steps)
        halts = [self._judged(forward_pass, scene, count, is_last=is_last) for forward_pass in ways]
        reached = [count if halt is None else halt.step for halt in halts]
        best = reached.index(max(reached))
        halt = halts[best]
        if halt is not None and reached[best] < len(self._so_far()) - 1:
            return halt.stop  # what fewer steps were trusted with stays: the doubt came with more
        self.trusted, self.meanwhile = _cut(ways[best].motion, reached[best]), None
        return None if halt is None else halt.stop

    def _judged(
        self, followed: ForwardPass, scene: Scene, count: int, *, is_last: bool
    ) -> Stopped | None:
        """Where a motion over so many steps stops to be trusted."""
        is_short = len(followed.motion) <= count  # it left the space before the camera
        halt = stopped(scene, followed, is_last=is_last or is_short)
        if halt is None and is_short:
            return Stopped(len(followed.motion) - 1, Stop(cause="left_picture"))
        return halt

    def _pictures(self, count: int, steps: int) -> Clip:
        """The pictures of the first `count` steps; of one size throughout."""
        line = self.line
        return line.clip(self.tracker.loader(line.span(steps)).load(*line.span(count)), count)

    def _block(self, count: int, steps: int) -> tuple[list[ForwardPass], Scene]:
        """All of the first `count` steps of so many, with keypoints and by brightness alone: the
        way that can be trusted longer is the one to go."""
        tracker, start, whole = self.tracker, self._start, self.line.span(steps)
        segment = Segment(0, count, start, start, self._pictures(count, steps))
        method = _method(self.settings)
        scene = tracker.scene_about([start], whole, method.density)
        source = tracker.keypoint_source(self.settings)
        brightness = source is None or "brightness" in self.settings.cues_used
        followed = by_brightness(scene, segment, method) if brightness else None
        if followed is not None:
            self._keep_if_cancelled(followed, scene, count)
            self._report(followed.motion)
        if source is None:
            assert followed is not None
            return [followed], scene
        free = tracker.scene_about([start], whole, method.density, free=True)
        motion = None if followed is None else followed.motion
        anchors = self._anchors(source, free, segment, whole, motion)
        if not anchors:
            self.notes = (NO_KEYPOINTS,)
            return [followed or by_brightness(scene, segment, method)], scene
        by_joints = self._reported(by_keypoints(free, segment, method, anchors, followed))
        return [by_joints] if followed is None else [by_joints, followed], scene

    def _keep_if_cancelled(self, followed: ForwardPass, scene: Scene, count: int) -> None:
        """Keep what brightness alone has found of a block where that is cancelled."""
        halt = self._judged(followed, scene, count, is_last=True)
        motion = _cut(followed.motion, count if halt is None else halt.step)
        if len(motion) > len(self._so_far()):
            self.meanwhile = motion

    def _anchors(
        self,
        source: KeypointSource,
        free: Scene,
        segment: Segment,
        whole: tuple[int, int],
        followed: Trajectory | None,
    ) -> tuple[Anchors, ...]:
        count, looks = segment.last_frame, itertools.count()

        def report() -> None:
            if next(looks) % LOOKS_BETWEEN_REPORTS == 0:
                self._report(self.meanwhile or self._so_far())

        keypoints: Keypoints | None = source.beyond(
            self.line.frame, self.line.frame_at(count), self.tracker.skeleton, segment.start, report
        )
        if keypoints is None:
            return ()
        camera, by_step = self.tracker.loader(whole).camera, self.line.keypoints(keypoints, count)
        return anchors_of(free, segment, camera, by_step, open_end=True, followed=followed)

    def _reported(self, work: Generator[Pass, None, ForwardPass]) -> ForwardPass:
        """What the work comes to; every motion on the way is emitted."""
        while True:
            try:
                step = next(work)
            except StopIteration as done:
                forward_pass: ForwardPass = done.value
                self._report(forward_pass.motion)
                return forward_pass
            self._report(step.trajectory)

    def _report(self, motion: Trajectory) -> None:
        self.emit(self.tracker.as_filmed(self.line.motion(motion)))

    def _so_far(self) -> Trajectory:
        if self.trusted is not None:
            return self.trusted
        start = self._start
        return Trajectory(0, start.Rs_parent_part[None], start.p_camera_root[None])

    @property
    def _start(self) -> Pose:
        return self.tracker.keyposes[self.line.frame]

    def _found(self, motion: Trajectory, stop: Stop) -> FoundAhead:
        line = self.line
        trajectory = self.tracker.as_filmed(line.motion(motion))
        return FoundAhead(line.frame, line.direction, trajectory, stop, self.notes)


def _cut(motion: Trajectory, last: int) -> Trajectory:
    count = max(last, 0) + 1
    return Trajectory(0, motion.Rs_parent_part[:count], motion.ps_camera_root[:count])


def _method(settings: TrackSettings) -> Keypose:
    """The published method follows from two keyframes only: then ours."""
    method = method_of(settings)
    return replace(method, templates=False) if isinstance(method, Keypose) else FULL
