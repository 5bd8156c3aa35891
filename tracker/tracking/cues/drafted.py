"""Keypoints that were found when a film was drafted, which serve its segments as well.

A network that looks again from a keyframe sees the same person from a region a little beside: the
same keypoints up to chance, for the same time once more.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.body.film_camera import FilmCamera
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import apply_transform
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.on_body import (
    FEWEST,
    OTHER_PERSON,
    PointsOnBody,
    height_px,
    points_on_body,
)
from keypose.tracker.keypoints.region import LEAST_DEPTH_M
from keypose.tracker.tracking.cues.sources import KeypointSource

if TYPE_CHECKING:
    from keypose.tracker.tracking.segment import Segment


@dataclass(frozen=True, eq=False)
class DraftedKeypoints:
    """Keypoints of a draft, where the body's poses lie on them; another source's elsewhere.

    drafted: as they were filmed.  camera, path: as of `DetectedKeypoints`.
    together: as of `drafted_over`.
    """

    drafted: Keypoints
    source: KeypointSource
    camera: Camera
    path: CameraPath | None = None
    together: bool = False

    def over(
        self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
    ) -> Keypoints | None:
        frames = segment.first_frame, segment.last_frame
        posed = dict(zip(frames, (segment.start, segment.end), strict=True))
        keypoints = self._shown(frames, skeleton, posed)
        return self.source.over(segment, skeleton, report) if keypoints is None else keypoints

    def at(self, frame: int, skeleton: Skeleton, pose: Pose) -> Keypoints | None:
        keypoints = self._shown((frame, frame), skeleton, {frame: pose})
        return self.source.at(frame, skeleton, pose) if keypoints is None else keypoints

    def beyond(
        self, frame: int, last: int, skeleton: Skeleton, pose: Pose, report: Callable[[], None]
    ) -> Keypoints | None:
        frames = min(frame, last), max(frame, last)
        keypoints = self._shown(frames, skeleton, {frame: pose})
        if keypoints is None:
            return self.source.beyond(frame, last, skeleton, pose, report)
        return keypoints

    def _shown(
        self, frames: tuple[int, int], skeleton: Skeleton, posed: Mapping[int, Pose]
    ) -> Keypoints | None:
        return drafted_over(
            self.drafted, frames, skeleton, posed, self.camera, self.path, together=self.together
        )


def drafted_over(
    drafted: Keypoints,
    frames: tuple[int, int],
    skeleton: Skeleton,
    posed: Mapping[int, Pose],
    camera: Camera,
    path: CameraPath | None = None,
    *,
    together: bool = False,
) -> Keypoints | None:
    """A draft's keypoints from the first frame to the last; None where a pose lies beside
    them, or where somebody was not seen at all of these frames.

    posed: poses of the body as it was filmed, by frame.  camera: of the video, with its distortion.
    path: of a camera that moves.
    together: whether the people around were followed as well: then who is unseen is hidden, and a
    second look would see somebody else. One pose has to show that the keypoints are the body's;
    in frames where another pose lies beside them, they alone do not count.
    """
    keypoints = drafted.over(*frames)
    on_body = points_on_body(skeleton.body, keypoints.names)
    is_seen = np.asarray(np.isfinite(keypoints.uv).all(axis=(1, 2)))
    is_drafted = drafted.first_frame <= frames[0] and frames[1] <= drafted.last_frame
    if len(on_body.indices) < FEWEST or not (is_drafted if together else is_seen.all()):
        return None
    compared = {frame: pose for frame, pose in posed.items() if is_seen[frame - frames[0]]}
    if posed and not compared:
        return None
    film_camera = FilmCamera(camera, path)
    beside = [
        frame
        for frame, pose in compared.items()
        if not _lies_on(
            keypoints.over(frame, frame), on_body, skeleton, pose, film_camera.at(frame)
        )
    ]
    if beside and (not together or len(beside) == len(compared)):
        return None
    return keypoints.without(beside)


def _lies_on(
    keypoints: Keypoints, on_body: PointsOnBody, skeleton: Skeleton, pose: Pose, camera: Camera
) -> bool:
    """Whether a posed body lies where keypoints of one frame show the person, whichever side
    they take for the left one."""
    Ts = pose_transforms(skeleton, pose)[on_body.part]
    p = apply_transform(Ts, on_body.point[:, None])[:, 0]
    if (p[:, 2] < LEAST_DEPTH_M).any():
        return False
    uv, at = camera.project(p), on_body.indices
    miss = [
        np.linalg.norm(each.uv[0, at] - uv, axis=-1) for each in (keypoints, keypoints.exchanged())
    ]
    return bool(min(map(np.median, miss)) <= OTHER_PERSON * height_px(skeleton, camera, pose))
