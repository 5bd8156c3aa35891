"""Where the keypoints of a segment come from: a network that looks for them, or a file of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from threading import Lock
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.film_camera import FilmCamera
from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints.augmented import AugmentedNetwork
from keypose.tracker.keypoints.blazepose import Seen
from keypose.tracker.keypoints.detect import Detector, Kept, Progress, Seed, detect
from keypose.tracker.keypoints.detectors import detector_fingerprint, open_detector
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.lifted_depth import DepthLifter
from keypose.tracker.keypoints.model_files import FULL, Model
from keypose.tracker.keypoints.paired import PairedNetwork
from keypose.tracker.keypoints.people import detect_people, people_changes
from keypose.tracker.keypoints.region import Region
from keypose.tracker.video.info import MissingFrame

if TYPE_CHECKING:
    from keypose.tracker.body.pose import Pose
    from keypose.tracker.body.skeleton import Skeleton
    from keypose.tracker.geometry.camera import Camera
    from keypose.tracker.geometry.camera_path import CameraPath
    from keypose.tracker.geometry.steady import SteadyCamera
    from keypose.tracker.session.annotations import KeypointCorrection
    from keypose.tracker.tracking.segment import Segment
    from keypose.tracker.video import Video

SEED_PARTS = 16
"""Regions of keyframes are rounded to so many parts of their size: a keyframe that is moved a
little is looked at from where it was, and what was found there can be used again."""


_LOOKING = Lock()
"""A network looks at one picture at a time."""


@cache
def _network(model: Model) -> Detector:
    return open_detector(model)


class FrameSource(Protocol):
    """What finds the keypoints of single frames."""

    def at(self, frame: int, skeleton: Skeleton, pose: Pose) -> Keypoints | None:
        """The keypoints of a frame in which the body is posed; None where nobody is
        found.
        """


class KeypointSource(FrameSource, Protocol):
    """What gives keypoints. A segment's depend on nothing but its own frames and keyposes; depth
    that is lifted, on frames around it as well."""

    def over(
        self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
    ) -> Keypoints | None:
        """The keypoints of a segment's frames; None where nobody is found.

        report: called again and again; what it raises ends the search within a frame.
        """

    def beyond(
        self, frame: int, last: int, skeleton: Skeleton, pose: Pose, report: Callable[[], None]
    ) -> Keypoints | None:
        """The keypoints from a frame in which the body is posed up to another, before or
        after it, in the order of frames; None where nobody is found.

        report: as of `over`.
        """


@dataclass(frozen=True, eq=False)
class GivenKeypoints:
    """Keypoints that somebody found, such as those of a file."""

    keypoints: Keypoints

    def over(
        self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
    ) -> Keypoints | None:
        return self.keypoints.over(segment.first_frame, segment.last_frame)

    def at(self, frame: int, skeleton: Skeleton, pose: Pose) -> Keypoints | None:
        return self.keypoints.over(frame, frame)

    def beyond(
        self, frame: int, last: int, skeleton: Skeleton, pose: Pose, report: Callable[[], None]
    ) -> Keypoints | None:
        return self.keypoints.over(min(frame, last), max(frame, last))


@dataclass(frozen=True, eq=False)
class DetectedKeypoints:
    """Keypoints by a network, which looks for the body from both of its keyposes.

    camera: of the video, with its distortion.  film: the video's fingerprint, under which what is
    found is kept.  model: the network.  every_second: as of `detect`.  path: of the camera.
    """

    video: Video
    camera: Camera
    film: str = ""
    kept: Kept | None = None
    model: Model = FULL
    every_second: bool = False
    path: CameraPath | None = None

    def over(
        self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
    ) -> Keypoints | None:
        first, last = segment.first_frame, segment.last_frame
        posed = {first: segment.start, last: segment.end}
        return self.follow((first, last), skeleton, posed, lambda progress: report())

    def at(self, frame: int, skeleton: Skeleton, pose: Pose) -> Keypoints | None:
        return self.follow((frame, frame), skeleton, {frame: pose}, lambda progress: None)

    def beyond(
        self, frame: int, last: int, skeleton: Skeleton, pose: Pose, report: Callable[[], None]
    ) -> Keypoints | None:
        frames = min(frame, last), max(frame, last)
        return self.follow(frames, skeleton, {frame: pose}, lambda progress: report())

    def follow(
        self,
        frames: tuple[int, int],
        skeleton: Skeleton,
        posed: Mapping[int, Pose],
        report: Callable[[Progress], None],
    ) -> Keypoints | None:
        """The keypoints of all frames from the first to the last; None where nobody is
        found.

        posed: poses of the body by frame, of one or more of these.  report: called before each
        look; what it raises ends the search.
        """
        seeds = _seeds(posed, skeleton, self.camera, self.path)
        with _LOOKING:
            network = _network(self.model)  # a KeypointError of its own where it is not here
            try:
                return detect(
                    self._frame,
                    frames,
                    seeds,
                    network,
                    report=report,
                    film=self.film,
                    kept=self.kept,
                    every_second=self.every_second,
                )
            except KeypointError:  # nobody is seen there: a body that is no person
                return None

    def follow_people(
        self,
        frames: tuple[int, int],
        people: Sequence[tuple[Skeleton, Mapping[int, Pose]]],
        report: Callable[[Progress], None],
    ) -> list[Keypoints] | None:
        """The keypoints of several people in all frames from the first to the last; None where one
        of them is not found.

        people: of each the body and its poses, as `posed` of `follow`.  report: likewise.
        """
        seeds = [_seeds(posed, skeleton, self.camera, self.path) for skeleton, posed in people]
        with _LOOKING:
            network = _network(self.model)
            try:
                return detect_people(
                    self._frame,
                    frames,
                    seeds,
                    network,
                    report=report,
                    film=self.film,
                    kept=self.kept,
                    every_second=self.every_second,
                )
            except KeypointError:  # somebody is not seen where they are posed
                return None

    def changes(
        self, people: Sequence[Keypoints], seeds: Sequence[int], report: Callable[[int, int], None]
    ) -> list[tuple[int, ...]]:
        """The frames from which on each of the people may be another one, ascending; see
        `people_changes`.

        seeds: the frames of the poses that they were followed from.
        """
        with _LOOKING:
            network = _network(self.model)
            if isinstance(network, AugmentedNetwork | PairedNetwork):
                network = network.plain
            half = self.every_second
            return people_changes(self._frame, people, seeds, network, report, every_second=half)

    def _frame(self, number: int) -> NDArray[np.uint8] | None:
        try:
            return self.video.frame(number)
        except MissingFrame:
            return None


@dataclass(frozen=True, eq=False)
class CorrectedKeypoints:
    """Keypoints of another source, with what a person said of them."""

    source: KeypointSource
    corrections: Sequence[KeypointCorrection]

    def over(
        self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
    ) -> Keypoints | None:
        return self._corrected(self.source.over(segment, skeleton, report))

    def at(self, frame: int, skeleton: Skeleton, pose: Pose) -> Keypoints | None:
        return self._corrected(self.source.at(frame, skeleton, pose))

    def beyond(
        self, frame: int, last: int, skeleton: Skeleton, pose: Pose, report: Callable[[], None]
    ) -> Keypoints | None:
        return self._corrected(self.source.beyond(frame, last, skeleton, pose, report))

    def _corrected(self, keypoints: Keypoints | None) -> Keypoints | None:
        return None if keypoints is None else keypoints.corrected(self.corrections)


@dataclass(frozen=True, eq=False)
class LiftedKeypoints:
    """Keypoints of another source, with the depth that is lifted from them.

    around: those of the whole film, where they are known: what is seen before and after the frames
    that are asked for.
    """

    source: KeypointSource
    lifter: DepthLifter
    around: Keypoints | None = None

    def over(
        self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
    ) -> Keypoints | None:
        return self._lifted(self.source.over(segment, skeleton, report), skeleton)

    def at(self, frame: int, skeleton: Skeleton, pose: Pose) -> Keypoints | None:
        return self._lifted(self.source.at(frame, skeleton, pose), skeleton)

    def beyond(
        self, frame: int, last: int, skeleton: Skeleton, pose: Pose, report: Callable[[], None]
    ) -> Keypoints | None:
        keypoints = self.source.beyond(frame, last, skeleton, pose, report)
        return self._lifted(keypoints, skeleton)

    def _lifted(self, keypoints: Keypoints | None, skeleton: Skeleton) -> Keypoints | None:
        if keypoints is None:
            return None
        first, last = keypoints.first_frame, keypoints.last_frame
        wider = keypoints
        if self.around is not None and _are_same(keypoints, self.around.over(first, last)):
            wider = self.around.over(*self.lifter.looked_at(first, last)).overlaid(keypoints)
        lifted = self.lifter.of(wider, skeleton.body).over(first, last)
        return replace(keypoints, p_hips=lifted.p_hips, depth_sigma_m=lifted.depth_sigma_m)


def _are_same(keypoints: Keypoints, around: Keypoints) -> bool:
    """Whether both hold the same keypoints, apart from those that a person set or that do not
    count."""
    if keypoints.names != around.names:
        return False
    same = np.isclose(keypoints.uv, around.uv, equal_nan=True).all(axis=-1)
    same |= np.isnan(keypoints.uv).any(axis=-1)
    return bool(same.all() if keypoints.by_hand is None else (same | keypoints.by_hand).all())


@dataclass(frozen=True, eq=False)
class SteadyKeypoints:
    """Keypoints of another source as a steady camera would have seen them, which poses are for."""

    source: KeypointSource
    steady: SteadyCamera

    def over(
        self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
    ) -> Keypoints | None:
        start = self._as_filmed(segment.first_frame, segment.start)
        end = self._as_filmed(segment.last_frame, segment.end)
        return self._seen(
            self.source.over(replace(segment, start=start, end=end), skeleton, report)
        )

    def at(self, frame: int, skeleton: Skeleton, pose: Pose) -> Keypoints | None:
        return self._seen(self.source.at(frame, skeleton, self._as_filmed(frame, pose)))

    def beyond(
        self, frame: int, last: int, skeleton: Skeleton, pose: Pose, report: Callable[[], None]
    ) -> Keypoints | None:
        filmed = self._as_filmed(frame, pose)
        return self._seen(self.source.beyond(frame, last, skeleton, filmed, report))

    def _as_filmed(self, frame: int, pose: Pose) -> Pose:
        return pose.carried(self.steady.Ts_camera_steady[frame])

    def _seen(self, keypoints: Keypoints | None) -> Keypoints | None:
        return None if keypoints is None else keypoints.steadied(self.steady)


class _NotKept(Exception):
    """What is asked for was not found before, or is not kept any more."""


@dataclass(frozen=True)
class _Recall:
    """Stands for a network whose answers are recalled, and is never shown a picture."""

    fingerprint: str

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        raise _NotKept


def found_before(
    posed: Mapping[int, Pose],
    skeleton: Skeleton,
    camera: Camera,
    film: str,
    kept: Kept,
    model: Model,
    path: CameraPath | None = None,
) -> Keypoints | None:
    """What a network found in a segment when it was tracked last, with no look at the film;
    None where it did not, or nobody keeps it any more.

    posed: the keyposes of the segment's first and last frame, by frame.  camera, film, model,
    path: as of `DetectedKeypoints`.
    """

    def no_picture(_number: int) -> None:
        raise _NotKept

    frames = (min(posed), max(posed))
    seeds, recall = _seeds(posed, skeleton, camera, path), _Recall(detector_fingerprint(model))
    for every_second in (True, False):
        with suppress(_NotKept, KeypointError):  # never looked for so, or nobody seen
            return detect(
                no_picture,
                frames,
                seeds,
                recall,
                film=film,
                kept=kept,
                every_second=every_second,
            )
    return None


def _seeds(
    posed: Mapping[int, Pose], skeleton: Skeleton, camera: Camera, path: CameraPath | None
) -> list[Seed]:
    def seed(frame: int, pose: Pose) -> Seed:
        here = FilmCamera(camera, path).at(frame)
        return Seed(frame, Region.of_pose(skeleton, pose, here).rounded(SEED_PARTS))

    return [seed(frame, pose) for frame, pose in posed.items()]
