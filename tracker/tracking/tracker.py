"""Tracking between keyframes: a film made ready, and its segments tracked one by one."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from copy import copy
from dataclasses import replace
from itertools import count, pairwise
from typing import Final, TypeAlias

import numpy as np

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.surface_points import SurfacePoints, sample_points
from keypose.tracker.body.trajectory import Pass, Trajectory, displaced, interpolate
from keypose.tracker.errors import SessionError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session.settings import IgnoreMask, TrackSettings
from keypose.tracker.tracking.agreement import films_agree
from keypose.tracker.tracking.anchored_cycle import expected_anchored_steps, track_anchored
from keypose.tracker.tracking.cues.anchors import (
    anchors_of,
    keyframe_off_person,
    with_free_joints,
)
from keypose.tracker.tracking.cues.keypoint_start import from_keypoints
from keypose.tracker.tracking.cues.other_film import OtherFilm
from keypose.tracker.tracking.cues.silhouette import Outlines, outlines_of, silhouette_mismatch
from keypose.tracker.tracking.cues.soft_correction import Correction, even_increments
from keypose.tracker.tracking.cues.sources import KeypointSource
from keypose.tracker.tracking.cycle import Work, track_segment
from keypose.tracker.tracking.diagnostics.judge import segment_result
from keypose.tracker.tracking.film_beside import FilmBeside
from keypose.tracker.tracking.initial.chains import fit_to_keyframes
from keypose.tracker.tracking.initial.choose import starts
from keypose.tracker.tracking.method import Keypose, Method, expected_steps, method_of
from keypose.tracker.tracking.parts.correct import (
    Evidence,
    KeptOutcomes,
    Kind,
    corrected,
    expected_limb_steps,
)
from keypose.tracker.tracking.parts.limb_keyframes import KeyedParts
from keypose.tracker.tracking.prepared_film import PreparedFilm
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.video import Video
from keypose.tracker.video.clip_loader import AGAIN, ClipLoader, Memory
from keypose.tracker.video.pyramid import Clip

Emit: TypeAlias = Callable[[Pass, int], None]
"""Is given every trajectory on the way, and its number; may raise Cancelled."""
LOOKS_BETWEEN_REPORTS = 8
"""Frames in which keypoints are looked for between two looks at whether to stop."""

ROUNDING: Final = 1e-9
"""Metres, and entries of rotations: by so little other processors and libraries may round apart."""

OTHER_UNSEEN = (
    "keypoints of another film show this body at neither keyframe: only its pictures count there"
)
WITHOUT_KEYPOINTS = "other films count together with keypoints only: this one alone was used"
NO_KEYPOINTS = "no keypoints were found on this body: brightness alone was used"


class Tracker:
    """A video, a camera, a body and its keyposes, made ready to be tracked.

    Keep it to track again after a keyframe has changed: pictures stay prepared. Raises SessionError
    with fewer than two keyposes, or than `fewest`: one is enough to follow the body ahead.
    `first_motion` is one to start from, wherever it reaches; before all others within the runs of
    frames `own`, where it is the film's own motion of before. `keyed_parts` are limbs that are
    exact at frames between keyposes.
    """

    def __init__(
        self,
        video: Video,
        camera: Camera,
        skeleton: Skeleton,
        keyposes: Mapping[int, Pose],
        masks: Sequence[IgnoreMask] = (),
        static_camera: bool = False,
        memory: Memory = AGAIN,
        first_motion: Trajectory | None = None,
        keypoints: KeypointSource | None = None,
        keyed_parts: Sequence[KeyedParts] = (),
        keys: Mapping[tuple[int, int], str] | None = None,
        *,
        fewest: int = 2,
        own: Sequence[tuple[int, int]] = (),
        people: KeypointSource | None = None,
        steady: SteadyCamera | None = None,
        turns: Array | None = None,
        drafted: Collection[int] = (),
        times_s: Array | None = None,
        films: Sequence[FilmBeside] = (),
    ) -> None:
        """keys: of the segments without `keyed_parts`; where two are equal so are the motions.
        people: what sees where in the picture a person is.  steady: the camera in whose place the
        film is tracked, where its own moves: keypoints are as it sees them, all poses that are
        given and found as the film's does.  turns (F, 3, 3): how that is turned from the world,
        where pictures are compared with the empty scene all around.  drafted: the frames of
        keyposes that nobody has posed since they were drafted.  times_s (F,): when frames are; None
        where nobody knows, and no pose makes depth surer near by.  films: others that show the same
        motion.
        """
        self._films = tuple(films)
        self._people, self._steady = people, steady
        self._drafted, self._times_s = frozenset(drafted), times_s
        self._own, self._keypoints = tuple(own), keypoints
        self._first_motion = None if first_motion is None else self._steadied(first_motion)
        self._keyed_parts = self._steady_parts(keyed_parts)
        self._keys, self._kept = keys or {}, KeptOutcomes()
        self.prepared = PreparedFilm(video, camera, masks, static_camera, memory, steady, turns)
        self._points_by_spacing: dict[float, SurfacePoints] = {}
        self._pose(skeleton, keyposes, fewest)

    def _pose(self, skeleton: Skeleton, keyposes: Mapping[int, Pose], fewest: int) -> None:
        """Take keyposes of a body."""
        if len(keyposes) < fewest:
            _require_two(keyposes)
        self.skeleton, self._filmed = skeleton, dict(keyposes)
        self.keyposes = {
            frame: self._steady_pose(frame, keyposes[frame]) for frame in sorted(keyposes)
        }

    def renewed(
        self,
        skeleton: Skeleton,
        keyposes: Mapping[int, Pose],
        first_motion: Trajectory | None = None,
        keypoints: KeypointSource | None = None,
        keyed_parts: Sequence[KeyedParts] = (),
        keys: Mapping[tuple[int, int], str] | None = None,
        *,
        fewest: int = 2,
        own: Sequence[tuple[int, int]] = (),
        people: KeypointSource | None = None,
        drafted: Collection[int] = (),
        films: Sequence[FilmBeside] = (),
    ) -> Tracker:
        """A tracker of other keyposes, or of another body, before the same video.

        Prepared pictures are shared between the two, and so are the arrays of the body where it is
        the same object. Both may be in use at the same time.
        """
        tracker = copy(self)
        tracker._first_motion = None if first_motion is None else self._steadied(first_motion)
        tracker._own, tracker._keypoints, tracker._people = tuple(own), keypoints, people
        tracker._keyed_parts, tracker._keys = self._steady_parts(keyed_parts), keys or {}
        tracker._drafted, tracker._films = frozenset(drafted), tuple(films)
        if skeleton is not self.skeleton:
            tracker._points_by_spacing = {}
        tracker._pose(skeleton, keyposes, fewest)
        return tracker

    def _steady_pose(self, frame: int, pose: Pose) -> Pose:
        return pose if self._steady is None else pose.carried(self._steady.Ts_steady_camera[frame])

    def _steady_parts(self, parts: Sequence[KeyedParts]) -> tuple[KeyedParts, ...]:
        return tuple(replace(each, pose=self._steady_pose(each.frame, each.pose)) for each in parts)

    def _steadied(self, motion: Trajectory) -> Trajectory:
        if self._steady is None:
            return motion
        rows = slice(motion.first_frame, motion.last_frame + 1)
        return motion.carried(self._steady.Ts_steady_camera[rows])

    def as_filmed(self, motion: Trajectory) -> Trajectory:
        """A motion that was found, as the film's own camera sees it. Where it meets a keyframe it
        has the very numbers that were set, whichever way this processor rounds."""
        poses = {
            frame: self._filmed[frame]
            for frame in (motion.first_frame, motion.last_frame)
            if frame in self._filmed and _meets(motion.pose(frame), self.keyposes[frame])
        }
        if self._steady is not None:
            rows = slice(motion.first_frame, motion.last_frame + 1)
            motion = motion.carried(self._steady.Ts_camera_steady[rows])
        poses = {
            frame: pose for frame, pose in poses.items() if not _are_equal(motion.pose(frame), pose)
        }
        if not poses:
            return motion
        R, t = motion.writable()
        for frame, pose in poses.items():
            row = frame - motion.first_frame
            R[row], t[row] = pose.Rs_parent_part, pose.p_camera_root
        return Trajectory(motion.first_frame, R, t)

    def loader(self, span: tuple[int, int]) -> ClipLoader:
        """What loads the pictures of a segment, in the size that its length allows."""
        return self.prepared.loader(span[1] - span[0] + 1)

    def scene(self, span: tuple[int, int], density: float, free: bool = False) -> Scene:
        """The scene of one segment, for its own two keyposes.

        free: with all parts that carry keypoints free to turn.
        """
        scene = self.scene_about([self.keyposes[frame] for frame in span], span, density, free)
        if not self.prepared.shows_background:
            return scene
        return self.prepared.before_plate(scene, self.pictures(span), self._interpolated(span))

    def pictures(self, span: tuple[int, int]) -> Clip:
        """The pictures of a segment, around the body as it is posed and interpolated."""
        return self.prepared.pictures(self.skeleton, self._interpolated(span))

    def _interpolated(self, span: tuple[int, int]) -> Trajectory:
        start, end = (self.keyposes[frame] for frame in span)
        return interpolate(start, end, *span)

    def scene_about(
        self, poses: Sequence[Pose], span: tuple[int, int], density: float, free: bool = False
    ) -> Scene:
        """The scene of frames in which the body is about as in these poses."""
        skeleton = with_free_joints(self.skeleton) if free else self.skeleton
        longest = span[1] - span[0] + 1
        return self.prepared.scene(skeleton, poses, longest, density, self._sample)

    def _sample(self, skeleton: Skeleton, spacing_m: float) -> SurfacePoints:
        """Surface points, cached by spacing."""
        if spacing_m not in self._points_by_spacing:  # what is free to turn does not matter
            self._points_by_spacing[spacing_m] = sample_points(skeleton, spacing_m)
        return self._points_by_spacing[spacing_m]

    @property
    def frame_count(self) -> int:
        """The number of frames of the video."""
        return self.prepared.frame_count

    @property
    def spans(self) -> list[tuple[int, int]]:
        """First and last frame of every segment."""
        return list(pairwise(self.keyposes))

    def expected_steps(self, span: tuple[int, int], settings: TrackSettings) -> int:
        """The expected number of trajectories from `run_segment`."""
        whole = expected_steps(settings)
        if self._uses_keypoints(settings):
            whole = expected_anchored_steps(self._method(settings).passes)
        inside = [each for each in self._keyed_parts if span[0] < each.frame < span[1]]
        if not inside:
            return whole
        is_kept = self._kept.get(self._kind(span, settings)) is not None
        return (0 if is_kept else whole) + expected_limb_steps(self.skeleton, inside, whole)

    def _kind(self, span: tuple[int, int], settings: TrackSettings) -> Kind:
        return self._keys.get(span, ""), settings.quality, settings.model_dump_json()

    def move_keyframe(self, frame: int, pose: Pose) -> None:
        """Give an existing keyframe another pose."""
        if frame not in self.keyposes:
            raise SessionError(f"Frame {frame} has no keyframe; add it to the session first.")
        self._filmed[frame], self.keyposes[frame] = pose, self._steady_pose(frame, pose)

    def run_segment(
        self, span: tuple[int, int], settings: TrackSettings, emit: Emit
    ) -> SegmentResult:
        """Track one segment, which depends on nothing but its own frames and keyposes.

        `emit` is given every trajectory and may raise Cancelled to stop the work. SessionError
        where one of its ends has no keypose, or where it is too long.
        """
        first, last = span
        for frame in span:
            if frame not in self.keyposes:
                raise SessionError(f"Frame {frame} has no keyframe; pose it first.")
        start, end = self.keyposes[first], self.keyposes[last]
        imported, own, motion = None, None, self._first_motion
        if motion is not None and any(a <= first and last <= b for a, b in self._own):
            imported = displaced(motion, start, end, first, last)
            if settings.initial == "auto":
                settings = settings.model_copy(update={"initial": "import"})
            own = imported if settings.initial == "import" else None
        elif motion is not None:
            imported = fit_to_keyframes(motion, start, end, first, last)
        clip = self.pictures(span)
        segment = Segment(first, last, start, end, clip, imported, own, self._to_posed_s(span))
        method = self._method(settings)
        scene = self.scene(span, method.density)
        outlines = self._outlines(segment, settings, emit)
        work, number = self._corrected_work(scene, segment, settings, emit), 0
        while True:
            try:
                step = next(work)
            except StopIteration as done:
                outcome, enlarged = done.value, self.loader(span).camera.fy / scene.camera.fy
                if self._uses_silhouette(settings):
                    mismatch = silhouette_mismatch(
                        scene, segment.clip, outcome.trajectory, outlines
                    )
                    outcome = replace(outcome, silhouette=mismatch)
                if outcome.joints is None and self._uses_keypoints(settings):
                    outcome = replace(outcome, notes=(*outcome.notes, NO_KEYPOINTS))
                result = segment_result(scene, segment, outcome, method, enlarged)
                return replace(result, trajectory=self.as_filmed(result.trajectory))
            emit(replace(step, trajectory=self.as_filmed(step.trajectory)), number)
            number += 1

    def _to_posed_s(self, span: tuple[int, int]) -> Array | None:
        """(N, P) seconds to the nearest frame at which a person posed a part."""
        if self._times_s is None:
            return None
        first, last = span
        inside = self._times_s[first : last + 1]
        to_posed_s = np.full((len(inside), self.skeleton.part_count), np.inf)
        whole = np.arange(self.skeleton.part_count)
        posed = [(frame, whole) for frame in span if frame not in self._drafted]
        limbs = [(key.frame, key.parts) for key in self._keyed_parts if first < key.frame < last]
        for frame, parts in (*posed, *limbs):
            away = np.abs(inside - self._times_s[frame])
            to_posed_s[:, parts] = np.minimum(to_posed_s[:, parts], away[:, None])
        return to_posed_s

    def _corrected_work(
        self, scene: Scene, segment: Segment, settings: TrackSettings, emit: Emit
    ) -> Work:
        """The segment tracked, or as it was tracked before; then with limbs where they were set."""
        first, last = segment.first_frame, segment.last_frame
        inside = [each for each in self._keyed_parts if first < each.frame < last]
        kind = self._kind((first, last), settings)
        outcome = self._kept.get(kind) if inside and kind[0] else None
        if outcome is None:
            outcome = yield from self._work(scene, segment, settings, emit)
            if kind[0]:
                self._kept.keep(kind, outcome)
        if not inside:
            return outcome
        evidence = self._evidence(scene, segment, settings, emit)
        return (yield from corrected(outcome, segment, inside, self._method(settings), evidence))

    def _evidence(
        self, scene: Scene, segment: Segment, settings: TrackSettings, emit: Emit
    ) -> Evidence:
        """What limbs are tracked from."""
        method = self._method(settings)
        keypoints = self._keypoints_of(self.keypoint_source(settings), segment, emit)
        if keypoints is None:
            return Evidence(scene)
        span = segment.first_frame, segment.last_frame
        free = self.scene(span, method.density, free=True)
        camera, brightness = self.loader(span).camera, "brightness" in settings.cues_used
        agreed = self._agreed(segment, camera, keypoints)
        candidates = anchors_of(free, segment, camera, keypoints) if self._films else ()
        films: tuple[OtherFilm, ...] = ()
        if candidates and isinstance(method, Keypose):
            films = self._beside(Correction(free, segment, candidates[0]), method, agreed)
        return Evidence(scene, free, camera, keypoints, brightness=brightness, films=films)

    def _work(self, scene: Scene, segment: Segment, settings: TrackSettings, emit: Emit) -> Work:
        """Track with keypoints where there are any; without, as if there never were."""
        method = self._method(settings)
        keypoints = self._keypoints_of(self.keypoint_source(settings), segment, emit)
        if keypoints is not None and isinstance(method, Keypose):
            span = segment.first_frame, segment.last_frame
            free = self.scene(span, method.density, free=True)
            camera, brightness = self.loader(span).camera, "brightness" in settings.cues_used
            begun = starts(scene, segment, replace(method, templates=False)) if brightness else None
            followed = begun.ways[0].trajectory if begun is not None else None
            agreed = self._agreed(segment, camera, keypoints)
            candidates = anchors_of(
                free, segment, camera, keypoints, followed=followed, agreed=agreed
            )
            if candidates:
                films = self._beside(Correction(free, segment, candidates[0]), method, agreed)
                outcome = yield from track_anchored(
                    scene, free, segment, method, candidates, begun, films=films
                )
                unseen = any(film.anchors is None for film in films)
                notes = (OTHER_UNSEEN,) if unseen else ()
                return replace(outcome, notes=(*outcome.notes, *notes))
            off_person = keyframe_off_person(free, segment, camera, keypoints)
            outcome = yield from track_segment(scene, segment, method)
            return replace(outcome, off_person=off_person)
        outcome = yield from track_segment(scene, segment, method)
        notes = (WITHOUT_KEYPOINTS,) if self._films else ()
        return replace(outcome, notes=(*outcome.notes, *notes))

    def _agreed(self, segment: Segment, camera: Camera, keypoints: Keypoints) -> tuple[int, ...]:
        """The keyframes of a segment that films agree of."""
        ends = {segment.first_frame: segment.start, segment.last_frame: segment.end}
        return tuple(
            frame
            for frame, pose in ends.items()
            if films_agree(frame, pose, self.skeleton, camera, keypoints, self._films)
        )

    def _beside(
        self, correction: Correction, method: Keypose, agreed: tuple[int, ...]
    ) -> tuple[OtherFilm, ...]:
        """What other films show of a segment; of one whose sides are in doubt as they go with what
        the first film's keypoints say."""
        segment, scene = correction.segment, correction.scene
        if not self._films:
            return ()
        held = (even_increments(scene, segment.interpolated()),)
        followed = from_keypoints(correction, reach_far=False)

        def cost(film: OtherFilm) -> float:
            both = replace(correction, films=(film,))
            return both.cost(from_keypoints(both, reach_far=False), held)

        shown = [
            film.over(segment, followed, scene.skeleton, method.density, self._sample, agreed)
            for film in self._films
        ]
        return tuple(
            films[0] if len(films) == 1 else min(films, key=cost) for films in shown if films
        )

    def _keypoints_of(
        self, source: KeypointSource | None, segment: Segment, emit: Emit
    ) -> Keypoints | None:
        """While they are looked for, the motion is interpolation: that is emitted now and then, so
        that the work can be stopped."""
        if source is None:
            return None
        looks, waiting = count(), Pass("interpolation", segment.interpolated(), None)

        waiting = replace(waiting, trajectory=self.as_filmed(waiting.trajectory))

        def report() -> None:
            if next(looks) % LOOKS_BETWEEN_REPORTS == 0:
                emit(waiting, 0)

        return source.over(segment, self.skeleton, report)

    def _outlines(self, segment: Segment, settings: TrackSettings, emit: Emit) -> Outlines | None:
        """Where the person is, before a camera that moves; None before one that stands
        still, and where no silhouette counts."""
        if self.prepared.shows_background or not self._uses_silhouette(settings):
            return None
        keypoints = self._keypoints_of(self._people, segment, emit)
        loader = self.loader((segment.first_frame, segment.last_frame))
        return outlines_of(keypoints, loader.camera, loader.size)

    def _method(self, settings: TrackSettings) -> Method:
        return method_of(settings, with_keypoints=self._uses_keypoints(settings))

    def keypoint_source(self, settings: TrackSettings) -> KeypointSource | None:
        """Where keypoints come from; None where they do not count."""
        return self._keypoints if self._uses_keypoints(settings) else None

    def _uses_keypoints(self, settings: TrackSettings) -> bool:
        """Whether keypoints count where there are any: never for the printed method, nor for
        bodies that are no person's.
        """
        wanted = settings.method == "keypose" and "keypoints" in settings.cues_used
        return self._keypoints is not None and wanted and is_persons(self.skeleton.body)

    def _uses_silhouette(self, settings: TrackSettings) -> bool:
        """Whether it counts: before a camera that stands still, and where there is a
        person."""
        wanted = settings.method == "keypose" and "silhouette" in settings.cues_used
        persons = self._people is not None and is_persons(self.skeleton.body)
        return wanted and (self.prepared.shows_background or persons)


def _are_equal(pose: Pose, other: Pose) -> bool:
    """Whether two poses have the same numbers."""
    same = np.array_equal(pose.Rs_parent_part, other.Rs_parent_part)
    return same and np.array_equal(pose.p_camera_root, other.p_camera_root)


def _meets(pose: Pose, other: Pose) -> bool:
    """Whether two poses are one but for rounding."""
    rotations = np.abs(pose.Rs_parent_part - other.Rs_parent_part).max(initial=0.0)
    places = np.abs(pose.p_camera_root - other.p_camera_root).max()
    return bool(max(rotations, places) <= ROUNDING)


def _require_two(keyposes: Mapping[int, Pose]) -> None:
    if len(keyposes) < 2:
        have = f"one, at frame {next(iter(keyposes))}" if keyposes else "none"
        raise SessionError(
            f"keyframes: at least two are needed to track between, and the session has {have}."
        )
